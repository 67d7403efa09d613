//! Devices on the gimbal in the tick: inertial unit, mirror, trackers.

use std::time::Duration;

use drivers::analyser::Analyser;
use drivers::device::{Channel, DeviceError};
use drivers::kvh::{Kvh, Opening};
use drivers::mirror::{self, Mirror};
use drivers::scope::Scope;
use drivers::tracker::{self, Tracker};
use procedures::case::{Case, Mode};

use crate::bystanders::Bystanders;
use crate::clamps::Clamps;
use crate::clock::Clock;
use crate::force::Force;
use crate::model::device::PayloadSettings;
use crate::reference::Reference;
use crate::tracking::Tracking;
use crate::wires::PayloadWires;

/// Between two looks at a line during a dialogue.
const DIALOGUE_STEP: Duration = Duration::from_millis(1);
/// Beyond this a dialogue that says nothing is given up, whatever its own timeouts do.
const DIALOGUE_LIMIT: Duration = Duration::from_secs(10);

/// What was opened, and where it hangs.
pub struct Payload {
    imu: Option<Kvh>,
    mirror: Option<Mirror>,
    coarse: Option<Tracker>,
    fine: Option<Tracker>,
    lines: PayloadWires,
    mirror_command_rad: [f64; 2],
    mirror_actuals: mirror::Actuals,
    bystanders: Option<Bystanders>,
    clamps: Option<Clamps>,
    force: Option<Force>,
    seen: [tracker::Actuals; 2],
    tracking: [f64; 8],
    reference: Option<Reference>,
    start: Duration,
    /// Rates and accelerations since the last row, and how many messages they are.
    imu_sums: [f64; 6],
    imu_sums_count: u32,
    /// The first wire that went; what hangs on it only ages from then on.
    failure: Option<DeviceError>,
}

/// Which devices have something to say in a point.
#[derive(Clone, Copy, Debug)]
pub struct LookedAt {
    /// Trackers and the loops behind them: there is a target, or a loop that is closed on one.
    pub trackers: bool,
    /// Force gauge: somebody pulls.
    pub force: bool,
}

impl LookedAt {
    /// By a point; by one that logs its payload fully, everything.
    pub fn by(case: &Case) -> Self {
        let tracks = case.segments.iter().any(|s| s.mode == Mode::Track || s.tracks.is_some());
        Self {
            trackers: case.logs_payload_fully || case.target.is_some() || tracks,
            force: case.logs_payload_fully || case.pull.is_some(),
        }
    }
}

/// What one device adds to the log.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// Topic without its slash.
    pub topic: &'static str,
    /// Type of its messages.
    pub message: &'static str,
    /// Its channels.
    pub channels: &'static [Channel],
}

/// Every group that a payload can have, in the order of their topics.
const GROUPS: [Group; 10] = [
    Group { topic: "imu", message: "Imu", channels: Kvh::CHANNELS },
    Group { topic: "fsm", message: "Mirror", channels: Bystanders::MIRROR_CHANNELS },
    Group { topic: "coarse", message: "Tracker", channels: Tracker::CHANNELS },
    Group { topic: "fine", message: "Tracker", channels: Tracker::CHANNELS },
    Group { topic: "track", message: "Tracking", channels: Tracking::CHANNELS },
    Group { topic: "reference", message: "Reference", channels: Reference::CHANNELS },
    Group { topic: "supply", message: "Supply", channels: Clamps::CHANNELS },
    Group { topic: "force", message: "Force", channels: Force::CHANNELS },
    Group { topic: "analyser", message: "Impedance", channels: Analyser::CHANNELS },
    Group { topic: "scope", message: "Record", channels: Scope::CHANNELS },
];

/// The groups of a rig.
pub fn groups(settings: &PayloadSettings) -> Vec<Group> {
    let there = [
        settings.imu.is_some(),
        settings.mirror.is_some(),
        settings.coarse.is_some(),
        settings.fine.is_some(),
        settings.coarse.is_some() || settings.fine.is_some(),
        settings.reference.is_some(),
        settings.clamps.is_some(),
        settings.force.is_some(),
        settings.analyser.is_some(),
        settings.scope.is_some(),
    ];
    GROUPS.into_iter().zip(there).filter_map(|(group, there)| there.then_some(group)).collect()
}

impl Payload {
    /// Nothing is open yet.
    pub fn closed(lines: PayloadWires) -> Self {
        Self {
            imu: None,
            mirror: None,
            coarse: None,
            fine: None,
            lines,
            mirror_command_rad: [0.0; 2],
            mirror_actuals: mirror::Actuals::default(),
            bystanders: None,
            clamps: None,
            force: None,
            seen: [tracker::Actuals::default(); 2],
            tracking: [0.0; 8],
            reference: None,
            start: Duration::ZERO,
            imu_sums: [0.0; 6],
            imu_sums_count: 0,
            failure: None,
        }
    }

