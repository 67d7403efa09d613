//! `junit.xml`: a test case for each requirement and limit, for build servers.
//!
//! Cases stand in the suite of the stage whose procedure decided them. Fail and conditional fail are failures; what the campaign must
//! measure and did not, inconclusive requirements, estimates that disagree, and procedures that were aborted, errored or lost are errors. Screened, reported
//! without a limit, not applicable, not in this campaign: skipped, with the reason. So a run that ends with exit code 0 has neither
//! failures nor errors. `time` is the time on the rig, s.
//!
//! The elements are those of Jenkins' `junit-10.xsd`, which lets properties stand in suites only: what lies behind a case is text in
//! its `system-out`.

use procedures::measurement::Measurement;
use procedures::verdict::{Judgement, Verdict};

use crate::markup::Markup;
use crate::number::{self, Shown};
use crate::record::{
    EvidenceState, Findings, LimitFindings, ProcedureFindings, RequirementFindings, Results, Status,
};
use crate::row::{self, Evidence, Row};
use crate::words;

/// What a case comes to.
#[derive(Debug)]
pub(crate) enum Result {
    Passed,
    Failed(String),
    Error(&'static str, String),
    Skipped(String),
}

#[derive(Debug)]
struct Case {
    name: String,
    result: Result,
    time_s: f64,
    /// Lines of its `system-out`.
    behind: Vec<String>,
}

#[derive(Debug)]
struct Suite {
    name: String,
    /// Procedures of the stage.
    procedures: Vec<String>,
    time_s: f64,
    cases: Vec<Case>,
}

/// The whole document.
pub fn render(results: &Results) -> String {
    let findings = &results.findings;
    let mut suites = stages(results);
    let mut unmeasured = Vec::new();
    for row in row::rows(findings) {
        let own = row.evidence.as_ref().and_then(|found| {
            suites.iter_mut().find(|suite| suite.procedures.iter().any(|id| id == found.procedure))
        });
        own.map_or(&mut unmeasured, |suite| &mut suite.cases).push(case(findings, &row));
    }
    unmeasured.extend(named(findings));
    suites.push(alone("not-measured", unmeasured));
    suites.push(alone("agreement", findings.disagreements.iter().map(|text| disagreement(text)).collect()));
    suites.push(alone("evidence", vec![evidence(results)]));
    suites.retain(|suite| !suite.cases.is_empty());
    write(results, &suites)
}

fn alone(name: &str, cases: Vec<Case>) -> Suite {
    Suite { name: name.to_owned(), procedures: Vec::new(), time_s: 0.0, cases }
}

/// A suite for each stage, in the order of the campaign; procedures without one have a suite of their own.
fn stages(results: &Results) -> Vec<Suite> {
    let mut suites: Vec<Suite> = Vec::new();
    for procedure in &results.findings.procedures {
        let name = procedure.stage.as_ref().unwrap_or(&procedure.id);
        let place = suites.iter().position(|suite| suite.name == *name).unwrap_or_else(|| {
            suites.push(alone(name, Vec::new()));
            suites.len() - 1
        });
        let suite = &mut suites[place];
        suite.procedures.push(procedure.id.clone());
        let time_s = results.record.attempt_at(&procedure.id).and_then(|a| a.ran_s).unwrap_or(0.0);
        suite.time_s += time_s;
        suite.cases.extend(procedure_case(procedure, time_s));
    }
    suites
}

/// A procedure that did not come to its end, and one of which nothing is judged: a suite without a case would look like none at all.
fn procedure_case(procedure: &ProcedureFindings, time_s: f64) -> Option<Case> {
    let reasons = procedure.points.iter().filter(|point| point.status != Status::Completed);
    let reason = reasons.filter_map(|point| Some(format!("{}: {}", point.point, point.reason.as_deref()?)));
    let word = procedure.status.word();
    let message = reason.take(1).fold(word.to_owned(), |word, reason| format!("{word}: {reason}"));
    let result = match procedure.status {
        Status::Completed if procedure.judgements.is_empty() => {
            Result::Skipped(format!("{} measurements, none of them judged", procedure.measurements.len()))
        }
        Status::Completed => return None,
        Status::Skipped | Status::NotRun => Result::Skipped(message),
        Status::Aborted | Status::Errored | Status::Lost => Result::Error("bench", message),
    };
    Some(Case { name: procedure.id.clone(), result, time_s, behind: Vec::new() })
}

/// Two estimates of one quantity that are too far apart: what is compared, up to the first colon, names the case.
fn disagreement(sentence: &str) -> Case {
    let name = sentence.split(':').next().unwrap_or(sentence).to_owned();
    Case { name, result: Result::Error("inconclusive", sentence.to_owned()), time_s: 0.0, behind: Vec::new() }
}

/// A requirement and the limit of one of its measurands.
fn case(findings: &Findings, row: &Row<'_>) -> Case {
    let Some(found) = &row.evidence else { return unmeasured(row) };
    let limit = limit(row.requirement, found.judgement, found.measurand);
    let text = row.band.or(limit.as_ref().map(|limit| limit.text.as_str())).unwrap_or("reported only");
    let deciding = findings.deciding_of(found.procedure, found.judgement);
    let time_s = deciding.map_or(0.0, |m| m.evidence.iter().fold(0.0, |s, e| s + e.t1_s - e.t0_s));
    Case {
        name: format!("{} {} {text}", row.requirement.id, found.measurand),
        result: result(row, found, limit.as_ref(), deciding),
        time_s,
        behind: behind(findings, row, found.measurand),
    }
}

fn unmeasured(row: &Row<'_>) -> Case {
    let requirement = row.requirement;
    let message = row.reason.clone().unwrap_or_else(|| "not measured".to_owned());
    let result =
        if requirement.required { Result::Error("inconclusive", message) } else { Result::Skipped(message) };
    let name = format!("{} {}", requirement.id, requirement.limit_text).trim_end().to_owned();
    Case { name, result, time_s: 0.0, behind: Vec::new() }
}

/// The limit by which this was judged.
fn limit(requirement: &RequirementFindings, j: &Judgement, measurand: &str) -> Option<LimitFindings> {
    let of_all = || requirement.judged(measurand)?.limit.clone();
    j.limit.as_ref().map(LimitFindings::from).or_else(of_all)
}

fn result(
    row: &Row<'_>,
    found: &Evidence<'_>,
    limit: Option<&LimitFindings>,
    deciding: Option<&Measurement>,
) -> Result {
    let reason = || row.reason.clone().unwrap_or_else(|| "no reason is given".to_owned());
    match row.verdict {
        Verdict::Pass | Verdict::ConditionalPass => Result::Passed,
        Verdict::Fail | Verdict::ConditionalFail => Result::Failed(shortfall(row, found, limit, deciding)),
        Verdict::Inconclusive => Result::Error("inconclusive", reason()),
        Verdict::Screened => Result::Skipped(format!("screened: {}", reason())),
        Verdict::None => Result::Skipped("no limit: reported only".to_owned()),
    }
}

/// `268.0 > 260 N*m (U 2.2)`.
fn shortfall(
    row: &Row<'_>,
    found: &Evidence<'_>,
    limit: Option<&LimitFindings>,
    deciding: Option<&Measurement>,
) -> String {
    let reason = row.reason.as_deref().map_or_else(String::new, |reason| format!("; {reason}"));
    let conditional = if row.verdict == Verdict::ConditionalFail { ", less than the guard band" } else { "" };
    let (Some(limit), Some(value)) = (limit, deciding.and_then(|m| m.value)) else {
        return format!("{}{reason}", row.sign.word);
    };
    let unit = Shown::of_limit(limit);
    let (value_text, u) = unit.pair(value, found.judgement.expanded_u);
    let bound = |si: f64| unit.with_unit(&number::short(unit.number(si), 6));
    let against = match (limit.low, limit.high) {
        (Some(low), _) if value < low => format!("< {}", bound(low)),
        (_, Some(high)) if value > high => format!("> {}", bound(high)),
        _ => format!("against {}", limit.text),
    };
    format!("{value_text} {against} (U {u}){conditional}{reason}")
}

/// What a person who opens the case wants to know: rule, and every number that was judged by the limit with its place in a log.
fn behind(findings: &Findings, row: &Row<'_>, measurand: &str) -> Vec<String> {
    let mut lines = vec![format!("verifies: {}: {}", row.requirement.id, row.requirement.text)];
    lines.extend(row.requirement.judged(measurand).map(|judged| format!("rule: {}", judged.rule.name())));
    lines.push(format!("verdict: {}", row.sign.word));
    for procedure in &findings.procedures {
        let judgements = procedure.judgements.iter().filter(|j| j.requirement == row.requirement.id);
        for judgement in judgements.filter(|j| j.band.as_deref() == row.band) {
            let own = procedure.measurements.get(judgement.measurement);
            let own = own.filter(|m| m.measurand == measurand);
            lines.extend(own.map(|m| point(procedure, judgement, m, row.requirement)));
        }
    }
    lines
}

/// `AZ-FRICTION velocity=10 deg/s: 212.3 N*m, U 4.1 N*m, margin 47.7 N*m: pass; AZ-FRICTION.mcap 12.300..19.800 s`.
fn point(
    procedure: &ProcedureFindings,
    j: &Judgement,
    m: &Measurement,
    requirement: &RequirementFindings,
) -> String {
    let limit = limit(requirement, j, &m.measurand);
    let unit = limit.as_ref().map_or_else(|| Shown::of_kind(m.kind), Shown::of_limit);
    let mut line = procedure.id.clone();
    if !m.axis.is_empty() {
        line += &format!(" {}", m.axis);
    }
    if let Some(point) = &m.point {
        line += &format!(" {point}");
    }
    let shown = |text: &str| unit.with_unit(text);
    line += &m.value.map_or_else(
        || ": no value".to_owned(),
        |value| {
            let (value, u) = unit.pair(value, j.expanded_u);
            format!(": {}, U {}", shown(&value), shown(&u))
        },
    );
    if let Some(margin) = j.margin {
        line += &format!(", margin {}", shown(&unit.pair(margin, j.expanded_u).0));
    }
    line += &format!(": {}", words::verdict(j.verdict).word);
    if let Some(reason) = j.reason.as_ref().or(m.inconclusive.as_ref()) {
        line += &format!(" ({reason})");
    }
    for e in &m.evidence {
        line += &format!("; {} {:.3}..{:.3} s", e.file, e.t0_s, e.t1_s);
    }
    line
}

/// Whether the files behind this document are those of the run: altered ones are an error, whatever the verdicts say.
fn evidence(results: &Results) -> Case {
    let sentence = words::evidence(results);
    let result = match results.evidence.as_ref().map(|found| found.state) {
        Some(EvidenceState::Intact) => Result::Passed,
        Some(EvidenceState::Altered) => Result::Error("bench", sentence.clone()),
        Some(EvidenceState::NotVerifiable) | None => Result::Skipped(sentence.clone()),
    };
    Case { name: "run-folder".to_owned(), result, time_s: 0.0, behind: vec![sentence] }
}

/// Requirements that the result only names.
fn named(findings: &Findings) -> Vec<Case> {
    let one = |(why, id): (&'static str, &str)| Case {
        name: id.to_owned(),
        result: Result::Skipped(why.to_owned()),
        time_s: 0.0,
        behind: Vec::new(),
    };
    let lists = row::named_only(findings).into_iter();
    lists.flat_map(|(why, ids)| ids.into_iter().map(move |id| (why, id))).map(one).collect()
}

fn write(results: &Results, suites: &[Suite]) -> String {
    let mut m = Markup::default();
    m.verbatim("<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
    let [tests, failures, errors, _] = sums(suites.iter().flat_map(|s| &s.cases).map(|case| &case.result));
    let name = class(results);
    let time = seconds(suites.iter().map(|suite| suite.time_s).sum());
    m.open(
        "testsuites",
        &[("name", &name), ("time", &time), ("tests", &tests), ("failures", &failures), ("errors", &errors)],
    );
    for suite in suites {
        write_suite(&mut m, results, suite);
    }
    m.finish()
}

fn class(results: &Results) -> String {
    format!("bench.{}", results.findings.campaign.id)
}

fn seconds(s: f64) -> String {
    format!("{s:.3}")
}

/// Tests, failures, errors, skipped.
pub(crate) fn sums<'a>(results: impl Iterator<Item = &'a Result>) -> [String; 4] {
    let mut counts = [0usize; 4];
    for result in results {
        counts[0] += 1;
        match result {
            Result::Passed => {}
            Result::Failed(_) => counts[1] += 1,
            Result::Error(..) => counts[2] += 1,
            Result::Skipped(_) => counts[3] += 1,
        }
    }
    counts.map(|n| n.to_string())
}

fn write_suite(m: &mut Markup, results: &Results, suite: &Suite) {
    let [tests, failures, errors, skipped] = sums(suite.cases.iter().map(|case| &case.result));
    let time = seconds(suite.time_s);
    let record = &results.record;
    let mut attributes = vec![
        ("name", suite.name.as_str()),
        ("tests", &tests),
        ("failures", &failures),
        ("errors", &errors),
        ("skipped", &skipped),
        ("time", &time),
    ];
    attributes.extend(record.station.as_deref().map(|host| ("hostname", host)));
    attributes.extend(record.started_utc.as_deref().map(|started| ("timestamp", started)));
    m.open("testsuite", &attributes);
    let findings = &results.findings;
    m.open("properties", &[]);
    for (name, value) in [
        ("procedures", suite.procedures.join(" ").as_str()),
        ("unit", &findings.unit),
        ("serial-number", record.serial_number.as_deref().unwrap_or("")),
        ("seed", &findings.seed.to_string()),
    ] {
        if !value.is_empty() {
            m.empty("property", &[("name", name), ("value", value)]);
        }
    }
    m.close();
    let class = class(results);
    for case in &suite.cases {
        m.open("testcase", &[("classname", &class), ("name", &case.name), ("time", &seconds(case.time_s))]);
        write_result(m, &case.result, "limit");
        if !case.behind.is_empty() {
            m.element("system-out", &[], &case.behind.join("\n"));
        }
        m.close();
    }
    m.close();
}

/// What a case comes to; `failure` is the type of a failed one.
pub(crate) fn write_result(m: &mut Markup, result: &Result, failure: &str) {
    match result {
        Result::Passed => {}
        Result::Failed(message) => m.empty("failure", &[("type", failure), ("message", message)]),
        Result::Error(kind, message) => m.empty("error", &[("type", kind), ("message", message)]),
        Result::Skipped(message) => m.empty("skipped", &[("message", message)]),
    }
}
