//! A requirement with several limits: of several measurands, and of one in bands of conditions.

use procedures::quantity::QuantityKind;
use procedures::verdict::MeasurandOutcome;

use super::*;

const BAND: &str = "<= 150 N*m where velocity <= 2 deg/s";

/// The sample with a second limit of friction, which its worst measurement breaks, too.
fn banded() -> Results {
    let mut results = without_pictures();
    let outcome =
        results.findings.outcomes.iter().position(|o| o.requirement == "FRC-AZ").expect("of the sample");
    let decided_by = results.findings.outcomes[outcome].decided_by.clone().expect("it was judged");
    let (_, measurement, _) = results.findings.deciding(&decided_by).expect("it was measured");
    let measurand = measurement.measurand.clone();
    let mut in_band = decided_by.clone();
    in_band.1.limit = QuantityKind::Torque.parse_limit("<= 150 N*m").ok();
    in_band.1.band = Some(BAND.to_owned());
    let one = |band: Option<&str>, decided_by: &(String, procedures::verdict::Judgement)| MeasurandOutcome {
        measurand: measurand.clone(),
        band: band.map(str::to_owned),
        verdict: Verdict::Fail,
        decided_by: decided_by.clone(),
        judged: 1,
    };
    let both = vec![one(None, &decided_by), one(Some(BAND), &in_band)];
    results.findings.outcomes[outcome].by_measurand = both;
    results
}

#[test]
fn each_band_has_a_row_with_its_own_limit_in_every_format() {
    let results = banded();
    let typeset = crate::number::typeset(BAND);
    let escaped = BAND.replace('<', "&lt;");
    for (name, limit) in [
        ("html", typeset.as_str()),
        ("md", typeset.as_str()),
        ("junit", escaped.as_str()),
        ("requirements-csv", BAND),
    ] {
        let text = rendered(name, &results);
        let before = rendered(name, &without_pictures());
        assert!(text.contains(limit) && !before.contains(limit), "{name}: {limit}");
    }
    let base = csv_records(&rendered("requirements-csv", &results));
    let limits: Vec<&str> =
        base.iter().filter(|r| r.iter().any(|cell| cell == "FRC-AZ")).map(|r| r[11].as_str()).collect();
    assert_eq!(limits, ["<= 260 N*m", BAND]);
}

/// `MOT-CUR-AZ` fails by its mean current and by its peak: whoever reads of one must read of the other.
#[test]
fn a_shortfall_of_a_second_measurand_has_a_row_of_its_own_in_every_format() {
    const SECOND: &str = "<= 42.6 N*m";
    let mut results = banded();
    let outcome = results.findings.outcomes.iter_mut().find(|o| o.requirement == "FRC-AZ").expect("banded");
    let second = &mut outcome.by_measurand[1];
    second.measurand = "peak-current-az".to_owned();
    second.band = None;
    second.decided_by.1.band = None;
    second.decided_by.1.limit = QuantityKind::Torque.parse_limit(SECOND).ok();
    for name in ["html", "md", "junit", "requirements-csv"] {
        let text = rendered(name, &results);
        let before = rendered(name, &without_pictures());
        assert!(text.contains("42.6") && !before.contains("42.6"), "{name}");
    }
    let junit = rendered("junit", &results);
    let failing =
        junit.split("<testcase").filter(|case| case.contains("\"FRC-AZ ") && case.contains("<failure"));
    assert_eq!(failing.count(), 2, "{junit}");
    let base = csv_records(&rendered("requirements-csv", &results));
    let rows = base.iter().filter(|r| r.iter().any(|cell| cell == "FRC-AZ"));
    assert_eq!(rows.map(|r| r[11].as_str()).collect::<Vec<_>>(), ["<= 260 N*m", SECOND]);
}

#[test]
fn two_bands_with_the_same_limit_have_each_its_own_numbers_in_junit() {
    const OTHER: &str = "<= 150 N*m where velocity >= 40 deg/s";
    let mut results = banded();
    let outcome = results.findings.outcomes.iter_mut().find(|o| o.requirement == "FRC-AZ").expect("banded");
    let mut other = outcome.by_measurand[1].clone();
    other.band = Some(OTHER.to_owned());
    other.decided_by.1.band = Some(OTHER.to_owned());
    let both = [outcome.by_measurand[1].decided_by.clone(), other.decided_by.clone()];
    outcome.by_measurand.push(other);
    for (procedure, judgement) in both {
        let own = results.findings.procedures.iter_mut().find(|p| p.id == procedure).expect("it was judged");
        own.judgements.push(judgement);
    }
    let text = rendered("junit", &results);
    for band in [BAND, OTHER] {
        let band = band.replace('<', "&lt;").replace('>', "&gt;");
        let case = text.split("<testcase").find(|case| case.contains(&band)).expect("a case of its own");
        let numbers = case.lines().filter(|line| line.contains("margin")).count();
        assert_eq!(numbers, 1, "{case}");
    }
}
