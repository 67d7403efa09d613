//! Disabled is not standstill: an axis whose cable spring is stronger than its friction swings back (director.md E23).

use std::time::Duration;

use bench::model::stopping::{LeastFriction, Loads, StopModel};
use procedures::case::Mode;
use procedures::stimulus::Stimulus;
use sim_devices::rig::{Fault, SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

use super::bed::{Bed, case, rig, segment};

/// Elevation with the spring of the study and its rest at 0 degrees.
fn sprung() -> UnitSettings {
    let mut unit = UnitSettings::default();
    unit.el.spring_stiffness_nm_per_rad = 54.0;
    unit.el.spring_rest_rad = 0.0;
    unit
}

/// A model that knows the unit's own figures instead of what a rig may rely on.
fn knowing(unit: &UnitSettings) -> StopModel {
    let el = &unit.el;
    StopModel {
        inertia_kg_m2: el.inertia_kg_m2,
        loads: Loads {
            unbalance_nm: el.unbalance_nm,
            spring_nm_per_rad: el.spring_stiffness_nm_per_rad,
            spring_rest_rad: el.spring_rest_rad,
        },
        friction: LeastFriction {
            static_nm: el.static_torque_nm,
            coulomb_nm: el.coulomb_torque_nm,
            viscous_nm_s_per_rad: el.viscous_damping_nm_s_per_rad,
        },
        ..rig(&[]).axes[1].guard.stop.clone()
    }
}

/// Where elevation comes to rest without torque, and its largest speed on the way, degrees.
fn let_go(unit: &UnitSettings, from_deg: f64) -> (f64, f64) {
    let address = SeedAddress { seed: 1, procedure: "SWING".to_owned(), point: "1".to_owned() };
    let start = StartState { az_rad: 0.0, el_rad: from_deg.to_radians(), heat_sink_degc: 40.0 };
    let simulated = SimulatedRig::new(unit, &address, start);
    let mut line = simulated.imu_line();
    let mut fastest = 0.0_f64;
    for ms in 0..20_000 {
        // Looking at the line is what makes time pass.
        line.read(Duration::from_millis(ms), &mut [0; 4096]).expect("a simulated line");
        fastest = fastest.max(simulated.truth_of_axes().rate_rad_per_s[1].abs());
    }
    let truth = simulated.truth_of_axes();
    assert!(truth.rate_rad_per_s[1].abs() < 1e-4, "still turns");
    assert!(simulated.record().crashes.is_empty());
    (truth.angle_rad[1].to_degrees(), fastest.to_degrees())
}

#[test]
fn let_go_at_90_degrees_elevation_swings_to_where_it_was_computed() {
    for from_deg in [90.0_f64, 75.0] {
        let unit = sprung();
        let swing =
            knowing(&unit).swing(from_deg.to_radians()).expect("the spring is stronger than friction");
        let (to_deg, fastest) = let_go(&unit, from_deg);
        let computed_deg = swing.to_rad.to_degrees();
        let computed_speed = swing.speed_rad_per_s.to_degrees();
        assert!(from_deg - to_deg > 10.0, "from {from_deg} to {to_deg} deg");
        // The Stribeck part of friction, which the model leaves out, holds the axis a little earlier.
        assert!((to_deg - computed_deg).abs() < 3.0, "{from_deg}: {to_deg} deg, computed {computed_deg} deg");
        assert!(fastest < 1.02 * computed_speed, "{fastest} deg/s, computed {computed_speed} deg/s");
    }
}

/// What a rig file relies on is less friction than there is: the axis never swings farther than that says.
#[test]
fn no_swing_is_longer_or_faster_than_what_the_rig_file_relies_on() {
    let unit = sprung();
    let model = StopModel { friction: rig(&[]).axes[1].guard.stop.friction, ..knowing(&unit) };
    for from_deg in [60.0_f64, 70.0, 80.0, 90.0] {
        let (to_deg, fastest) = let_go(&unit, from_deg);
        let Some(swing) = model.swing(from_deg.to_radians()) else {
            assert!((to_deg - from_deg).abs() < 0.1, "{from_deg}: swings, which was not computed");
            continue;
        };
        assert!(to_deg > swing.to_rad.to_degrees(), "{from_deg}: {to_deg} deg, {swing:?}");
        assert!(fastest < swing.speed_rad_per_s.to_degrees(), "{from_deg}: {fastest} deg/s, {swing:?}");
    }
}

#[test]
fn with_the_rest_of_the_shipped_unit_it_stays_at_90_degrees() {
    assert_eq!(knowing(&UnitSettings::default()).swing(1.57), None);
    let (to_deg, fastest) = let_go(&UnitSettings::default(), 90.0);
    assert!((to_deg - 90.0).abs() < 0.1 && fastest < 0.1, "{to_deg} deg, {fastest} deg/s");
}

/// The same out of the loop: held by torque, then the emergency stop.
#[test]
fn an_emergency_stop_lets_a_held_elevation_swing_and_the_loop_waits_for_its_end() {
    let unit = sprung();
    let hold = segment(Mode::Position, Stimulus::Hold { torque_nm: 0.0 }, 4.0);
    let mut bed = Bed::new(case("el", [0.0, 89.0], vec![hold]));
    bed.start_deg = [0.0, 89.0];
    bed.faults = vec![(Duration::from_secs(2), Fault::EmergencyStop { pressed: true })];
    let swing = knowing(&unit).swing(89.0_f64.to_radians()).expect("the spring is stronger than friction");
    bed.unit = unit;
    let ran = bed.run();
    let last = ran.column("/el", "position_rad").last().expect("rows").to_degrees();
    let computed = swing.to_rad.to_degrees();
    assert!((last - computed).abs() < 3.0, "{last} deg, computed {computed} deg");
    assert!(ran.outcome.trip.is_some() && ran.outcome.safe.standstill, "{:?}", ran.outcome);
    assert_eq!(ran.contacts, 0);
}
