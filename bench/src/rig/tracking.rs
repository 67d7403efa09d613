//! Track loops in the tick: coarse tracker → rates of the axes, fine tracker → mirror, off-load from one to the other.
//!
//! The laws are those of production, put together as the control computer does it: the coarse law at 2 kHz, the fine one
//! with every tick. A frame is handed on once, with its age; between frames the gyros carry the line of sight on.

use std::time::Duration;

use controllers::camera::{Frame, TrackState};
use controllers::coarse_track::CoarseTracker;
use controllers::fine_track::FineTracker;
use controllers::keyhole::Keyhole;
use controllers::off_load::OffLoad;
use controllers::{DirectorGains, FineTrackGains};
use drivers::device::{Channel, Width};
use drivers::tracker::Actuals;
use procedures::case::{Mode, Segment};
use procedures::device::DeviceRole;

use crate::model::rig::{Gimbal, Rig};
use crate::rig::devices::tracker::FRAME_RATE;
use crate::rig::hearing::FRAMES_TO_LOSE;

/// Rate of the coarse law (study 4.5).
const LAW_RATE_HZ: f64 = 2000.0;

/// Which loops are closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Closed {
    /// Coarse tracker to the axes.
    pub coarse: bool,
    /// Fine tracker to the mirror.
    pub fine: bool,
    /// Mean mirror angle to the axes.
    pub off_load: bool,
}

impl Closed {
    /// The loops of a segment.
    pub fn of(segment: &Segment) -> Self {
        let tracks = segment.tracks.unwrap_or_default();
        let coarse = segment.mode == Mode::Track;
        Self { coarse, fine: tracks.fine, off_load: coarse && tracks.fine && tracks.off_load }
    }
}

/// What the laws see in a tick; pairs are azimuth, elevation.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Time of the tick.
    pub now: Duration,
    /// Newest frames of the coarse and the fine tracker.
    pub frames: &'a [Actuals; 2],
    /// Rates of the axes over the ground, by the gyros.
    pub rate_rad_per_s: [f64; 2],
    /// Elevation by the encoder of the inner axis.
    pub elevation_rad: f64,
    /// Angles of the mirror.
    pub mirror_rad: [f64; 2],
    /// Steps that the laws take in this tick, one for every period since the tick before.
    pub steps: u32,
}

/// What the laws ask for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Asked {
    /// Rates of azimuth and elevation; 0 without a target.
    pub rate_rad_per_s: [f64; 2],
    /// Angles of the mirror; `None` while the fine loop is open.
    pub mirror_rad: Option<[f64; 2]>,
}

/// Both track loops of both axes.
#[derive(Clone, Debug)]
pub struct Tracking {
    keyhole: Option<Keyhole>,
    coarse: [CoarseTracker; 2],
    fine: [FineTracker; 2],
    off_load: [Option<OffLoad>; 2],
    frame_s: [f64; 2],
    /// Settings of the fine loops, and their optical gains.
    fine_gains: FineTrackGains,
    optical: [f64; 2],
    period: Duration,
    law_ticks: u64,
    ticks: u64,
    closed: Closed,
    /// Stamp of the newest frame of each tracker, on its own clock.
    newest: [Duration; 2],
    /// When each tracker last showed the target, since its loop was closed.
    shown: [Option<Duration>; 2],
    locked_since: Option<Duration>,
    /// A coarse frame that came between two updates of its law.
    waiting: Option<Actuals>,
    wish_rad_per_s: [f64; 2],
    handed_rad_per_s: [f64; 2],
}

