//! What a build server reads of a run.

use procedures::verdict::{Overall, Verdict};

use super::{rendered, without_pictures};
use crate::sample;

#[test]
fn a_missing_required_requirement_is_an_error_for_a_build_server() {
    let xml = rendered("junit", &sample::results());
    let after = xml.split("name=\"SPR-EL ").nth(1).expect("it is there");
    let case = after.split("</testcase>").next().expect("it is closed");
    assert!(case.contains("<error type=\"inconclusive\" message=\"nothing was measured\"/>"), "{case}");
}

#[test]
fn counts_of_junit_are_the_cases_that_it_lists() {
    let xml = rendered("junit", &sample::results());
    let total = |name: &str| -> usize {
        let suites = xml.split("<testsuite ").skip(1).filter_map(|t| t.split('>').next());
        let value = |head: &str| head.split(&format!("{name}=\"")).nth(1)?.split('"').next()?.parse().ok();
        suites.map(|head| -> usize { value(head).expect("a number") }).sum()
    };
    for (name, element) in
        [("tests", "<testcase "), ("failures", "<failure "), ("errors", "<error "), ("skipped", "<skipped ")]
    {
        assert_eq!(total(name), xml.matches(element).count(), "{name}");
    }
}

/// Names of the cases with this element in them, or of all.
fn cases<'a>(xml: &'a str, element: &str) -> Vec<&'a str> {
    let all = xml.split("<testcase ").skip(1).map(|t| t.split("</testcase>").next().unwrap_or(t));
    let holds = all.filter(|case| case.contains(element));
    holds.filter_map(|case| case.split(" name=\"").nth(1)?.split('"').next()).collect()
}

#[test]
fn junit_has_a_case_for_each_requirement_and_limit_and_its_counts_are_those_of_the_verdicts() {
    let results = sample::results();
    let xml = rendered("junit", &results);
    let judged_as = |verdicts: &[Verdict]| {
        results.findings.outcomes.iter().filter(|o| o.judged > 0 && verdicts.contains(&o.verdict)).count()
    };
    assert_eq!(cases(&xml, "<failure ").len(), judged_as(&[Verdict::Fail, Verdict::ConditionalFail]));
    let errors = cases(&xml, "<error type=\"inconclusive\"");
    let missing = results.findings.outcomes.iter().filter(|o| o.required && o.judged == 0).count();
    assert_eq!(errors.len(), judged_as(&[Verdict::Inconclusive]) + missing, "{errors:?}");
    let all = cases(&xml, "");
    for outcome in results.findings.outcomes.iter().filter(|o| o.judged > 0) {
        let own = all.iter().filter(|name| name.starts_with(&format!("{} ", outcome.requirement))).count();
        assert_eq!(own, outcome.by_measurand.len().max(1), "{}", outcome.requirement);
    }
    assert!(xml.contains("message=\"529.9 &gt; 260 N*m (U 5.7)\""), "{xml}");
}

#[test]
fn a_run_that_ends_with_0_has_neither_failures_nor_errors_and_what_was_screened_is_skipped() {
    let mut results = without_pictures();
    let findings = &mut results.findings;
    findings.overall = Overall::Screening;
    for (k, outcome) in findings.outcomes.iter_mut().filter(|o| o.judged > 0).enumerate() {
        outcome.verdict = if k == 0 { Verdict::Screened } else { Verdict::Pass };
        outcome.reason = (k == 0).then(|| "not measured: elevation 45 deg".to_owned());
    }
    findings.outcomes.iter_mut().for_each(|o| o.required = false);
    findings.requirements.iter_mut().for_each(|r| r.required = false);
    findings.procedures.iter_mut().for_each(|p| p.status = crate::record::Status::Completed);
    let xml = rendered("junit", &results);
    assert_eq!((cases(&xml, "<failure "), cases(&xml, "<error ")), (vec![], vec![]));
    let screened = cases(&xml, "<skipped message=\"screened: not measured: elevation 45 deg\"");
    assert_eq!(screened.len(), 1, "{xml}");
}

#[test]
fn estimates_that_disagree_are_an_error_for_a_build_server_and_stand_at_the_top_of_the_report() {
    let mut results = without_pictures();
    let sentence = "viscous-coefficient of el: FAST found 81 ± 1, SLOW found 68 ± 1: 9.2 apart, 3 allowed.";
    results.findings.disagreements = vec![sentence.to_owned()];
    let case = format!("<error type=\"inconclusive\" message=\"{sentence}\"");
    assert!(rendered("junit", &results).contains(&case), "{}", rendered("junit", &results));
    let page = rendered("html", &results);
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text} in the page"));
    assert!(place("Estimates disagree: ") < place("Statement of conformity"));
    assert!(rendered("md", &results).contains(&format!("**Estimates disagree: {sentence}**")));
}

#[test]
fn a_procedure_that_did_not_come_to_its_end_is_an_error_with_its_reason() {
    let mut results = without_pictures();
    let procedure = &mut results.findings.procedures[0];
    procedure.status = crate::record::Status::Aborted;
    procedure.points[0].status = crate::record::Status::Aborted;
    procedure.points[0].reason = Some("tripped: following error: az".to_owned());
    let xml = rendered("junit", &results);
    let case = xml.split("name=\"AZ-FRICTION\" time=").nth(1).and_then(|t| t.split("</testcase>").next());
    let case = case.expect("it has a case of its own");
    assert!(
        case.contains("<error type=\"bench\"") && case.contains("tripped: following error: az"),
        "{case}"
    );
}
