//! What procedures of a campaign say of each other: self-checks of the bench, each compared with the one before, and estimates of
//! one quantity by several procedures.

use procedures::agreement;
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
                between.remarks.push(doubtful(between));
            }
        }
    }
}

/// Compares what procedures in the final build state found of one quantity, and judges again what disagrees.
pub(super) fn compare_estimates(procedures: &mut [ProcedureFindings], requirements: &Requirements) {
    let in_final_state = |p: &ProcedureFindings| p.state.is_none();
    let mut found: Vec<_> = procedures
        .iter()
        .map(|p| (p.id.clone(), if in_final_state(p) { p.measurements.clone() } else { Vec::new() }))
        .collect();
    agreement::name_cross_checks(&mut found);
    let sentences = agreement::compare(&mut found);
    for (index, (procedure, (_, measurements))) in procedures.iter_mut().zip(found).enumerate() {
        if !in_final_state(procedure) {
            continue;
        }
        procedure.measurements = measurements;
        let own: Vec<&String> = sentences.iter().filter(|(k, _)| *k == index).map(|(_, text)| text).collect();
        if !own.is_empty() {
            procedure.remarks.extend(own.iter().map(|sentence| format!("{sentence}.")));
            judge_again(procedure, requirements);
        }
    }
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
