//! Measured coarse track loops against the model of the same unit.
//!
//! Runs a track-loop procedure through wires, drivers, cameras, loop, log and judge, and sets its margins beside those of
//! the linear model; elevation's sweep covers its travel, so the model is averaged over it.
//!
//! `[AXIS=el] cargo run --release -p validation -- track_margins [UNIT] [SEEDS]`

use bench::files::parameters;
use bench::files::unit::load_unit;
use num_complex::Complex64;
use procedures::measurement::PointResult;
use validation::linear::{CoarseCamera, Margins, Sensor, VelocityLoop, coarse_open_loop, margins};
use validation::measured_points;

/// Elevations over which elevation's model is averaged.
const SWEPT_DEG: [f64; 2] = [-2.0, 82.0];
/// Where crossings are searched.
const BAND_HZ: [f64; 2] = [0.6, 60.0];
/// Period of the coarse law.
const LAW_S: f64 = 5e-4;

pub(crate) fn study() {
    let mut arguments = crate::arguments();
    let unit = arguments.next().unwrap_or_else(|| "as-measured".to_owned());
    let seeds: u64 = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(1);
    let only = std::env::var("AXIS").ok();
    for (axis, name) in
        [(0, "az"), (1, "el")].into_iter().filter(|(_, n)| only.as_deref().is_none_or(|o| o == *n))
    {
        let rows = (1..=seeds).flat_map(|seed| run(&unit, name, seed));
        print(name, rows.filter_map(|point| row(&unit, axis, &point)).collect());
    }
}

/// The points of a run, judged again from its log.
fn run(unit: &str, axis: &str, seed: u64) -> Vec<PointResult> {
    let file = format!("procedures/fat/{axis}-track-loop.toml");
    let id = format!("{}-TRACK-LOOP", axis.to_uppercase());
    measured_points::run("track-margins", unit, axis, &file, &id, seed)
}

/// Measured, model and expanded uncertainty: bandwidth Hz, gain margin dB, phase margin deg.
fn row(unit: &str, axis: usize, point: &PointResult) -> Option<(f64, [[f64; 3]; 3])> {
    let of = |name: &str| point.measurements.iter().find(|m| m.measurand == name);
    let elevation_rad = of("track-bandwidth")?.conditions.first()?.achieved?;
    let model = model(unit, axis, elevation_rad);
    let degrees = 180.0 / std::f64::consts::PI;
    let measured = [
        ("track-bandwidth", 1.0, model.bandwidth_hz),
        ("track-gain-margin", 1.0, model.gain_margin_db),
        ("track-phase-margin", degrees, model.phase_margin_deg),
    ];
    let one = |(name, factor, truth): (&str, f64, f64)| {
        let m = of(name)?;
        Some([m.value? * factor, truth, 2.0 * m.u * factor])
    };
    let [bandwidth, gain, phase] = measured.map(one);
    Some((elevation_rad.to_degrees(), [bandwidth?, gain?, phase?]))
}

fn model(unit: &str, axis: usize, elevation_rad: f64) -> Margins {
    let unit = load_unit(unit).expect("a unit that parses");
    let unit = unit.director().expect("a director").clone();
    let (_, gains) = parameters::named("director", None).expect("shipped parameters");
    let own = if axis == 0 { gains.az } else { gains.el };
    let elevations: Vec<f64> = match axis {
        0 => vec![elevation_rad],
        _ => (0..=12)
            .map(|k| (SWEPT_DEG[0] + (SWEPT_DEG[1] - SWEPT_DEG[0]) * f64::from(k) / 12.0).to_radians())
            .collect(),
    };
    let loops: Vec<_> = elevations
        .iter()
        .map(|el| {
            let velocity = VelocityLoop::new(&unit, axis, *el, Sensor::Gyro, &own, 4000.0);
            let camera = CoarseCamera::new(&unit, &velocity, &gains.track, LAW_S);
            (velocity, camera)
        })
        .collect();
    let open = |hz: f64| {
        loops.iter().map(|(v, c)| coarse_open_loop(v, c, hz)).sum::<Complex64>() / loops.len() as f64
    };
    margins(open, BAND_HZ[0], BAND_HZ[1]).expect("it crosses 0 dB")
}

fn print(axis: &str, rows: Vec<(f64, [[f64; 3]; 3])>) {
    println!("{axis}: elevation deg, then bandwidth Hz, gain margin dB, phase margin deg: measured - model");
    for (elevation_deg, values) in &rows {
        let text = values.map(|[found, truth, u]| {
            format!("{found:8.3} - {truth:8.3} = {:+7.3} (U {u:.3})", found - truth)
        });
        println!("{elevation_deg:7.2}   {}", text.join("   "));
    }
    for (k, name) in ["bandwidth", "gain", "phase"].iter().enumerate() {
        let differences: Vec<f64> =
            rows.iter().map(|(_, values)| (values[k][0] - values[k][1]).abs()).collect();
        let covered = rows.iter().filter(|(_, v)| (v[k][0] - v[k][1]).abs() <= v[k][2]).count();
        let worst = differences.iter().copied().fold(0.0, f64::max);
        println!("  {name}: worst {worst:.3}, covered {covered} of {}", rows.len());
    }
}
