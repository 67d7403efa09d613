//! Monte-Carlo recovery of the kind `hysteresis`: truth in, estimates out, against what the issue demands.
//!
//! `cargo run --release -p procedures --example recovery_hysteresis` prints one table over 400 seeds fixed beforehand.
//! Rows "on means" feed the estimator; all others go from keys through plan, window, `analyse` and `conclude`.

#![allow(clippy::print_stdout, reason = "a program that prints a table")]

extern crate procedures;

#[path = "recovery_hysteresis/synthetic_axis.rs"]
mod synthetic_axis;
#[path = "recovery_hysteresis/table.rs"]
mod table;

use std::f64::consts::TAU;

use analysis::cogging::{Branch, Settings, Spectrum};
use analysis::stribeck::{Parameters, Point, StribeckFit, fisher};
use procedures::diagnostic::SourceFile;
use procedures::kinds::kind;
use procedures::measurement::Measurement;
use procedures::table::read_file;
use synthetic_axis::{Gauss, Truth, azimuth, elevation, rig};
use table::{Row, print};

/// Seeds of every row: 0 … 399.
const SEEDS: u64 = 400;

fn main() {
    let mut rows = Vec::new();
    for truth in [azimuth(), elevation()] {
        rows.extend(stribeck(&truth));
    }
    rows.extend(whole_kind(&azimuth(), "-60 deg .. 60 deg"));
    rows.extend(whole_kind(&elevation(), "-8 deg .. 88 deg"));
    rows.extend(hundred_periods());
    print(&rows, SEEDS);
}

/// 30 log-spaced velocities, noise of 1 % of T_C on each mean.
fn stribeck(truth: &Truth) -> Vec<Row> {
    let parameters = Parameters {
        coulomb_nm: truth.coulomb_nm,
        static_nm: truth.static_nm,
        stribeck_rad_per_s: truth.stribeck_rad_per_s,
        viscous_nm_s_per_rad: truth.viscous_nm_s_per_rad,
        shape_ratio: truth.shape_ratio,
    };
    let from = 0.05 * truth.stribeck_rad_per_s;
    let to = 60_f64.to_radians();
    let u_nm = 0.01 * truth.coulomb_nm;
    let exact: Vec<Point> = (0..30)
        .map(|k| from * (to / from).powf(f64::from(k) / 29.0))
        .map(|v| Point { velocity_rad_per_s: v, friction_nm: parameters.at_nm(v), u_nm })
        .collect();
    let bound = fisher(&exact, &parameters).try_inverse().expect("30 velocities tell five parameters apart");
    let names = ["T_C", "T_S", "omega_s", "sigma2", "delta"];
    let mut rows: Vec<Row> = names
        .iter()
        .zip(parameters.as_array())
        .enumerate()
        .map(|(k, (name, value))| {
            let limit = 1.15 * bound[(k, k)].sqrt() / value;
            Row::new(format!("{} {name}, on means", truth.name), value, limit)
        })
        .collect();
    for seed in 0..SEEDS {
        let mut random = Gauss::new(seed);
        let noisy: Vec<Point> =
            exact.iter().map(|p| Point { friction_nm: p.friction_nm + u_nm * random.next(), ..*p }).collect();
        match StribeckFit::new(&noisy) {
            Ok(fit) => rows
                .iter_mut()
                .enumerate()
                .for_each(|(k, row)| row.add(fit.parameters.as_array()[k], fit.u(k), fit.dof_count as f64)),
            Err(_) => rows.iter_mut().for_each(Row::miss),
        }
    }
    rows
}

