use procedures::measurement::{Condition, Measurement};
use procedures::quantity::QuantityKind as Q;
use procedures::verdict::Overall;
use reports::record::{CampaignFindings, Origin};
use sim_devices::unit::{PARAMETERS, UnitSettings};

use super::relations::{RELATIONS, Relation};
use super::shown::Shown;
use super::*;
use crate::files::unit::load_unit;

fn setup() -> Setup {
    Setup { axes: ["az", "el"].map(str::to_owned), rig_nm_per_a: [60.0, 52.0], tick_s: 250e-6 }
}

/// A finding of a procedure, SI.
fn found(measurand: &str, axis: &str, value: f64, u: f64) -> Measurement {
    Measurement { value: Some(value), u, ..Measurement::new(measurand, axis, Q::Ratio, None, "test/1") }
}

fn under(mut m: Measurement, conditions: &[(&str, f64)]) -> Measurement {
    let condition = |(name, value): &(&str, f64)| Condition {
        name: (*name).to_owned(),
        requested: *value,
        achieved: None,
        kind: Q::Ratio,
    };
    m.conditions = conditions.iter().map(condition).collect();
    m
}

fn flagged(mut m: Measurement, flag: &str) -> Measurement {
    m.flags.push(flag.to_owned());
    m
}

/// A run of one procedure `AZ-TEST` with these findings.
fn run(measurements: Vec<Measurement>) -> Findings {
    let procedure = ProcedureFindings {
        id: "AZ-TEST".to_owned(),
        log: Some("AZ-TEST.mcap".to_owned()),
        measurements,
        ..ProcedureFindings::default()
    };
    Findings {
        campaign: CampaignFindings {
            id: "quick".to_owned(),
            title: "Quick".to_owned(),
            partial: false,
            left_out: Vec::new(),
            sha256: None,
            requirements_sha256: None,
        },
        unit: "unit-1".to_owned(),
        origin: Origin::Simulated,
        seed: 1,
        overall: Overall::Pass,
        requirements: Vec::new(),
        outcomes: Vec::new(),
        not_in_this_campaign: Vec::new(),
        no_kind_measures_it_yet: Vec::new(),
        disagreements: Vec::new(),
        not_enforced: Vec::new(),
        procedures: vec![procedure],
    }
}

fn identified(measurements: Vec<Measurement>) -> Identified {
    identify(&run(measurements), &setup(), &UnitSettings::default())
}

fn setting<'a>(found: &'a Identified, key: &str) -> &'a IdentifiedSetting {
    found
        .settings
        .iter()
        .find(|own| own.key == key)
        .unwrap_or_else(|| panic!("no {key}: {:?}", found.settings))
}

#[test]
fn every_relation_names_settings_that_exist_and_have_a_spread() {
    for relation in RELATIONS {
        for key in relation.settings {
            for axis in ["az", "el"] {
                let key = key.replace('*', axis);
                assert!(PARAMETERS.iter().any(|p| p.key == key), "{}: {key}", relation.measurand);
            }
        }
    }
    let all = ["az", "el"].into_iter().flat_map(|axis| {
        let constant = found("torque-constant", axis, 55.0, 0.1);
        let order = under(
            found("cogging-phase", axis, 1.0, 0.1),
            &[("order", if axis == "az" { 144.0 } else { 108.0 })],
        );
        [constant, order]
    });
    assert!(identified(all.collect()).settings.len() >= 4);
}

#[test]
fn a_finding_of_one_setting_gives_it_its_value_uncertainty_and_evidence() {
    let found = identified(vec![found("torque-constant", "az", 58.8, 0.19)]);
    let own = setting(&found, "az.torque-constant");
    assert!((own.value.value_si - 58.8).abs() < 1e-3 && (own.value.u_si - 0.19).abs() < 1e-3, "{own:?}");
    assert_eq!(own.standing, Standing::Measured);
    assert_eq!(own.evidence, ["torque-constant of AZ-TEST (AZ-TEST.mcap)"]);
    assert_eq!(found.settings.len(), 1);
    assert!(!found.not_measured().contains(&"az.torque-constant".to_owned()));
    assert!(found.not_measured().contains(&"el.torque-constant".to_owned()));
    assert_eq!(found.unit.el, UnitSettings::default().el);
}

/// What a unit would show, as exact findings.
fn shown_by(unit: &UnitSettings, asked: Vec<Measurement>) -> Vec<Measurement> {
    let empty = ProcedureFindings::default();
    let setup = setup();
    let exact = |mut m: Measurement| {
        let axis = setup.axes.iter().position(|name| *name == m.axis);
        let finding = Finding { procedure: &empty, measurement: &m, axis, value: m.value.unwrap_or(0.0) };
        let relation = Relation::of(&finding).expect("a relation");
        let value = (relation.shown)(&Shown { finding: &finding, unit, setup: &setup }).expect("a value");
        m.value = Some(value);
        m.u = 1e-4 * value.abs();
        m
    };
    asked.into_iter().map(exact).collect()
}

