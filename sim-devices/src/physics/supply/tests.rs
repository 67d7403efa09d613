use super::*;
use crate::unit::{AxisSettings, UnitSettings};

const STEP_S: f64 = 50e-6;

fn run(supply: &mut Supply, steps: u32, power_w: f64) {
    for _ in 0..steps {
        supply.step(power_w);
    }
}

fn nominal() -> UnitSettings {
    UnitSettings::default()
}

/// What an axis draws at this speed and acceleration, its motor working against inertia and sliding friction.
fn axis_w(settings: &AxisSettings, speed: f64, acceleration: f64) -> f64 {
    let excess = settings.static_torque_nm - settings.coulomb_torque_nm;
    let ratio = (speed / settings.stribeck_velocity_rad_per_s).powf(settings.stribeck_shape_exponent);
    let friction =
        settings.coulomb_torque_nm + excess * (-ratio).exp() + settings.viscous_damping_nm_s_per_rad * speed;
    let torque = settings.inertia_kg_m2 * acceleration + if speed > 0.0 { friction } else { 0.0 };
    drive_w(settings.loss_resistance_ohm(), torque, speed, torque / settings.torque_constant_nm_per_a)
}

/// Both axes at once to 60 deg/s and back to rest with 90 deg/s² and no pause, over and over.
fn slew(unit: &UnitSettings, seconds: f64, mut see: impl FnMut(f64, f64, &Supply)) {
    let mut supply = Supply::new(&unit.supply, STEP_S);
    let top = 60.0_f64.to_radians();
    let acceleration = 90.0_f64.to_radians();
    let ramp_s = top / acceleration;
    for k in 0..(seconds / STEP_S).round() as u32 {
        let t = f64::from(k) * STEP_S % (2.0 * ramp_s);
        let (speed, sign) =
            if t < ramp_s { (acceleration * t, 1.0) } else { (top - acceleration * (t - ramp_s), -1.0) };
        let power =
            axis_w(&unit.az, speed, sign * acceleration) + axis_w(&unit.el, speed, sign * acceleration);
        let before = supply.bus_v();
        supply.step(power);
        see(before, power, &supply);
    }
}

#[test]
fn both_axes_slewing_and_braking_keep_bus_supply_and_shunt_inside_their_limits() {
    let mut lowest = 1e9_f64;
    let mut highest = 0.0_f64;
    let mut most_a = 0.0_f64;
    let mut most_shunt = 0.0_f64;
    let mut burnt_j = 0.0;
    slew(&nominal(), 20.0, |_, _, s| {
        lowest = lowest.min(s.bus_v());
        highest = highest.max(s.bus_v());
        most_a = most_a.max(s.supply_a());
        most_shunt = most_shunt.max(s.shunt_w());
        burnt_j += s.shunt_w() * STEP_S;
    });
    assert!(lowest > 480.0 && highest < 620.0, "{lowest} .. {highest} V");
    assert!(highest > 600.0 && burnt_j > 100.0, "braking must reach the shunt: {highest} V, {burnt_j} J");
    assert!(most_shunt <= 6700.0 && most_shunt > 6000.0, "{most_shunt} W");
    assert!(most_a < 30.0, "{most_a} A");
}

/// What the defect `shunt-open` rests on.
#[test]
fn without_its_shunt_the_bus_leaves_its_band_when_both_axes_stop() {
    let mut unit = nominal();
    unit.supply.shunt_resistance_ohm = 1.0e6;
    let mut highest = 0.0_f64;
    slew(&unit, 1.4, |_, _, s| highest = highest.max(s.bus_v()));
    assert!((630.0..660.0).contains(&highest), "{highest} V");
}

#[test]
fn energy_is_neither_lost_nor_won() {
    let unit = nominal();
    let capacitance = unit.supply.capacitance_f;
    let mut balance_j = 0.0;
    let mut turned_over_j = 0.0;
    slew(&unit, 10.0, |before, power, s| {
        let mean = 0.5 * (before + s.bus_v());
        let fed = s.supply_a() * mean;
        let burnt = s.shunt_w();
        let stored = 0.5 * capacitance * (s.bus_v().powi(2) - before.powi(2)) / STEP_S;
        balance_j += (fed - power - burnt - stored) * STEP_S;
        turned_over_j += power.abs() * STEP_S;
    });
    assert!(
        turned_over_j > 10_000.0 && balance_j.abs() < 1e-9 * turned_over_j,
        "{balance_j} of {turned_over_j} J"
    );
}

