use std::collections::{BTreeMap, BTreeSet};

use procedures::case::Case;
use procedures::condition::same;
use procedures::kinds::{self, Measurand};
use procedures::measurement::{Condition, Measurement};
use procedures::requirement::{Judged, Requirement};
use procedures::stimulus::Stimulus;
use procedures::verdict::applies;

use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};
use crate::model::rig::Rig;
use crate::plan::{CampaignPlan, PlanError, PlannedProcedure, Wanted, plan};

fn rig() -> Rig {
    shipped::find(Folder::Rigs, "sim", None).and_then(read_rig).expect("the shipped rig")
}

/// Friction as a torque table, then signs, friction, current loop and, where that completed, velocity loop.
pub(crate) fn staged() -> CampaignPlan {
    selected(&[])
}

fn selected(select: &[&str]) -> CampaignPlan {
    let asks = |id: &str| format!("[[stage.prompt]]\nid = \"{id}\"\nclass = \"safety\"\ntext = \"?\"\n");
    let table = format!("state = \"azimuth-table\"\ninertia = {{ az = \"640 kg*m^2\" }}\n{}", asks("bare"));
    let text = stage("azimuth-table", &table, "shipped:fat/az-friction-table.toml")
        + "[[procedure]]\nfile = \"shipped:fat/polarity-table.toml\"\nstage = \"azimuth-table\"\n"
        + &stage("signs", &format!("state = \"final\"\n{}", asks("complete")), "shipped:polarity.toml")
        + &stage("friction", "", "shipped:quick/az-friction.toml")
        + &stage("current-loop", "", "shipped:quick/az-current.toml")
        + &stage("velocity-loop", "needs = [\"current-loop\"]", "shipped:quick/az-velocity-loop.toml");
    planned(&text, "\"UNB-AZ\", \"VEL-GM\"", select).expect("it plans")
}

fn shipped_selection(campaign: &str, select: &[&str]) -> CampaignPlan {
    let select = select.iter().map(|&word| word.to_owned()).collect();
    plan(&Wanted { names: vec![campaign.to_owned()], select, ..Wanted::default() }, &rig()).expect("it plans")
}

fn ids(plan: &CampaignPlan) -> Vec<&str> {
    plan.procedures.iter().map(|p| p.procedure.id.as_str()).collect()
}

#[test]
fn a_selection_by_stage_takes_the_stage_and_what_proves_its_signs() {
    let table = selected(&["azimuth-table"]);
    assert_eq!(ids(&table), ["AZ-FRICTION-TABLE", "POLARITY-TABLE"]);
    assert_eq!(table.must_measure, Vec::<String>::new(), "an earlier build state verifies nothing");
    let loops = selected(&["velocity-loop", "AZ-VELOCITY-LOOP", "AZ-VELOCITY-LOOP"]);
    assert_eq!(
        ids(&loops).iter().filter(|id| **id == "AZ-VELOCITY-LOOP").count(),
        1,
        "selected twice, run once"
    );
    assert!(ids(&loops).contains(&"POLARITY") && !ids(&loops).contains(&"AZ-CURRENT"));
    let stage = loops.stages.iter().find(|s| s.stage.id == "velocity-loop").expect("kept");
    assert_eq!(stage.waived, ["stage `current-loop`"], "nobody waits for what is not run");
    assert_eq!(loops.must_measure, ["VEL-GM"]);
}

#[test]
fn a_selection_behind_trackers_takes_what_shows_their_signs_and_waits_for_it() {
    let lost = shipped_selection("fat", &["TRK-LOSS"]);
    let kinds: Vec<&str> = lost.procedures.iter().map(|p| p.procedure.kind).collect();
    for kind in ["polarity", "tracker-latency", "optical-gain", "track"] {
        assert!(kinds.contains(&kind), "{kind}: {kinds:?}");
    }
    let needs = |id: &str| {
        let stage = lost.stages.iter().find(|s| s.stage.id == id).expect("kept");
        stage.stage.needs.iter().map(|(id, _)| id.clone()).collect::<Vec<_>>()
    };
    assert_eq!(needs("trackers"), ["sight"]);
    assert_eq!(needs("tracking"), ["trackers"]);
}

