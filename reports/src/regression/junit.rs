//! A regression as test cases.

use procedures::regression::{Call, Outcome};

use super::Regression;
use super::sections;
use crate::junit::{Result, sums, write_result};
use crate::markup::Markup;

struct Case {
    name: String,
    result: Result,
}

pub(super) fn render(found: &Regression) -> String {
    let cases = cases(found);
    let [tests, failures, errors, skipped] = sums(cases.iter().map(|case| &case.result));
    let name = format!("bench.regress.{}", found.scenario.campaign);
    let mut m = Markup::default();
    m.verbatim("<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
    let counts = [("name", name.as_str()), ("tests", &tests), ("failures", &failures), ("errors", &errors)];
    m.open("testsuites", &counts);
    m.open("testsuite", &[counts.as_slice(), &[("skipped", skipped.as_str())]].concat());
    for case in &cases {
        m.open("testcase", &[("classname", &name), ("name", &case.name)]);
        write_result(&mut m, &case.result, "regression");
        m.close();
    }
    m.finish()
}

fn cases(found: &Regression) -> Vec<Case> {
    let criteria = found
        .worst_first()
        .into_iter()
        .map(|outcome| Case { name: outcome.criterion.name(), result: result(outcome) });
    let ends = found.ends.iter().map(|end| {
        let why = end.candidate.as_ref().or(end.baseline.as_ref()).cloned().unwrap_or_default();
        let result = if end.candidate_first {
            Result::Failed(format!("ended early with the candidate: {why}"))
        } else {
            Result::Skipped(format!("ended early with the baseline, too: {why}"))
        };
        Case { name: format!("unit {} with seed {}", end.unit, end.seed), result }
    });
    criteria.chain(ends).collect()
}

fn result(outcome: &Outcome) -> Result {
    let said = format!("{}: {}", sections::word(outcome), sections::shift(outcome));
    match outcome.call {
        _ if outcome.blocks => Result::Failed(said),
        Call::Worse | Call::Inconclusive if outcome.criterion.blocking => Result::Error("inconclusive", said),
        Call::Worse | Call::Inconclusive => Result::Skipped(said),
        Call::Better | Call::Equivalent | Call::Identical => Result::Passed,
    }
}