    /// Opens every device, from `now` on; gives the time at which that was done.
    ///
    /// # Errors
    /// The first device that does not answer or is not what it must be.
    pub fn open(
        &mut self,
        settings: &PayloadSettings,
        clock: &Clock,
        now: Duration,
    ) -> Result<Duration, DeviceError> {
        let (mut now, lines) = (now, &mut self.lines);
        if let Some(settings) = &settings.imu {
            let mut opening = Opening::new(settings.clone())?;
            let dialogue = |at| opening.poll(&mut *lines.imu, at);
            self.imu = Some(converse(clock, &mut now, &settings.name, dialogue)?);
        }
        if let Some(settings) = &settings.mirror {
            let mut mirror = Mirror::new(settings.clone())?;
            converse(clock, &mut now, &settings.name, |at| mirror.configure(&mut *lines.mirror, at))?;
            self.mirror = Some(mirror);
        }
        self.bystanders = settings.bystanders.clone().map(Bystanders::new);
        self.clamps = settings.clamps.clone().map(Clamps::new);
        self.force = settings.force.clone().map(Force::new);
        self.coarse = settings.coarse.clone().map(Tracker::new).transpose()?;
        self.fine = settings.fine.clone().map(Tracker::new).transpose()?;
        self.reference = settings.reference.clone().map(Reference::new);
        Ok(now)
    }

    /// The loop begins at this time: exposures are told from there on, as the log's own time is.
    pub fn start_of_ticks(&mut self, start: Duration) {
        self.start = start;
    }

    /// Once a tick, after the exchange: takes what arrived, sends the mirror its command. A wire that is gone silences
    /// what hangs on it and nothing else.
    pub fn poll(&mut self, now: Duration) {
        let polled = [
            self.poll_imu(now),
            self.poll_mirror(now),
            self.poll_tracker(0, now),
            self.poll_tracker(1, now),
            self.poll_reference(now),
            self.clamps.as_mut().map_or(Ok(()), |clamps| clamps.exchange(&mut *self.lines.analog, now)),
            self.force.as_mut().map_or(Ok(()), |force| force.exchange(&mut *self.lines.analog, now)),
        ];
        if let Some(error) = polled.into_iter().find_map(Result::err) {
            self.failure.get_or_insert(error);
        }
    }

    fn poll_imu(&mut self, now: Duration) -> Result<(), DeviceError> {
        let Some(imu) = &mut self.imu else { return Ok(()) };
        let messages_count = imu.poll(&mut *self.lines.imu, now)?;
        if let (true, Some(sample)) = (messages_count > 0, imu.sample()) {
            let values = sample.rate_rad_per_s.iter().chain(&sample.acceleration_m_per_s2);
            self.imu_sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            self.imu_sums_count += 1;
        }
        Ok(())
    }

    fn poll_mirror(&mut self, now: Duration) -> Result<(), DeviceError> {
        let Some(mirror) = &mut self.mirror else { return Ok(()) };
        let (line, analog) = (&mut *self.lines.mirror, &mut *self.lines.analog);
        self.mirror_actuals = mirror.exchange(line, analog, self.mirror_command_rad, now)?;
        match &mut self.bystanders {
            Some(bystanders) => bystanders.exchange(analog, now),
            None => Ok(()),
        }
    }

    fn poll_reference(&mut self, now: Duration) -> Result<(), DeviceError> {
        match &mut self.reference {
            Some(reference) => reference.exchange(&mut *self.lines.analog, now),
            None => Ok(()),
        }
    }

    /// Raises the synchronisation signal of the oscilloscope, or lets it fall.
    pub fn synchronise(&mut self, now: Duration, high: bool) {
        if let Some(bystanders) = &mut self.bystanders
            && let Err(error) = bystanders.synchronise(&mut *self.lines.analog, now, high)
        {
            self.failure.get_or_insert(error);
        }
    }

    fn poll_tracker(&mut self, which: usize, now: Duration) -> Result<(), DeviceError> {
        let (tracker, port) = match which {
            0 => (&mut self.coarse, &mut self.lines.coarse),
            _ => (&mut self.fine, &mut self.lines.fine),
        };
        if let Some(tracker) = tracker {
            self.seen[which] = tracker.poll(&mut **port, now)?.0;
        }
        Ok(())
    }

    /// Tilt of the mirror that is sent from the next tick on: azimuth, elevation.
    pub fn command_mirror(&mut self, command_rad: [f64; 2]) {
        self.mirror_command_rad = command_rad;
    }

