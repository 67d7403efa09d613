use super::*;
use crate::probe::shipped::director_gains;

/// The shipped file, as far as the loops depend on it.
fn as_measured() -> UnitSettings {
    let text = include_str!("../../units/as-measured.toml");
    let section = |name: &str| {
        let after = text.split(&format!("[{name}]")).nth(1).expect("the section is there");
        after.split("\n[").next().unwrap_or(after)
    };
    let numbers = |name: &str, key: &str| {
        let list = section(name).split(&format!("{key} =")).nth(1).expect("the key is there");
        let list = if list.trim_start().starts_with('[') {
            list.split("\n]").next().unwrap_or(list)
        } else {
            list.split('\n').next().unwrap_or(list)
        };
        let texts = list
            .lines()
            .flat_map(|line| line.split('#').next().unwrap_or(line).split('"').skip(1).step_by(2));
        let number = |text: &str| {
            let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
            let number: f64 = number.parse().expect("a number");
            if unit == "ms" { number / 1000.0 } else { number }
        };
        texts.map(number).collect::<Vec<f64>>()
    };
    let mut unit = UnitSettings::default();
    unit.az.command_delay_s = numbers("az", "command-delay")[0];
    unit.el.command_delay_s = numbers("el", "command-delay")[0];
    unit.az.sensor_delay_s = numbers("az", "sensor-delay")[0];
    unit.el.sensor_delay_s = numbers("el", "sensor-delay")[0];
    unit.imu.delay_s = numbers("imu", "delay")[0];
    unit.trackers.coarse.scale_ratio = numbers("trackers", "coarse-scale")[0];
    for (name, structure) in [("az", &mut unit.az_structure), ("el", &mut unit.el_structure)] {
        structure.rigid_gain_ratio = numbers(&format!("{name}-structure"), "rigid-gain");
        structure.modes[0].gyro_per_kg_m2 = numbers(&format!("{name}-structure"), "mode-1-gyro");
        assert_eq!(structure.modes[0].gyro_per_kg_m2.len(), 11);
    }
    unit
}

/// Rows that do not hold, as text.
fn failing(rows: &[Row]) -> String {
    let failing: Vec<Row> = rows.iter().filter(|row| !row.holds()).cloned().collect();
    if failing.is_empty() { String::new() } else { table(&failing) }
}

/// Tables 4.4 and 4.5, prediction on, at all elevations: three figures for elevation, two for azimuth (E21).
#[test]
fn the_coarse_track_loop_of_the_measured_unit_shows_the_published_figures() {
    let rows = track_rows(&as_measured(), &director_gains());
    assert_eq!(rows.len(), 11 * (3 + 2));
    assert_eq!(failing(&rows), "");
    for row in &rows {
        let tolerance = if row.quantity == "bandwidth Hz" { 0.005 } else { 0.15 };
        assert!((row.simulated - row.model).abs() < tolerance, "{}", table(std::slice::from_ref(row)));
    }
}
