use procedures::population::{MeasuredUnit, Reading, evaluate};
use procedures::quantity::QuantityKind;
use procedures::verdict::Verdict;

use super::*;

/// Forty units whose bandwidth falls with their inertia; two of them fail, one is inconclusive.
fn report(draws: Draws) -> PopulationReport {
    let unit = |k: usize| {
        let order = (k * 17) % 40;
        let value_hz = 10.0 - 0.05 * order as f64;
        let verdict = match order {
            38 | 39 => Verdict::Fail,
            0 => Verdict::Inconclusive,
            _ => Verdict::Pass,
        };
        let reading = Reading {
            requirement: "VEL-BW".to_owned(),
            measurand: "velocity-bandwidth".to_owned(),
            kind: QuantityKind::Frequency,
            value_si: (order > 0).then_some(value_hz),
            verdict,
        };
        let settings_si = vec![
            ("az.inertia".to_owned(), 1000.0 + 10.0 * order as f64),
            ("mirror.coupling".to_owned(), ((k * 7) % 40) as f64),
        ];
        MeasuredUnit { id: format!("u-{k}"), set: k / 4, settings_si, readings: vec![reading] }
    };
    let units: Vec<MeasuredUnit> = (0..40).map(unit).collect();
    let title = Title {
        family: "production".to_owned(),
        family_sha256: "ab".repeat(32),
        method: if draws == Draws::Independent { "independent" } else { "sobol" }.to_owned(),
        seed: 7,
        campaign: "quick".to_owned(),
    };
    PopulationReport::new(title, units.len(), vec![41, 42], draws, evaluate(&units, draws))
}

#[test]
fn a_population_as_text() {
    let independent = text(&report(Draws::Independent));
    let designed = text(&report(Draws::Randomised { sets: 10 }));
    insta::assert_snapshot!(format!("{independent}\n\n{designed}"));
}

#[test]
fn a_population_as_markdown_and_as_data() {
    let report = report(Draws::Independent);
    let markdown = markdown(&report);
    assert!(markdown.contains("| VEL-BW | velocity-bandwidth | 40 | 37 | 1 | 92 % ("), "{markdown}");
    assert!(
        markdown.contains("| VEL-BW | velocity-bandwidth | az.inertia | -1.00, u = 0.00 | &lt; 0.0001 |"),
        "{markdown}"
    );
    assert!(!markdown.contains("mirror.coupling"));
    let data: serde_json::Value = serde_json::from_str(&json(&report)).expect("JSON");
    assert_eq!(data["schema"], "population/1");
    assert_eq!(data["rows"][0]["passes"], 37);
    assert_eq!(data["rows"][0]["quantiles"][1]["share"], 0.5);
    assert_eq!(data["missing"], serde_json::json!([41, 42]));
}
