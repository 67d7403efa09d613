//! The director as its control computer has it: wires and production drivers.

use std::time::Duration;

use drivers::cia402::{
    self, Cia402, CyclicMode, DriveCommand, DriveSettings, PowerState, PowerTarget, Waiting,
};
use drivers::device::DeviceError;
use drivers::kvh::{Format, Kvh, KvhSettings, Opening, Synchronisation};
use drivers::mirror::{self, Mirror, MirrorSettings, Path};
use drivers::tracker::{self, DeclaredDelay, Source, Tracker, TrackerSettings};
use drivers::wire::{AnalogPort, BusState, ByteLine, DatagramPort, Fieldbus, ProcessImage};
use sim_devices::physics::noise::SeedAddress;
use sim_devices::rig::{SimulatedRig, StartState};
use sim_devices::unit::{AxisSettings, CameraSettings, UnitSettings};

use super::Row;

/// Tick of the control computer.
const TICK: Duration = Duration::from_micros(250);
/// Longer than any dialogue or power transition takes.
const PATIENCE: Duration = Duration::from_secs(3);

/// What the laws ask for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Commands {
    pub(super) torque_nm: [f64; 2],
    pub(super) mirror_rad: [f64; 2],
}

/// What the drivers decoded in one tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensed {
    pub(super) now: Duration,
    pub(super) drives: [cia402::Actuals; 2],
    pub(super) body_rad_per_s: [f64; 3],
    pub(super) mirror: mirror::Actuals,
    /// With whether the frame is new.
    pub(super) coarse: (tracker::Actuals, bool),
    pub(super) fine: (tracker::Actuals, bool),
}

/// Everything open, both drives enabled.
pub(super) struct Director {
    rig: SimulatedRig,
    bus: Box<dyn Fieldbus>,
    image: ProcessImage,
    drives: [Cia402; 2],
    lines: Lines,
    imu: Kvh,
    mirror: Mirror,
    coarse: Tracker,
    fine: Tracker,
    now: Duration,
}

struct Lines {
    imu: Box<dyn ByteLine>,
    mirror: Box<dyn ByteLine>,
    analog: Box<dyn AnalogPort>,
    coarse: Box<dyn DatagramPort>,
    fine: Box<dyn DatagramPort>,
}

impl Director {
    /// Opens every device, then enables both drives at zero torque.
    pub(super) fn open(
        unit: &UnitSettings,
        address: &SeedAddress,
        start: StartState,
    ) -> Result<Self, DeviceError> {
        let rig = SimulatedRig::new(unit, address, start);
        let mut lines = Lines {
            imu: rig.imu_line(),
            mirror: rig.mirror_line(),
            analog: rig.analog_card(),
            coarse: rig.coarse_port(),
            fine: rig.fine_port(),
        };
        let mut now = Duration::ZERO;
        let mut opening = Opening::new(imu_settings())?;
        let imu = converse(&mut now, "imu", |at| opening.poll(&mut *lines.imu, at))?;
        let mut mirror = Mirror::new(mirror_settings(unit))?;
        converse(&mut now, "mirror", |at| mirror.configure(&mut *lines.mirror, at))?;
        let mut bus = rig.bus();
        let mut open = |name: &str, station: u16, unit: &AxisSettings| {
            // A simulated mailbox answers at once.
            let mut waiting = Waiting { now, pause: &mut || now };
            Cia402::open(&mut *bus, drive_settings(name, station, unit), &mut waiting).map(|opened| opened.0)
        };
        let az = open("az", 1, &unit.az)?;
        let el = open("el", 2, &unit.el)?;
        let (image, slots) = bus.map()?;
        let mut drives = [az, el];
        for (drive, (_, slot)) in drives.iter_mut().zip(&slots) {
            drive.attach(slot.clone());
        }
        let coarse = Tracker::new(tracker_settings("coarse", Source::Coarse, &unit.trackers.coarse))?;
        let fine = Tracker::new(tracker_settings("fine", Source::Fine, &unit.trackers.fine))?;
        let mut director = Self { rig, bus, image, drives, lines, imu, mirror, coarse, fine, now };
        director.enable()?;
        Ok(director)
    }

    fn enable(&mut self) -> Result<(), DeviceError> {
        self.bus.request(BusState::SafeOp);
        self.exchange(&Commands::default())?;
        self.bus.request(BusState::Op);
        let until = self.now + PATIENCE;
        loop {
            self.wait();
            let drives = self.exchange(&Commands::default())?.drives;
            if drives.iter().all(|seen| PowerState::of(seen.statusword) == PowerState::OperationEnabled) {
                self.wait();
                return Ok(());
            }
            if self.now > until {
                return Err(silent("drives"));
            }
        }
    }

