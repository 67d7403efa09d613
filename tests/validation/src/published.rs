//! The study's reference results beside what the linear model and the simulated plant give: tables 4.1 to 4.5.

mod figures;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;

use controllers::{AxisGains, DirectorGains};
use num_complex::Complex64;
use sim_devices::unit::UnitSettings;

use crate::linear::{CoarseCamera, Sensor, VelocityLoop, coarse_open_loop, margins, step_response};
use crate::probe::{Background, CoarseBench, LAW_TICKS, measured_step, measured_velocity_loop};

/// Loop rate of the study.
const LOOP_RATE_HZ: f64 = 4000.0;
/// Where a loop is searched for crossings.
const SEARCHED_HZ: [f64; 2] = [0.6, 110.0];
/// Rates at which friction no longer shows, with some reserve: azimuth, elevation (director.md, section 4.2).
const SLIDING_RAD_PER_S: [f64; 2] = [0.30, 0.06];
/// Where the coarse track loop is searched for crossings: below the azimuth's modes, whose circles are far inside 0 dB.
const TRACK_SEARCHED_HZ: [f64; 2] = [0.6, 55.0];
/// Small enough for the torque limit, large enough for friction.
const STEP_DEG: f64 = 0.5;

/// One figure of one table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Number of the study's table.
    pub table: &'static str,
    /// Elevation of the row.
    pub elevation_deg: f64,
    /// What it is, with unit.
    pub quantity: &'static str,
    /// The study's figure.
    pub published: f64,
    /// From the linear model.
    pub model: f64,
    /// From the simulated plant in the time domain.
    pub simulated: f64,
    /// How far both may be from the published figure; a ratio of it where `relative`.
    pub tolerance: f64,
    /// Whether the tolerance is relative.
    pub relative: bool,
}

impl Row {
    /// Simulated minus published.
    pub fn difference(&self) -> f64 {
        self.simulated - self.published
    }

    /// Whether model and simulation are both within the tolerance.
    pub fn holds(&self) -> bool {
        let allowed = if self.relative { self.tolerance * self.published.abs() } else { self.tolerance };
        [self.model, self.simulated].iter().all(|value| (value - self.published).abs() <= allowed)
    }
}

/// Every figure of the velocity, position and coarse track tables for a unit and its gains.
pub fn rows(unit: &UnitSettings, gains: &DirectorGains) -> Vec<Row> {
    let mut rows = Vec::new();
    for (axis, table) in [(1, &figures::ELEVATION_VELOCITY), (0, &figures::AZIMUTH_VELOCITY)] {
        let gains = if axis == 0 { &gains.az } else { &gains.el };
        for &(elevation_deg, published) in table {
            rows.extend(velocity(unit, axis, gains, elevation_deg, published));
        }
    }
    for &(elevation_deg, published) in &figures::AZIMUTH_POSITION {
        rows.extend(position(unit, &gains.az, elevation_deg, published));
    }
    rows.extend(track_rows(unit, gains));
    rows
}

/// The figures of the coarse track tables alone.
pub fn track_rows(unit: &UnitSettings, gains: &DirectorGains) -> Vec<Row> {
    let at = |axis| figures::TRACK_ELEVATIONS_DEG.iter().map(move |elevation_deg| (axis, *elevation_deg));
    let places = at(1).chain(at(0));
    places.flat_map(|(axis, elevation_deg)| track(unit, axis, gains, elevation_deg)).collect()
}

/// Rows of a table at an elevation, from quantity, published, modelled and simulated value, with an absolute tolerance.
fn absolute(table: &'static str, elevation_deg: f64) -> impl Fn(&'static str, f64, f64, f64, f64) -> Row {
    move |quantity, published, model, simulated, tolerance| Row {
        table,
        elevation_deg,
        quantity,
        published,
        model,
        simulated,
        tolerance,
        relative: false,
    }
}

