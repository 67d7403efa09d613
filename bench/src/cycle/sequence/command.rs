//! What each axis is commanded in a tick.

use std::time::Duration;

use drivers::device::DeviceError;
use procedures::case::Mode;
use procedures::excitation::Injection;

use super::{Sequencer, State};
use crate::cycle::velocity_loop::LawFault;
use crate::rig::ArmedRig;

impl Sequencer<'_> {
    /// Leaves a command for every axis, whatever goes wrong with one of them; gives the first error.
    pub(super) fn command(
        &mut self,
        now: Duration,
        rig: &mut ArmedRig,
        dither: &mut dyn FnMut() -> f64,
    ) -> Result<(), DeviceError> {
        let mut outcome = Ok(());
        self.excite(now, rig);
        self.track(now, rig);
        for axis in 0..self.loops.len() {
            self.loops[axis].pass(rig.passed_periods(), rig.law_steps());
            outcome = outcome.and(self.command_axis(axis, now, rig, dither));
        }
        outcome
    }

    /// Leaves the command of a stop for every axis, in place of the one that [`Self::step`] has left in this tick.
    pub fn command_stop(&mut self, now: Duration, rig: &mut ArmedRig) -> Result<(), DeviceError> {
        let mut outcome = Ok(());
        for axis in 0..self.loops.len() {
            outcome = outcome.and(self.command_axis(axis, now, rig, &mut || 0.0));
        }
        outcome
    }

    /// What made an external law unusable in this tick, and the axis, once.
    pub fn take_law_fault(&mut self) -> Option<(usize, LawFault)> {
        self.loops.iter_mut().enumerate().find_map(|(axis, own)| Some((axis, own.take_law_fault()?)))
    }

    fn command_axis(
        &mut self,
        axis: usize,
        now: Duration,
        rig: &mut ArmedRig,
        dither: &mut dyn FnMut() -> f64,
    ) -> Result<(), DeviceError> {
        // Once finished nothing enables or moves any more: from here on it is `make_safe`'s command.
        if self.finished() || rig.torque_is_forbidden(axis) {
            crate::cycle::safe::settle(rig, axis, now, self.case.open_loop);
            self.loops[axis].sent(0.0);
            return Ok(());
        }
        let target = self.power_target(axis, rig);
        match rig.controlword(axis, target, now) {
            Ok(controlword) => {
                let torque_nm = self.torque_nm(axis, now, rig, dither);
                let sent_nm = match self.drive_velocity(axis, now) {
                    Some(rad_per_s) => rig.command_velocity(axis, controlword, rad_per_s),
                    None => rig.command(axis, controlword, torque_nm),
                };
                self.loops[axis].sent(sent_nm);
                Ok(())
            }
            Err(error) => {
                crate::cycle::safe::settle(rig, axis, now, self.case.open_loop);
                self.loops[axis].sent(0.0);
                Err(error)
            }
        }
    }

    /// What is added in this tick; the mirror is told at once.
    fn excite(&mut self, now: Duration, rig: &mut ArmedRig) {
        let excited = match &self.state {
            State::Running(running) => running.segment.excited,
            _ => None,
        };
        let before = self.excitation;
        self.excitation = excited.and_then(|index| self.playbacks.get_mut(index)).map(|p| p.at(now));
        let value = |excitation: Option<(Injection, f64)>| excitation.map_or(0.0, |(_, value)| value);
        if value(before) != value(self.excitation) && rig.instruments().awaits_edge() {
            rig.synchronise(now, true);
        }
        match (before, self.excitation) {
            (_, Some((Injection::MirrorAz, rad))) => rig.devices_mut().command_mirror([rad, 0.0]),
            (_, Some((Injection::MirrorEl, rad))) => rig.devices_mut().command_mirror([0.0, rad]),
            (Some((Injection::MirrorAz | Injection::MirrorEl, _)), _) => rig.rest_mirror(),
            _ => {}
        }
    }

    /// What is added in this tick to a command of an axis, or of the mirror, in the unit of its place: for the log.
    pub fn excitation(&self, axis: usize) -> f64 {
        if axis == self.moving { self.excitation.map_or(0.0, |(_, value)| value) } else { 0.0 }
    }

    /// Velocity for the drive's own loop, where a segment asks for it.
    fn drive_velocity(&self, axis: usize, now: Duration) -> Option<f64> {
        match &self.state {
            State::Running(running) if axis == self.moving && running.segment.mode == Mode::DriveVelocity => {
                Some(running.setpoint(now).velocity_rad_per_s)
            }
            _ => None,
        }
    }

    fn torque_nm(
        &mut self,
        axis: usize,
        now: Duration,
        rig: &ArmedRig,
        dither: &mut dyn FnMut() -> f64,
    ) -> f64 {
        if !self.expects_operation() {
            return 0.0;
        }
        let actuals = rig.actuals(axis);
        let any = match &self.state {
            State::Running(running) => Some(running),
            _ => None,
        };
        let running = any.filter(|_| axis == self.moving);
        let wanted = match running {
            Some(running) => self.tracked(axis, rig).or(Some(running.setpoint(now))),
            None => self.tracked(axis, rig).or(any.and_then(|running| running.setpoint_along(axis, now))),
        };
        let dithered = running.is_some_and(|running| running.segment.dithered);
        if self.case.open_loop {
            let torque_nm = self.loops[axis].open(wanted.as_ref());
            return if dithered { torque_nm + dither() } else { torque_nm };
        }
        if matches!(self.state, State::Stopping) {
            let believed = rig.believed_actuals(axis);
            return self.loops[axis].brake(&believed, rig.braking_share(axis));
        }
        let rate = rig.feedback(axis).0;
        let excitation = self.excitation.filter(|_| running.is_some());
        let torque_nm = self.loops[axis].excited(excitation).torque(actuals, rate, wanted.as_ref());
        if dithered { torque_nm + dither() } else { torque_nm }
    }
}