    /// One tick at its due time: sends the commands of the tick before, takes what the devices say.
    pub(super) fn exchange(&mut self, commands: &Commands) -> Result<Sensed, DeviceError> {
        let now = self.now;
        let mut drives = [cia402::Actuals::default(); 2];
        for (k, drive) in self.drives.iter_mut().enumerate() {
            let last = drive.decode(&self.image.inputs);
            let target = PowerTarget::Enabled;
            let controlword = drive.controlword(target, last.statusword, last.error_code, now)?;
            let mode = CyclicMode::Torque;
            let torque_nm = commands.torque_nm[k];
            let command = DriveCommand { controlword, mode, torque_nm, velocity_rad_per_s: 0.0 };
            drive.encode(&command, &mut self.image.outputs);
        }
        self.bus.exchange(now, &mut self.image)?;
        for (actuals, drive) in drives.iter_mut().zip(&mut self.drives) {
            *actuals = drive.decode(&self.image.inputs);
        }
        self.imu.poll(&mut *self.lines.imu, now)?;
        let line = &mut *self.lines.mirror;
        let analog = &mut *self.lines.analog;
        let mirror = self.mirror.exchange(line, analog, commands.mirror_rad, now)?;
        Ok(Sensed {
            now,
            drives,
            body_rad_per_s: self.imu.valid_sample().map_or([0.0; 3], |sample| sample.rate_rad_per_s),
            mirror,
            coarse: self.coarse.poll(&mut *self.lines.coarse, now)?,
            fine: self.fine.poll(&mut *self.lines.fine, now)?,
        })
    }

    /// The next tick is due.
    pub(super) fn wait(&mut self) {
        self.now += TICK;
    }

    /// When the next tick is due.
    pub(super) fn now(&self) -> Duration {
        self.now
    }

    /// What really is now.
    pub(super) fn row(&self, sensed: &Sensed, locked: bool) -> Row {
        let (truth, mirror_rad) = self.rig.truth();
        let encoder_rad = sensed.drives.map(|drive| drive.position_rad);
        Row { time_s: self.now.as_secs_f64(), truth, mirror_rad, encoder_rad, locked }
    }
}

/// Calls every millisecond until there is an answer.
fn converse<T>(
    now: &mut Duration,
    device: &str,
    mut ask: impl FnMut(Duration) -> Result<Option<T>, DeviceError>,
) -> Result<T, DeviceError> {
    let until = *now + PATIENCE;
    while *now < until {
        if let Some(answer) = ask(*now)? {
            return Ok(answer);
        }
        *now += 4 * TICK;
    }
    Err(silent(device))
}

fn silent(device: &str) -> DeviceError {
    DeviceError::Bus { device: device.to_owned(), reason: format!("not ready within {PATIENCE:?}") }
}

fn drive_settings(name: &str, station: u16, axis: &AxisSettings) -> DriveSettings {
    DriveSettings {
        name: name.into(),
        station,
        profile: bench::files::profile::simulated(),
        torque_constant_nm_per_a: axis.torque_constant_nm_per_a,
        rated_current_a: axis.rated_current_a,
        rated_torque_nm: axis.rated_torque_nm,
        max_torque_nm: axis.torque_constant_nm_per_a * axis.current_limit_a,
        encoder_counts_per_rev: 1 << axis.encoder_bits_count as u32,
        encoder_offset_rad: axis.encoder_zero_rad,
        encoder_sign: axis.encoder_sign_factor,
        soft_limits_rad: [axis.lower_stop_rad, axis.upper_stop_rad],
        max_velocity_rad_per_s: 1.2,
        quick_stop_deceleration_rad_per_s2: 1.5,
        quick_stop_option: 6,
        fault_reaction_option: 2,
        abort_connection_option: 1,
        watchdog_s: 0.02,
        cycle_s: TICK.as_secs_f64(),
        transition_timeout_s: 2.0,
    }
}

fn imu_settings() -> KvhSettings {
    KvhSettings {
        name: "imu".into(),
        baud: 4_147_200,
        format: Format::A,
        synchronisation: Synchronisation::External,
        message_rate_hz: 1.0 / TICK.as_secs_f64(),
        rate_output: true,
        answer_timeout_s: 0.1,
    }
}

fn mirror_settings(unit: &UnitSettings) -> MirrorSettings {
    MirrorSettings {
        name: "fsm".into(),
        scale_rad_per_v: unit.mirror.scale_rad_per_v,
        stroke_rad: unit.mirror.stroke_rad,
        command: Path::Analog,
        feedback: Path::Analog,
        command_outputs: [0, 1],
        feedback_inputs: [0, 1],
        reply_timeout_s: 0.01,
    }
}

/// The map of the camera, inverted: both are permutations with signs, whose inverse is the transpose.
fn tracker_settings(name: &str, source: Source, camera: &CameraSettings) -> TrackerSettings {
    TrackerSettings {
        name: name.into(),
        source,
        ifov_rad: [camera.ifov_x_rad, camera.ifov_y_rad],
        map: [
            [camera.x_of_cross_elevation_ratio, camera.y_of_cross_elevation_ratio],
            [camera.x_of_elevation_ratio, camera.y_of_elevation_ratio],
        ],
        declared_delay: DeclaredDelay { delay_s: camera.latency_s, u_s: 0.0 },
        poll_period: TICK,
    }
}
