//! Modes over elevation: the base's curves, scaled to what was found at some elevations.
//!
//! Between two elevations the scale is interpolated, outside it is that of the nearest. Modes are matched by their rank in frequency
//! at the elevation.

use std::f64::consts::PI;

use procedures::quantity::QuantityKind;
use sim_devices::unit::{CURVES, StructureSettings, UnitSettings};

use super::{CONTRADICTS_U, Finding, Identified, IdentifiedCurve, Value};

/// Measurands whose names say the number of the mode.
const FREQUENCIES: [[&str; 2]; 4] = [
    ["first-mode-frequency", "mode-1-departure"],
    ["second-mode-frequency", "mode-2-departure"],
    ["third-mode-frequency", "mode-3-departure"],
    ["fourth-mode-frequency", "mode-4-departure"],
];
/// Elevations that are closer than this are one.
const SAME_ELEVATION_RAD: f64 = 0.02;

/// A value of one mode at one elevation.
#[derive(Clone, Debug)]
struct Point {
    /// Place in [`CURVES`].
    curve: usize,
    elevation_rad: f64,
    value: Value,
    evidence: String,
}

/// Adds what was found of the modes.
pub(super) fn identify(findings: &[Finding<'_>], base: &UnitSettings, found: &mut Identified) {
    let viscous = [0, 1].map(|axis| found.unit.axis(axis).viscous_damping_nm_s_per_rad);
    let mut points: Vec<Point> =
        findings.iter().filter_map(|finding| point(finding, base, viscous)).collect();
    points
        .sort_by(|a, b| (a.curve, a.elevation_rad).partial_cmp(&(b.curve, b.elevation_rad)).expect("finite"));
    for own in points.chunk_by(|a, b| a.curve == b.curve) {
        let merged: Vec<(f64, Value)> = own
            .chunk_by(|a, b| b.elevation_rad - a.elevation_rad < SAME_ELEVATION_RAD)
            .map(|same| mean(same, &mut found.contradictions))
            .collect();
        let curve = &CURVES[own[0].curve];
        let structure = structure(base, curve.table);
        let nominal = curve.get(base);
        let at = |elevation_rad: f64| structure.interpolate(nominal, elevation_rad);
        let scales: Vec<(f64, f64)> = merged
            .iter()
            .map(|(elevation_rad, value)| (*elevation_rad, value.value_si / at(*elevation_rad)))
            .collect();
        let nodes = structure.elevation_rad.iter().zip(nominal);
        let [least, most] = curve.range_si;
        let values = nodes.map(|(node_rad, value)| (value * scale(&scales, *node_rad)).clamp(least, most));
        curve.set(&mut found.unit, values.collect());
        let mut evidence: Vec<String> = own.iter().map(|point| point.evidence.clone()).collect();
        evidence.dedup();
        found.curves.push(IdentifiedCurve { table: curve.table, key: &curve.key, points: merged, evidence });
    }
}

fn structure<'a>(unit: &'a UnitSettings, table: &str) -> &'a StructureSettings {
    if table.starts_with("az") { &unit.az_structure } else { &unit.el_structure }
}

/// Share of the contribution of friction to damping that is not known: participations are those of the base.
const UNKNOWN_RATIO: f64 = 0.2;

/// What a finding says of a mode that the base has. `viscous` are the viscous coefficients of both axes, N·m·s/rad.
fn point(finding: &Finding<'_>, base: &UnitSettings, viscous: [f64; 2]) -> Option<Point> {
    let m = finding.measurement;
    let (rank, part, ratio) = match FREQUENCIES.iter().position(|names| names.contains(&m.measurand.as_str()))
    {
        Some(rank) => (rank, "frequency", frequency_hz(finding)? / finding.value_of_frequency()),
        None if m.measurand == "mode-damping" => (rank_of_flag(finding)?, "damping", 1.0),
        None => return None,
    };
    let elevation_rad = finding.condition("elevation")?;
    let axis = finding.axis?;
    let table = ["az-structure", "el-structure"][axis];
    let structure = structure(base, table);
    let here = |k: &usize| structure.interpolate(&structure.modes[*k].frequency_hz, elevation_rad);
    let mut modes: Vec<usize> = (0..structure.modes.len()).filter(|k| here(k) > 0.0).collect();
    modes.sort_by(|a, b| here(a).total_cmp(&here(b)));
    let mode = *modes.get(rank)?;
    let key = format!("mode-{}-{part}", mode + 1);
    let curve = CURVES.iter().position(|curve| curve.table == table && curve.key == key)?;
    // Viscous friction of the sliding axis damps the mode, too: sigma_2 c/(2 omega), c its participation in the shaft.
    let by_friction = if part == "damping" {
        let shaft_per_kg_m2 = structure.interpolate(&structure.modes[mode].encoder_per_kg_m2, elevation_rad);
        viscous[axis] * shaft_per_kg_m2 / (4.0 * PI * here(&mode))
    } else {
        0.0
    };
    let value_si = finding.value_of_frequency() * ratio - by_friction;
    let value = Value { value_si, u_si: (m.u * ratio).hypot(UNKNOWN_RATIO * by_friction), dof: m.dof };
    (value_si > 0.0).then(|| Point { curve, elevation_rad, value, evidence: finding.evidence() })
}

impl Finding<'_> {
    /// The value, or one more than it for the departure from a calculated frequency: what a frequency is proportional to.
    fn value_of_frequency(&self) -> f64 {
        if self.measurement.measurand.ends_with("-departure") { 1.0 + self.value } else { self.value }
    }
}

/// The frequency that was found; the departure from a calculation says it in a flag.
fn frequency_hz(finding: &Finding<'_>) -> Option<f64> {
    if finding.measurement.kind == QuantityKind::Frequency {
        return Some(finding.value);
    }
    QuantityKind::Frequency.parse(finding.flag("found at ")?).ok()
}

/// Of a flag such as `mode 2 at 17.83 Hz`.
fn rank_of_flag(finding: &Finding<'_>) -> Option<usize> {
    let number: usize = finding.flag("mode ")?.split(' ').next()?.parse().ok()?;
    number.checked_sub(1)
}

/// Scale at an elevation.
fn scale(scales: &[(f64, f64)], elevation_rad: f64) -> f64 {
    let after = scales.partition_point(|(at, _)| *at < elevation_rad);
    match (after.checked_sub(1).map(|k| scales[k]), scales.get(after)) {
        (Some((x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * (elevation_rad - x0) / (x1 - x0),
        (Some((_, y)), None) => y,
        (None, Some(&(_, y))) => y,
        (None, None) => 1.0,
    }
}

/// Mean by inverse variances, no better than the best of them: they share their method.
fn mean(same: &[Point], contradictions: &mut Vec<String>) -> (f64, Value) {
    let weight = |point: &Point| 1.0 / point.value.u_si.powi(2).max(f64::MIN_POSITIVE);
    let total: f64 = same.iter().map(weight).sum();
    let value_si = same.iter().map(|point| weight(point) * point.value.value_si).sum::<f64>() / total;
    let elevation_rad = same.iter().map(|point| weight(point) * point.elevation_rad).sum::<f64>() / total;
    let best = same.iter().min_by(|a, b| a.value.u_si.total_cmp(&b.value.u_si)).expect("at least one");
    for point in same {
        let apart_u = (point.value.value_si - value_si).abs() / point.value.u_si;
        if apart_u > CONTRADICTS_U {
            contradictions
                .push(format!("{}: {apart_u:.1} u from the mean at this elevation", point.evidence));
        }
    }
    (elevation_rad, Value { value_si, ..best.value })
}
