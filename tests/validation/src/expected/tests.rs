use bench::files::rig::read_rig;
use bench::files::unit::load_unit;
use bench::site::unit::Unit;

use super::*;
use crate::prediction::rig_limits;
use crate::shipped::director;

fn judge() -> Judge {
    Judge::shipped().expect("the shipped files are good")
}

#[test]
fn predictions_assume_the_limits_of_the_shipped_rig() {
    let source = shipped::find(Folder::Rigs, "sim", None).expect("the rig is shipped");
    let rig = read_rig(source).expect("the rig is good");
    for (k, axis) in rig.axes.iter().enumerate() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * a.abs().max(1.0);
        let ends = |a: [f64; 2], b: [f64; 2]| near(a[0], b[0]) && near(a[1], b[1]);
        assert!(ends(axis.limits.travel_rad, rig_limits::TRAVEL_RAD[k]));
        assert!(ends(axis.limits.soft_limits_rad, rig_limits::SOFT_RAD[k]));
        assert!(near(axis.limits.max_velocity_rad_per_s, rig_limits::VELOCITY_RAD_PER_S));
        assert!(near(axis.limits.max_acceleration_rad_per_s2, rig_limits::ACCELERATION_RAD_PER_S2));
        assert!(near(axis.limits.max_jerk_rad_per_s3, rig_limits::JERK_RAD_PER_S3));
        assert!(near(axis.limits.max_torque_nm, rig_limits::TORQUE_NM[k]));
    }
}

/// A prediction without a limit would pass whatever it says.
#[test]
fn every_prediction_has_a_limit_of_its_kind() {
    let judge = judge();
    for row in judge.verify(&UnitSettings::default()) {
        let id = row.expected.requirement;
        let quantity = row.expected.quantity;
        assert!(limits::known(id, quantity).is_some(), "{id} {quantity}");
        assert!(row.limit.is_some() || id == "TRK-RMS-F", "{id} {quantity}");
    }
}

/// Where a kind measures a requirement already, the limits of its measurands are the ones here.
#[test]
fn limits_that_stand_here_and_in_the_requirements_are_the_same() {
    let judge = judge();
    for quantity in QUANTITIES.iter().filter(|q| q.limit.is_some()) {
        let requirement = judge.requirements.get(quantity.requirement).expect("it is listed");
        let Some(judged) = requirement.judged(quantity.name.trim_end_matches("-az").trim_end_matches("-el"))
        else {
            continue;
        };
        let limit = judged.limit.as_ref().expect("it has one");
        assert_eq!(Some(limit.text.as_str()), quantity.limit, "{}", quantity.requirement);
    }
}

/// Everything judged that is no pass: requirement, axis, condition, verdict.
fn short_of(rows: &[Verified]) -> Vec<(&str, &str, &str, Verdict)> {
    let judged = rows.iter().filter(|row| row.limit.is_some() && row.verdict != Verdict::Pass);
    let told = |row: &'_ Verified| row.expected.axis.map_or("", |axis| ["az", "el"][axis]);
    judged.map(|r| (r.expected.requirement, told(r), r.expected.condition.as_str(), r.verdict)).collect()
}

#[test]
fn nominal_meets_every_requirement_with_guard_bands() {
    let rows = judge().verify(&director("nominal"));
    assert_eq!(short_of(&rows), []);
    insta::assert_snapshot!(table(worst(&rows)));
}

#[test]
fn as_measured_falls_short_exactly_as_the_study_did() {
    let rows = judge().verify(&director("as-measured"));
    let (track, rest): (Vec<_>, Vec<_>) = short_of(&rows).into_iter().partition(|row| row.0 == "TRK-BW");
    let expected = [
        ("VEL-BW", "az", "elevation 80 deg", Verdict::Fail),
        ("VEL-GM", "az", "elevation 20 deg", Verdict::ConditionalPass),
    ];
    let mut rest = rest;
    rest.sort_by_key(|row| row.0);
    assert_eq!(rest, expected);
    // TRK-BW is conditional where the loop crosses 0 dB at 1.00 to 1.02 Hz, and nowhere else.
    assert!(!track.is_empty() && track.iter().all(|row| row.3 == Verdict::ConditionalPass), "{track:?}");
    for row in rows.iter().filter(|row| row.expected.requirement == "TRK-BW") {
        let near = (1.0..1.02).contains(&row.expected.value_si);
        assert_eq!(row.verdict == Verdict::ConditionalPass, near, "{row:?}");
    }
    insta::assert_snapshot!(table(worst(&rows)));
}

#[test]
fn every_defect_flips_what_it_must_and_nothing_else() {
    let judge = judge();
    let nominal = judge.verify(&director("nominal"));
    let defects =
        shipped::all(Folder::Units).map(|file| load_unit(file.stem()).expect("the shipped units are good"));
    let defects: Vec<Unit> = defects.filter(|unit| unit.is_defect() && unit.director().is_some()).collect();
    assert!(defects.len() >= 28, "{}", defects.len());
    let broken = |half: &[Unit]| -> Vec<String> {
        let each = half.iter().flat_map(|defect| {
            let found = flips(defect, &judge.verify(defect.director().expect("a director")), &nominal).broken;
            found.into_iter().map(|claim| format!("{}: {claim}", defect.id))
        });
        each.collect()
    };
    let (first, second) = defects.split_at(defects.len() / 2);
    let found = std::thread::scope(|scope| {
        let other = scope.spawn(|| broken(second));
        let mut found = broken(first);
        found.extend(other.join().expect("no panic"));
        found
    });
    assert_eq!(found, Vec::<String>::new());
}
