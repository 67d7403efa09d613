use procedures::quantity::QuantityKind;
use procedures::regression::{
    ARM_SCHEMA, Criterion, End, Population, Replicate, ReplicateValue, Scale, Worse,
};

use super::*;

fn criterion(
    requirement: &str,
    measurand: &str,
    kind: QuantityKind,
    scale: Scale,
    worse: Worse,
) -> Criterion {
    Criterion {
        requirement: requirement.to_owned(),
        measurand: measurand.to_owned(),
        place: String::new(),
        kind,
        margin: 0.05,
        scale,
        worse,
        blocking: true,
    }
}

fn criteria() -> Criteria {
    let all = vec![
        criterion("VEL-BW", "velocity-bandwidth", QuantityKind::Frequency, Scale::Difference, Worse::Lower),
        criterion("TRK-RMS-C", "coarse-track-rms", QuantityKind::Angle, Scale::LogRatio, Worse::Higher),
        Criterion {
            blocking: false,
            ..criterion("MOT-CUE", "cue-settling-time", QuantityKind::Time, Scale::LogRatio, Worse::Higher)
        },
    ];
    Criteria { looks: vec![5], all }
}

/// An arm on four units: bandwidth, tracking error and settling time of each.
fn arm(parameters: &str, values: [[f64; 3]; 4]) -> ArmRecord {
    let names = [
        ("VEL-BW", "velocity-bandwidth", "AZ-VELOCITY-LOOP az, elevation=60 deg"),
        ("TRK-RMS-C", "coarse-track-rms", "TRACK-RAIL"),
        ("MOT-CUE", "cue-settling-time", "AZ-CUE az"),
    ];
    let value = |((requirement, measurand, place), value): (&(&str, &str, &str), &f64)| ReplicateValue {
        requirement: (*requirement).to_owned(),
        measurand: (*measurand).to_owned(),
        place: (*place).to_owned(),
        value: Some(*value),
        u: 0.0,
        passes: *requirement != "VEL-BW" || *value >= 3.5,
    };
    let replicate = |(unit, values): (u32, &[f64; 3])| Replicate {
        unit,
        unit_id: format!("unit-{unit}"),
        unit_sha256: "digest".to_owned(),
        seed: u64::from(unit),
        end: End::Completed,
        values: names.iter().zip(values).map(value).collect(),
    };
    ArmRecord {
        schema: ARM_SCHEMA.to_owned(),
        program: Program {
            version: "0.1.0".to_owned(),
            sha256: "0123456789abcdef".to_owned(),
            processor: "x86_64".to_owned(),
        },
        controller: Controller {
            parameters: parameters.to_owned(),
            sha256: format!("{parameters}-0123456789"),
            states: Vec::new(),
            laws: Vec::new(),
        },
        scenario: Scenario {
            campaign: "regression".to_owned(),
            campaign_sha256: "cafe".repeat(8),
            rig: "sim".to_owned(),
            rig_sha256: "beef".repeat(8),
            population: Population { name: "files".to_owned(), sha256: "f00d".repeat(8), units: 4 },
            seed: 1,
            seeds_per_unit: 1,
        },
        shard: Shard::WHOLE,
        look: None,
        replicates: (1..).zip(&values).map(replicate).collect(),
    }
}

fn baseline() -> ArmRecord {
    arm("director", [[4.0, 50e-6, 0.8], [4.1, 52e-6, 0.9], [3.9, 49e-6, 0.7], [3.6, 51e-6, 0.8]])
}

/// Lower bandwidth, better tracking, a settling time that nobody can tell.
fn candidate() -> ArmRecord {
    arm("slow|er.toml", [[3.8, 45e-6, 0.9], [3.88, 46e-6, 0.8], [3.71, 44e-6, 0.8], [3.4, 46e-6, 0.7]])
}

fn compared(candidate: &ArmRecord) -> Regression {
    Regression::new(&criteria(), &baseline(), candidate, Look::Single).expect("alike")
}

#[test]
fn the_worst_criterion_stands_first_in_every_form() {
    let found = compared(&candidate());
    assert_eq!(found.call(), Call::Worse);
    insta::assert_snapshot!("text", text(&found));
    insta::assert_snapshot!("markdown", markdown(&found));
    insta::assert_snapshot!("junit", junit(&found));
    let data: serde_json::Value = serde_json::from_str(&json(&found)).expect("JSON");
    assert_eq!((&data["schema"], &data["call"]), (&"regression/1".into(), &"worse".into()));
}

#[test]
fn an_arm_beside_itself_is_identical_in_every_form() {
    let found = compared(&baseline());
    assert_eq!((found.call(), found.call().exit_code()), (Call::Identical, 0));
    assert!(
        text(&found).ends_with("identical: 2 blocking comparisons with the same values"),
        "{}",
        text(&found)
    );
    assert!(junit(&found).contains("failures=\"0\" errors=\"0\""), "{}", junit(&found));
}

#[test]
fn a_candidate_that_ends_early_where_the_baseline_does_not_is_worse_whatever_it_measures() {
    let mut tripped = baseline();
    tripped.replicates[1].end =
        End::Aborted { procedure: 3, why: "AZ-STEP aborted: tracking error of az".to_owned() };
    let found = compared(&tripped);
    assert_eq!(found.call(), Call::Worse);
    assert_eq!(found.headline(), "worse: 1 run ended early with the candidate");
    assert!(junit(&found).contains("failures=\"1\""));
    assert!(markdown(&found).contains("| 2 | 2 | completed | AZ-STEP aborted: tracking error of az |"));
    tripped
        .replicates
        .iter_mut()
        .for_each(|r| r.end = End::Aborted { procedure: 3, why: "no light".to_owned() });
    tripped.replicates.iter_mut().for_each(|r| r.values.clear());
    let nothing = Regression::new(&criteria(), &tripped, &tripped, Look::Single).expect("alike");
    assert_eq!(nothing.call(), Call::Inconclusive, "nothing was measured");
}

#[test]
fn tables_of_markdown_are_whole_whatever_stands_in_their_cells() {
    let mut columns = 0;
    for line in markdown(&compared(&candidate())).lines() {
        let bars = line.replace("\\|", "").matches('|').count();
        match (line.starts_with('|'), columns) {
            (false, _) => columns = 0,
            (true, 0) => columns = bars,
            (true, _) => assert_eq!(bars, columns, "{line}"),
        }
    }
}
