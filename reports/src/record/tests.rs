use super::*;
use crate::{json, sample};
use procedures::trace::{LimitLine, Series};

fn verdict_of(results: &Results, id: &str) -> Verdict {
    results.findings.outcome(id).expect("it is in the sample").verdict
}

#[test]
fn a_value_that_is_not_finite_becomes_none_with_a_flag_and_no_verdict_rests_on_it() {
    for broken in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut results = sample::results();
        assert_eq!(verdict_of(&results, "SPR-AZ"), Verdict::Pass);
        let spring = &mut results.findings.procedures[0].measurements[4];
        spring.value = Some(broken);
        results.make_finite();
        let spring = &results.findings.procedures[0].measurements[4];
        assert_eq!(spring.value, None);
        assert_eq!(spring.flags, ["value not a finite number"]);
        assert_eq!(spring.inconclusive.as_deref(), Some("value is not a finite number"));
        assert_eq!(results.findings.procedures[0].judgements[3].verdict, Verdict::Inconclusive);
        assert_eq!(verdict_of(&results, "SPR-AZ"), Verdict::Inconclusive);
        assert_eq!(results.findings.overall, Overall::Fail, "the worst verdict stays");
    }
}

#[test]
fn an_infinite_uncertainty_takes_the_pass_from_a_campaign() {
    let mut results = sample::results();
    results.findings.overall = Overall::Pass;
    results.findings.procedures[0].measurements[4].u = f64::INFINITY;
    results.make_finite();
    assert_eq!(results.findings.overall, Overall::Inconclusive);
}

#[test]
fn an_infinite_expanded_uncertainty_makes_its_judgement_inconclusive() {
    let mut results = sample::results();
    results.findings.procedures[1].judgements[2].expanded_u = f64::NAN;
    results.make_finite();
    let judgement = &results.findings.procedures[1].judgements[2];
    assert_eq!((judgement.expanded_u, judgement.verdict), (0.0, Verdict::Inconclusive));
    assert_eq!(judgement.margin, None);
}

#[test]
fn json_holds_no_null_where_the_structure_has_a_number() {
    let mut results = sample::results();
    let procedure = &mut results.findings.procedures[0];
    procedure.measurements[0].u = f64::NAN;
    procedure.measurements[1].conditions[0].requested = f64::INFINITY;
    procedure.measurements[2].evidence[0].t0_s = f64::NAN;
    procedure.judgements[0].k = f64::NAN;
    procedure.judgements[1].acceptance = [Some(f64::NEG_INFINITY), None];
    procedure.plots[0].series[0].y[3] = f64::NAN;
    procedure.plots[0].limits.push(LimitLine { label: String::new(), y: f64::INFINITY, x: None });
    results.record.wall_s = f64::NAN;
    results.record.speed_factor = Some(f64::INFINITY);
    let back = json::parse(&json::render(&results)).expect("null in place of a number does not read back");
    let plot = &back.findings.procedures[0].plots[0];
    assert_eq!((plot.series[0].x.len(), plot.series[0].y.len(), plot.limits.len()), (480, 480, 0));
    assert_eq!(back.record.speed_factor, None);
}

#[test]
fn series_of_unequal_length_are_cut_to_whole_points() {
    let mut results = sample::results();
    results.findings.procedures[0].plots[0].series[0] = Series {
        label: String::new(),
        style: procedures::trace::Style::Line,
        x: vec![1.0, 2.0, 3.0],
        y: vec![1.0, 2.0],
        u: vec![0.1],
        whole: None,
    };
    results.make_finite();
    let series = &results.findings.procedures[0].plots[0].series[0];
    assert_eq!((series.x.len(), series.y.len(), series.u.len()), (2, 2, 0));
}

#[test]
fn finite_results_are_left_alone() {
    let results = sample::results();
    let mut same = results.clone();
    same.make_finite();
    assert_eq!(same, results);
}

#[test]
fn a_row_collects_what_names_its_point() {
    let procedure = &sample::results().findings.procedures[0];
    let row = &procedure.points[1];
    assert_eq!(row.measurements, [1]);
    assert_eq!(row.verdict, Verdict::Fail);
    assert_eq!(row.conditions.len(), 1);
    assert_eq!(procedure.points[2].verdict, Verdict::None, "no requirement judges 60 °/s");
}

#[test]
fn a_final_report_needs_its_title_page() {
    let mut record = sample::results().record;
    assert_eq!(
        record.missing_for_final(),
        ["report number", "revision", "date of issue", "part number", "unit revision", "station"]
    );
    let some = || Some("x".to_owned());
    record.title_page = TitlePage {
        report_id: some(),
        revision: some(),
        issued_utc: some(),
        part_number: some(),
        unit_revision: some(),
        ..TitlePage::default()
    };
    record.station = some();
    assert!(record.missing_for_final().is_empty());
}