#[test]
fn exact_findings_of_another_unit_give_its_settings_back() {
    let mut unit = UnitSettings::default();
    unit.az.torque_constant_nm_per_a = 58.8;
    unit.az.coulomb_torque_nm = 162.5;
    unit.az.static_torque_nm = 205.2;
    unit.az.viscous_damping_nm_s_per_rad = 287.8;
    unit.az.bristle_damping_nm_s_per_rad = 14025.0;
    unit.az.inertia_kg_m2 = 1105.0;
    unit.az.cogging_phase_rad = 2.5;
    unit.el.spring_stiffness_nm_per_rad = 12.8;
    unit.el.spring_rest_rad = 0.684;
    unit.mirror.capacitance_f = 29.4e-6;
    unit.mirror.coupling_ratio = 0.104;
    unit.trackers.fine.latency_s = 7.3e-3;
    let plain = |measurand: &str, axis: &str| found(measurand, axis, 1e9, 0.0);
    let friction = [0.035, 0.17, 0.35, 0.7, 1.05]
        .map(|rate| under(plain("friction-torque", "az"), &[("velocity", rate)]));
    let mut asked = vec![
        plain("torque-constant", "az"),
        plain("presliding-damping", "az"),
        under(plain("apparent-inertia", "az"), &[("elevation", 1.047)]),
        under(found("cogging-phase", "az", 1.0, 0.0), &[("order", 144.0)]),
        plain("spring-stiffness", "el"),
        flagged(plain("spring-torque", "el"), "largest at 90 deg"),
        plain("mirror-capacitance", "az"),
        plain("mirror-coupling", "az"),
        Measurement { point: Some("fine tracker".to_owned()), ..plain("tracker-latency", "el") },
    ];
    asked.extend(friction);
    let found = identified(shown_by(&unit, asked));
    for key in [
        "az.torque-constant",
        "az.coulomb-torque",
        "az.viscous-damping",
        "az.bristle-damping",
        "az.inertia",
        "az.cogging-phase",
        "el.spring-stiffness",
        "el.spring-rest",
        "mirror.capacitance",
        "mirror.coupling",
        "trackers.fine-latency",
    ] {
        let parameter = PARAMETERS.iter().find(|p| p.key == key).expect("a setting");
        let [value, truth] = [parameter.get(&found.unit), parameter.get(&unit)];
        assert!((value - truth).abs() <= 5e-3 * truth.abs(), "{key}: {value}, not {truth}");
        assert_eq!(setting(&found, key).standing, Standing::Measured, "{key}");
    }
    assert!(found.contradictions.is_empty(), "{:?}", found.contradictions);
}

/// Gravity says where the zero of the encoder is, and the phase of cogging follows it. An angle between the axes of gyros and mount,
/// known by its size alone, must not drive the zero away.
#[test]
fn the_zero_of_elevation_stays_where_gravity_and_gyros_have_it() {
    let mut unit = UnitSettings::default();
    unit.imu.misalignment_rad = [275e-6, 37e-6, 38e-6];
    let cogging = |order| under(found("cogging-phase", "el", 1.0, 0.01), &[("order", order)]);
    let asked = vec![
        found("elevation-zero-error", "el", 1.0, 0.0),
        under(found("gyro-mapping-error", "az", 1.0, 0.0), &[("elevation", 40_f64.to_radians())]),
        found("gyro-mapping-error", "el", 1.0, 0.0),
        cogging(108.0),
        cogging(216.0),
    ];
    let mut shown = shown_by(&unit, asked);
    // What gravity says holds the bias of the accelerometers.
    shown[0].value = shown[0].value.map(|zero_rad| zero_rad + 150e-6);
    let u = [245e-6, 6.5e-6, 4.4e-6, 2.5e-3, 8e-3];
    shown.iter_mut().zip(u).for_each(|(own, u)| own.u = u);
    let found = identified(shown);
    assert!(found.contradictions.is_empty(), "{:?}", found.contradictions);
    assert!(found.unit.el.encoder_zero_rad.abs() < 350e-6, "{}", found.unit.el.encoder_zero_rad);
    let phase = setting(&found, "el.cogging-phase").value;
    assert!(phase.u_si > 0.01, "U of the zero times the order: {phase:?}");
}