/// `v = (E + √(E² − 4·R·P))/2`.
#[test]
fn a_constant_load_settles_where_the_circuit_says() {
    let unit = nominal();
    let mut supply = Supply::new(&unit.supply, STEP_S);
    run(&mut supply, 10_000, 10_000.0);
    let open = 560.0_f64;
    let ohm = 0.4;
    let expected = 0.5 * (open + (open * open - 4.0 * ohm * 10_000.0).sqrt());
    assert!((supply.bus_v() - expected).abs() < 1e-9, "{} V, not {expected}", supply.bus_v());
    assert!((supply.supply_a() - 10_000.0 / expected).abs() < 1e-9);
}

#[test]
fn nothing_flows_back_into_the_supply_and_the_shunt_works_between_its_two_voltages() {
    let unit = nominal();
    let mut supply = Supply::new(&unit.supply, STEP_S);
    let mut lowest = 1e9_f64;
    let mut highest = 0.0_f64;
    let mut closed = 0;
    let mut steps = 0;
    for k in 0..200_000 {
        supply.step(-3000.0);
        assert_eq!(supply.supply_a(), 0.0);
        if k > 20_000 {
            (lowest, highest) = (lowest.min(supply.bus_v()), highest.max(supply.bus_v()));
            closed += u32::from(supply.shunt_w() > 0.0);
            steps += 1;
        }
    }
    assert!((594.9..595.0).contains(&lowest) && (610.0..610.1).contains(&highest), "{lowest} .. {highest} V");
    let burnt_w = f64::from(closed) / f64::from(steps) * 602.5 * 602.5 / 58.0;
    assert!((burnt_w - 3000.0).abs() < 30.0, "{burnt_w} W");
}

#[test]
fn a_source_that_is_limited_lets_the_bus_fall_below_the_drives_trip() {
    let mut unit = nominal();
    (unit.supply.continuous_current_a, unit.supply.peak_current_a) = (5.0, 5.0);
    let mut lowest = f64::INFINITY;
    slew(&unit, 0.66, |_, _, s| lowest = lowest.min(s.bus_v()));
    assert!(lowest < unit.az.under_voltage_v, "{lowest} V");
}

#[test]
fn the_peak_current_lasts_for_the_peak_time_and_comes_back_after_a_rest() {
    let unit = nominal();
    let mut supply = Supply::new(&unit.supply, STEP_S);
    // More than the supply can give at its peak: it stays at its limit.
    let held = |supply: &mut Supply| {
        (1..200_000).find(|_| {
            // The link is held up by drawing what the peak current can bring at 500 V.
            supply.step(60.0 * supply.bus_v() * 1.0001);
            supply.supply_a() < 59.0 && supply.mean_square_a2 > 890.0
        })
    };
    let first = held(&mut supply).map(|k| f64::from(k) * STEP_S);
    assert!(first.is_some_and(|t| (t - 3.0).abs() < 0.05), "{first:?} s");
    run(&mut supply, 2_000_000, 0.0);
    let again = held(&mut supply).map(|k| f64::from(k) * STEP_S);
    assert!(again.is_some_and(|t| (t - 3.0).abs() < 0.1), "{again:?} s");
}

#[test]
fn a_load_beyond_all_means_breaks_the_link_down_without_breaking_the_numbers() {
    let mut supply = Supply::new(&nominal().supply, STEP_S);
    for _ in 0..20_000 {
        supply.step(1.0e6);
        assert!(supply.bus_v().is_finite() && supply.bus_v() >= 0.0);
        assert!(supply.supply_a() <= 60.0 && supply.drawn_w() <= 1.0e6);
    }
    assert!(supply.bus_v() < 50.0, "{} V", supply.bus_v());
    run(&mut supply, 40_000, 0.0);
    assert!((supply.bus_v() - 560.0).abs() < 1.0, "{} V once the load is gone", supply.bus_v());
}

#[test]
fn twice_the_step_tells_the_same_story() {
    let unit = nominal();
    let at = |step_s: f64| {
        let mut supply = Supply::new(&unit.supply, step_s);
        run(&mut supply, (0.05 / step_s).round() as u32, 9000.0);
        run(&mut supply, (0.02 / step_s).round() as u32, -2000.0);
        supply.bus_v()
    };
    let fine = at(STEP_S);
    let coarse = at(5.0 * STEP_S);
    assert!((fine - coarse).abs() < 0.05, "{fine} against {coarse} V");
}
