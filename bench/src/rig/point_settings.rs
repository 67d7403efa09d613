//! What a point changes on an open rig: torque limit, fences, the mirror's way of commands, the frame rate.
//!
//! One path for every site: the settings of a point are given to the open rig, read back, and taken back by giving it its
//! own again.

use std::time::Duration;

use drivers::cia402::DriveLimits;
use drivers::device::DeviceError;
use procedures::case::{Case, MirrorChannel};
use procedures::device::DeviceRole;

use super::ArmedRig;
use super::devices::mirror::COMMAND_PATH;
use super::devices::tracker::FRAME_RATE;
use crate::clock::Clock;
use crate::model::rig::Rig;

/// Settings that a point may change.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSettings {
    axes: Vec<AxisSettings>,
    /// Way of the mirror's commands; `None` without a mirror.
    pub mirror_channel: Option<MirrorChannel>,
    /// Frames per second of the fine tracker; `None` without one.
    pub fine_frame_rate_hz: Option<f64>,
}

/// Settings of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AxisSettings {
    drive: DriveLimits,
    /// Torque that the interlocks expect the drive to show at the most.
    guard_max_torque_nm: f64,
    /// Soft limits that the interlocks enforce.
    guard_soft_limits_rad: [f64; 2],
}

impl PointSettings {
    /// A rig's own, as it is opened.
    pub fn own(rig: &Rig) -> Self {
        let axis = |axis: &crate::model::axis::RigAxis| AxisSettings {
            drive: DriveLimits {
                max_torque_nm: axis.drive.max_torque_nm,
                soft_limits_rad: axis.drive.soft_limits_rad,
            },
            guard_max_torque_nm: axis.guard.max_torque_nm,
            guard_soft_limits_rad: axis.guard.stop.soft_limits_rad,
        };
        Self {
            axes: rig.axes.iter().map(axis).collect(),
            mirror_channel: rig.device(DeviceRole::Mirror).map(|mirror| match mirror.text(COMMAND_PATH) {
                "serial" => MirrorChannel::Serial,
                _ => MirrorChannel::Analog,
            }),
            fine_frame_rate_hz: rig.device(DeviceRole::FineTracker).map(|fine| fine.number(FRAME_RATE)),
        }
    }

    /// A rig's own with what a point changes: the torque limit of its axis, its fences, its way to the mirror, its frame
    /// rate.
    pub fn for_case(rig: &Rig, case: &Case) -> Self {
        let mut settings = Self::own(rig);
        for (axis, own) in rig.axes.iter().zip(&mut settings.axes) {
            if let Some(limit_nm) = case.torque_limit_nm.filter(|_| axis.name == case.axis) {
                own.drive.max_torque_nm = limit_nm.min(own.drive.max_torque_nm);
                own.guard_max_torque_nm = own.drive.max_torque_nm;
            }
            let Some(fence) = &case.fence else { continue };
            if let Some(&limits_rad) = fence.bench_rad.get(&axis.name) {
                own.guard_soft_limits_rad = limits_rad;
            }
            if let Some(&limits_rad) = fence.drive_rad.get(&axis.name) {
                own.drive.soft_limits_rad = limits_rad;
            }
        }
        settings.mirror_channel =
            settings.mirror_channel.and(case.mirror_channel).or(settings.mirror_channel);
        settings.fine_frame_rate_hz =
            settings.fine_frame_rate_hz.and(case.fine_frame_rate_hz).or(settings.fine_frame_rate_hz);
        settings
    }
}

impl ArmedRig {
    /// Begins to give the rig other settings; [`ArmedRig::poll_change`] goes on with it. What the rig has already is not
    /// written again. Until a drive has its limits, interlocks keep to its old ones.
    ///
    /// # Errors
    /// Settings that a device cannot be given.
    pub fn change(&mut self, settings: &PointSettings) -> Result<(), DeviceError> {
        for (drive, wanted) in self.drives.iter_mut().zip(&settings.axes) {
            if drive.limits() != wanted.drive {
                drive.change_limits(wanted.drive)?;
            }
        }
        self.devices.change(settings)?;
        if let Some(rate_hz) = settings.fine_frame_rate_hz {
            self.tracking.set_fine_frame_rate(rate_hz);
        }
        self.wanted = Some(settings.clone());
        Ok(())
    }

    /// Goes on with [`ArmedRig::change`] as far as it gets without waiting; whether the rig has the settings now.
    ///
    /// # Errors
    /// A device that refuses, or reads back something else: what it has then is not known.
    pub fn poll_change(&mut self, now: Duration) -> Result<bool, DeviceError> {
        // One transfer at a time: the drives share a bus. A reading of a heat sink ends first, within a second.
        if self.reads_heat_sink.is_some() {
            return Ok(false);
        }
        for drive in &mut self.drives {
            if !drive.poll_change(&mut *self.bus, now)? {
                return Ok(false);
            }
        }
        if !self.devices.poll_change(&mut self.ports, now)? {
            return Ok(false);
        }
        if let Some(settings) = self.wanted.take() {
            for (axis, wanted) in settings.axes.iter().enumerate() {
                self.hold_axis_to(axis, wanted);
            }
        }
        Ok(true)
    }

    /// Interlocks, laws and stops of an axis follow what its drive has.
    fn hold_axis_to(&mut self, axis: usize, wanted: &AxisSettings) {
        let own = &mut self.axes[axis];
        let drive = &self.drives[axis];
        own.drive.max_torque_nm = wanted.drive.max_torque_nm;
        own.drive.soft_limits_rad = wanted.drive.soft_limits_rad;
        own.guard.max_torque_nm = wanted.guard_max_torque_nm;
        own.guard.stop.soft_limits_rad = wanted.guard_soft_limits_rad;
        own.guard.stop.deceleration_rad_per_s2 = self.stated_rad_per_s2[axis];
        own.guard.rely_on(drive.available_torque_nm());
    }

    /// Gives the rig other settings before the first tick, letting time pass until it has them.
    ///
    /// # Errors
    /// Settings that a device cannot be given, refuses, or reads back as something else.
    pub fn change_before_ticks(
        &mut self,
        settings: &PointSettings,
        clock: &Clock,
    ) -> Result<(), DeviceError> {
        self.change(settings)?;
        let mut now = self.opened_at;
        super::devices::converse(clock, &mut now, "point settings", |at| {
            Ok(self.poll_change(at)?.then_some(()))
        })?;
        self.begin_ticks_after(now);
        Ok(())
    }
}