    /// Topics of the devices on the gimbal.
    pub fn groups_count(&self) -> usize {
        let (coarse, fine) = (self.coarse.is_some(), self.fine.is_some());
        let tracking = coarse || fine;
        let bench = [self.reference.is_some(), self.clamps.is_some(), self.force.is_some()];
        let gimbal = [self.imu.is_some(), self.mirror.is_some(), coarse, fine, tracking];
        let there = gimbal.into_iter().chain(bench);
        there.filter(|there| *there).count()
    }

    /// The inertial unit.
    pub fn imu(&self) -> Option<&Kvh> {
        self.imu.as_ref()
    }

    /// Newest samples of the coarse and the fine tracker.
    pub fn trackers(&self) -> &[tracker::Actuals; 2] {
        &self.seen
    }

    /// Angles of the mirror by its strain gauges: azimuth, elevation.
    pub fn mirror_rad(&self) -> [f64; 2] {
        self.mirror_actuals.angle_rad
    }

    /// What the track loops log, in the order of [`Tracking::CHANNELS`].
    pub fn show_tracking(&mut self, row: [f64; 8]) {
        self.tracking = row;
    }

    /// The first wire that went.
    pub fn failure(&self) -> Option<&DeviceError> {
        self.failure.as_ref()
    }

    /// Who they are, as name and identity.
    pub fn identities(&self) -> Vec<(String, String)> {
        let imu = self
            .imu
            .as_ref()
            .map(|imu| (imu.settings().name.clone(), format!("KVH 1775, serial {}", imu.identity().serial)));
        let mirror = self.mirror.as_ref().map(|mirror| {
            (mirror.settings().name.clone(), "CCBu40 servo, analog and serial channel".to_owned())
        });
        imu.into_iter().chain(mirror).collect()
    }

    /// Puts the values of each group into `row` and hands it on, in the order of [`groups`]; `None` for a group that says
    /// nothing in this point. Rates and accelerations are means since the row before: picking every n-th message would fold
    /// its noise.
    pub fn rows<const N: usize>(
        &mut self,
        row: &mut [f64; N],
        looked_at: LookedAt,
        mut each: impl FnMut(Option<&[f64; N]>),
    ) {
        let mut put = |values: &[f64], told: bool| {
            row[..values.len()].copy_from_slice(values);
            each(told.then_some(&*row));
        };
        if let Some(imu) = &self.imu {
            let mut values = imu.row();
            if self.imu_sums_count > 0 {
                let count = f64::from(self.imu_sums_count);
                values.iter_mut().zip(self.imu_sums).for_each(|(value, sum)| *value = sum / count);
            }
            put(&values, true);
            (self.imu_sums, self.imu_sums_count) = ([0.0; 6], 0);
        }
        if self.mirror.is_some() {
            let seen = self.bystanders.as_ref().map_or([0.0; 4], Bystanders::row);
            put(&concatenated(&self.mirror_actuals.row(), &seen), true);
        }
        for (tracker, seen) in [&self.coarse, &self.fine].into_iter().zip(&self.seen) {
            if tracker.is_some() {
                let since_start = seen.exposure.saturating_sub(self.start);
                put(&tracker::Actuals { exposure: since_start, ..*seen }.row(), looked_at.trackers);
            }
        }
        if self.coarse.is_some() || self.fine.is_some() {
            put(&self.tracking, looked_at.trackers);
        }
        if let Some(reference) = &self.reference {
            put(&reference.row(), true);
        }
        if let Some(clamps) = &mut self.clamps {
            put(&clamps.row(), true);
        }
        if let Some(force) = &mut self.force {
            put(&force.row(), looked_at.force);
        }
    }
}

/// One row out of two.
fn concatenated(first: &[f64; 5], second: &[f64; 4]) -> [f64; 9] {
    let mut whole = [0.0; 9];
    whole[..5].copy_from_slice(first);
    whole[5..].copy_from_slice(second);
    whole
}

/// Polls a dialogue until it ends, letting time pass.
pub(crate) fn converse<T>(
    clock: &Clock,
    now: &mut Duration,
    device: &str,
    mut poll: impl FnMut(Duration) -> Result<Option<T>, DeviceError>,
) -> Result<T, DeviceError> {
    let until = *now + DIALOGUE_LIMIT;
    while *now < until {
        if let Some(opened) = poll(*now)? {
            return Ok(opened);
        }
        *now = clock.wait_until(*now + DIALOGUE_STEP);
    }
    let reason = format!("no end of its configuration within {} s", DIALOGUE_LIMIT.as_secs());
    Err(DeviceError::Bus { device: device.to_owned(), reason })
}
