//! `junit.xml`: a test suite a procedure, a test case a measurement and requirement, for build servers.
//!
//! Fail and conditional fail are failures; inconclusive measurements, points that did not complete and required
//! requirements without a measurement are errors: red beats silent. Measurements that nothing judges are passed
//! cases without a requirement.

use procedures::measurement::Measurement;
use procedures::verdict::{Judgement, Verdict};

use crate::markup::Markup;
use crate::number::Shown;
use crate::record::{
    EvidenceState, Findings, LimitFindings, PointRow, ProcedureFindings, RequirementFindings, Results, Status,
};
use crate::{row, words};

/// What a case comes to.
#[derive(Debug)]
enum Result {
    Passed,
    Failed(String),
    Error(&'static str, String),
    Skipped(String),
}

#[derive(Debug)]
struct Case {
    name: String,
    result: Result,
    properties: Vec<(&'static str, String)>,
}

#[derive(Debug)]
struct Suite {
    name: String,
    cases: Vec<Case>,
}

/// The whole document.
pub fn render(results: &Results) -> String {
    let findings = &results.findings;
    let mut suites: Vec<Suite> = findings.procedures.iter().map(|p| suite(findings, p)).collect();
    suites.extend(unmeasured(findings));
    suites.push(evidence(results));
    let mut m = Markup::default();
    m.verbatim("<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
    let (tests, failures, errors, skipped) = sums(suites.iter().flat_map(|s| &s.cases));
    let name = format!("bench.{}", findings.campaign.id);
    let time = format!("{:.3}", results.record.wall_s);
    m.open(
        "testsuites",
        &[
            ("name", &name),
            ("tests", &tests),
            ("failures", &failures),
            ("errors", &errors),
            ("skipped", &skipped),
            ("time", &time),
        ],
    );
    for suite in &suites {
        write_suite(&mut m, results, suite);
    }
    m.finish()
}

fn sums<'a>(cases: impl Iterator<Item = &'a Case>) -> (String, String, String, String) {
    let mut counts = [0usize; 4];
    for case in cases {
        counts[0] += 1;
        match case.result {
            Result::Passed => {}
            Result::Failed(_) => counts[1] += 1,
            Result::Error(..) => counts[2] += 1,
            Result::Skipped(_) => counts[3] += 1,
        }
    }
    let [tests, failures, errors, skipped] = counts.map(|n| n.to_string());
    (tests, failures, errors, skipped)
}

fn write_suite(m: &mut Markup, results: &Results, suite: &Suite) {
    let (tests, failures, errors, skipped) = sums(suite.cases.iter());
    let started = results.record.started_utc.as_deref().unwrap_or("");
    let host = results.record.station.as_deref().unwrap_or("");
    let mut attributes = vec![
        ("name", suite.name.as_str()),
        ("tests", &tests),
        ("failures", &failures),
        ("errors", &errors),
        ("skipped", &skipped),
        ("hostname", host),
    ];
    if !started.is_empty() {
        attributes.push(("timestamp", started));
    }
    m.open("testsuite", &attributes);
    let class = format!("bench.{}", suite.name);
    for case in &suite.cases {
        m.open("testcase", &[("classname", &class), ("name", &case.name)]);
        write_case(m, case);
        m.close();
    }
    m.close();
}

fn write_case(m: &mut Markup, case: &Case) {
    if !case.properties.is_empty() {
        m.open("properties", &[]);
        for (name, value) in &case.properties {
            m.empty("property", &[("name", name), ("value", value)]);
        }
        m.close();
    }
    match &case.result {
        Result::Passed => {}
        Result::Failed(message) => m.empty("failure", &[("type", "limit"), ("message", message)]),
        Result::Error(kind, message) => m.empty("error", &[("type", kind), ("message", message)]),
        Result::Skipped(message) => m.empty("skipped", &[("message", message)]),
    }
}

fn suite(findings: &Findings, p: &ProcedureFindings) -> Suite {
    let mut cases: Vec<Case> =
        p.points.iter().filter(|row| row.status != Status::Completed).map(point_case).collect();
    for (index, measurement) in p.measurements.iter().enumerate() {
        let judgements: Vec<&Judgement> = p.judgements_of(index).collect();
        if judgements.is_empty() {
            cases.push(case(findings, measurement, None));
        }
        cases.extend(judgements.into_iter().map(|j| case(findings, measurement, Some(j))));
    }
    if cases.is_empty() {
        // Red beats silent: a suite without a single case would look green.
        let message = format!("{}: nothing was measured", p.status.word());
        let result = Result::Error("bench", message);
        cases.push(Case { name: "procedure".to_owned(), result, properties: Vec::new() });
    }
    Suite { name: p.id.clone(), cases }
}

fn point_case(point: &PointRow) -> Case {
    let reason = point.reason.as_deref().map_or(String::new(), |r| format!(": {r}"));
    let message = format!("{}{reason}", point.status.word());
    let result = match point.status {
        Status::Skipped | Status::NotRun => Result::Skipped(message),
        _ => Result::Error("bench", message),
    };
    Case { name: format!("point[{}]", point.point), result, properties: Vec::new() }
}

fn case(findings: &Findings, m: &Measurement, j: Option<&Judgement>) -> Case {
    let requirement = j.and_then(|j| findings.requirement(&j.requirement));
    let mut name = match &m.point {
        Some(point) => format!("{}[{point}]", m.measurand),
        None => m.measurand.clone(),
    };
    if let Some(j) = j {
        name += &format!(" {}", j.requirement);
    }
    let screened =
        j.and_then(|j| findings.outcome(&j.requirement)).filter(|o| o.verdict == Verdict::Screened);
    let result = match (result(requirement, m, j), screened) {
        (Result::Passed, Some(outcome)) => Result::Skipped(format!(
            "screened: {}",
            outcome.reason.as_deref().unwrap_or("not measured in full")
        )),
        (other, _) => other,
    };
    Case { name, result, properties: properties(requirement, m, j) }
}

fn result(requirement: Option<&RequirementFindings>, m: &Measurement, j: Option<&Judgement>) -> Result {
    let reason = || {
        let of_judgement = j.and_then(|j| j.reason.as_deref());
        of_judgement.or(m.inconclusive.as_deref()).unwrap_or("no reason given").to_owned()
    };
    match j.map(|j| j.verdict) {
        Some(Verdict::Fail | Verdict::ConditionalFail) => Result::Failed(failure(requirement, m, j)),
        Some(Verdict::Inconclusive) => Result::Error("inconclusive", reason()),
        None if m.inconclusive.is_some() => Result::Error("inconclusive", reason()),
        _ => Result::Passed,
    }
}

/// `432 N*m breaks <= 260 N*m (U 4.1 N*m): fail`.
fn failure(requirement: Option<&RequirementFindings>, m: &Measurement, j: Option<&Judgement>) -> String {
    let of_all = || requirement.and_then(|r| r.judged(&m.measurand)?.limit.clone());
    let limit = j.and_then(|j| j.limit.as_ref()).map(LimitFindings::from).or_else(of_all);
    let unit = limit.as_ref().map_or_else(|| Shown::of_kind(m.kind), Shown::of_limit);
    let limit = limit.map_or_else(|| "its limit".to_owned(), |l| l.text);
    let (Some(value), Some(j)) = (m.value, j) else { return format!("against {limit}: no value") };
    let (value, u) = unit.pair(value, j.expanded_u);
    format!(
        "{} against {limit} (U {}): {}",
        unit.with_unit(&value),
        unit.with_unit(&u),
        words::verdict(j.verdict).word
    )
}

fn properties(
    requirement: Option<&RequirementFindings>,
    m: &Measurement,
    j: Option<&Judgement>,
) -> Vec<(&'static str, String)> {
    let mut list = Vec::new();
    if let Some(j) = j {
        list.push(("verifies", j.requirement.clone()));
        list.push(("verdict", words::verdict(j.verdict).word.to_owned()));
    }
    if let Some(value) = m.value {
        list.push(("value", format!("{value}")));
        list.push(("unit", m.kind.si_unit().to_owned()));
        list.push(("u", format!("{}", m.u)));
        list.extend(j.map(|j| ("U", format!("{}", j.expanded_u))));
    }
    if let Some(judged) = requirement.and_then(|r| r.judged(&m.measurand)) {
        let special = j.and_then(|j| j.limit.as_ref()).map(LimitFindings::from);
        let limit = special.as_ref().or(judged.limit.as_ref());
        list.extend(limit.and_then(|l| l.low).map(|v| ("low", format!("{v}"))));
        list.extend(limit.and_then(|l| l.high).map(|v| ("high", format!("{v}"))));
        list.push(("rule", judged.rule.name().to_owned()));
    }
    list.extend(
        m.evidence.iter().map(|e| ("evidence", format!("{} {:.3}..{:.3} s", e.file, e.t0_s, e.t1_s))),
    );
    list
}

/// Whether the files behind this document are those of the run: altered ones are an error, whatever the verdicts say.
fn evidence(results: &Results) -> Suite {
    let sentence = words::evidence(results);
    let result = match results.evidence.as_ref().map(|found| found.state) {
        Some(EvidenceState::Intact) => Result::Passed,
        Some(EvidenceState::Altered) => Result::Error("bench", sentence.clone()),
        Some(EvidenceState::NotVerifiable) | None => Result::Skipped(sentence.clone()),
    };
    let properties = vec![("evidence", sentence)];
    Suite {
        name: "evidence".to_owned(),
        cases: vec![Case { name: "run-folder".to_owned(), result, properties }],
    }
}

/// Requirements without a measurement: an error if required, else skipped.
fn unmeasured(findings: &Findings) -> Option<Suite> {
    let mut cases: Vec<Case> = row::rows(findings)
        .into_iter()
        .filter(|r| r.evidence.is_none())
        .map(|r| {
            let message = r.reason.unwrap_or_else(|| "not measured".to_owned());
            let required = r.requirement.required;
            let result =
                if required { Result::Error("inconclusive", message) } else { Result::Skipped(message) };
            let verifies = vec![("verifies", r.requirement.id.clone())];
            Case { name: r.requirement.id.clone(), result, properties: verifies }
        })
        .collect();
    for (why, ids) in row::named_only(findings) {
        cases.extend(ids.into_iter().map(|id| Case {
            name: id.to_owned(),
            result: Result::Skipped(why.to_owned()),
            properties: vec![("verifies", id.to_owned())],
        }));
    }
    (!cases.is_empty()).then(|| Suite { name: "not-measured".to_owned(), cases })
}
