//! Which procedures fit a rig: one that needs a device that the rig lacks is refused, or left out where that is asked for.

use std::collections::BTreeSet;

use procedures::device::DeviceRole;
use procedures::diagnostic::Diagnostic;

use super::select::serves;
use super::{CampaignPlan, PlanError, PlannedProcedure};
use crate::model::rig::Rig;
use crate::rig::devices::DRIVERS;

/// A procedure that was left out.
struct LeftOut {
    planned: PlannedProcedure,
    /// What the rig lacks for it.
    lacks: Vec<DeviceRole>,
}

/// The plan if the rig has what its procedures need. With `skip_missing` it is a plan without those that do not fit: a part
/// of its campaign, which must measure what is left of it.
///
/// # Errors
/// All procedures that do not fit, unless they may be left out; that nothing is left.
pub(super) fn fit(mut plan: CampaignPlan, rig: &Rig, skip_missing: bool) -> Result<CampaignPlan, PlanError> {
    let mut left_out = Vec::new();
    let mut kept = Vec::new();
    for planned in std::mem::take(&mut plan.procedures) {
        let lacks: Vec<DeviceRole> =
            needs(&planned).into_iter().filter(|role| rig.device(*role).is_none()).collect();
        if lacks.is_empty() {
            kept.push(planned);
        } else {
            left_out.push(LeftOut { planned, lacks });
        }
    }
    plan.procedures = kept;
    if left_out.is_empty() {
        return Ok(plan);
    }
    if !skip_missing {
        return Err(PlanError::Refused(left_out.iter().map(|left| refusal(left, rig)).collect()));
    }
    if plan.procedures.is_empty() {
        let message =
            format!("--skip-missing: no procedure is left, because rig `{}` lacks a device for each", rig.id);
        return Err(PlanError::NothingSelected(message));
    }
    Ok(without(plan, &left_out))
}

fn needs(planned: &PlannedProcedure) -> BTreeSet<DeviceRole> {
    let own = planned.procedure.experiment.needs();
    planned.cases.iter().flat_map(procedures::case::Case::needs).chain(own).collect()
}

fn refusal(left: &LeftOut, rig: &Rig) -> Diagnostic {
    let procedure = &left.planned.procedure;
    let lacks = &left.lacks;
    let message = format!(
        "{} (kind `{}`) needs {}, and rig `{}` has none",
        procedure.id,
        procedure.kind,
        nouns(lacks),
        rig.id
    );
    let drivers = DRIVERS.iter().filter(|driver| driver.role.is_some_and(|role| lacks.contains(&role)));
    let drivers = drivers.map(|driver| format!("`{}`", driver.name)).collect::<Vec<_>>().join(", ");
    let help = format!(
        "add a `[[device]]` to the rig file (driver {drivers}), or leave such procedures out with --skip-missing"
    );
    Diagnostic::new(message).in_file(&procedure.source).help(help)
}

fn nouns(roles: &[DeviceRole]) -> String {
    roles.iter().map(|role| role.noun()).collect::<Vec<_>>().join(" and ")
}

/// What is left of a plan, and what the rest costs.
fn without(mut plan: CampaignPlan, left_out: &[LeftOut]) -> CampaignPlan {
    let serving = |id: &str, planned: &PlannedProcedure| {
        plan.requirements.get(id).is_some_and(|r| plan.is_judged(planned) && serves(&planned.procedure, r))
    };
    let is_left = |id: &&String| plan.procedures.iter().any(|planned| serving(id, planned));
    let sentence = |left: &LeftOut| {
        let asked = plan.requirements.all.iter().map(|r| &r.id);
        let cost: Vec<&str> =
            asked.filter(|id| serving(id, &left.planned) && !is_left(id)).map(String::as_str).collect();
        let cost = if cost.is_empty() { "no requirement".to_owned() } else { cost.join(", ") };
        format!(
            "{} was left out: the rig has no {}; this leaves {cost} unmeasured",
            left.planned.procedure.id,
            left.lacks.iter().map(|role| role.bare()).collect::<Vec<_>>().join(" and no ")
        )
    };
    let sentences = left_out.iter().map(sentence).collect();
    let must_measure = plan.must_measure.iter().filter(is_left).cloned().collect();
    (plan.left_out, plan.must_measure, plan.partial) = (sentences, must_measure, true);
    plan.drop_empty_stages();
    plan
}
