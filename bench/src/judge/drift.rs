//! Self-checks of a campaign: each is compared with the one before; what drifted puts what lies between in doubt.

use procedures::drift;
use procedures::requirement::Requirements;
use procedures::verdict::Verdict;
use reports::record::{ProcedureFindings, Status};

/// Compares consecutive self-checks, in the order of the campaign, and judges again what rests on a channel that drifted.
///
/// One that left no log or did not complete is not compared: the campaign is incomplete anyway.
pub(super) fn hold_together(procedures: &mut [ProcedureFindings], requirements: &Requirements) {
    let is_check = |p: &ProcedureFindings| p.kind == drift::KIND && p.status == Status::Completed;
    let checks: Vec<usize> = (0..procedures.len()).filter(|&i| is_check(&procedures[i])).collect();
    for pair in checks.windows(2) {
        let (before, after) = procedures.split_at_mut(pair[1]);
        let drifts = drift::compare(&before[pair[0]].measurements, &mut after[0].measurements);
        after[0].remarks.extend(drifts.iter().map(|drift| format!("{}.", drift.reason)));
        for between in before[pair[0] + 1..].iter_mut().filter(|between| between.state.is_none()) {
            if drift::put_in_doubt(&mut between.measurements, &drifts) {
                judge_again(between, requirements);
            }
        }
    }
}

/// Name of the kind that finds torque constants.
const TORQUE_CONSTANT: &str = "torque-constant";

/// What comes after a torque constant that is not that of the rig file says so.
pub(super) fn tell_suspicion(procedures: &mut [ProcedureFindings]) {
    for index in 0..procedures.len() {
        let (before, after) = procedures.split_at_mut(index + 1);
        if before[index].kind == TORQUE_CONSTANT {
            for later in after {
                drift::call_suspicious(&mut later.measurements, &before[index].measurements);
            }
        }
    }
}

fn judge_again(found: &mut ProcedureFindings, requirements: &Requirements) {
    found.judgements = super::judge_all(&found.measurements, requirements);
    found.verdict = found.judgements.iter().map(|j| j.verdict).max().unwrap_or(Verdict::None);
    for row in &mut found.points {
        let own = found.judgements.iter().filter(|j| row.measurements.contains(&j.measurement));
        row.verdict = own.map(|j| j.verdict).max().unwrap_or(Verdict::None);
    }
    let doubtful = |m: &&procedures::measurement::Measurement| m.value.is_some() && m.inconclusive.is_some();
    let count = found.measurements.iter().filter(doubtful).count();
    found.remarks.push(format!("{count} results rest on a channel that drifted between the self-checks."));
}

#[cfg(test)]
mod tests;
