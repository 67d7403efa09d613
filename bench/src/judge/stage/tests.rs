use procedures::diagnostic::SourceFile;
use procedures::measurement::{Estimate, Measurement, Proof};
use procedures::quantity::QuantityKind;
use procedures::verdict::Overall;
use reports::record::Origin;

use super::*;
use crate::judge::findings::{Fold, fold};
use crate::judge::missing;
use crate::record::page::KeptFile;

/// A planned sweep of friction of azimuth in a stage.
pub(in crate::judge) fn planned(id: &str, stage: &str) -> PlannedLog {
    PlannedLog {
        id: id.to_owned(),
        title: String::new(),
        kind: "hysteresis".to_owned(),
        axis: "az".to_owned(),
        log: format!("{id}.mcap"),
        yields: vec!["friction-torque".to_owned()],
        closes_loops: false,
        stage: Some(stage.to_owned()),
        state: None,
        planned_s: None,
    }
}

/// Friction (two procedures), then loops, then position, each needing the one before.
fn page(needs_pass: &[&str]) -> Page {
    let nothing = || KeptFile { name: String::new(), text: String::new() };
    let stage = |id: &str, needs: &[&str]| PageStage {
        id: id.to_owned(),
        needs: needs.iter().map(|&n| n.to_owned()).collect(),
        ..PageStage::default()
    };
    let position = PageStage {
        needs_pass: needs_pass.iter().map(|&n| n.to_owned()).collect(),
        ..stage("position", &["loops"])
    };
    Page {
        schema: 1,
        campaign: "c".to_owned(),
        title: String::new(),
        partial: false,
        left_out: Vec::new(),
        campaign_file: None,
        requirements: nothing(),
        must_measure: Vec::new(),
        claim: procedures::campaign::Claim::Acceptance,
        rig: nothing(),
        rig_id: String::new(),
        unit: String::new(),
        unit_files: Vec::new(),
        seed: 1,
        origin: Origin::Simulated,
        devices: Vec::new(),
        polarity: crate::record::page::Basis::default(),
        stages: vec![stage("friction", &[]), stage("loops", &["friction"]), position],
        procedures: vec![
            planned("A", "friction"),
            planned("B", "friction"),
            planned("C", "loops"),
            planned("D", "position"),
        ],
        instruments: Vec::new(),
        grants: Vec::new(),
        title_page: reports::record::TitlePage::default(),
        operator: None,
        serial_number: None,
        command_line: String::new(),
        jobs: 1,
        wire_faults: Vec::new(),
        laws: Vec::new(),
        started_utc: String::new(),
    }
}

/// Friction of azimuth below 260 N·m.
pub(in crate::judge) fn requirements() -> Requirements {
    let text = "schema = 1\n[[requirement]]\nid = 'FRC-AZ'\ntext = 't'\nsource = 's'\nmethod = 'test'\n\
                measurand = ['friction-torque']\naxis = 'az'\nlimit = '<= 260 N*m'\n";
    Requirements::parse(&SourceFile { name: "r.toml".to_owned(), text: text.to_owned() }).expect("right")
}

fn completed(page: &Page, index: usize, friction_nm: Option<f64>) -> JudgedLog {
    let mut log = missing(&page.procedures[index], 1);
    log.findings.status = Status::Completed;
    let estimate = |value| Estimate { value, u: 1.0, dof: 50.0, n: 51 };
    let measured =
        |nm| Measurement::new("friction-torque", "az", QuantityKind::Torque, Some(estimate(nm)), "e/1");
    log.findings.measurements = friction_nm.map(measured).into_iter().collect();
    log
}

fn told(page: &Page, index: usize, judged: &[Option<&JudgedLog>]) -> Option<String> {
    Progress { page, requirements: &requirements(), judged }.held_back(index)
}

#[test]
fn a_stage_begins_when_all_that_it_needs_completed_and_nothing_else_keeps_it() {
    let page = page(&[]);
    let a = completed(&page, 0, None);
    let b = completed(&page, 1, None);
    assert_eq!(told(&page, 0, &[None; 4]), None, "it needs nothing");
    assert_eq!(told(&page, 2, &[Some(&a), Some(&b), None, None]), None);
    let told_of = |b: Option<&JudgedLog>| told(&page, 2, &[Some(&a), b, None, None]).unwrap_or_default();
    assert_eq!(told_of(None), "stage `loops` needs stage `friction`: B left no log");
    let mut tripped = b.clone();
    tripped.findings.status = Status::Aborted;
    assert_eq!(told_of(Some(&tripped)), "stage `loops` needs stage `friction`: B aborted");
    let mut cut = b.clone();
    cut.damage = Some("damaged: cut off".to_owned());
    assert_eq!(told_of(Some(&cut)), "stage `loops` needs stage `friction`: B: damaged: cut off");
    let mut wrong = b;
    wrong.proof = Some(Proof { gate: "self-check".to_owned(), faults: vec!["probe: no signal".to_owned()] });
    assert_eq!(told_of(Some(&wrong)), "stage `loops` needs stage `friction`: B: probe: no signal");
}

#[test]
fn a_requirement_is_read_from_every_stage_before_and_from_the_final_build_state_only() {
    let with = |friction_nm: Option<f64>, needs_pass: &[&str], early: bool| {
        let mut page = page(needs_pass);
        page.procedures[0].state = early.then(|| "azimuth-table".to_owned());
        let logs: Vec<_> = (0..3).map(|k| completed(&page, k, friction_nm.filter(|_| k == 0))).collect();
        told(&page, 3, &[Some(&logs[0]), Some(&logs[1]), Some(&logs[2]), None])
    };
    assert_eq!(with(Some(200.0), &["FRC-AZ"], false), None);
    assert_eq!(with(Some(300.0), &[], false), None, "nobody asked for it");
    let held = |reason: &str| Some(format!("stage `position` needs requirement FRC-AZ to pass: {reason}"));
    assert_eq!(with(Some(300.0), &["FRC-AZ"], false), held("it failed"));
    assert_eq!(with(None, &["FRC-AZ"], false), held("it was not measured"));
    assert_eq!(with(Some(200.0), &["FRC-AZ"], true), held("it was not measured"));
}

/// Friction passes in both procedures; the coefficient that they disagree about is judged by no requirement.
#[test]
fn a_run_passes_nothing_where_its_procedures_disagree_about_what_no_requirement_judges() {
    let page = Page { stages: Vec::new(), ..page(&[]) };
    let overall = |coefficients: [f64; 4]| {
        let judged: Vec<Option<JudgedLog>> = coefficients
            .iter()
            .enumerate()
            .map(|(index, value)| {
                let mut log = completed(&page, index, Some(200.0));
                let estimate = Some(Estimate { value: *value, u: 1.0, dof: 50.0, n: 51 });
                let kind = QuantityKind::Damping;
                let coefficient = Measurement::new("viscous-coefficient", "az", kind, estimate, "e/1");
                log.findings.measurements.push(coefficient);
                Some(log)
            })
            .collect();
        // None of these numbers rests on a current: no log is read again.
        let folder = std::path::Path::new("");
        let by = Fold { page: &page, requirements: &requirements(), requirements_text: "", folder };
        let findings = fold(&by, &judged);
        (findings.overall, findings.disagreements.len())
    };
    assert_eq!(overall([300.0, 301.0, 302.0, 300.0]), (Overall::Pass, 0));
    assert_eq!(overall([300.0, 301.0, 302.0, 310.0]), (Overall::Inconclusive, 3));
}
