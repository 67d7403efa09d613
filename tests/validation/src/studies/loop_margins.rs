//! Measured velocity loops against the model of the same unit, over all elevations.
//!
//! Runs a velocity-loop procedure through wires, drivers, loop, log and judge, and sets its margins beside those of the
//! linear model, whose open loop is averaged over the angles that the strokes cover.
//!
//! `[AXIS=el] cargo run --release -p validation -- loop_margins [UNIT] [SEEDS]`

use num_complex::Complex64;
use procedures::measurement::PointResult;
use validation::linear::{Margins, Sensor, VelocityLoop, margins};
use validation::{measured_points, shipped};

/// Angles over which the model is averaged, about the mean that was reached (elevation only).
const HALF_WIDTH_DEG: f64 = 2.2;
/// Where crossings are searched.
const BAND_HZ: [f64; 2] = [0.6, 110.0];

pub(crate) fn study() {
    let mut arguments = crate::arguments();
    let unit = arguments.next().unwrap_or_else(|| "as-measured".to_owned());
    let seeds: u64 = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(1);
    let only = std::env::var("AXIS").ok();
    let wanted = |name: &str| only.as_deref().is_none_or(|only| only == name);
    for (axis, name) in [(0, "az"), (1, "el")].into_iter().filter(|(_, name)| wanted(name)) {
        let mut table = Table::default();
        for seed in 1..=seeds {
            for point in run(&unit, name, seed) {
                table.add(&unit, axis, &point);
            }
        }
        table.print(name);
    }
}

/// The points of a run, judged again from its log.
fn run(unit: &str, axis: &str, seed: u64) -> Vec<PointResult> {
    let file = format!("procedures/fat/{axis}-velocity-loop.toml");
    let id = format!("{}-VELOCITY-LOOP", axis.to_uppercase());
    measured_points::run("loop-margins", unit, axis, &file, &id, seed)
}

#[derive(Default)]
struct Table {
    rows: Vec<String>,
    /// Differences and expanded uncertainties: bandwidth Hz, gain dB, phase deg.
    differences: [Vec<(f64, f64)>; 3],
}

impl Table {
    fn add(&mut self, unit: &str, axis: usize, point: &PointResult) {
        let of = |name: &str| point.measurements.iter().find(|m| m.measurand == name);
        let Some(bandwidth) = of("velocity-bandwidth") else { return };
        let elevation_rad = bandwidth.conditions[0].achieved.unwrap_or(0.0);
        let model = Model::new(unit, axis, elevation_rad);
        let expected = model.margins();
        let names = ["velocity-bandwidth", "velocity-gain-margin", "velocity-phase-margin"];
        let truth = [expected.bandwidth_hz, expected.gain_margin_db, expected.phase_margin_deg];
        let mut row = format!("{:>7.2}", elevation_rad.to_degrees());
        for (k, (name, truth)) in names.iter().zip(truth).enumerate() {
            let degrees = if k == 2 { 180.0 / std::f64::consts::PI } else { 1.0 };
            match of(name).and_then(|m| m.value.map(|v| (v * degrees, 2.0 * m.u * degrees))) {
                Some((value, u)) => {
                    self.differences[k].push((value - truth, u));
                    row += &format!("   {value:8.3} - {truth:8.3} = {:+7.3} (U {u:.3})", value - truth);
                }
                None => row += &format!("   {:?}", of(name).and_then(|m| m.inconclusive.as_deref())),
            }
        }
        self.rows.push(row);
    }

    fn print(&self, axis: &str) {
        println!("{axis}: elevation, bandwidth Hz, gain margin dB, phase margin deg: measured - model");
        self.rows.iter().for_each(|row| println!("{row}"));
        for (name, all) in ["bandwidth", "gain", "phase"].iter().zip(&self.differences) {
            let worst = all.iter().map(|(d, _)| d.abs()).fold(0.0, f64::max);
            let covered = all.iter().filter(|(d, u)| d.abs() <= *u).count();
            println!("  {name}: worst {worst:.3}, covered {covered} of {}", all.len());
        }
    }
}

/// The linear model of a unit around an elevation.
struct Model(Vec<VelocityLoop>);

impl Model {
    fn new(unit: &str, axis: usize, elevation_rad: f64) -> Self {
        let settings = &shipped::director(unit);
        let gains = shipped::gains();
        let gains = if axis == 0 { gains.az } else { gains.el };
        let steps: i32 = if axis == 0 { 0 } else { 8 };
        let at = |k: i32| {
            let away = if steps == 0 { 0.0 } else { HALF_WIDTH_DEG * f64::from(k) / f64::from(steps) };
            let elevation_rad = elevation_rad + away.to_radians();
            VelocityLoop::new(settings, axis, elevation_rad, Sensor::Gyro, &gains, 4000.0)
        };
        Self((-steps..=steps).map(at).collect())
    }

    fn open(&self, hz: f64) -> Complex64 {
        self.0.iter().map(|l| l.open(hz)).sum::<Complex64>() / self.0.len() as f64
    }

    fn margins(&self) -> Margins {
        margins(|hz| self.open(hz), BAND_HZ[0], BAND_HZ[1]).expect("it crosses 0 dB")
    }
}
