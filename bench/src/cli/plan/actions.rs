//! The order of actions of a run, as `bench plan` prints it.

use procedures::quantity::QuantityKind as Q;

use crate::cycle::gate;
use crate::model::rig::Rig;
use crate::model::safety::SafeState;
use crate::plan::CampaignPlan;

/// One line an action.
pub(super) fn list(plan: &CampaignPlan, rig: &Rig) -> Vec<String> {
    let mut lines: Vec<String> = BEFORE.iter().map(|line| (*line).to_owned()).collect();
    for (index, planned) in plan.procedures.iter().enumerate() {
        let mut gates: Vec<String> = gate::GATES.iter().map(|g| g.name.to_owned()).collect();
        gates.extend(planned.procedure.gates.iter().map(|(name, limit)| format!("{name} {}", limit.text)));
        lines.push(format!("{}. {}", BEFORE.len() + index + 1, planned.procedure.id));
        lines.push(format!("   gates: {}", gates.join(", ")));
        if let Some(cool_down_s) = planned.procedure.cool_down_s {
            lines.push(format!(
                "   pause: up to {cool_down_s:.0} s before a point, until the heat sinks have cooled down"
            ));
        }
        let open_loop = planned.cases.iter().all(|c| c.open_loop);
        lines.push(format!("   {}", if open_loop { OPEN_LOOP_POINT } else { POINT }));
        lines.push(format!("   per point: {}", segments(planned)));
        let notes = planned.procedure.experiment.notes(&planned.procedure.axis, &rig.limits());
        let cuts = planned.cuts(rig);
        lines.extend(notes.iter().chain(&cuts).map(|note| format!("   note: {note}")));
    }
    let left =
        rig.axes.iter().map(|axis| match (axis.guard.safety.safe_state, axis.guard.safety.safe_pose_rad) {
            (SafeState::Hold, _) => format!("{} is held (quick stop active, torque on)", axis.name),
            (SafeState::Release, None) => format!("{} is released where friction holds it", axis.name),
            (SafeState::Release, Some(pose)) => {
                format!(
                    "{} is parked at {} and released where friction holds it",
                    axis.name,
                    Q::Angle.format(pose)
                )
            }
        });
    lines.push(format!("final state: {}", left.collect::<Vec<_>>().join("; ")));
    lines.push(
        "after each procedure: its log is closed and judged; at the end: results, report, journal".to_owned(),
    );
    lines
}

/// What comes before the first procedure; nothing can move in it.
const BEFORE: [&str; 4] = [
    "1. open (PRE-OP, nothing can move): identity, scales, mapping, limits, watchdog; all written and read back",
    "2. lock the rig's resources where a device is real; refuse to start where another run or an \
     unfinished run has locked them",
    "3. title page, journal, free disk for the planned logs",
    "4. polarity (proves encoder, gyro and torque signs) before the first closed loop, unless already proven",
];

/// A point with closed loops.
const POINT: &str = "each point: SAFE-OP with zero torque, OP, gates, fault reset, safety prompts, enable, homing, \
                     other prompts, segments, parking, controlled stop, disabling or hold";

/// A point without.
const OPEN_LOOP_POINT: &str = "each point: SAFE-OP with zero torque, OP, gates, fault reset, safety \
                               prompts, enable, segments without any closed loop; a stop switches the \
                               torque off";

/// Labels of the segments of the longest point, repeated ones once.
fn segments(planned: &crate::plan::PlannedProcedure) -> String {
    let longest = planned.cases.iter().max_by_key(|c| c.segments.len());
    let mut labels: Vec<&str> = Vec::new();
    for segment in longest.iter().flat_map(|c| &c.segments) {
        if !labels.contains(&segment.label.as_str()) {
            labels.push(&segment.label);
        }
    }
    labels.join(", ")
}
