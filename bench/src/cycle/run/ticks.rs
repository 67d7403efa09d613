//! Time in the loop, and what goes into the log with it.

use std::ops::Range;
use std::time::Duration;

use drivers::device::DeviceError;
use procedures::log::{LatenessHistogram, Stall, StopManner};

use super::means::Means;
use super::{Conditions, row};
use crate::cycle::interlock::{self, Situation, Trip, Watch, per_axis};
use crate::cycle::recorder::{Item, LoopEvent, MAX_CHANNELS, Recorder};
use crate::cycle::sequence::Sequencer;
use crate::cycle::stops::Stops;
use crate::realtime::{Woken, wake};
use crate::rig::ArmedRig;
use crate::rig::device::LookedAt;

/// The loop's time, its interlocks, its stops.
pub(super) struct Ticks<'a> {
    pub(super) conditions: Conditions<'a>,
    pub(super) watch: Watch,
    pub(super) period: Duration,
    pub(super) start: Duration,
    pub(super) due: Duration,
    pub(super) now: Duration,
    pub(super) count: u64,
    started: bool,
    missed: u32,
    pub(super) missed_since_row: u32,
    /// How late its ticks came so far.
    lateness: LatenessHistogram,
    /// Periods that were missed before this tick, until the log knows it.
    stall: Option<Stall>,
    /// Stalls that the log may still be told.
    stalls_left: u32,
    /// The longest stall that the log was told, s.
    longest_told_s: f64,
    means: Means,
    /// The one axis that moves: the others only hold, and are logged as seldom as the payload.
    alone: Option<usize>,
    looked_at: LookedAt,
    /// When an axis moved last on the way to the safe state.
    pub(super) moved: Option<Duration>,
    /// Whether the last tick was kept as it was.
    was_evidence: bool,
    rows_since_payload: u64,
    pub(super) stops: Stops,
    ring_told: bool,
    failure_told: bool,
    /// Whether the events belong to no point.
    is_untold: bool,
    /// Trips that stand in the log already, as interlock and axis: what was seen does not vanish in one tick.
    told: [Option<(&'static str, Option<usize>)>; MOST_TRIPS],
    /// In this tick a sensor has turned out to be wrong.
    pub(super) learned: bool,
}

impl<'a> Ticks<'a> {
    pub(super) fn new(conditions: Conditions<'a>, axes: usize) -> Self {
        let case = conditions.case;
        let moving = conditions.moving;
        let period = Duration::from_secs_f64(1.0 / conditions.loop_rate_hz);
        Self {
            conditions,
            watch: Watch::new(period.as_secs_f64())
                .keeping_out_of(case.fence.as_ref().map_or(&[], |fence| &fence.zones)),
            period,
            start: Duration::ZERO,
            due: Duration::ZERO,
            now: Duration::ZERO,
            count: 0,
            started: false,
            missed: 0,
            missed_since_row: 0,
            lateness: LatenessHistogram::default(),
            stall: None,
            stalls_left: MOST_STALLS,
            longest_told_s: 0.0,
            means: Means::default(),
            looked_at: LookedAt::by(case),
            alone: (!case.logs_all_axes()).then_some(moving),
            moved: None,
            was_evidence: false,
            rows_since_payload: 0,
            stops: Stops::new(axes),
            ring_told: false,
            failure_told: false,
            is_untold: false,
            told: [None; MOST_TRIPS],
            learned: false,
        }
    }

    /// The first tick is due at `start`.
    pub(super) fn begin(&mut self, start: Duration) {
        (self.start, self.due, self.now) = (start, start, start);
    }

    /// The next tick is due at `due`: others had the rig meanwhile.
    pub(super) fn resume(&mut self, due: Duration) {
        (self.due, self.started) = (due, false);
    }

    /// Log time of the first tick.
    pub(super) fn set_log_start(&mut self, log_start_ns: u64) {
        self.conditions.log_start_ns = log_start_ns;
    }

    /// From now on events belong to no point: only what goes wrong is told.
    pub(super) fn leave_untold(&mut self) {
        self.is_untold = true;
    }

    /// Forgets which trips stand in the log: what happens from now on is told again.
    pub(super) fn forget_trips(&mut self) {
        self.told = [None; MOST_TRIPS];
        self.moved = None;
    }

    /// Waits for the next tick. Missed periods are skipped, never caught up.
    pub(super) fn next(&mut self) {
        if self.started {
            self.due += self.period;
        }
        self.started = true;
        let woken = wake(&self.conditions.clock, self.due, self.period);
        self.missed = woken.missed_periods;
        self.take(&woken);
    }

    /// A tick has come: notes its time, and how late it is.
    pub(super) fn take(&mut self, woken: &Woken) {
        (self.now, self.due) = (woken.now, woken.due);
        let missed_periods = woken.missed_periods;
        self.lateness.count(woken.late, missed_periods);
        self.missed_since_row = self.missed_since_row.saturating_add(missed_periods);
        let length_s = woken.late.as_secs_f64();
        self.stall = (missed_periods > 0).then_some(Stall { length_s, missed_periods });
    }

    /// Tells the log of a stall before this tick. A loop that stalls all the time tells only the first stalls, and later ones that
    /// are longer than all before.
    fn tell_stall(&mut self, recorder: &mut Recorder) {
        let Some(stall) = self.stall.take() else { return };
        if self.stalls_left == 0 && stall.length_s <= self.longest_told_s {
            return;
        }
        self.stalls_left = self.stalls_left.saturating_sub(1);
        self.longest_told_s = self.longest_told_s.max(stall.length_s);
        self.tell(recorder, LoopEvent::Stall { point: self.conditions.point, stall });
    }

    /// Tells which device has failed first, and how those are heard that send messages by themselves.
    fn tell_devices(&mut self, rig: &mut ArmedRig, recorder: &mut Recorder) {
        let point = self.conditions.point;
        if let Some(error) = rig.failure().filter(|_| !self.failure_told) {
            let error = Box::new(error.clone());
            self.failure_told = true;
            self.tell(recorder, LoopEvent::DeviceFailed { point, error });
        }
        let (looked_at, now) = (self.looked_at, self.now);
        rig.devices_mut().tell_silence(looked_at, now, |device, news| {
            self.tell(recorder, LoopEvent::Heard { point, device, news });
        });
    }

    /// Tells what the lines of devices have lost in the point.
    pub(super) fn tell_losses(&self, rig: &ArmedRig, recorder: &mut Recorder) {
        let point = self.conditions.point;
        rig.devices().tell_losses(self.looked_at, self.now, |device, news| {
            self.tell(recorder, LoopEvent::Heard { point, device, news });
        });
    }

    /// What is wrong with the sensor that an interlock has missed; `None` for an interlock on anything else.
    pub(super) fn cause(&self, trip: &Trip, rig: &ArmedRig) -> Option<DeviceError> {
        let is_of_sensor =
            [interlock::RATE_FEEDBACK.name, interlock::TRACKER_LOST.name].contains(&trip.interlock);
        rig.devices().silence(self.looked_at, self.now).filter(|_| is_of_sensor)
    }

    /// Tells how late the ticks came; virtual time has nothing to tell.
    pub(super) fn tell_lateness(&self, recorder: &mut Recorder) {
        if !self.conditions.clock.is_virtual() {
            let event = LoopEvent::Lateness { point: self.conditions.point, histogram: self.lateness };
            self.tell(recorder, event);
        }
    }

    /// A point that lasts longer than everything planned for it hangs somewhere.
    pub(super) fn overrun(&self, sequencer: &Sequencer<'_>) -> bool {
        const POWER_UP_AND_STOPS_S: f64 = 30.0;
        let planned_s = self.conditions.case.planned_s() + sequencer.off_plan_s(self.now);
        (self.now - self.start).as_secs_f64() > planned_s + POWER_UP_AND_STOPS_S
    }

    /// The first interlock that trips in this tick, in whatever state the loop is.
    pub(super) fn first_out(
        &mut self,
        rig: &mut ArmedRig,
        sequencer: Option<&Sequencer<'_>>,
        recorder: &mut Recorder,
        latched: Option<&Trip>,
    ) -> Option<Trip> {
        self.tell_stall(recorder);
        let point = self.conditions.point;
        rig.tell_notices(&mut |notice| self.tell(recorder, LoopEvent::Noticed { point, notice }));
        self.tell_devices(rig, recorder);
        let real_time = recorder.keeps() && !recorder.waits();
        let ring_ratio = if real_time { recorder.ring_ratio() } else { 0.0 };
        if ring_ratio > 0.5 && !self.ring_told {
            self.ring_told = true;
            self.tell(recorder, LoopEvent::RingHalfFull { point: self.conditions.point });
        }
        let count = rig.axes().len();
        let situation = Situation {
            waits_for_inputs: sequencer.is_some_and(Sequencer::waits_for_inputs),
            expects_operation: sequencer.is_some_and(Sequencer::expects_operation),
            // A stop is closed on the encoder, and on the gyro where that is not believed.
            uses_feedback: sequencer
                .is_some_and(|s| s.uses_feedback() || s.expects_operation() && rig.distrusts_an_encoder()),
            following_error_rad: per_axis(count, |axis| sequencer?.following_error_rad(axis)),
            sent_nm: per_axis(count, |axis| sequencer.map_or(0.0, |s| s.axis_loop(axis).sent_nm())),
            bounds: self.conditions.case.bounds,
            target_missing_s: rig.tracking().missing_s(self.now),
            missed_periods: self.missed,
            max_missed_periods: self.conditions.max_missed_periods,
            // In virtual time the loop waits for the writer.
            ring_ratio,
            // The writer may be silent, on a disk that stalls, for as long as the ring takes what it does not.
            silent_s: 0.0,
        };
        let trip = self.watch.tick(rig, &situation, latched);
        self.learned = false;
        // Where nothing has tripped there is nothing to be learned.
        let axes = if trip.is_some() || latched.is_some() { rig.axes().len() } else { 0 };
        for axis in 0..axes {
            self.learned |= self.learn(axis, rig, &situation);
            self.learned |= rig.is_over_voltage(axis) && rig.spare_link();
        }
        trip
    }

    /// What the interlocks say of sensors and torque, whichever of them was first: a stop must know it. Gives whether a
    /// sensor is not believed any more that was.
    fn learn(&self, axis: usize, rig: &mut ArmedRig, situation: &Situation) -> bool {
        let sees = |interlock| self.watch.sees(rig, situation, axis, interlock);
        // What no motor can do, and the gyro does not see: it is the encoder that is wrong.
        let jumps = rig.gyro_contradicts(axis) && sees(&interlock::ACCELERATION);
        let encoder = jumps || sees(&interlock::FROZEN_ENCODER);
        let torque = sees(&interlock::UNCOMMANDED_TORQUE) || sees(&interlock::RUNAWAY);
        let gyro = sees(&interlock::FROZEN_GYRO) || sees(&interlock::RATE_FEEDBACK);
        let encoder = encoder && rig.distrust_encoder(axis);
        let gyro = gyro && rig.distrust_gyro();
        if torque {
            rig.forbid_torque(axis);
        }
        encoder || gyro
    }

    /// Tells a trip, each one once.
    pub(super) fn tell_trip(&mut self, recorder: &mut Recorder, trip: Trip) {
        let this = Some((trip.interlock, trip.axis));
        if self.told.contains(&this) {
            return;
        }
        if let Some(free) = self.told.iter_mut().find(|told| told.is_none()) {
            *free = this;
            self.tell(recorder, LoopEvent::Tripped { point: self.conditions.point, trip });
        }
    }

    /// A stop begins in this tick, with the deceleration of each axis.
    pub(super) fn stops(&mut self, manner: StopManner, rig: &ArmedRig, deceleration: impl Fn(usize) -> f64) {
        self.stops.begin(manner, self.now, rig, deceleration);
    }

    pub(super) fn time_ns(&self) -> u64 {
        self.conditions.log_start_ns + u64::try_from((self.now - self.start).as_nanos()).unwrap_or(u64::MAX)
    }

    /// Tells an event; of a way that no plan has, only what went wrong and how late its ticks came.
    pub(super) fn tell(&self, recorder: &mut Recorder, event: LoopEvent) {
        let goes_wrong = matches!(
            event,
            LoopEvent::Tripped { .. }
                | LoopEvent::Stopped { .. }
                | LoopEvent::RingHalfFull { .. }
                | LoopEvent::Stall { .. }
                | LoopEvent::Noticed { .. }
                | LoopEvent::DeviceFailed { .. }
                | LoopEvent::Heard { .. }
                | LoopEvent::Lateness { .. }
        );
        if self.is_untold && !goes_wrong {
            return;
        }
        recorder.push(Item::Event { time_ns: self.time_ns(), event });
    }

    pub(super) fn row(
        &mut self,
        rig: &mut ArmedRig,
        sequencer: Option<&Sequencer<'_>>,
        recorder: &mut Recorder,
    ) {
        if !recorder.keeps() {
            return;
        }
        let segment = sequencer.and_then(Sequencer::excited_segment);
        if segment.is_some() && segment != self.means.segment {
            // Rows begin with an excitation: what was gathered before it is a row of its own.
            self.axis_rows(0..rig.axes().len(), recorder);
        }
        self.means.segment = segment;
        let is_evidence = self.is_evidence(rig, sequencer.is_none());
        if is_evidence && !self.was_evidence {
            // What was gathered at rest is no part of the first tick of a stop.
            self.axis_rows(0..rig.axes().len(), recorder);
        }
        self.was_evidence = is_evidence;
        let time_ns = self.time_ns();
        let mut values = [0.0; MAX_CHANNELS];
        for axis in 0..rig.axes().len() {
            row::axis(rig, axis, sequencer, &mut values);
            self.means.add(axis, &values);
            if is_evidence {
                recorder.push_stop(axis, time_ns, values);
            }
        }
        self.means.ends(time_ns);
        if self.means.ticks() < self.conditions.log_every {
            return;
        }
        self.rows_since_payload += 1;
        let with_payload = self.rows_since_payload >= self.conditions.log_payload_every;
        // A log at the rate of the loop has every tick of every axis.
        let thins = self.conditions.log_every > 1 && !with_payload && sequencer.is_some();
        match self.alone.filter(|_| thins) {
            Some(axis) => self.axis_rows(axis..axis + 1, recorder),
            None => self.axis_rows(0..rig.axes().len(), recorder),
        }
        let mut topic = rig.axes().len() as u8;
        // In thinned logs the loop itself is as seldom as the payload, unless it missed something.
        if with_payload || self.conditions.log_every == 1 || self.missed_since_row > 0 || sequencer.is_none()
        {
            row::of_loop(rig, sequencer, self, &mut values);
            recorder.push(Item::Row { topic, time_ns, values });
            self.missed_since_row = 0;
        }
        if with_payload {
            self.rows_since_payload = 0;
            rig.devices_mut().rows(&mut values, self.looked_at, |values| {
                topic += 1;
                if let Some(&values) = values {
                    recorder.push(Item::Row { topic, time_ns, values });
                }
            });
        }
    }

    /// Whether every tick is kept: a stop, until the axes have stood for a while, and what follows a trip. Logs at the rate of the
    /// loop have every tick anyway.
    fn is_evidence(&mut self, rig: &ArmedRig, leaving: bool) -> bool {
        if !leaving || self.conditions.log_every == 1 {
            return false;
        }
        if !(0..rig.axes().len()).all(|axis| rig.believed(axis).stands()) {
            self.moved = Some(self.now);
        }
        let lingers = |moved: Duration| self.now.saturating_sub(moved) <= LINGERS;
        self.told[0].is_some() || self.moved.is_some_and(lingers)
    }

    /// Rows of axes over all ticks since their last ones.
    pub(super) fn axis_rows(&mut self, axes: Range<usize>, recorder: &mut Recorder) {
        for axis in axes {
            if let Some((time_ns, values)) = self.means.take(axis) {
                recorder.push(Item::Row { topic: axis as u8, time_ns, values });
            }
        }
        self.means.clear();
    }

    /// What instruments measured: whether and how fast devices are logged does not matter here.
    pub(super) fn instrument_rows(&self, rig: &mut ArmedRig, recorder: &mut Recorder) {
        let topics = rig.devices().groups_count() + rig.axes().len() + 1;
        let time_ns = self.time_ns();
        let mut values = [0.0; MAX_CHANNELS];
        rig.instruments_mut().rows(|instrument, row| {
            let topic = (topics + instrument) as u8;
            values[..row.len()].copy_from_slice(row);
            recorder.push(Item::Row { topic, time_ns, values });
        });
    }
}

/// So long every tick is kept after the axes have come to rest.
const LINGERS: Duration = Duration::from_millis(100);

/// More stalls than these say nothing new about a point, unless they are longer.
const MOST_STALLS: u32 = 1000;

/// More trips than these say nothing new about a point.
const MOST_TRIPS: usize = 16;
