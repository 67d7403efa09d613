//! Friction, loads and cogging, as torques that follow the torque constant that the force gauge finds.

use std::f64::consts::TAU;

use sim_devices::physics::lugre::LuGre;
use sim_devices::unit::AxisSettings;

use super::drivetrain::Drivetrain;
use super::{Expected, Subject, rig_limits, row};

const DEG: f64 = std::f64::consts::PI / 180.0;
/// Rates of the friction procedures within the limit of FRC, deg/s.
const RATES_DEG_PER_S: [f64; 2] = [2.0, 10.0];
/// Slowest ramp of the breakaway procedures: the contact ages on the way.
const RAMP_A_PER_S: f64 = 0.01;
/// Longest rest before a ramp of 1 A/s.
const LONGEST_DWELL_S: f64 = 100.0;
const DWELL_RAMP_A_PER_S: f64 = 1.0;
/// Poses of HOLD-EL.
const HOLD_DEG: [f64; 3] = [20.0, 40.0, 60.0];

/// Torque constant 0.5 % and row 13 (T_S 0.3 %, T_C 0.5…0.75 %), k = 2.
const FRICTION_U: f64 = 0.012;
/// Rows 16 and 17: unbalance and spring by least squares over −8…88°, inflation 14, and the torque constant.
const LOAD_U: f64 = 0.01;
const LOAD_U_NM: f64 = 1.5;
/// Row 16: amplitude 1 %, k = 2, and the torque constant.
const COGGING_U: f64 = 0.023;
/// Row 16: what a line that is not there may show, half a percent of the largest, and the resolution in orders.
const ORDER_U_PER_REV: f64 = 0.02;

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    (0..2).flat_map(|axis| axis_rows(subject, axis)).collect()
}

fn axis_rows(subject: &Subject<'_>, axis: usize) -> Vec<Expected> {
    let settings = subject.axis(axis);
    let train = Drivetrain::new(subject, axis, 0.0);
    let mut rows = Vec::new();
    let mut friction = |condition: String, torque_nm: f64| {
        rows.push(row(
            ["FRC-AZ", "FRC-EL"][axis],
            axis,
            "friction",
            condition,
            torque_nm,
            FRICTION_U * torque_nm,
        ));
    };
    for rate in RATES_DEG_PER_S {
        friction(format!("{rate} deg/s"), train.friction_nm(rate * DEG));
    }
    friction("breakaway, 0.01 A/s".into(), breakaway_nm(settings, 0.0, RAMP_A_PER_S));
    friction("breakaway after 100 s".into(), breakaway_nm(settings, LONGEST_DWELL_S, DWELL_RAMP_A_PER_S));
    rows.extend(loads(settings, &train, axis));
    rows.extend(cogging(settings, axis));
    rows
}

fn loads(settings: &AxisSettings, train: &Drivetrain<'_>, axis: usize) -> Vec<Expected> {
    let of = |id, quantity, condition: String, value: f64| {
        row(id, axis, quantity, condition, value, LOAD_U * value.abs() + LOAD_U_NM)
    };
    let reach_rad = rig_limits::TRAVEL_RAD[axis]
        .iter()
        .map(|end| (end - settings.spring_rest_rad).abs())
        .fold(0.0, f64::max);
    let spring_nm = settings.spring_stiffness_nm_per_rad * reach_rad;
    let mut rows = vec![
        of(["UNB-AZ", "UNB-EL"][axis], "unbalance", String::new(), settings.unbalance_nm.abs()),
        of(["SPR-AZ", "SPR-EL"][axis], "spring", "largest over the travel".into(), spring_nm),
    ];
    if axis == 1 {
        rows.extend(HOLD_DEG.map(|pose| {
            // A fresh contact: rest only makes it hold better.
            let margin_nm = settings.static_torque_nm - train.load_nm(pose * DEG).abs();
            of("HOLD-EL", "hold-margin", format!("elevation {pose} deg"), margin_nm)
        }));
    }
    rows
}

fn cogging(settings: &AxisSettings, axis: usize) -> [Expected; 3] {
    let id = ["COG-AZ", "COG-EL"][axis];
    let names = [
        ["cogging-order-az", "cogging-amplitude-az", "cogging-peak-az"],
        ["cogging-order-el", "cogging-amplitude-el", "cogging-peak-el"],
    ];
    let base = settings.cogging_orders_per_rev;
    let lines = [
        (base, settings.cogging_amplitude_nm),
        (2.0 * base, settings.cogging_second_amplitude_nm),
        (settings.ripple_orders_per_rev, settings.ripple_amplitude_nm),
    ];
    // The largest line is the cogging that is found.
    let (order, amplitude) =
        lines.into_iter().fold(lines[0], |most, line| if line.1 > most.1 { line } else { most });
    [
        row(id, axis, names[axis][0], "", order, ORDER_U_PER_REV),
        row(id, axis, names[axis][1], "", amplitude, COGGING_U * amplitude),
        row(id, axis, names[axis][2], "", cogging_peak_nm(settings), COGGING_U * amplitude),
    ]
}

/// Points in a period of the second line of cogging: between them the sum is at most 0.03 % larger.
const POINTS: f64 = 128.0;

/// Largest magnitude of cogging and ripple together over a turn.
pub(crate) fn cogging_peak_nm(settings: &AxisSettings) -> f64 {
    let base = settings.cogging_orders_per_rev;
    let highest = (2.0 * base).max(settings.ripple_orders_per_rev);
    let count = (POINTS * highest).ceil();
    let sum_nm = |k: usize| {
        let angle_rad = TAU * k as f64 / count;
        settings.cogging_amplitude_nm * (base * angle_rad + settings.cogging_phase_rad).sin()
            + settings.cogging_second_amplitude_nm
                * (2.0 * base * angle_rad + settings.cogging_second_phase_rad).sin()
            + settings.ripple_amplitude_nm
                * (settings.ripple_orders_per_rev * angle_rad + settings.ripple_phase_rad).sin()
    };
    (0..count as usize).map(|k| sum_nm(k).abs()).fold(0.0, f64::max)
}

/// Torque at which a contact that rested gives way under a torque ramp, inertia left out: while `z` follows the torque
/// (`z = T/σ0`), `ω = ż/(1 − T/s)`, and the age goes by `φ̇ = 1 − ω·φ/D_c`; it slides once `T = s(ω, φ)`.
fn breakaway_nm(axis: &AxisSettings, rested_s: f64, ramp_a_per_s: f64) -> f64 {
    const NEARLY: f64 = 0.999;
    let law = LuGre::new(axis, 1e-3);
    let rate_nm_per_s = ramp_a_per_s * axis.torque_constant_nm_per_a;
    let step_s = 1e-4 * axis.static_torque_nm / rate_nm_per_s;
    let deflection_rate = rate_nm_per_s / axis.bristle_stiffness_nm_per_rad;
    let memory_rad = axis.static_torque_nm / axis.bristle_stiffness_nm_per_rad;
    let mut torque_nm = 0.0;
    let mut age_s = rested_s;
    let mut rate = 0.0;
    loop {
        let bristles_nm = law.sliding_torque_nm(rate, age_s);
        let share = torque_nm / bristles_nm;
        if share >= NEARLY {
            return torque_nm;
        }
        rate = deflection_rate / (1.0 - share);
        age_s = (age_s + step_s * (1.0 - rate * age_s / memory_rad)).clamp(0.0, axis.ageing_limit_s);
        torque_nm += rate_nm_per_s * step_s;
    }
}
