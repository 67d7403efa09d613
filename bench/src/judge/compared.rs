//! What procedures of a campaign say of each other: self-checks of the bench, each compared with the one before, and estimates of
//! one quantity by several procedures.

use std::collections::BTreeMap;

use procedures::agreement;
use procedures::drift;
use procedures::requirement::Requirements;
use procedures::verdict::Verdict;
use reports::record::{ProcedureFindings, Status};

use super::jitter::count_jitter;
use super::known;

/// All that procedures of a campaign say of each other; returns what disagrees, a sentence each. `sources` names the procedure
/// that measured the torque constant of an axis.
pub(super) fn compare_all(
    procedures: &mut [ProcedureFindings],
    sources: &BTreeMap<String, String>,
    requirements: &Requirements,
) -> Vec<String> {
    hold_together(procedures, requirements);
    doubt_torques(procedures, sources, requirements);
    count_jitter(procedures, requirements);
    compare_estimates(procedures, requirements)
}

/// Compares consecutive self-checks, in the order of the campaign, and judges again what rests on a channel that drifted.
///
/// One that left no log or did not complete is not compared: the campaign is incomplete anyway.
fn hold_together(procedures: &mut [ProcedureFindings], requirements: &Requirements) {
    let is_check = |p: &ProcedureFindings| p.kind == drift::KIND && p.status == Status::Completed;
    let checks: Vec<usize> = (0..procedures.len()).filter(|&i| is_check(&procedures[i])).collect();
    for pair in checks.windows(2) {
        let (before, after) = procedures.split_at_mut(pair[1]);
        let drifts = drift::compare(&before[pair[0]].measurements, &mut after[0].measurements);
        after[0].remarks.extend(drifts.iter().map(|drift| format!("{}.", drift.reason)));
        for between in before[pair[0] + 1..].iter_mut().filter(|between| between.state.is_none()) {
            if drift::put_in_doubt(&mut between.measurements, &drifts) {
                judge_again(between, requirements);
                between.remarks.push(doubtful(between));
            }
        }
    }
}

/// Takes the verdict from torques that follow a torque constant which is itself in doubt by now: a force gauge that drifted spoils
/// more than what was read from it.
fn doubt_torques(
    procedures: &mut [ProcedureFindings],
    sources: &BTreeMap<String, String>,
    requirements: &Requirements,
) {
    for (axis, source) in sources {
        let constant = procedures
            .iter()
            .find(|p| p.id == *source)
            .and_then(|p| p.measurements.iter().find(|m| m.measurand == known::CONSTANT && m.axis == *axis));
        let Some(why) = constant.and_then(|m| m.inconclusive.as_ref()) else { continue };
        let reason = format!(
            "torques of {axis} follow the torque constant that {source} measured, which is in doubt: {why}"
        );
        let others = procedures.iter_mut().filter(|p| p.state.is_none() && known::follows_constants(p));
        for other in others {
            let mut count = 0_usize;
            for told in other.measurements.iter_mut().filter(|m| drift::rests_on_torque_constant(m, axis)) {
                told.inconclusive.get_or_insert_with(|| reason.clone());
                count += 1;
            }
            if count > 0 {
                judge_again(other, requirements);
                other.remarks.push(format!(
                    "Results that rest on the torque constant of {axis}, which is in doubt: {count}."
                ));
            }
        }
    }
}

/// Compares what procedures in the final build state found of one quantity, and judges again what disagrees: a sentence each.
fn compare_estimates(procedures: &mut [ProcedureFindings], requirements: &Requirements) -> Vec<String> {
    let in_final_state = |p: &ProcedureFindings| p.state.is_none();
    let mut found: Vec<_> = procedures
        .iter()
        .map(|p| (p.id.clone(), if in_final_state(p) { p.measurements.clone() } else { Vec::new() }))
        .collect();
    agreement::name_cross_checks(&mut found);
    let disagreements = agreement::compare(&mut found);
    for (index, (procedure, (_, measurements))) in procedures.iter_mut().zip(found).enumerate() {
        if !in_final_state(procedure) {
            continue;
        }
        procedure.measurements = measurements;
        let own: Vec<String> = disagreements
            .iter()
            .filter(|d| d.procedures.contains(&index))
            .map(|d| format!("{}.", d.sentence))
            .collect();
        if !own.is_empty() {
            procedure.remarks.extend(own);
            judge_again(procedure, requirements);
        }
    }
    disagreements.into_iter().map(|d| format!("{}.", d.sentence)).collect()
}

/// Judges the measurements of a procedure again after they were put in doubt.
pub(super) fn judge_again(found: &mut ProcedureFindings, requirements: &Requirements) {
    found.judgements = super::judge_all(&found.measurements, requirements);
    found.verdict = found.judgements.iter().map(|j| j.verdict).max().unwrap_or(Verdict::None);
    for row in &mut found.points {
        let own = found.judgements.iter().filter(|j| row.measurements.contains(&j.measurement));
        row.verdict = own.map(|j| j.verdict).max().unwrap_or(Verdict::None);
    }
}

fn doubtful(found: &ProcedureFindings) -> String {
    let doubtful = |m: &&procedures::measurement::Measurement| m.value.is_some() && m.inconclusive.is_some();
    let count = found.measurements.iter().filter(doubtful).count();
    format!("Results that rest on a channel that drifted between the self-checks: {count}.")
}

#[cfg(test)]
mod tests;
