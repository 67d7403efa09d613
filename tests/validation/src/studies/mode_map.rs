//! Measured modes against those of the same unit, over all elevations.
//!
//! Runs a modes procedure through wires, drivers, loop, log and judge, and sets frequency and damping of every expected
//! mode beside the unit's own, interpolated at the elevation that was reached.
//!
//! `cargo run --release -p validation -- mode_map [UNIT] [SEEDS] [az|el] [FILE]`

use bench::files::unit::load_unit;
use procedures::kinds::PointModes;
use procedures::measurement::{Measurement, PointResult};
use validation::measured_points;

/// Demand on a frequency that is found.
const MOST_DEPARTURE: f64 = 0.005;

pub(crate) fn study() {
    let arguments: Vec<String> = crate::arguments().collect();
    let unit = arguments.first().map_or("nominal", String::as_str);
    let seeds: u64 = arguments.get(1).and_then(|n| n.parse().ok()).unwrap_or(1);
    for (axis, name) in [(0, "az"), (1, "el")] {
        if arguments.get(2).is_some_and(|a| a != name) {
            continue;
        }
        let shipped = format!("procedures/fat/{name}-modes.toml");
        let file = arguments.get(3).unwrap_or(&shipped);
        let mut table = Table::default();
        for seed in 1..=seeds {
            let id = format!("{}-MODES", name.to_uppercase());
            for point in measured_points::run("mode-map", unit, name, file, &id, seed) {
                table.add(unit, axis, &point);
            }
        }
        table.print(unit, name);
    }
}

#[derive(Default)]
struct Table {
    rows: Vec<String>,
    modes: usize,
    seen: usize,
    covered: usize,
    worst: f64,
}

impl Table {
    fn add(&mut self, unit: &str, axis: usize, point: &PointResult) {
        let Some(modes) = point.reduced.get::<PointModes>() else {
            self.rows.push(format!("{}: {:?}", point.point, point.inconclusive));
            return;
        };
        let elevation_rad = modes.elevation_rad;
        self.rows.push(format!(
            "{:6.2} deg: transport {:.3} ms (u {:.3}), inertia {:.1?}, misfit {:.2}, excluded {:?}",
            elevation_rad.to_degrees(),
            1e3 * modes.delay_s,
            1e3 * modes.delay_u_s,
            modes.inertia_kg_m2,
            modes.misfit_ratio,
            point.excluded.iter().map(|e| (e.count, &e.reason)).collect::<Vec<_>>()
        ));
        for (k, [true_hz, true_damping]) in truth(unit, axis, elevation_rad).into_iter().enumerate() {
            self.modes += 1;
            let Some(found) = modes.visible.iter().find(|mode| mode.expected == Some(k + 1)) else {
                self.rows.push(format!("    mode {}: {true_hz:7.3} Hz not found", k + 1));
                continue;
            };
            let departure = found.frequency_hz / true_hz - 1.0;
            self.seen += 1;
            self.covered += usize::from((found.frequency_hz - true_hz).abs() <= 2.0 * found.frequency_u_hz);
            self.worst = self.worst.max(departure.abs());
            self.rows.push(format!(
                "    mode {}: {:7.3} - {true_hz:7.3} Hz = {:+.3} % (U {:.3} %), damping {:.4} - {true_damping:.4}, gyro {:+.4}, encoder {:+.4}",
                k + 1,
                found.frequency_hz,
                100.0 * departure,
                200.0 * found.frequency_u_hz / true_hz,
                found.damping_ratio.unwrap_or(f64::NAN),
                found.gyro,
                found.encoder
            ));
        }
        let strange = modes.visible.iter().filter(|mode| mode.expected.is_none());
        self.rows.extend(strange.map(|mode| format!("    not expected: {:.3} Hz", mode.frequency_hz)));
        let broken = |m: &&Measurement| m.value.is_none();
        let reasons = point.measurements.iter().filter(broken).filter_map(|m| m.inconclusive.clone());
        self.rows.extend(reasons.map(|reason| format!("    {reason}")));
    }

    fn print(&self, unit: &str, axis: &str) {
        println!("{unit}, {axis}: frequency found - the unit's own");
        self.rows.iter().for_each(|row| println!("{row}"));
        println!(
            "  {} of {} modes found, worst {:.3} % (demand {:.1} %), {} covered by U",
            self.seen,
            self.modes,
            100.0 * self.worst,
            100.0 * MOST_DEPARTURE,
            self.covered
        );
    }
}

/// Frequency (Hz) and damping ratio of the unit's modes at an elevation, by ascending frequency.
fn truth(unit: &str, axis: usize, elevation_rad: f64) -> Vec<[f64; 2]> {
    let unit = load_unit(unit).expect("a unit that parses");
    let settings = unit.director().expect("a director");
    let structure = if axis == 0 { &settings.az_structure } else { &settings.el_structure };
    let at = |values: &[f64]| structure.interpolate(values, elevation_rad);
    let mut modes: Vec<[f64; 2]> =
        structure.modes.iter().map(|m| [at(&m.frequency_hz), at(&m.damping_ratio)]).collect();
    modes.sort_by(|x, y| x[0].total_cmp(&y[0]));
    modes
}
