//! The rig: opened it can be asked, armed it can be commanded. Only an [`ArmedRig`] has a way to move anything.

use std::time::Duration;

use drivers::cia402::{Actuals, Cia402, CyclicMode, DriveCommand, PowerState, PowerTarget};
use drivers::device::DeviceError;
use drivers::wire::{BusState, Fieldbus, Notice, ProcessImage};
use procedures::case::Case;

use crate::model::axis::{RigAxis, VelocityFeedback};
use crate::model::rig::Gimbal;
use crate::rig::feedback::RateFeedback;
use crate::rig::tracking::{Asked, Closed, Seen, Tracking};

mod believed;
pub(crate) mod device;
pub mod devices;
pub(crate) mod driver;
mod emergency_stop;
pub(crate) mod feedback;
pub(crate) mod hearing;
mod heat_sinks;
pub mod identities;
pub(crate) mod instruments;
mod link;
mod opening;
mod pace;
mod phase;
mod point_settings;
pub(crate) mod tracking;
pub mod wires;

pub use believed::Believed;
use believed::Reckoning;
use devices::Devices;
use emergency_stop::EmergencyStop;
use instruments::{Instruments, Tasks};
pub use opening::OpenRig;
use pace::Pace;
use phase::Phase;
pub use point_settings::PointSettings;
use wires::Ports;

/// Age in periods of a gyro sample beyond which the loop falls back on the encoder (safety.md: ten periods).
pub(crate) const FEEDBACK_AGE_TICKS: u32 = 10;

/// Time of the first tick is a multiple of this.
const OPENING: Duration = Duration::from_millis(100);

/// A rig that can be commanded, one exchange a tick.
pub struct ArmedRig {
    bus: Box<dyn Fieldbus>,
    drives: Vec<Cia402>,
    axes: Vec<RigAxis>,
    ports: Ports,
    /// Which of the axes are azimuth and elevation of the gyros, the trackers and the mirror.
    gimbal: Option<Gimbal>,
    devices: Devices,
    instruments: Instruments,
    feedback: RateFeedback,
    tracking: Tracking,
    /// Decelerations of the rig file, whatever the drives' present limits leave of them.
    stated_rad_per_s2: Vec<f64>,
    /// Settings of a point that are being written.
    wanted: Option<PointSettings>,
    /// The drive whose heat sink is being read.
    reads_heat_sink: Option<usize>,
    /// The emergency stop where it is wired to a terminal.
    emergency_stop: Option<EmergencyStop>,
    /// When the dialogues with the devices were over.
    opened_at: Duration,
    ready: Duration,
    pace: Pace,
    image: ProcessImage,
    actuals: Vec<Actuals>,
    age_ticks: Vec<u32>,
    reckoned: Vec<Reckoning>,
    /// The inertial unit, which all axes share, is silent or frozen.
    distrusts_gyro: bool,
    link_is_full: bool,
    controlwords: Vec<u16>,
    working_counter: u16,
    bad_in_row: u32,
    recent_bad: u128,
    /// Keeps the ticks in phase with the clock of the bus; `None` in virtual time.
    phase: Option<Phase>,
}

impl Drop for ArmedRig {
    /// A rig whose drives have all given up their torque needs nobody to hold it.
    fn drop(&mut self) {
        let states = self.actuals.iter().map(|actuals| PowerState::of(actuals.statusword));
        if states.zip(&self.age_ticks).all(|(state, &age)| age == 0 && state.is_without_torque()) {
            self.bus.let_go();
        }
    }
}

impl ArmedRig {
    /// The dialogues before the ticks were over at this time.
    fn begin_ticks_after(&mut self, opened_at: Duration) {
        // A round time: what the devices take to answer must not shift the first tick, and with it all noise.
        let rounds = opened_at.as_nanos().div_ceil(OPENING.as_nanos()).max(1);
        (self.opened_at, self.ready) = (opened_at, OPENING * u32::try_from(rounds).unwrap_or(u32::MAX));
        self.devices.start_of_ticks(self.ready);
    }

