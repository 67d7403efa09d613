//! Gates between stages: a stage begins when those that it needs have come out in order.
//!
//! Everything follows from the title page and the judged logs, so whoever judges them again finds the same gates closed.

use procedures::campaign::Claim;
use procedures::requirement::Requirements;
use procedures::verdict::{Verdict, roll_up};
use reports::record::Status;

use crate::judge::JudgedLog;
use crate::model::signs;
use crate::record::page::{Page, PageStage, PlannedLog};
use crate::record::polarity;

#[cfg(test)]
pub(super) mod tests;

/// What is known of a run so far.
#[derive(Clone, Copy)]
pub(crate) struct Progress<'a> {
    /// Title page of the run.
    pub page: &'a Page,
    /// Requirements that it is judged by.
    pub requirements: &'a Requirements,
    /// The judged logs, in the page's order; `None` where there is none.
    pub judged: &'a [Option<&'a JudgedLog>],
}

impl Progress<'_> {
    /// Why the procedure of an index must not begin: what it relies on is not there. `None` if it may.
    pub(crate) fn held_back(&self, index: usize) -> Option<String> {
        let planned = self.page.procedures.get(index)?;
        self.polarity(planned).or_else(|| self.stages(planned))
    }

    fn log(&self, index: usize) -> Option<&JudgedLog> {
        *self.judged.get(index)?
    }

    /// Signs and scales in its build state, where it closes loops.
    fn polarity(&self, planned: &PlannedLog) -> Option<String> {
        if !planned.closes_loops || planned.kind == signs::POLARITY {
            return None;
        }
        let outcome = |index: usize| self.log(index).map(|log| (log.findings.status, log.proof.clone()));
        let gate = polarity::gate_in(planned.state.as_deref(), &self.page.procedures, outcome);
        gate.reason().map(str::to_owned)
    }

    fn stages(&self, planned: &PlannedLog) -> Option<String> {
        let own = self.stage(planned.stage.as_deref()?)?;
        let not_in_order = own.needs.iter().find_map(|id| {
            let reason = self.members(id).find_map(|(index, p)| self.out_of_order(index, p))?;
            Some(format!("stage `{}` needs stage `{id}`: {reason}", own.id))
        });
        not_in_order.or_else(|| self.not_passed(own))
    }

    fn stage(&self, id: &str) -> Option<&PageStage> {
        self.page.stages.iter().find(|stage| stage.id == id)
    }

    fn members(&self, stage: &str) -> impl Iterator<Item = (usize, &PlannedLog)> {
        self.page.procedures.iter().enumerate().filter(move |(_, p)| p.stage.as_deref() == Some(stage))
    }

    /// How a procedure of a needed stage fell short.
    fn out_of_order(&self, index: usize, planned: &PlannedLog) -> Option<String> {
        let Some(log) = self.log(index) else { return Some(format!("{} left no log", planned.id)) };
        if let Some(damage) = &log.damage {
            return Some(format!("{}: {damage}", planned.id));
        }
        if log.findings.status != Status::Completed {
            return Some(format!("{} {}", planned.id, log.findings.status.word()));
        }
        if log.proof.is_none() && planned.kind == signs::TRACKER_SIGN {
            return Some(format!("{} did not prove the tracker's sign", planned.id));
        }
        let fault = log.proof.as_ref().and_then(|proof| proof.faults.first())?;
        Some(format!("{}: {fault}", planned.id))
    }

    /// The first requirement that what was measured before does not pass.
    fn not_passed(&self, own: &PageStage) -> Option<String> {
        if own.needs_pass.is_empty() {
            return None;
        }
        let mut measured = Vec::new();
        for stage in self.before(own) {
            let judged = self.members(&stage).filter(|(_, p)| p.state.is_none());
            measured.extend(judged.filter_map(|(index, p)| {
                Some((p.id.clone(), self.log(index)?.findings.measurements.clone()))
            }));
        }
        let (outcomes, _) = roll_up(self.requirements, &measured, &[], Claim::Acceptance);
        own.needs_pass.iter().find_map(|id| {
            let verdict =
                outcomes.iter().find(|o| o.requirement == *id).map_or(Verdict::None, |o| o.before_coverage);
            let found = match verdict {
                Verdict::Pass | Verdict::ConditionalPass => return None,
                Verdict::None | Verdict::Screened => "it was not measured",
                Verdict::Inconclusive => "it is inconclusive",
                Verdict::ConditionalFail | Verdict::Fail => "it failed",
            };
            Some(format!("stage `{}` needs requirement {id} to pass: {found}", own.id))
        })
    }

    /// Ids of the stages that a stage needs, directly or through others.
    fn before(&self, own: &PageStage) -> Vec<String> {
        let mut all = own.needs.clone();
        let mut next = 0;
        while let Some(id) = all.get(next).cloned() {
            let further = self.stage(&id).map_or(&[][..], |stage| stage.needs.as_slice());
            let new: Vec<String> = further.iter().filter(|id| !all.contains(id)).cloned().collect();
            all.extend(new);
            next += 1;
        }
        all
    }
}