#[test]
fn a_slip_that_may_be_none_is_none_and_a_clear_one_is_kept() {
    let with = |slip: f64| identified(vec![found("encoder-slip", "az", slip, 21e-6)]);
    let [chance, clear] = [45.9e-6, 120e-6].map(with);
    assert_eq!(chance.unit.az.encoder_slip_ratio, 0.0);
    assert!(chance.remarks[0].starts_with("az.encoder-slip: 4"), "{:?}", chance.remarks);
    assert!(clear.unit.az.encoder_slip_ratio > 100e-6, "{:?}", clear.settings);
}

#[test]
fn the_sum_of_two_delays_is_kept_on_whole_steps_and_its_parts_are_marked() {
    let found = identified(vec![found("transport-round-trip", "az", 2.449e-3, 0.2e-6)]);
    let own = &found.unit.az;
    let sum_s = own.command_delay_s + own.sensor_delay_s + 250e-6;
    assert!((sum_s - 2.45e-3).abs() < 1e-9, "{sum_s}");
    for key in ["az.command-delay", "az.sensor-delay"] {
        let own = setting(&found, key);
        let steps = own.value.value_si * 20_000.0;
        assert!((steps - steps.round()).abs() < 1e-6, "{own:?}");
        assert_eq!(own.standing, Standing::InPart, "{own:?}");
    }
}

#[test]
fn findings_that_contradict_each_other_are_told() {
    let twice = |other: f64| {
        let bits = under(found("apparent-inertia", "az", 1000.0, 1.0), &[("elevation", 1.0)]);
        identified(vec![bits, under(found("small-motion-inertia", "az", other, 1.0), &[("elevation", 1.0)])])
    };
    assert!(twice(1001.0).contradictions.is_empty());
    let contradictions = twice(1020.0).contradictions;
    assert_eq!(contradictions.len(), 2, "{contradictions:?}");
    assert!(contradictions[0].starts_with("apparent-inertia of AZ-TEST"), "{contradictions:?}");
}

#[test]
fn a_mode_scales_the_curve_of_the_base() {
    let mode = |departure: f64, elevation: f64| {
        let m = under(found("mode-2-departure", "el", departure, 1e-4), &[("elevation", elevation)]);
        flagged(m, &format!("found at {:.3} Hz", 18.0 * (1.0 + departure)))
    };
    let base = UnitSettings::default();
    let found = identified(vec![mode(0.01, 0.0), mode(0.02, 1.5)]);
    assert_eq!(found.curves.len(), 1);
    let (own, nominal) = (&found.unit.el_structure, &base.el_structure);
    let changed: Vec<usize> = (0..nominal.modes.len())
        .filter(|&k| own.modes[k].frequency_hz != nominal.modes[k].frequency_hz)
        .collect();
    assert_eq!(changed.len(), 1, "one curve is scaled: {changed:?}");
    let at = |elevation_rad| own.interpolate(&own.modes[changed[0]].frequency_hz, elevation_rad);
    assert!((at(0.0) - 18.18).abs() < 2e-3, "{}", at(0.0));
    assert!((at(1.5) - 18.36).abs() < 0.02, "{}", at(1.5));
}

#[test]
fn the_file_is_read_back_as_the_twin_with_its_marks() {
    let found = identified(vec![
        found("torque-constant", "az", 58.8127, 0.19),
        found("transport-round-trip", "az", 2.449e-3, 0.2e-6),
        flagged(
            under(found("mode-2-departure", "el", 0.01, 1e-4), &[("elevation", 0.7)]),
            "found at 18.180 Hz",
        ),
        found("spring-stiffness", "az", -3.0, 0.5),
    ]);
    let said = ["From a test.".to_owned()];
    let text = unit_file(&found, "twin", "Twin of \"unit-1\"", "nominal", &said);
    assert_eq!(text, unit_file(&found, "twin", "Twin of \"unit-1\"", "nominal", &said));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("twin.toml");
    std::fs::write(&path, &text).expect("a writable folder");
    let unit = load_unit(path.to_str().expect("a plain path")).unwrap_or_else(|m| panic!("{m:?}\n{text}"));
    assert_eq!(unit.title, "Twin of \"unit-1\"");
    let settings = unit.director().expect("a director");
    for parameter in PARAMETERS.iter() {
        let [read, twin] = [parameter.get(settings), parameter.get(&found.unit)];
        assert!((read - twin).abs() <= 1e-5 * twin.abs(), "{}: {read}, not {twin}", parameter.key);
    }
    let line = text.lines().find(|line| line.starts_with("torque-constant")).expect("a line");
    assert!(line.ends_with("# ± 0.38 N*m/A: torque-constant of AZ-TEST (AZ-TEST.mcap)"), "{line}");
    assert!(text.contains("# in part, ± "), "{text}");
    assert!(text.contains("az.spring-stiffness: the findings lie outside"), "{text}");
    assert!(
        text.lines().any(|line| line.starts_with("# Not measured by this run, as in `nominal`: step-rate,")),
        "{text}"
    );
}