impl Tracking {
    /// What it logs, in the order of [`Tracking::row`].
    pub const CHANNELS: &'static [Channel] = &[
        channel("az_target_rad_per_s", "rad/s", Width::F64),
        channel("el_target_rad_per_s", "rad/s", Width::F64),
        channel("az_off_load_rad_per_s", "rad/s", Width::F64),
        channel("el_off_load_rad_per_s", "rad/s", Width::F64),
        channel("coarse_state", "", Width::I8),
        channel("fine_state", "", Width::I8),
        channel("az_saturated", "", Width::I8),
        channel("el_saturated", "", Width::I8),
    ];

    /// Open loops of a rig.
    pub fn new(rig: &Rig, gains: &DirectorGains) -> Self {
        let tick_s = 1.0 / rig.loop_rate_hz;
        let law_ticks = (rig.loop_rate_hz / LAW_RATE_HZ).round().max(1.0);
        let frame_s = [DeviceRole::CoarseTracker, DeviceRole::FineTracker].map(|role| {
            let rate_hz = rig.device(role).map_or(0.0, |tracker| tracker.number(FRAME_RATE));
            1.0 / rate_hz
        });
        let optical = [gains.fine.az_optical_gain, gains.fine.el_optical_gain];
        let coarse = rig.gimbal().map_or([0, 1], Gimbal::both).map(|axis| {
            let limit = rig.axes.get(axis).map_or(0.0, |axis| axis.limits.max_velocity_rad_per_s);
            CoarseTracker::new(&gains.axes[axis].track, &gains.track, limit, law_ticks * tick_s)
        });
        Self {
            keyhole: Keyhole::new(&gains.keyhole),
            coarse,
            fine: optical.map(|gain| FineTracker::new(&gains.fine, gain, frame_s[1], tick_s)),
            off_load: optical.map(|gain| OffLoad::new(&gains.off_load, gain, tick_s)),
            frame_s,
            fine_gains: gains.fine,
            optical,
            period: Duration::from_secs_f64(tick_s),
            law_ticks: law_ticks as u64,
            ticks: 0,
            closed: Closed::default(),
            newest: [Duration::ZERO; 2],
            shown: [None; 2],
            locked_since: None,
            waiting: None,
            wish_rad_per_s: [0.0; 2],
            handed_rad_per_s: [0.0; 2],
        }
    }

    /// Open loops that know nothing of any target, as in a rig that was just opened.
    pub fn begin_anew(&mut self) {
        self.closed = Closed::default();
        (self.newest, self.shown) = ([Duration::ZERO; 2], [None; 2]);
        (self.locked_since, self.waiting) = (None, None);
        (self.wish_rad_per_s, self.handed_rad_per_s) = ([0.0; 2], [0.0; 2]);
        self.ticks = 0;
    }

    /// The frame rate of the fine camera from now on; its loop is open.
    pub fn set_fine_frame_rate(&mut self, rate_hz: f64) {
        let frame_s = 1.0 / rate_hz;
        let tick_s = self.period.as_secs_f64();
        if frame_s == self.frame_s[1] {
            return;
        }
        self.frame_s[1] = frame_s;
        self.fine = self.optical.map(|gain| FineTracker::new(&self.fine_gains, gain, frame_s, tick_s));
    }

    /// One tick: loops that are to be closed and were not begin without a target.
    pub fn update(&mut self, closed: Closed, seen: &Seen<'_>) -> Asked {
        self.switch(closed, seen);
        if !(closed.coarse || closed.fine) {
            return Asked::default();
        }
        // A law takes the steps of missed periods first, as between two frames: what came belongs to the last one.
        for left in (1..seen.steps).rev() {
            let now = seen.now.saturating_sub(self.period * left);
            self.step(&Seen { now, ..*seen }, [None; 2]);
        }
        let fresh = [0, 1].map(|which| self.take(which, seen));
        self.step(seen, fresh)
    }

    fn step(&mut self, seen: &Seen<'_>, fresh: [Option<Actuals>; 2]) -> Asked {
        let closed = self.closed;
        let mirror_rad = closed.fine.then(|| self.follow_fine(seen, fresh[1]));
        let rate_rad_per_s = if closed.coarse { self.follow_coarse(seen, fresh[0]) } else { [0.0; 2] };
        self.ticks += 1;
        self.locked_since = self.has_target().then(|| self.locked_since.unwrap_or(seen.now));
        Asked { rate_rad_per_s, mirror_rad }
    }

    /// Which loops are closed.
    pub fn closed(&self) -> Closed {
        self.closed
    }

    /// Since when every closed loop has had its target without a break.
    pub fn locked_since(&self) -> Option<Duration> {
        self.locked_since
    }

    /// How long the target that the axes follow has been missing, and how long it may be; `None` while no axis follows
    /// one that was found.
    pub fn missing_s(&self, now: Duration) -> Option<(f64, f64)> {
        let shown = self.shown[0].filter(|_| self.closed.coarse)?;
        Some((now.saturating_sub(shown).as_secs_f64(), FRAMES_TO_LOSE * self.frame_s[0]))
    }

    /// The values in the order of [`Tracking::CHANNELS`].
    pub fn row(&self) -> [f64; 8] {
        let [az, el] = [0, 1].map(|k| self.coarse[k].target_rate_rad_per_s());
        let state = |closed: bool, state: TrackState| if closed { number(state) } else { -1.0 };
        let saturated = |k: usize| f64::from(u8::from(self.closed.fine && self.fine[k].is_saturated()));
        let [handed_az, handed_el] = self.handed_rad_per_s;
        [
            az,
            el,
            handed_az,
            handed_el,
            state(self.closed.coarse, self.coarse[0].state()),
            state(self.closed.fine, self.fine[0].state()),
            saturated(0),
            saturated(1),
        ]
    }

    fn switch(&mut self, closed: Closed, seen: &Seen<'_>) {
        let before = std::mem::replace(&mut self.closed, closed);
        if closed.coarse && !before.coarse {
            for (tracker, rate) in self.coarse.iter_mut().zip(seen.rate_rad_per_s) {
                tracker.reset(rate);
            }
            (self.wish_rad_per_s, self.shown[0], self.waiting) = ([0.0; 2], None, None);
        }
        if closed.fine && !before.fine {
            self.fine.iter_mut().for_each(|tracker| tracker.reset(0.0));
            self.shown[1] = None;
        }
        if closed.off_load && !before.off_load {
            self.off_load.iter_mut().flatten().for_each(|off_load| off_load.reset(0.0));
        }
        if !closed.off_load {
            self.handed_rad_per_s = [0.0; 2];
        }
        if closed != before {
            self.locked_since = None;
        }
    }

    /// The frame of a tracker, if it is a new one.
    fn take(&mut self, which: usize, seen: &Seen<'_>) -> Option<Actuals> {
        let frame = seen.frames[which];
        if frame.stamp == self.newest[which] {
            return None;
        }
        self.newest[which] = frame.stamp;
        if frame.is_valid() {
            self.shown[which] = Some(seen.now);
        }
        Some(frame)
    }

    fn follow_fine(&mut self, seen: &Seen<'_>, fresh: Option<Actuals>) -> [f64; 2] {
        let errors_rad = fresh.map_or([0.0; 2], |frame| [frame.cross_elevation_rad, frame.elevation_rad]);
        [0, 1].map(|k| self.fine[k].update(fresh.map(|frame| as_frame(&frame, errors_rad[k], seen.now))))
    }

    /// Rates: of the coarse law, and what the mirror hands over.
    fn follow_coarse(&mut self, seen: &Seen<'_>, fresh: Option<Actuals>) -> [f64; 2] {
        self.waiting = fresh.or(self.waiting);
        let secant = self.keyhole.as_mut().map(|keyhole| keyhole.update(seen.elevation_rad));
        let (gain, fade) = secant.map_or((1.0, 1.0), |secant| (secant.gain, secant.integral_factor));
        if self.ticks.is_multiple_of(self.law_ticks) {
            self.coarse[0].fade_integral(fade);
            let frame = self.waiting.take();
            self.wish_rad_per_s = [0, 1].map(|k| {
                let frame = frame.map(|frame| {
                    let error_rad = [gain * frame.cross_elevation_rad, frame.elevation_rad][k];
                    as_frame(&frame, error_rad, seen.now)
                });
                self.coarse[k].update(frame, seen.rate_rad_per_s[k])
            });
        }
        if self.closed.off_load {
            let held = [0, 1].map(|k| {
                let tracking = self.fine[k].state() == TrackState::Tracking;
                let mirror_rad = if tracking { seen.mirror_rad[k] } else { 0.0 };
                self.off_load[k].as_mut().map_or(0.0, |off_load| off_load.update(mirror_rad))
            });
            self.handed_rad_per_s = [gain * held[0], held[1]];
        }
        [0, 1].map(|k| self.wish_rad_per_s[k] + self.handed_rad_per_s[k])
    }

    fn has_target(&self) -> bool {
        let coarse = self.coarse.iter().map(CoarseTracker::state).filter(|_| self.closed.coarse);
        let fine = self.fine.iter().map(FineTracker::state).filter(|_| self.closed.fine);
        coarse.chain(fine).all(|state| state == TrackState::Tracking)
    }
}

fn as_frame(frame: &Actuals, error_rad: f64, now: Duration) -> Frame {
    let age_s = now.saturating_sub(frame.exposure).as_secs_f64();
    Frame { error_rad: frame.is_valid().then_some(error_rad), age_s }
}

fn number(state: TrackState) -> f64 {
    match state {
        TrackState::Lost => 0.0,
        TrackState::Holding => 1.0,
        TrackState::Tracking => 2.0,
    }
}

const fn channel(name: &'static str, unit: &'static str, width: Width) -> Channel {
    Channel { name, unit, width }
}

#[cfg(test)]
mod tests;
