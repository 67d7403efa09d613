//! Analog against serial channel: level and phase up to a frequency, known delays taken off.

use std::f64::consts::TAU;

use analysis::frf::{C64, Line};

use super::Point;
use crate::case::{Case, MirrorChannel};
use crate::kinds::fsm_response::keys::Keys;
use crate::kinds::fsm_response::level::{Reading, decibel};
use crate::kinds::fsm_response::lines::{Judged, from_numbers};
use crate::kinds::fsm_response::measure::{complete, measurement};
use crate::kinds::fsm_response::record::GAUGE;
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;

pub(in crate::kinds::fsm_response) const LEVEL_DIFFERENCE: &str = "channel-level-difference";
pub(in crate::kinds::fsm_response) const PHASE_DIFFERENCE: &str = "channel-phase-difference";

/// Share of the lines up to the highest frequency that is compared that must count in both channels: a few that are left
/// say nothing of a response.
const LEAST_SHARE: f64 = 0.8;

/// Two lines at one frequency, as a ratio.
struct Pair {
    frequency_hz: f64,
    ratio: C64,
    relative_u: f64,
    dof: f64,
}

/// Largest differences of the two channels of one axis at one level; nothing where that level was not planned.
pub(super) fn difference(keys: &Keys, responses: &[Point<'_>], level_v: f64) -> Vec<Measurement> {
    let at = |channel: MirrorChannel| {
        let planned = |case: &Case| {
            case.mirror_channel == Some(channel)
                && case.requested("level").is_some_and(|level| crate::condition::same(level, level_v))
        };
        responses.iter().copied().find(|(case, _)| planned(case))
    };
    let (Some(analog), Some(serial)) = (at(MirrorChannel::Analog), at(MirrorChannel::Serial)) else {
        return Vec::new();
    };
    let pairs = pairs(keys, analog, serial);
    let worst = |size: &dyn Fn(&Pair) -> Reading| -> Result<Reading, String> {
        let all = pairs.as_ref().map_err(Clone::clone)?.iter().map(size);
        all.max_by(|a, b| a.value.total_cmp(&b.value)).ok_or_else(|| "no line counts in both".to_owned())
    };
    let n = pairs.as_ref().map_or(0, Vec::len);
    let level = worst(&|p| Reading {
        value: decibel(p.ratio.norm().ln()).abs(),
        u: decibel(p.relative_u),
        dof: p.dof,
        n,
    });
    let delays_u_s = keys.delays.u_s * std::f64::consts::SQRT_2;
    let phase = worst(&|p| {
        let of_delays = TAU * p.frequency_hz * delays_u_s;
        let u = p.relative_u.hypot(of_delays);
        // Welch–Satterthwaite: the delays are known, type B.
        let dof = p.dof * (u / p.relative_u.max(f64::MIN_POSITIVE)).powi(4);
        Reading { value: p.ratio.arg().abs(), u, dof, n }
    });
    [(LEVEL_DIFFERENCE, Q::Decibel, level), (PHASE_DIFFERENCE, Q::Angle, phase)]
        .into_iter()
        .map(|(measurand, kind, reading)| {
            let mut m = measurement(measurand, kind, analog.0, reading);
            complete(&mut m, keys, analog.0, &analog.1.numbers);
            m.point = None;
            m.flags.retain(|flag| !flag.ends_with(" channel"));
            m.flags.push(format!("up to {}", Q::Frequency.format(keys.delays.compared_to_hz)));
            m
        })
        .collect()
}

fn pairs(keys: &Keys, analog: Point<'_>, serial: Point<'_>) -> Result<Vec<Pair>, String> {
    let lines = |(case, result): Point<'_>| -> Result<Vec<Judged>, String> {
        if let Some(reason) = &result.inconclusive {
            return Err(format!("{}: {reason}", case.point));
        }
        let numbers = result.numbers.get(GAUGE);
        Ok(from_numbers(numbers.ok_or_else(|| format!("{}: no lines", case.point))?))
    };
    let (analog, serial) = (lines(analog)?, lines(serial)?);
    let inside = |l: &Judged| l.line.frequency_hz <= keys.delays.compared_to_hz * (1.0 + 1e-9);
    let shared = |(a, s): (&Judged, &Judged)| -> Option<Pair> {
        (a.counts() && s.counts() && inside(a)).then(|| pair(&a.line, &s.line))
    };
    let pairs: Vec<Pair> = analog.iter().zip(&serial).filter_map(shared).collect();
    let planned = analog.iter().filter(|l| inside(l)).count();
    covered(&pairs, planned, keys.delays.compared_to_hz).map(|()| pairs)
}

/// Whether enough is left to compare, up to the top; `planned` lines were excited there.
fn covered(pairs: &[Pair], planned: usize, compared_to_hz: f64) -> Result<(), String> {
    let to = Q::Frequency.format(compared_to_hz);
    if (pairs.len() as f64) < LEAST_SHARE * planned as f64 || pairs.is_empty() {
        let percent = 100.0 * LEAST_SHARE;
        return Err(format!(
            "{} of {planned} lines up to {to} count in both channels, at least {percent} % are needed",
            pairs.len()
        ));
    }
    // A third of an octave below: where a difference in delay shows most.
    let top_hz = compared_to_hz / 2.0_f64.cbrt();
    if pairs.iter().all(|p| p.frequency_hz < top_hz) {
        return Err(format!("no line between {top_hz:.1} Hz and {to} counts in both channels"));
    }
    Ok(())
}

fn pair(analog: &Line, serial: &Line) -> Pair {
    Pair {
        frequency_hz: analog.frequency_hz,
        ratio: serial.value / analog.value,
        relative_u: analog.relative_sd().hypot(serial.relative_sd()),
        // Each complex degree of freedom is two real ones.
        dof: 2.0 * analog.dof.min(serial.dof),
    }
}
