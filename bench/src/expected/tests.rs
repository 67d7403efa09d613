use sim_devices::prediction::rig_limits;

use super::*;
use crate::model::rig::Rig;

#[test]
fn predictions_assume_the_limits_of_the_shipped_rig() {
    let source = shipped::find(Folder::Rigs, "sim", None).expect("the rig is shipped");
    let rig = Rig::parse(source).expect("the rig is good");
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

#[test]
fn every_requirement_is_predicted_or_named_as_one_that_no_unit_decides() {
    let judge = Judge::shipped().expect("the files are good");
    let rows = judge.verify(&UnitSettings::default());
    for id in judge.ids() {
        let predicted = rows.iter().any(|row| row.expected.requirement == id);
        let undecided = UNDECIDED.iter().any(|(other, _)| *other == id);
        assert!(predicted != undecided, "{id}");
    }
}

/// A prediction without a limit would pass whatever it says.
#[test]
fn every_prediction_has_a_limit_of_its_kind() {
    let judge = Judge::shipped().expect("the files are good");
    for row in judge.verify(&UnitSettings::default()) {
        let (id, quantity) = (row.expected.requirement, row.expected.quantity);
        assert!(limits::of(id, quantity).is_some(), "{id} {quantity}");
        assert!(row.limit.is_some() || id == "TRK-RMS-F", "{id} {quantity}");
    }
}

/// Where a kind measures a requirement already, the limits of its measurands are the ones here.
#[test]
fn limits_that_stand_here_and_in_the_requirements_are_the_same() {
    let judge = Judge::shipped().expect("the files are good");
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
