use super::*;
use crate::sample;

fn facts() -> Vec<Fact> {
    let fact =
        |what: &str, a: &str, b: &str| Fact { what: what.to_owned(), a: a.to_owned(), b: b.to_owned() };
    vec![fact("seed", "1", "2"), fact("rig", "sim", "sim")]
}

/// The sample beside itself with one value changed, one lost and one verdict changed.
fn changed() -> RunComparison {
    let a = sample::results().findings;
    let mut b = a.clone();
    let measurements = &mut b.procedures[0].measurements;
    let first = measurements.iter().position(|m| m.value.is_some() && m.u > 0.0).expect("a measured value");
    measurements[first].value =
        measurements[first].value.map(|value| value + 40.0 * a.procedures[0].measurements[first].u);
    let last = measurements.iter().rposition(|m| m.value.is_some()).expect("a measured value");
    assert_ne!(first, last);
    measurements[last].value = None;
    measurements[last].inconclusive = Some("the | axis\u{1b}[31m did not slide".to_owned());
    b.outcomes[0].verdict = Verdict::Inconclusive;
    RunComparison::of_runs(["runs/1", "runs/2"], facts(), [&a, &b], None)
}

#[test]
fn a_run_beside_itself_is_identical_in_every_form() {
    let findings = sample::results().findings;
    let same = RunComparison::of_runs(["runs/1", "runs/1"], facts(), [&findings, &findings], None);
    assert!(!same.differs() && !same.is_empty());
    assert!(same.headline().starts_with("identical: "), "{}", same.headline());
    assert!(text(&same).ends_with(&same.headline()));
    assert!(markdown(&same).contains("## Identical values"));
    assert!(json(&same).contains("\"identical\": true"));
}

#[test]
fn what_differs_what_is_lost_and_what_changed_its_verdict_is_told() {
    let compared = changed();
    assert!(compared.differs());
    let text = text(&compared);
    for part in
        ["Values that differ: 1", "Values of A alone: 1", "Verdicts that changed", "did not slide", "28 "]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let seed = text.lines().find(|line| line.starts_with("seed ")).expect("a fact");
    assert!(seed.ends_with("differs"), "{seed}");
    let rig = text.lines().find(|line| line.starts_with("rig ")).expect("a fact");
    assert!(!rig.ends_with("differs"), "{rig}");
    assert!(!text.contains('\u{1b}'), "nothing steers a terminal");
}

#[test]
fn tables_of_markdown_are_whole_whatever_stands_in_their_cells() {
    let page = markdown(&changed());
    let mut columns = 0;
    for line in page.lines() {
        let bars = line.replace("\\|", "").matches('|').count();
        match (line.starts_with('|'), columns) {
            (false, _) => columns = 0,
            (true, 0) => columns = bars,
            (true, _) => assert_eq!(bars, columns, "{line}"),
        }
    }
    assert!(page.contains("the \\| axis\u{fffd}\\[31m did not slide"), "{page}");
}

#[test]
fn the_data_says_of_every_pair_what_the_comparison_says() {
    let data: serde_json::Value = serde_json::from_str(&json(&changed())).expect("JSON");
    assert_eq!((&data["schema"], &data["differs"]), (&"comparison/1".into(), &true.into()));
    let values = data["findings"]["values"].as_array().expect("a list of values");
    let differs: Vec<_> = values.iter().filter(|pair| pair["call"] == "differs").collect();
    assert_eq!(differs.len(), 1);
    let apart = differs[0]["difference"]["apart_u"].as_f64().expect("in units of u");
    assert!((apart - 40.0 / 2.0_f64.sqrt()).abs() < 1e-9, "{apart}");
    assert!(values.iter().any(|pair| pair["call"] == "only-in-a" && pair["b"].is_null()));
}
