//! Segments in which axes or mirror follow a target.

use std::time::Duration;

use procedures::case::{Condition, Mode, Segment, Then};
use procedures::log::EndedBy;
use procedures::stimulus::Setpoint;

use super::{Sequencer, State};
use crate::rig::ArmedRig;
use crate::rig::tracking::Closed;

/// What comes after a segment that ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum After {
    /// This segment, in the same tick.
    Start(usize),
    /// Rest, then this segment.
    Rest(usize),
}

impl Sequencer<'_> {
    /// One tick of the track loops that the running segment closes; in every other state they are open.
    pub(super) fn track(&mut self, now: Duration, rig: &mut ArmedRig) {
        let closed = match &self.state {
            State::Running(running) => Closed::of(running.segment),
            _ => Closed::default(),
        };
        self.tracked_rad_per_s = rig.track(closed, now).rate_rad_per_s;
    }

    /// What an axis follows in this tick, if it tracks.
    pub(super) fn tracked(&self, axis: usize, rig: &ArmedRig) -> Option<Setpoint> {
        let State::Running(running) = &self.state else { return None };
        let velocity_rad_per_s = self.tracked_rad_per_s[rig.gimbal()?.place_of(axis)?];
        let position_rad = rig.actuals(axis).position_rad;
        let setpoint = Setpoint { position_rad, velocity_rad_per_s, ..Setpoint::default() };
        running.segment.is_tracked(axis == self.moving).then_some(setpoint)
    }

    /// Brings every axis to rest that a segment moved.
    pub(super) fn arrest(&mut self, segment: &Segment, next: usize, now: Duration, rig: &ArmedRig) {
        for (axis, axis_loop) in self.loops.iter_mut().enumerate() {
            // A companion was brought on its way to rest when its segment ended.
            let along = self.companion == Some(axis);
            self.arrests[axis] = axis == self.moving || segment.is_tracked(false) || along;
            if self.arrests[axis] && !along {
                axis_loop.start_stop(rig.actuals(axis), rig.feedback(axis).0);
            }
        }
        self.go(State::Arresting { next }, now);
    }

    pub(super) fn at_rest(&self, rig: &ArmedRig) -> bool {
        let rests = |axis: usize| !self.arrests[axis] || self.loops[axis].stopped(rig.actuals(axis));
        (0..self.loops.len()).all(rests)
    }

    /// What follows a segment. A target that was not found ends the point; only a segment that tracks goes on from one that
    /// does without a stop.
    pub(super) fn after(&self, index: usize, segment: &Segment, by: EndedBy) -> After {
        let not_found = by == EndedBy::Timeout && matches!(segment.until, Some(Condition::Locked { .. }));
        if not_found {
            return After::Rest(usize::MAX);
        }
        // An axis that followed and does so no more must come to rest first: its reference stands where it began.
        let follows = |next: &Segment| {
            next.mode == Mode::Track && (next.is_tracked(false) || !segment.is_tracked(false))
        };
        let goes_on = self.case.segments.get(index + 1).is_some_and(follows);
        match segment.then {
            Then::Next if segment.mode != Mode::Track || goes_on => After::Start(index + 1),
            Then::Next | Then::Hold => After::Rest(index + 1),
            Then::Stop | Then::QuickStop | Then::TorqueOff => After::Rest(usize::MAX),
        }
    }
}
