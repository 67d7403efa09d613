//! Rows of the log, in the order of `channels`.

use super::Ticks;
use crate::cycle::progress::MAKE_SAFE;
use crate::cycle::recorder::MAX_CHANNELS;
use crate::cycle::sequence::Sequencer;
use crate::rig::ArmedRig;

/// The row of an axis: what the drive said, then what it is told.
pub(super) fn axis(
    rig: &ArmedRig,
    axis: usize,
    sequencer: Option<&Sequencer<'_>>,
    values: &mut [f64; MAX_CHANNELS],
) {
    let actuals = rig.actuals(axis).row();
    let (said, told) = values.split_at_mut(actuals.len());
    said.copy_from_slice(&actuals);
    let axis_loop = sequencer.map(|s| s.axis_loop(axis));
    told[0] = axis_loop.map_or(0.0, |l| l.sent_nm());
    told[1] = axis_loop.map_or(rig.actuals(axis).position_rad, |l| l.setpoint().position_rad);
    told[2] = axis_loop.map_or(0.0, |l| l.setpoint().velocity_rad_per_s);
    let [command, feedback] = axis_loop.map_or([0.0, rig.feedback(axis).0], |l| l.closed_on_rad_per_s());
    told[3] = command;
    told[4] = feedback;
    told[5] = sequencer.map_or(0.0, |s| s.excitation(axis));
    told[6] = f64::from(rig.last_controlword(axis));
    told[7] = f64::from(rig.age_ticks(axis));
}

/// The row of the loop itself.
pub(super) fn of_loop(
    rig: &ArmedRig,
    sequencer: Option<&Sequencer<'_>>,
    ticks: &Ticks<'_>,
    values: &mut [f64; MAX_CHANNELS],
) {
    values[0] = ticks.count as f64;
    values[1] = ticks.now.saturating_sub(ticks.due).as_secs_f64();
    values[2] = f64::from(ticks.missed_since_row);
    values[3] = f64::from(rig.working_counter());
    values[4] = f64::from(sequencer.map_or(MAKE_SAFE, |s| s.state().number()));
}