#[test]
fn who_needs_a_stage_that_is_not_run_needs_what_that_one_needed() {
    let text = stage("table", "", "shipped:quick/az-friction.toml")
        + &stage("current-loop", "needs = [\"table\"]", "shipped:quick/az-current.toml")
        + &stage("velocity-loop", "needs = [\"current-loop\"]", "shipped:quick/az-velocity-loop.toml");
    let plan = planned(&text, "", &["velocity-loop", "table"]).expect("it plans");
    let loops = plan.stages.iter().find(|s| s.stage.id == "velocity-loop").expect("kept");
    assert_eq!(loops.stage.needs.iter().map(|(id, _)| id.as_str()).collect::<Vec<_>>(), ["table"]);
    assert_eq!(loops.waived, ["stage `current-loop`"]);
}

#[test]
fn a_requirement_selects_no_procedure_of_an_earlier_build_state() {
    let friction = selected(&["FRC-AZ"]);
    assert!(ids(&friction).contains(&"AZ-FRICTION") && !ids(&friction).contains(&"AZ-FRICTION-TABLE"));
    assert!(friction.stages.iter().all(|s| s.state.is_none()));
}

#[test]
fn the_rig_of_a_stage_has_the_inertia_of_its_build_state_and_no_heavier_one() {
    let plan = selected(&["azimuth-table", "AZ-FRICTION"]);
    let inertia = |id: &str| {
        let planned = plan.procedures.iter().find(|p| p.procedure.id == id).expect("planned");
        planned.on(&rig()).axes[0].limits.inertia_kg_m2
    };
    assert_eq!((inertia("AZ-FRICTION-TABLE"), inertia("AZ-FRICTION")), (640.0, 1200.0));
    assert!(rig().with_inertia(&[("az".to_owned(), 1201.0)]).is_err());
    assert!(rig().with_inertia(&[("ax".to_owned(), 1.0)]).is_err());
}

fn campaign(stages: &str) -> Result<CampaignPlan, PlanError> {
    planned(stages, "", &[])
}

fn planned(stages: &str, must_measure: &str, select: &[&str]) -> Result<CampaignPlan, PlanError> {
    let folder = tempfile::tempdir().expect("temporary folder");
    let head = format!(
        "schema = 1\nid = \"c\"\ntitle = \"C\"\nrequirements = \"shipped:requirements.toml\"\nmust-measure = [{must_measure}]\n"
    );
    let path = folder.path().join("c.toml");
    std::fs::write(&path, format!("{head}{stages}")).expect("a writable folder");
    let select = select.iter().map(|&word| word.to_owned()).collect();
    plan(&Wanted { names: vec![path.display().to_string()], select, ..Wanted::default() }, &rig())
}

fn stage(id: &str, more: &str, file: &str) -> String {
    format!(
        "[[stage]]\nid = \"{id}\"\ntitle = \"T\"\n{more}\n[[procedure]]\nfile = \"{file}\"\nstage = \"{id}\"\n"
    )
}

#[test]
fn loops_in_a_rebuilt_unit_want_polarity_of_their_own_and_no_check_of_it_waits_for_them() {
    let ask = "[[stage.prompt]]\nid = \"p\"\nclass = \"safety\"\ntext = \"?\"\n";
    let early =
        stage("table", &format!("state = \"azimuth-table\"\n{ask}"), "shipped:quick/az-friction.toml");
    let Err(PlanError::Mistakes(found)) = campaign(&early) else { panic!("a mistake") };
    assert!(
        found[0].message.contains("but no procedure checks polarity in that state"),
        "{}",
        found[0].message
    );
    let circle = stage("friction", "", "shipped:quick/az-friction.toml")
        + &stage("signs", "needs = [\"friction\"]", "shipped:polarity.toml");
    let Err(PlanError::Mistakes(found)) = campaign(&circle) else { panic!("a mistake") };
    assert!(found[0].message.contains("circular dependency"), "{}", found[0].message);
    let unknown = stage("table", &format!("state = \"azimut-table\"\n{ask}"), "shipped:polarity.toml");
    let Err(PlanError::Mistakes(found)) = campaign(&unknown) else { panic!("a mistake") };
    assert!(found[0].message.contains("no build state `azimut-table`"), "{}", found[0].message);
}