/// 10 deg/s, one cycle at 4 kHz, white noise of 1 % of T_C a sample, through the whole kind.
fn whole_kind(truth: &Truth, span: &str) -> Vec<Row> {
    let text = format!("[sweep]\nvelocity = [\"10 deg/s\"]\nspan = \"{span}\"\ncycles = 1\n");
    let source = SourceFile { name: "recovery.toml".to_owned(), text };
    let hysteresis = kind("hysteresis").expect("the kind is in the list");
    let experiment = read_file(&source, hysteresis.fields, hysteresis.read).expect("the keys are right");
    let mut axes = rig(&[truth]);
    // Type B parts are not simulated: without them coverage tests what is.
    axes.all_mut().iter_mut().for_each(|axis| axis.limits.torque_constant_u_ratio = 0.0);
    let cases = experiment.plan(truth.name, &axes).expect("the axis can do it");
    let case = &cases[0];
    let limits = axes.get(truth.name).expect("the rig has it");
    let spring = limits.travel_rad.map(|a| (truth.spring_nm_per_rad * (a - truth.rest_rad)).abs());
    let named = |text: &str| format!("{} {text}", truth.name);
    let mut rows = vec![
        (
            "friction-torque",
            Row::new(named("friction at 10 deg/s"), truth.friction_nm(10_f64.to_radians()), 0.01),
        ),
        ("cogging-amplitude", Row::new(named("cogging amplitude"), truth.cogging[0][1], 0.01)),
        ("cogging-order", Row::new(named("cogging order"), truth.cogging[0][0], 0.001)),
    ];
    if truth.unbalance_nm > 0.0 {
        rows.push(("unbalance-torque", Row::new(named("unbalance"), truth.unbalance_nm, 0.02)));
        rows.push(("spring-torque", Row::new(named("spring torque"), spring[0].max(spring[1]), 0.02)));
        rows.push(("spring-stiffness", Row::new(named("spring stiffness"), truth.spring_nm_per_rad, 0.02)));
    }
    for seed in 0..SEEDS {
        let point = experiment.analyse(case, &truth.run(case, 4000.0, seed), &axes);
        let found = experiment.conclude(&cases, &[point], &axes);
        for (name, row) in &mut rows {
            match found.measurements.iter().find(|m| m.measurand == *name) {
                Some(Measurement { value: Some(value), u, dof, .. }) => {
                    row.add(*value, *u, dof.unwrap_or(f64::INFINITY))
                }
                _ => row.miss(),
            }
        }
    }
    rows.into_iter().map(|(_, row)| row).collect()
}

/// 100 periods each way, friction present, noise of 2 % of the largest on each 4 kHz sample at 2 deg/s: 5000 samples
/// a period, means of 78 in each of 64 bins.
fn hundred_periods() -> Vec<Row> {
    const TRUTH: [[f64; 3]; 4] =
        [[36.0, 0.25, 1.0], [144.0, 8.45, -0.3], [288.0, 1.2, 2.0], [432.0, 0.2, 0.5]];
    let span = 100.0 / 144.0 * TAU;
    let angle: Vec<f64> = (0..6400).map(|k| (f64::from(k) + 0.5) / 6400.0 * span - span / 2.0).collect();
    let settings =
        Settings { span_rad: span, full_turn: false, most_order_per_rev: 1152.0, bin_width_rad: 0.0 };
    let mut rows: Vec<Row> = TRUTH
        .iter()
        .map(|[order, amplitude, _]| Row::new(format!("az harmonic {order}, 100 periods"), *amplitude, 0.01))
        .collect();
    let mut spurious = Row::new("az largest spurious line over largest".to_owned(), 0.0, 0.005);
    for seed in 0..SEEDS {
        let mut random = Gauss::new(seed);
        let branches = [false, true].map(|reverse| {
            let sign = if reverse { -1.0 } else { 1.0 };
            let value = angle
                .iter()
                .map(|a| {
                    let ripple: f64 = TRUTH.iter().map(|[o, c, p]| c * (o * a + p).cos()).sum();
                    sign * 170.0 + ripple + 0.02 * 8.45 / 78_f64.sqrt() * random.next()
                })
                .collect();
            Branch { reverse, angle_rad: angle.clone(), value, weight: vec![1.0; angle.len()] }
        });
        let Some(spectrum) = Spectrum::new(&branches, &settings) else { continue };
        let of = |order: f64| spectrum.harmonics.iter().find(|h| h.at_order_per_rev == order);
        for (row, [order, ..]) in rows.iter_mut().zip(&TRUTH) {
            match of(*order) {
                Some(h) => row.add(h.mean.amplitude, h.mean.u, h.mean.dof),
                None => row.miss(),
            }
        }
        let known = |order: f64| TRUTH.iter().any(|t| (t[0] - order).abs() < 1.5);
        let lines = spectrum.order_per_rev.iter().zip(&spectrum.amplitude).skip(2);
        let plain = lines.filter(|(o, _)| !known(**o)).map(|(_, a)| *a).fold(0.0, f64::max);
        let listed =
            spectrum.harmonics.iter().filter(|h| !known(h.at_order_per_rev)).map(|h| h.mean.amplitude);
        spurious.add(listed.fold(plain, f64::max) / 8.45, 0.0, f64::INFINITY);
    }
    rows.push(spurious);
    rows
}
