//! Units that nobody has tuned anything on. `cargo run --release -p validation -- blind` takes sixty of them over whole campaigns.

use rayon::prelude::*;
use validation::blind::{Asked, Unit, Units, measured};

#[test]
#[ignore = "takes the better part of a minute; `.ci/run` runs it after the others"]
fn four_drawn_units_show_friction_loads_and_constants_within_twice_their_uncertainty_and_no_false_pass() {
    let asked = Asked {
        program: env!("CARGO_BIN_EXE_bench").into(),
        campaign: "quick".to_owned(),
        select: [
            "AZ-TORQUE-CONSTANT",
            "EL-TORQUE-CONSTANT",
            "AZ-FRICTION",
            "EL-FRICTION",
            "AZ-LATENCY",
            "FSM-IMPEDANCE",
            "IMU-CONSISTENCY",
        ]
        .map(str::to_owned)
        .into(),
        units: Units::Drawn,
    };
    let units: Vec<Unit> = (101..105_u32).into_par_iter().map(|number| measured(&asked, number)).collect();
    for unit in &units {
        assert!(unit.scored.len() >= 20, "{} findings have a truth", unit.scored.len());
        assert!(unit.troubles.is_empty(), "{:?}", unit.troubles);
        let far: Vec<String> =
            unit.scored.iter().filter(|one| one.error_in_u().abs() > 2.0).map(|one| one.text()).collect();
        assert!(far.is_empty(), "{far:#?}");
        assert!(unit.scored.iter().all(|one| !one.is_false_pass()));
    }
}