/// Measurands that say over which angles they were measured, with the beginning of the labels of the segments that they look at.
const STATE_ANGLES: [(&str, &str); 13] = [
    ("cogging-order", ""),
    ("cogging-amplitude", ""),
    ("cogging-harmonic", ""),
    ("cogging-peak", ""),
    ("friction-torque", ""),
    ("friction-difference", ""),
    ("friction-unevenness", ""),
    ("unbalance-torque", ""),
    ("spring-torque", ""),
    ("encoder-slip", ""),
    ("encoder-pitch-error", "slow"),
    ("cue-overshoot-excess", "slew"),
    ("cue-settling-time", "slew"),
];

/// The axes on which a case measures it: a drive's load is that of its own axis, whichever one the case is about.
fn axes_of<'a>(measurand: &str, case: &'a Case) -> Vec<&'a str> {
    let moved = case.moved_axes();
    match moved.iter().find(|axis| measurand.ends_with(&format!("-current-{axis}"))) {
        Some(axis) => vec![axis],
        None if ["heat-sink-end", "time-above-continuous"].contains(&measurand) => moved,
        None => vec![&case.axis],
    }
}

/// What a campaign measures in the final build state, if every point reaches what is asked of it.
fn reached_as_planned(plan: &CampaignPlan) -> Vec<Measurement> {
    let of_case = |yields: &[&Measurand], case: &Case| {
        let conditions = Condition::reached(case, |request| Some(request.value));
        let angles_rad = |name: &str| {
            let (_, label) = STATE_ANGLES.iter().find(|(states, _)| *states == name)?;
            let segments = case.segments.iter().filter(|segment| segment.label.starts_with(label));
            let ends = segments.filter_map(|segment| match segment.stimulus {
                Stimulus::Reversals { from_rad, to_rad, .. } => {
                    Some([from_rad.min(to_rad), from_rad.max(to_rad)])
                }
                Stimulus::Move { target_rad, .. } if !label.is_empty() => Some([target_rad; 2]),
                _ => None,
            });
            ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
        };
        let one = |m: &Measurand, axis: &str| Measurement {
            conditions: conditions.clone(),
            value: Some(0.0),
            angles_rad: angles_rad(m.name),
            ..Measurement::new(m.name, axis, m.kind, None, "plan/1")
        };
        let of_axes =
            |m: &&Measurand| axes_of(m.name, case).into_iter().map(|axis| one(m, axis)).collect::<Vec<_>>();
        yields.iter().flat_map(of_axes).collect::<Vec<Measurement>>()
    };
    let of_procedure = |planned: &PlannedProcedure| {
        let kind = kinds::kind(planned.procedure.kind).expect("a kind of ours");
        let yields = kind.measurands.iter().filter(|m| planned.procedure.yields.contains(&m.name));
        let yields: Vec<&Measurand> = yields.collect();
        planned.cases.iter().flat_map(|case| of_case(&yields, case)).collect::<Vec<_>>()
    };
    let in_final_state = |p: &&PlannedProcedure| plan.state_of(p).is_none();
    plan.procedures.iter().filter(in_final_state).flat_map(of_procedure).collect()
}