    /// Sends the commands of the tick before and takes what was sampled at `now`. A bad exchange keeps the last
    /// sample of whoever is not known to have taken part, lets it age and is counted; the interlocks decide.
    pub fn exchange(&mut self, now: Duration) {
        self.pace.tick(now);
        let answer = self.bus.exchange(now, &mut self.image);
        let good = matches!(&answer, Ok(x) if x.working_counter == x.expected);
        self.working_counter = answer.map_or(0, |x| x.working_counter);
        if let (true, Some(phase)) = (good, &mut self.phase) {
            phase.follow(self.bus.lateness_ns());
        }
        self.recent_bad = (self.recent_bad << 1) | u128::from(!good);
        self.bad_in_row = if good { 0 } else { self.bad_in_row + 1 };
        for axis in 0..self.drives.len() {
            // A station that stays out must not hide where the other axes are while they are being stopped.
            if good || self.bus.took_part(self.drives[axis].settings().station) {
                self.actuals[axis] = self.drives[axis].decode(&self.image.inputs);
                self.age_ticks[axis] = 0;
            } else {
                self.age_ticks[axis] = self.age_ticks[axis].saturating_add(self.pace.passed());
            }
        }
        self.poll_heat_sinks(now);
        if let Some(stop) = &mut self.emergency_stop {
            stop.poll(&mut self.ports, now);
        }
        self.devices.poll(&mut self.ports, now);
        self.instruments.poll(&mut self.ports, now);
        let seen = self.gimbal.map(|gimbal| gimbal.both().map(|axis| &self.actuals[axis]));
        self.feedback.update(self.devices.rate_sensor(), seen, self.pace.passed());
        self.reckon();
    }

    fn reckon(&mut self) {
        for axis in 0..self.reckoned.len() {
            // Without a gyro an angle whose encoder is not believed stays where it was.
            let gyro_rad_per_s = self.gyro_place(axis).map_or(0.0, |place| self.feedback.rad_per_s(place));
            let passed_s = f64::from(self.pace.passed()) * self.axes[axis].drive.cycle_s;
            self.reckoned[axis].take(&self.actuals[axis], gyro_rad_per_s, passed_s);
        }
    }

    /// Tells what stations of the bus have said by themselves since this was last called.
    pub fn tell_notices(&mut self, tell: &mut dyn FnMut(Notice)) {
        self.bus.tell_notices(tell);
    }

    /// Which of the axes are outer and inner axis of the gimbal.
    pub fn gimbal(&self) -> Option<Gimbal> {
        self.gimbal
    }

    /// Place of an axis among the rates of the inertial unit; `None` for an axis whose rate it does not see.
    fn gyro_place(&self, axis: usize) -> Option<usize> {
        self.gimbal?.place_of(axis)
    }

    /// Periods since the exchange before this one: 1, and more where the loop missed some.
    pub fn passed_periods(&self) -> u32 {
        self.pace.passed()
    }

    /// Steps that the control laws take in this tick, so that their integrals and filters follow time: one for every
    /// period that has passed, up to what the drives' watchdogs let pass.
    pub fn law_steps(&self) -> u32 {
        self.pace.steps()
    }

    /// Sends the mirror to its middle from the next tick on.
    pub fn rest_mirror(&mut self) {
        self.devices.command_mirror([0.0; 2]);
    }

    /// One tick of the track loops; rates of outer and inner axis. The mirror is told at once, and goes back to its
    /// middle when its loop opens.
    pub fn track(&mut self, closed: Closed, now: Duration) -> Asked {
        let mirror_rad = self.devices.mirror_rad();
        let rate_rad_per_s =
            self.gimbal.map_or([0.0; 2], |gimbal| gimbal.both().map(|axis| self.feedback(axis).0));
        let seen = Seen {
            now,
            frames: self.devices.trackers(),
            rate_rad_per_s,
            elevation_rad: self.gimbal.map_or(0.0, |gimbal| self.actuals[gimbal.inner].position_rad),
            mirror_rad,
            steps: self.pace.steps(),
        };
        let was_fine = self.tracking.closed().fine;
        let asked = self.tracking.update(closed, &seen);
        match asked.mirror_rad {
            Some(mirror_rad) => self.devices.command_mirror(mirror_rad),
            None if was_fine => self.devices.command_mirror([0.0; 2]),
            None => {}
        }
        self.devices.log_tracking(self.tracking.row());
        asked
    }

