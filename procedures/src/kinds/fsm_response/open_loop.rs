//! The loop of the mirror's servo, opened by calculation: L = T/(1 − T) of the response behind its own gauge.

use std::f64::consts::TAU;

use analysis::frf::{C64, Line};
use analysis::margins::{MarginError, Margins, Settings, margins, open_loop_from_closed};

use super::keys::Keys;
use super::level::Reading;
use super::lines::Judged as Closed;
use super::measure::measurement;
use crate::case::Case;
use crate::kinds::frequency_response::{honest, pictures, velocity};
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;
use crate::trace::Plot;

pub(super) const NAMES: [&str; 4] =
    ["mirror-crossover", "mirror-gain-margin", "mirror-phase-margin", "mirror-modulus-margin"];
const KINDS: [Q; 4] = [Q::Frequency, Q::Decibel, Q::Angle, Q::Ratio];
/// P + I/s + I²/s² (director.md, 3).
const INTEGRATORS: u32 = 2;

/// Margins of the loop. The gauge is the sensor of the loop, so neither its scale nor its filter counts; the delay of the
/// command channel, which is not in the loop, does by its uncertainty.
pub(super) fn measurements(keys: &Keys, case: &Case, lines: &[Closed]) -> Vec<Measurement> {
    let found =
        open(lines, 0.0).and_then(|loop_| read(&loop_.lines).map(|margins| (loop_.lines.len(), margins)));
    let (n, margins) = match found {
        Ok(found) => found,
        Err(reason) => return none(case, &reason),
    };
    let late = open(lines, keys.delays.u_s).and_then(|loop_| read(&loop_.lines));
    let shifted = late.map(|margins| values(&margins)).unwrap_or_else(|_| NAMES.map(|_| Err(String::new())));
    let freedom = |l: &Closed| 2.0 * l.line.dof;
    let dof = lines.iter().filter(|l| l.counts()).map(freedom).fold(f64::INFINITY, f64::min);
    let one = |(k, found): (usize, Result<[f64; 2], String>)| {
        let reading = found.map(|[value, u]| {
            let of_delay = shifted[k].as_ref().map_or(0.0, |[shifted, _]| shifted - value);
            Reading { value, u: u.hypot(of_delay), dof, n }
        });
        let mut m = measurement(NAMES[k], KINDS[k], case, reading);
        m.estimator = "mirror-margins/1".to_owned();
        m.flags.extend(margins.doubts.iter().map(|doubt| format!("not certified: {doubt}")));
        m
    };
    values(&margins).into_iter().enumerate().map(one).collect()
}

/// The same without values.
pub(super) fn none(case: &Case, reason: &str) -> Vec<Measurement> {
    let none = |(name, kind): (&&str, Q)| measurement(name, kind, case, Err(reason.to_owned()));
    NAMES.iter().zip(KINDS).map(none).collect()
}

/// Bode and Nyquist of the open loop.
pub(super) fn plots(case: &Case, lines: &[Closed]) -> Vec<Plot> {
    let Ok(judged) = open(lines, 0.0) else { return Vec::new() };
    let slug: String = case.point.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let title = |what: &str| format!("{what}, {}", case.point);
    let mut plots =
        pictures::bode(&format!("mirror-loop-{slug}"), &title("Open loop of the mirror"), "1", &judged);
    if let Ok(found) = read(&judged.lines) {
        let id = format!("mirror-nyquist-{slug}");
        plots.push(pictures::nyquist(&id, &title("Nyquist of the mirror"), &judged, &found));
    }
    plots
}

/// Lines of the open loop; those of a command channel that is later by so much than was taken off.
fn open(lines: &[Closed], later_s: f64) -> Result<honest::Judged, String> {
    let turned = |l: &Closed| {
        let turn = C64::from_polar(1.0, TAU * l.line.frequency_hz * later_s);
        Line { value: l.line.value * turn, ..l.line }
    };
    let counting: Vec<Line> = lines.iter().filter(|l| l.counts()).map(turned).collect();
    Ok(honest::judge_noise(open_loop_from_closed(&counting).map_err(|e| e.to_string())?))
}

fn read(lines: &[Line]) -> Result<Margins, String> {
    let settings = Settings { integrators_count: INTEGRATORS, ..Settings::default() };
    margins(lines, &settings).map_err(|e| e.to_string())
}

/// Values with their standard uncertainties, as [`NAMES`].
fn values(found: &Margins) -> [Result<[f64; 2], String>; 4] {
    let [crossover, gain, phase, _, modulus, _] = velocity::readings(found);
    [crossover, gain, phase, modulus].map(|(_, reading)| match reading {
        Ok([_, value, u]) => Ok([value, u]),
        Err(none) => Err(MarginError::from(none).to_string()),
    })
}

#[cfg(test)]
mod tests;
