use super::*;
use crate::procedure::Procedure;
use crate::procedure::sample::SAMPLE_KINDS;
use crate::quantity::QuantityKind;
use crate::requirement::{Judged, Requirement, Requirements, Rule, Take};

const RIGHT: &str = r#"schema = 1
id = "friction-only"
title = "Friction"
requirements = "requirements.toml"
must-measure = ["FRC-AZ"]
[[procedure]]
file = "fat/az-friction.toml"
points = { velocity = ["10 deg/s", "60 deg/s"] }
[[procedure]]
file = "fat/el-friction.toml"
"#;

fn read(text: &str) -> Result<Campaign, Vec<Diagnostic>> {
    Campaign::parse(SourceFile::new("friction-only.toml", text))
}

fn printed(mistakes: &[Diagnostic]) -> String {
    mistakes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn procedure(id: &str, axis: &str, cogging: bool) -> Procedure {
    let text = format!(
        "schema = 1\nid = '{id}'\ntitle = 't'\nkind = 'sample'\naxis = '{axis}'\ncogging = {cogging}\n\
         sweep.velocity = ['1 deg/s']\n"
    );
    Procedure::parse_with(SourceFile::new(format!("{id}-{axis}.toml"), text), SAMPLE_KINDS)
        .expect("a right file")
}

fn requirement(id: &str, axis: &str, measurands: &[&str]) -> Requirement {
    let judged = |m: &&str| Judged {
        measurand: (*m).to_owned(),
        limit: QuantityKind::Ratio.parse_limit("<= 1 %").ok(),
        bands: Vec::new(),
        mask: None,
        goal: None,
        rule: Rule::GuardedU,
    };
    Requirement {
        id: id.to_owned(),
        text: String::new(),
        source: String::new(),
        method: "test".to_owned(),
        judges: measurands.iter().map(judged).collect(),
        limit_text: String::new(),
        goal_text: None,
        axis: Some(axis.to_owned()),
        conditions: Vec::new(),
        evidence: None,
        axes: Vec::new(),
        covers: Vec::new(),
        take: Take::Worst,
        rule: Rule::GuardedU,
    }
}

fn requirements() -> Requirements {
    let all = vec![
        requirement("FRC-AZ", "az", &["friction-torque", "breakaway-torque"]),
        requirement("COG-AZ", "az", &["cogging-order", "cogging-amplitude"]),
        requirement("COG-EL", "el", &["cogging-order", "cogging-amplitude"]),
        requirement("MOT-ACC", "az", &[]),
    ];
    Requirements { all }
}

#[test]
fn a_campaign_lists_procedures_in_order_with_their_subsets() {
    let campaign = read(RIGHT).expect("the file is right");
    assert_eq!(campaign.must_measure(&requirements()), ["FRC-AZ"]);
    assert_eq!(campaign.procedures[0].points[0].text(), "velocity = 10 deg/s, 60 deg/s");
    assert_eq!(&campaign.source.text[campaign.procedures[1].span.clone()], "\"fat/el-friction.toml\"");
    let both = [procedure("A", "az", false), procedure("B", "el", false)];
    // FRC-AZ is friction and breakaway: sliding friction alone does not verify it.
    let found = check(&campaign, Some(both.iter().collect()), &requirements());
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].message.contains("measures `breakaway-torque`"), "{}", found[0].message);
    let only_friction = Requirements { all: vec![requirement("FRC-AZ", "az", &["friction-torque"])] };
    assert_eq!(check(&campaign, Some(both.iter().collect()), &only_friction), []);
}

#[test]
fn wrong_subsets_and_an_empty_campaign_are_refused() {
    let text = RIGHT.replace(
        "velocity = [\"10 deg/s\", \"60 deg/s\"]",
        "velocty = ['1 s'], dwell = ['1 deg'], rate = []",
    );
    insta::assert_snapshot!(printed(&read(&text).expect_err("three mistakes")));
    let head = RIGHT.split("[[").next().expect("a head");
    let empty = read(&format!("{head}procedure = []\n")).expect_err("no procedure");
    assert!(printed(&empty).contains("the campaign has no procedure"));
}

#[test]
fn requirements_that_cannot_get_a_verdict_are_found_before_motion() {
    let text = RIGHT.replace("[\"FRC-AZ\"]", "[\"FRC-AX\", \"MOT-ACC\", \"COG-EL\", \"COG-AZ\", \"COG-AZ\"]");
    let campaign = read(&text).expect("the file itself is right");
    let both = [procedure("A", "az", true), procedure("A", "el", false)];
    insta::assert_snapshot!(printed(&check(&campaign, Some(both.iter().collect()), &requirements())));
}

#[test]
fn procedures_that_could_not_be_read_are_not_blamed_for_what_they_do_not_yield() {
    let campaign = read(RIGHT).expect("the file is right");
    assert_eq!(check(&campaign, None, &requirements()), []);
}

#[test]
fn the_shipped_campaigns_must_measure_every_requirement_and_check_signs() {
    let requirements = include_str!("../../requirements.toml");
    let requirements =
        Requirements::parse(&SourceFile::new("requirements.toml", requirements)).expect("right");
    for (name, text) in [("quick", include_str!("../../quick.toml")), ("fat", include_str!("../../fat.toml"))]
    {
        let campaign = read(text).unwrap_or_else(|all| panic!("{}", all[0]));
        assert_eq!(campaign.id, name);
        let judged = requirements.all.iter().filter(|r| !r.judges.is_empty()).map(|r| r.id.clone());
        assert_eq!(campaign.must_measure(&requirements), judged.collect::<Vec<_>>(), "{name}");
        let prefix = format!("{name}/");
        let own = |file: &str| file.starts_with(&prefix) || file == "polarity.toml";
        assert!(campaign.procedures.iter().all(|entry| own(&entry.file)), "{name}");
        let checked = campaign.procedures.iter().position(|entry| entry.file == "polarity.toml");
        assert!(checked.is_some(), "{name}: signs come before any loop closes");
    }
}

#[test]
fn full_coverage_asks_for_every_requirement_that_is_not_declared() {
    let full = RIGHT.replace("must-measure = [\"FRC-AZ\"]", "coverage = \"full\"");
    let campaign = read(&full).expect("the file is right");
    let mut all = requirements();
    let both = [procedure("A", "az", true), procedure("B", "el", true)];
    insta::assert_snapshot!(printed(&check(&campaign, Some(both.iter().collect()), &all)));
    all.all[0] = requirement("FRC-AZ", "az", &["friction-torque"]);
    all.all[3].evidence = Some("calculation 7".to_owned());
    assert_eq!(check(&campaign, Some(both.iter().collect()), &all), []);
    assert_eq!(campaign.must_measure(&all), ["FRC-AZ", "COG-AZ", "COG-EL"]);
}

#[test]
fn what_must_be_measured_is_said_once() {
    let both = RIGHT.replace("must-measure", "coverage = \"full\"\nmust-measure");
    let neither = RIGHT.replace("must-measure = [\"FRC-AZ\"]\n", "");
    let found = [both, neither].map(|text| printed(&read(&text).expect_err("twice, or not at all")));
    insta::assert_snapshot!(found.join("\n"));
}