/// Every torque rests on the constants: without a gauge they are known to 2.9 % only.
#[test]
fn both_axes_have_a_force_gauge_in_both_campaigns_and_a_selected_torque_takes_its_own_along() {
    for campaign in ["quick", "fat"] {
        let whole = shipped_selection(campaign, &[]);
        for gauge in ["AZ-TORQUE-CONSTANT", "EL-TORQUE-CONSTANT"] {
            assert!(ids(&whole).contains(&gauge), "{campaign}: {gauge}");
        }
        let selected = shipped_selection(campaign, &["FRC-EL"]);
        assert!(ids(&selected).contains(&"EL-TORQUE-CONSTANT"), "{campaign}: {:?}", ids(&selected));
        assert!(!ids(&selected).contains(&"AZ-TORQUE-CONSTANT"), "{campaign}: {:?}", ids(&selected));
    }
}

/// A claim that no plan reaches leaves its requirement without a verdict after hours on the real unit.
#[test]
fn the_acceptance_test_plans_every_stretch_that_its_requirements_claim_and_quick_does_not() {
    let lacking = |campaign: &str| {
        let plan = shipped_selection(campaign, &[]);
        let measured = reached_as_planned(&plan);
        let of = |requirement: &Requirement| {
            let seen: Vec<&Measurement> = measured.iter().filter(|m| applies(requirement, m)).collect();
            requirement.not_covered(&seen)
        };
        // Axes of a measurand that is not the case's (gyros, mirror) and targets within a point are not in the plan.
        let is_planned = |phrase: &String| phrase.contains(": ") && !phrase.contains(": target ");
        plan.requirements.all.iter().flat_map(of).filter(is_planned).collect::<Vec<String>>()
    };
    assert_eq!(lacking("fat"), [""; 0]);
    insta::assert_snapshot!(lacking("quick").join("\n"));
}

/// Where a verdict rests on several values of a condition, one of them alone is not what the requirement means. What is listed here
/// stays without a claim: a kind measures it in every run (directions, offsets, elevations of a gravity fit), takes one of several
/// (the slowest velocity with a spectrum), or it does not change what is measured (the level of a transport latency).
#[test]
fn a_condition_that_the_acceptance_test_varies_is_claimed_by_the_requirement() {
    let plan = shipped_selection("fat", &[]);
    let measured = reached_as_planned(&plan);
    let mut silent = Vec::new();
    for requirement in &plan.requirements.all {
        for judged in requirement.judges.iter().filter(|judged| judged.is_limited()) {
            let own = |m: &&Measurement| m.measurand == judged.measurand && applies(requirement, m);
            let own: Vec<&Measurement> = measured.iter().filter(own).collect();
            silent.extend(
                varied(&own)
                    .filter(|name| !claims(requirement, judged, name))
                    .map(|name| format!("{} {}: {name}", requirement.id, judged.measurand)),
            );
        }
    }
    insta::assert_snapshot!(silent.join("\n"));
}

/// Names of the conditions that have several values on an axis.
fn varied<'a>(own: &[&'a Measurement]) -> impl Iterator<Item = &'a str> {
    let mut values: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
    for m in own {
        for condition in &m.conditions {
            let values = values.entry((&condition.name, &m.axis)).or_default();
            if !values.iter().any(|&value| same(value, condition.requested)) {
                values.push(condition.requested);
            }
        }
    }
    let varied = values.into_iter().filter(|(_, values)| values.len() > 1).map(|((name, _), _)| name);
    varied.collect::<BTreeSet<&str>>().into_iter()
}

/// Whether a requirement says of a condition which values it means.
fn claims(requirement: &Requirement, judged: &Judged, condition: &str) -> bool {
    let of_measurand = |name: &Option<String>| name.as_ref().is_none_or(|name| *name == judged.measurand);
    requirement.covers.iter().any(|cover| cover.condition == condition && of_measurand(&cover.measurand))
        || requirement.conditions.iter().any(|filter| filter.condition == condition)
        || judged.mask.as_ref().is_some_and(|mask| mask.condition == condition)
}