fn velocity(
    unit: &UnitSettings,
    axis: usize,
    gains: &AxisGains,
    elevation_deg: f64,
    published: [f64; 3],
) -> Vec<Row> {
    let (elevation_rad, [from_hz, to_hz]) = (elevation_deg.to_radians(), SEARCHED_HZ);
    let model = VelocityLoop::new(unit, axis, elevation_rad, Sensor::Gyro, gains, LOOP_RATE_HZ);
    let background = Background::Sliding(SLIDING_RAD_PER_S[axis]);
    let simulated = measured_velocity_loop(unit, axis, elevation_rad, gains, background);
    let (Some(model), Some(simulated)) =
        (margins(|hz| model.open(hz), from_hz, to_hz), margins(|hz| simulated.at(hz), from_hz, to_hz))
    else {
        return Vec::new();
    };
    let row = absolute(if axis == 1 { "4.1" } else { "4.2" }, elevation_deg);
    let [bandwidth, phase, gain] = published;
    vec![
        row("bandwidth Hz", bandwidth, model.bandwidth_hz, simulated.bandwidth_hz, 0.1),
        row("phase margin deg", phase, model.phase_margin_deg, simulated.phase_margin_deg, 2.0),
        row("gain margin dB", gain, model.gain_margin_db, simulated.gain_margin_db, 1.5),
    ]
}

fn position(unit: &UnitSettings, gains: &AxisGains, elevation_deg: f64, published: [f64; 2]) -> Vec<Row> {
    let elevation_rad = elevation_deg.to_radians();
    let velocity = VelocityLoop::new(unit, 0, elevation_rad, Sensor::Gyro, gains, LOOP_RATE_HZ);
    let closed = |hz: f64| {
        let s = Complex64::new(0.0, std::f64::consts::TAU * hz);
        let aged = (-s * unit.az.sensor_delay_s).exp();
        let open = gains.position_gain_per_s * velocity.command_to_shaft(hz) / s * aged;
        open / (1.0 + open)
    };
    let model = step_response(closed);
    let simulated = measured_step(unit, 0, elevation_rad, gains, STEP_DEG.to_radians());
    let row = |quantity, published, model, simulated| Row {
        table: "4.3",
        elevation_deg,
        quantity,
        published,
        model,
        simulated,
        tolerance: 0.1,
        relative: true,
    };
    vec![
        row("rise s", published[0], model.rise_s, simulated.rise_s),
        row("settling s", published[1], model.settling_s, simulated.settling_s),
    ]
}

fn track(unit: &UnitSettings, axis: usize, gains: &DirectorGains, elevation_deg: f64) -> Vec<Row> {
    let (elevation_rad, [from_hz, to_hz]) = (elevation_deg.to_radians(), TRACK_SEARCHED_HZ);
    let of_axis = if axis == 0 { &gains.az } else { &gains.el };
    let settings = &gains.track;
    let velocity = VelocityLoop::new(unit, axis, elevation_rad, Sensor::Gyro, of_axis, LOOP_RATE_HZ);
    let camera = CoarseCamera::new(unit, &velocity, settings, LAW_TICKS as f64 / LOOP_RATE_HZ);
    let rate = SLIDING_RAD_PER_S[axis];
    let simulated = CoarseBench::new(unit, axis, elevation_rad, of_axis, settings, rate).measured();
    let model = margins(|hz| coarse_open_loop(&velocity, &camera, hz), from_hz, to_hz);
    let (Some(model), Some(simulated)) = (model, margins(|hz| simulated.at(hz), from_hz, to_hz)) else {
        return Vec::new();
    };
    let row = absolute(if axis == 1 { "4.4" } else { "4.5" }, elevation_deg);
    let [bandwidth, phase] = if axis == 1 {
        [figures::ELEVATION_TRACK[0], figures::ELEVATION_TRACK[1]]
    } else {
        figures::AZIMUTH_TRACK
    };
    let mut rows = vec![
        row("bandwidth Hz", bandwidth, model.bandwidth_hz, simulated.bandwidth_hz, 0.05),
        row("phase margin deg", phase, model.phase_margin_deg, simulated.phase_margin_deg, 3.0),
    ];
    if axis == 1 {
        let gain = figures::ELEVATION_TRACK[2];
        rows.push(row("gain margin dB", gain, model.gain_margin_db, simulated.gain_margin_db, 2.0));
    }
    rows
}

/// The rows as text, one line each.
pub fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "{:5} {:>9} {:18} {:>9} {:>9} {:>9} {:>10}  {}\n",
        "table", "elevation", "quantity", "published", "model", "simulated", "difference", "within"
    );
    for row in rows {
        let verdict = if row.holds() { "yes" } else { "NO" };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:5} {:>9} {:18} {:>9.3} {:>9.3} {:>9.3} {:>+10.3}  {verdict}",
            row.table,
            row.elevation_deg,
            row.quantity,
            row.published,
            row.model,
            row.simulated,
            row.difference(),
        );
    }
    text
}
