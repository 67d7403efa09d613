//! The closed velocity loop of a simulated unit, from the procedure file to the numbers: that of its linear model.

use num_complex::Complex64;
use validation::linear::{Sensor, VelocityLoop};
use validation::shipped;

use crate::bench::{folder, run_in, write};

/// Elevation of the point, and how far its strokes go each way: the structure changes with both.
const ELEVATION_DEG: f64 = 20.0;
const HALF_WIDTH_DEG: f64 = 2.2;

/// The model over the angles of the strokes.
fn model() -> Vec<VelocityLoop> {
    let settings = shipped::director("nominal");
    let gains = shipped::gains();
    let at = |k: i32| {
        let elevation_deg = ELEVATION_DEG + 0.25 * HALF_WIDTH_DEG * f64::from(k);
        VelocityLoop::new(&settings, 1, elevation_deg.to_radians(), Sensor::Gyro, &gains.el, 4000.0)
    };
    (-4..=4).map(at).collect()
}

/// First frequency below −3 dB, Hz, and the peak, dB, on a grid of 10 mHz.
fn read(closed: impl Fn(f64) -> Complex64) -> [f64; 2] {
    let db: Vec<(f64, f64)> =
        (100..1200).map(|k| 0.01 * f64::from(k)).map(|hz| (hz, 20.0 * closed(hz).norm().log10())).collect();
    let falls = db.iter().find(|(_, db)| *db < -20.0 * 2_f64.sqrt().log10()).expect("it falls").0;
    [falls, db.iter().map(|(_, db)| *db).fold(f64::NEG_INFINITY, f64::max)]
}

/// Value and standard uncertainty of a measurand, wherever the results hold it.
fn found(results: &serde_json::Value, measurand: &str) -> Option<[f64; 2]> {
    match results {
        serde_json::Value::Object(map) if map.get("measurand").is_some_and(|m| m == measurand) => {
            Some([map.get("value")?.as_f64()?, map.get("u")?.as_f64()?])
        }
        serde_json::Value::Object(map) => map.values().find_map(|v| found(v, measurand)),
        serde_json::Value::Array(all) => all.iter().find_map(|v| found(v, measurand)),
        _ => None,
    }
}

#[test]
fn the_closed_velocity_loop_of_a_unit_is_that_of_its_model_by_both_sensors() {
    let folder = folder();
    let text = include_str!("../procedures/quick/el-velocity-loop.toml");
    // Rows are means over eight ticks: they must not show in the response.
    let text = text.replace(
        "1 kHz\"                         # rows are means over 4",
        "500 Hz\"  # rows are means over 8",
    );
    write(folder.path(), "el.toml", &text);
    let said = run_in(folder.path(), &["run", "./el.toml", "--out", "run", "--non-interactive"]);
    assert!(said.code == 0 || said.code == 3, "exit {}\n{}\n{}", said.code, said.out, said.err);
    let text = std::fs::read_to_string(folder.path().join("run/results.json")).expect("results of the run");
    let results = serde_json::from_str(&text).expect("results are JSON");
    let model = model();
    let mean = |of: &dyn Fn(&VelocityLoop) -> Complex64| {
        model.iter().map(of).sum::<Complex64>() / model.len() as f64
    };
    let shaft = read(|hz| mean(&|l| l.command_to_shaft(hz)));
    let gyro = read(|hz| mean(&|l| l.closed(hz)));
    for (sensor, expected) in [("", shaft), ("-gyro", gyro)] {
        for (name, expected, within) in [("bandwidth", expected[0], 0.06), ("peak", expected[1], 0.08)] {
            let name = format!("closed-velocity-{name}{sensor}");
            let [value, u] = found(&results, &name).unwrap_or_else(|| panic!("{name} has no value"));
            assert!((value - expected).abs() < within, "{name}: {value} ± {u}, model {expected}");
        }
    }
}