    /// The track loops.
    pub fn tracking(&self) -> &Tracking {
        &self.tracking
    }

    /// Whether every velocity loop has a valid sample to be closed on.
    pub fn feedback_is_valid(&self) -> bool {
        (0..self.axes.len()).all(|axis| self.feedback(axis).1 <= FEEDBACK_AGE_TICKS)
    }

    /// Gyro rate less encoder rate of an axis, smoothed; 0 where its loop is closed on the encoder.
    pub fn feedback_disagreement(&self, axis: usize) -> f64 {
        match (self.axes[axis].velocity_feedback, self.gyro_place(axis)) {
            (VelocityFeedback::Gyro, Some(place)) => self.feedback.disagreement_rad_per_s(place),
            _ => 0.0,
        }
    }

    /// Time of the first tick: the dialogues that opened the devices lie before it.
    pub fn ready(&self) -> Duration {
        self.ready
    }

    /// Devices that are polled in the tick.
    pub fn devices(&self) -> &Devices {
        &self.devices
    }

    /// Devices that are polled in the tick, for their commands and their rows.
    pub fn devices_mut(&mut self) -> &mut Devices {
        &mut self.devices
    }

    /// Instruments on the bench.
    pub fn instruments(&self) -> &Instruments {
        &self.instruments
    }

    /// Instruments of the rig, for their tasks and their rows.
    pub fn instruments_mut(&mut self) -> &mut Instruments {
        &mut self.instruments
    }

    /// The first device or instrument that failed, and why.
    pub fn failure(&self) -> Option<&DeviceError> {
        self.devices.failure().or(self.instruments.failure())
    }

    /// Begins the task of a segment, if it has one that has not begun.
    pub fn begin_task(&mut self, segment: usize, now: Duration) {
        if self.instruments.begin(segment, &mut self.ports, now) {
            self.synchronise(now, false);
        }
    }

    /// Whatever an instrument does ends, and the synchronisation signal with it.
    pub fn stop_instruments(&mut self, now: Duration) {
        self.instruments.stop(&mut self.ports, now);
        self.synchronise(now, false);
    }

    /// Raises the synchronisation signal of the oscilloscope, or lets it fall.
    pub fn synchronise(&mut self, now: Duration, high: bool) {
        self.devices.synchronise(&mut self.ports, now, high);
    }

    /// Readies every task that a point has for instruments.
    ///
    /// # Errors
    /// A task for an instrument that the rig lacks, or that the instrument cannot do.
    pub fn ready_tasks(&self, case: &Case) -> Result<Tasks, DeviceError> {
        let pair = self.gimbal.map_or([0, 1], Gimbal::both);
        let probed = pair.map(|axis| self.axes.get(axis).map(|axis| axis.name.clone()));
        self.instruments.preparer().ready(case, &probed)
    }

    /// Takes the readied tasks of a point; those of the point before go where these were.
    pub fn take_tasks(&mut self, tasks: &mut Tasks) {
        self.instruments.take(tasks);
    }

    /// The rate that the velocity loop of an axis is closed on, and the age in periods of the sample it is from.
    pub fn feedback(&self, axis: usize) -> (f64, u32) {
        let by_encoder = self.actuals[axis].velocity_rad_per_s;
        match (self.axes[axis].velocity_feedback, self.gyro_place(axis)) {
            (VelocityFeedback::Encoder, _) | (_, None) => (by_encoder, self.age_ticks[axis]),
            // Without a valid gyro the loop goes on with the encoder: the interlock on its age stops the axis.
            (VelocityFeedback::Gyro, Some(place)) => {
                let age = self.feedback.age_ticks();
                let by_gyro = self.feedback.rad_per_s(place);
                if age <= FEEDBACK_AGE_TICKS { (by_gyro, age) } else { (by_encoder, age) }
            }
        }
    }

