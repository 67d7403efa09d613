use reports::record::DeviceRecord;

use super::*;

fn planned(kind: &str) -> PlannedLog {
    PlannedLog {
        id: "POLARITY".into(),
        title: String::new(),
        kind: kind.into(),
        axis: "az".into(),
        log: String::new(),
        yields: Vec::new(),
        closes_loops: false,
        stage: None,
        state: None,
        planned_s: None,
    }
}

fn proof(faults: &[&str]) -> Option<Proof> {
    Some(Proof { gate: POLARITY.into(), faults: faults.iter().map(|&f| f.to_owned()).collect() })
}

#[test]
fn the_gate_opens_only_on_a_whole_proof_without_faults() {
    let closed = |text: &str| Gate::Closed(text.to_owned());
    for (outcome, expected) in [
        (Some((Status::Completed, proof(&[]))), Gate::Open),
        (Some((Status::Completed, proof(&["encoder sign of az"]))), closed("polarity: encoder sign of az")),
        (Some((Status::Aborted, proof(&["gyro sign"]))), closed("polarity: gyro sign")),
        (Some((Status::Aborted, proof(&[]))), closed("polarity: not proven: POLARITY aborted")),
        (Some((Status::Completed, None)), closed("polarity: not proven: POLARITY completed")),
        (None, closed("polarity: not proven: POLARITY left no log that can be judged")),
    ] {
        assert_eq!(gate_in(None, &[planned(POLARITY)], |_| outcome.clone()), expected);
    }
    assert_eq!(gate_in(None, &[planned("hysteresis")], |_| None), Gate::Open, "nothing asks for it");
}

#[test]
fn what_was_proven_in_one_build_state_says_nothing_of_another() {
    let early = PlannedLog { id: "EARLY".into(), state: Some("bare".into()), ..planned(POLARITY) };
    let both = [early, planned(POLARITY)];
    let outcome = |index| (index == 1).then(|| (Status::Completed, proof(&[])));
    assert_eq!(gate_in(None, &both, outcome), Gate::Open);
    let closed = Gate::Closed("polarity: not proven: EARLY left no log that can be judged".to_owned());
    assert_eq!(gate_in(Some("bare"), &both, outcome), closed);
}

#[test]
fn a_proof_of_another_gate_does_not_open_this_one() {
    let other = Some(Proof { gate: "homing".into(), faults: Vec::new() });
    assert!(
        gate_in(None, &[planned(POLARITY)], |_| Some((Status::Completed, other.clone()))).reason().is_some()
    );
}

fn basis() -> Basis {
    let device = |name: &str| DeviceRecord {
        name: name.into(),
        identity: "SIM drive, firmware 1.0".into(),
        may_be_real: false,
        proven_real: false,
        grounds: String::new(),
    };
    let devices = [device("az-drive"), device("el-drive")];
    Basis::new(&devices, &["unit".into()], "rig", &controllers::DirectorGains::default(), &[])
}

#[test]
fn every_part_of_what_was_proven_changes_the_hash_and_is_named() {
    type Change = fn(&mut Basis);
    let table: [(&str, Change); 4] = [
        ("the unit file", |b| b.unit_sha256.push('x')),
        ("the rig file", |b| b.rig_sha256.push('x')),
        ("the parameters of the controllers", |b| b.parameters_sha256.push('x')),
        ("a device (it was az-drive: SIM drive, firmware 1.0)", |b| b.identities[0].push('x')),
    ];
    for (named, change) in table {
        let mut now = basis();
        change(&mut now);
        assert_ne!(now.hash(), basis().hash(), "{named}");
        assert_eq!(now.changes_since(&basis()), [named]);
    }
    let gains = controllers::DirectorGains::default();
    assert_ne!(
        Basis::new(&[], &["unit".into()], "rig", &gains, &[]).changes_since(&basis()),
        Vec::<String>::new()
    );
}

#[test]
fn any_gain_of_any_controller_changes_the_hash() {
    let hash = |gains: &controllers::DirectorGains| Basis::new(&[], &[], "rig", gains, &[]).hash();
    let before = hash(&controllers::DirectorGains::default());
    for parameter in controllers::parameter::PARAMETERS {
        let mut gains = controllers::DirectorGains::default();
        (parameter.set)(&mut gains, 1.5);
        assert_ne!(hash(&gains), before, "{}", parameter.key);
    }
    for parameter in controllers::parameter::AXIS_PARAMETERS {
        let mut gains = controllers::DirectorGains::default();
        (parameter.set)(&mut gains.axes[2], 1.5);
        assert_ne!(hash(&gains), before, "{} of a third axis", parameter.key);
    }
}
