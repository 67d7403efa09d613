//! Measurements that rest on one response.

use std::collections::BTreeMap;

use analysis::estimate::Estimate;

use super::conclude::harmonics;
use super::keys::Keys;
use super::level::{Reading, bandwidth_hz, gain_at};
use super::lines::{Judged, from_numbers};
use super::open_loop;
use super::plan::{MEASURE, mirror_axis, word};
use super::record::{GAUGE, LEVEL, REACTION, REFERENCE, SPAN};
use crate::case::Case;
use crate::kinds::frames::MIRROR_AXES;
use crate::measurement::{Condition, Evidence, Measurement};
use crate::quantity::QuantityKind as Q;

pub(super) const BANDWIDTH: &str = "mirror-bandwidth";
pub(super) const ATTENUATION: &str = "mirror-attenuation-100-hz";
pub(super) const RESONANCE: &str = "reaction-resonance";
/// Estimator of numbers from responses.
pub(super) const ESTIMATOR: &str = "mirror-response/1";

/// Where attenuation is asked for.
const ATTENUATION_HZ: f64 = 100.0;

/// Axis of the mirror that a case is about, for measurements.
pub(super) fn axis_of(case: &Case) -> &'static str {
    mirror_axis(case).map_or("", |axis| MIRROR_AXES[axis])
}

fn is_response(case: &Case) -> bool {
    case.segments.iter().any(|s| s.label == MEASURE)
}

/// All measurements that rest on one point alone.
pub(super) fn of_point(keys: &Keys, case: &Case, numbers: &BTreeMap<String, Vec<f64>>) -> Vec<Measurement> {
    if !is_response(case) {
        return harmonics::of_point(keys, case, numbers);
    }
    let Sensor { lines, scale_u_ratio, flags } = Sensor::of(keys, numbers);
    let attenuation =
        gain_at(&lines, ATTENUATION_HZ, scale_u_ratio).map(|r| Reading { value: -r.value, ..r });
    let mut all = vec![
        measurement(BANDWIDTH, Q::Frequency, case, bandwidth_hz(&lines, scale_u_ratio)),
        measurement(ATTENUATION, Q::Decibel, case, attenuation),
        resonance(case, numbers),
    ];
    // The servo closes its loop by the gauge, whatever else sees the mirror.
    all.extend(open_loop::measurements(keys, case, &stored(numbers, GAUGE)));
    for m in &mut all {
        complete(m, keys, case, numbers);
        if [BANDWIDTH, ATTENUATION].contains(&m.measurand.as_str()) {
            m.flags.extend(flags.iter().map(|flag| (*flag).to_owned()));
        }
    }
    all
}

/// What the tilt of the mirror is read from.
struct Sensor {
    lines: Vec<Judged>,
    /// Standard uncertainty of its scale, where that is known.
    scale_u_ratio: f64,
    flags: Vec<&'static str>,
}

impl Sensor {
    /// The autocollimator, which sees the mirror itself, and else the gauge, which the servo follows: a wrong scale of that
    /// is in its response and does not show there.
    fn of(keys: &Keys, numbers: &BTreeMap<String, Vec<f64>>) -> Self {
        if numbers.contains_key(REFERENCE) {
            let flags = vec!["by the autocollimator"];
            return Self { lines: stored(numbers, REFERENCE), scale_u_ratio: keys.reference_u_ratio, flags };
        }
        let unknown = keys.gauge_u_ratio.is_none().then_some("scale of the gauge not in u");
        Self {
            lines: stored(numbers, GAUGE),
            scale_u_ratio: keys.gauge_u_ratio.unwrap_or(0.0),
            flags: std::iter::once("by the strain gauge").chain(unknown).collect(),
        }
    }
}

fn stored(numbers: &BTreeMap<String, Vec<f64>>, sensor: &str) -> Vec<Judged> {
    from_numbers(numbers.get(sensor).map_or(&[], Vec::as_slice))
}

/// The same without values.
pub(super) fn none_of_point(case: &Case, reason: &str) -> Vec<Measurement> {
    if !is_response(case) {
        return Vec::new();
    }
    let none = |measurand, kind| measurement(measurand, kind, case, Err(reason.to_owned()));
    let mut all =
        vec![none(BANDWIDTH, Q::Frequency), none(ATTENUATION, Q::Decibel), none(RESONANCE, Q::Frequency)];
    all.extend(open_loop::none(case, reason));
    all
}

fn resonance(case: &Case, numbers: &BTreeMap<String, Vec<f64>>) -> Measurement {
    let Some(&[value, u, damping_ratio, size_db]) = numbers.get(REACTION).map(Vec::as_slice) else {
        let none = Err("none visible: the response is smooth where a support was looked for".to_owned());
        return measurement(RESONANCE, Q::Frequency, case, none);
    };
    let mut m =
        measurement(RESONANCE, Q::Frequency, case, Ok(Reading { value, u, dof: f64::INFINITY, n: 1 }));
    m.flags.push(format!("bends the response by {size_db:.2} dB"));
    m.flags.push(format!("damping ratio about {damping_ratio}"));
    m
}

/// A measurement of the mirror axis at this point.
pub(super) fn measurement(
    measurand: &str,
    kind: Q,
    case: &Case,
    reading: Result<Reading, String>,
) -> Measurement {
    let axis = axis_of(case);
    let mut m = match reading {
        Ok(Reading { value, u, dof, n }) => {
            Measurement::new(measurand, axis, kind, Some(Estimate { value, u, dof, n }), ESTIMATOR)
        }
        Err(reason) => Measurement::inconclusive(measurand, axis, kind, ESTIMATOR, reason),
    };
    m.point = Some(case.point.clone());
    m
}

/// Conditions, flags and evidence of a point.
pub(super) fn complete(m: &mut Measurement, keys: &Keys, case: &Case, numbers: &BTreeMap<String, Vec<f64>>) {
    if let Some(requested) = case.requested("level") {
        let achieved = numbers.get(LEVEL).and_then(|l| l.first()).copied();
        m.conditions.push(Condition { name: "level".to_owned(), requested, achieved, kind: Q::Voltage });
    }
    if let Some(channel) = case.mirror_channel {
        m.flags.push(format!("{} channel", word(channel)));
    }
    m.flags.push(format!("on the {}", keys.place));
    m.evidence.extend(evidence(case, numbers));
}

/// Where in the log a point's numbers come from.
pub(super) fn evidence(case: &Case, numbers: &BTreeMap<String, Vec<f64>>) -> Option<Evidence> {
    let &[t0_s, t1_s] = numbers.get(SPAN)?.as_slice() else { return None };
    let axis = axis_of(case);
    let reference = numbers.contains_key(REFERENCE).then_some("reference");
    let parts = ["command", "angle"].into_iter().chain(reference);
    let channels = parts.map(|part| format!("/fsm {part}_{axis}_rad")).collect();
    Some(Evidence { file: String::new(), channels, t0_s, t1_s })
}