    /// Periods for which whatever the velocity loop of an axis is closed on has sent nothing valid.
    pub fn feedback_silent_ticks(&self, axis: usize) -> u32 {
        match self.axes[axis].velocity_feedback {
            VelocityFeedback::Encoder => self.age_ticks[axis],
            VelocityFeedback::Gyro => self.feedback.silent_ticks(),
        }
    }

    /// Puts an axis command into the image of the next exchange; returns the torque that really goes out, N·m.
    pub fn command(&mut self, axis: usize, controlword: u16, torque_nm: f64) -> f64 {
        self.controlwords[axis] = controlword;
        let command =
            DriveCommand { controlword, mode: CyclicMode::Torque, torque_nm, velocity_rad_per_s: 0.0 };
        self.drives[axis].encode(&command, &mut self.image.outputs)
    }

    /// Commands a velocity to the drive's own loop; returns the torque that the drive shows, N·m.
    pub fn command_velocity(&mut self, axis: usize, controlword: u16, velocity_rad_per_s: f64) -> f64 {
        self.controlwords[axis] = controlword;
        let command = DriveCommand {
            controlword,
            mode: CyclicMode::Velocity,
            torque_nm: self.actuals[axis].torque_nm,
            velocity_rad_per_s,
        };
        self.drives[axis].encode(&command, &mut self.image.outputs);
        self.actuals[axis].torque_nm
    }

    /// The controlword of this tick on an axis' way to a power state.
    ///
    /// # Errors
    /// When the drive is in fault or too slow.
    pub fn controlword(
        &mut self,
        axis: usize,
        target: PowerTarget,
        now: Duration,
    ) -> Result<u16, DeviceError> {
        let Actuals { statusword, error_code, .. } = self.actuals[axis];
        self.drives[axis].controlword(target, statusword, error_code, now)
    }

    /// Asks the bus for a state.
    pub fn request(&mut self, state: BusState) {
        self.bus.request(state);
    }

    /// The lowest bus state of all stations.
    pub fn bus_state(&self) -> BusState {
        self.bus.state()
    }

    /// Newest sample of an axis.
    pub fn actuals(&self, axis: usize) -> &Actuals {
        &self.actuals[axis]
    }

    /// Whether the newest sample of an axis is younger than the rig calls stale.
    pub fn is_fresh(&self, axis: usize) -> bool {
        let (axis, age_ticks) = (&self.axes[axis], self.age_ticks[axis]);
        f64::from(age_ticks) * axis.drive.cycle_s <= axis.guard.safety.watchdog_s
    }

    /// Periods since that sample was taken, missed ones counted; the largest number before the first.
    pub fn age_ticks(&self, axis: usize) -> u32 {
        self.age_ticks[axis]
    }

    /// The controlword that goes out with the next exchange.
    pub fn last_controlword(&self, axis: usize) -> u16 {
        self.controlwords[axis]
    }

    /// The axes' part of the rig file.
    pub fn axes(&self) -> &[RigAxis] {
        &self.axes
    }

    /// Whether the emergency stop chain is open by the input of a terminal.
    pub fn emergency_stop_is_open(&self) -> bool {
        self.emergency_stop.is_some_and(|stop| stop.is_open())
    }

    /// Working counter of the last exchange.
    pub fn working_counter(&self) -> u16 {
        self.working_counter
    }

    /// Bad exchanges in a row, and among the last hundred.
    pub fn bad_exchanges(&self) -> (u32, u32) {
        (self.bad_in_row, (self.recent_bad & ((1 << 100) - 1)).count_ones())
    }
}
