use std::collections::BTreeMap;

use super::keys::{HoldKeys, Keys, MapKeys, MultisineKeys, RampKeys};
use super::*;
use crate::measurement::Measurement;

/// What the support files call us by.
mod procedures {
    pub(super) use crate::{axis, case, log, stimulus};
}
#[path = "../../../examples/recovery_breakaway/bench.rs"]
mod bench;
#[path = "../../../examples/recovery_breakaway/plant.rs"]
mod plant;

use plant::{AZIMUTH, ELEVATION, Plant};

const DEGREE: f64 = std::f64::consts::TAU / 360.0;

fn keys(pose: f64, displacement: f64) -> Keys {
    Keys {
        pose_rad: pose * DEGREE,
        displacement_rad: displacement * DEGREE,
        holding_torque_nm: 0.0,
        approach_rad_per_s: 2.0 * DEGREE,
        map: Some(MapKeys { velocity_rad_per_s: DEGREE, periods: 2, cycles: 1 }),
        ramps: Vec::new(),
        multisine: None,
        hold: None,
        dwell_constant_s: 1.0,
    }
}

fn axes(plant: &Plant, torque_constant: f64) -> Axes {
    Axes(BTreeMap::from([("el".to_owned(), bench::limits(plant, torque_constant))]))
}

/// Plans, runs on the plant with noise of 1 % of T_C, analyses and concludes.
fn conclusion(keys: &Keys, plant: &Plant, torque_constant: f64, seed: u64) -> Conclusion {
    let axes = axes(plant, torque_constant);
    let cases = keys.plan("el", &axes).expect("the axis allows it");
    let points: Vec<_> = cases
        .iter()
        .enumerate()
        .map(|(k, case)| {
            let clean = bench::run(plant, case, k);
            keys.analyse(case, &bench::measured(&clean.window, 0.01 * plant.coulomb, seed), &axes)
        })
        .collect();
    keys.conclude(&cases, &points, &axes)
}

fn all<'a>(conclusion: &'a Conclusion, measurand: &str) -> Vec<&'a Measurement> {
    conclusion.measurements.iter().filter(|m| m.measurand == measurand).collect()
}

#[test]
fn explore() {
    for (plant, kt, pose, d) in [(AZIMUTH, 60.0, 0.0, 1.6), (ELEVATION, 52.0, 60.0, 0.6)] {
        let mut k = keys(pose, d);
        k.ramps = vec![RampKeys { rates_a_per_s: vec![1.0, 3.0], dwells_s: vec![1.0], repeats: 1 }];
        k.multisine =
            Some(MultisineKeys { level_ratio: 0.1, from_hz: 0.2, to_hz: 10.0, lines: 14, periods: 5 });
        if pose > 0.0 {
            k.hold = Some(HoldKeys {
                poses_rad: [20.0, 40.0, 60.0, 75.0, 87.0, -7.0].map(|d| d * DEGREE).to_vec(),
                rate_a_per_s: 1.0,
                release_s: 4.0,
            });
        }
        let c = conclusion(&k, &plant, kt, 1);
        for m in &c.measurements {
            eprintln!(
                "{} {:?} {:?} u {:.4} dof {:?} {:?} {:?} {:?}",
                m.measurand,
                m.point,
                m.value,
                m.u,
                m.dof,
                m.conditions.iter().map(|c| (c.name.clone(), c.achieved)).collect::<Vec<_>>(),
                m.flags,
                m.inconclusive
            );
        }
        for r in &c.remarks {
            eprintln!("{r}");
        }
    }
}
