//! Devices on the gimbal in the tick: inertial unit, mirror, trackers.

use std::time::Duration;

use drivers::device::{Channel, DeviceError};
use drivers::kvh::{Kvh, Opening};
use drivers::mirror::{self, Mirror};
use drivers::tracker::{self, Tracker};

use crate::clock::Clock;
use crate::files::rig::PayloadSettings;
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
    seen: [tracker::Actuals; 2],
    /// The first wire that went; what hangs on it only ages from then on.
    failure: Option<DeviceError>,
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
const GROUPS: [Group; 4] = [
    Group { topic: "imu", message: "Imu", channels: Kvh::CHANNELS },
    Group { topic: "fsm", message: "Mirror", channels: Mirror::CHANNELS },
    Group { topic: "coarse", message: "Tracker", channels: Tracker::CHANNELS },
    Group { topic: "fine", message: "Tracker", channels: Tracker::CHANNELS },
];

/// The groups of a rig.
pub fn groups(settings: &PayloadSettings) -> Vec<Group> {
    let there = [
        settings.imu.is_some(),
        settings.mirror.is_some(),
        settings.coarse.is_some(),
        settings.fine.is_some(),
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
            seen: [tracker::Actuals::default(); 2],
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
        self.coarse = settings.coarse.clone().map(Tracker::new).transpose()?;
        self.fine = settings.fine.clone().map(Tracker::new).transpose()?;
        Ok(now)
    }

    /// Once a tick, after the exchange: takes what arrived, sends the mirror its command.
    pub fn poll(&mut self, now: Duration) {
        if let Err(error) = self.try_poll(now) {
            self.failure.get_or_insert(error);
        }
    }

    fn try_poll(&mut self, now: Duration) -> Result<(), DeviceError> {
        if let Some(imu) = &mut self.imu {
            imu.poll(&mut *self.lines.imu, now)?;
        }
        if let Some(mirror) = &mut self.mirror {
            let (line, analog) = (&mut *self.lines.mirror, &mut *self.lines.analog);
            self.mirror_actuals = mirror.exchange(line, analog, self.mirror_command_rad, now)?;
        }
        let ports = [&mut self.lines.coarse, &mut self.lines.fine];
        for (k, (tracker, port)) in [&mut self.coarse, &mut self.fine].into_iter().zip(ports).enumerate() {
            if let Some(tracker) = tracker {
                self.seen[k] = tracker.poll(&mut **port, now)?.0;
            }
        }
        Ok(())
    }

    /// Tilt of the mirror that is sent from the next tick on: azimuth, elevation.
    pub fn command_mirror(&mut self, command_rad: [f64; 2]) {
        self.mirror_command_rad = command_rad;
    }

    /// The inertial unit.
    pub fn imu(&self) -> Option<&Kvh> {
        self.imu.as_ref()
    }

    /// Newest samples of the coarse and the fine tracker.
    pub fn trackers(&self) -> &[tracker::Actuals; 2] {
        &self.seen
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

    /// Puts the values of each group into `row` and hands it on, in the order of [`groups`].
    pub fn rows<const N: usize>(&self, row: &mut [f64; N], mut each: impl FnMut(&[f64; N])) {
        let mut put = |values: &[f64]| {
            row[..values.len()].copy_from_slice(values);
            each(row);
        };
        if let Some(imu) = &self.imu {
            put(&imu.row());
        }
        if self.mirror.is_some() {
            put(&self.mirror_actuals.row());
        }
        if self.coarse.is_some() {
            put(&self.seen[0].row());
        }
        if self.fine.is_some() {
            put(&self.seen[1].row());
        }
    }
}

/// Polls a dialogue until it ends, letting time pass.
fn converse<T>(
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
