//! What a point hands to `conclude`: packed into plain numbers, so that points can be kept and merged.

use std::collections::BTreeMap;

use analysis::cogging::{Amplitude, Harmonic};
use analysis::gravity::HalfSum;

use super::measurands::{FRICTION, FRICTION_CURRENT};
use super::point::{Finding, own_spread};
use super::record::Record;
use crate::measurement::{Condition, Evidence, PointResult};
use crate::quantity::QuantityKind as Q;

type Numbers = BTreeMap<String, Vec<f64>>;

const SHARED: &str = "torque-constant-u";
const OWN: &str = "own-spread";
const QUANTUM: &str = "quantum-u";
const ONE_SIDED: &str = "one-sided";
const OFFSET: &str = "offset";
const ANGLE: &str = "half-sum-angle";
const COSINE: &str = "half-sum-cosine";
const TORQUE: &str = "half-sum-torque";
const LINE_ORDER: &str = "line-order";
const LINE_AMPLITUDE: &str = "line-amplitude";
const HARMONICS: &str = "harmonics";
const MAP: &str = "map";
/// Numbers of an amplitude: amplitude, phase, u, degrees of freedom (negative: infinite).
const OF_AMPLITUDE: usize = 4;
/// Numbers of a harmonic: three orders and three amplitudes.
const OF_HARMONIC: usize = 3 + 3 * OF_AMPLITUDE;

/// Cogging of a point.
pub(super) struct Cogging {
    pub(super) line_order: Vec<f64>,
    pub(super) line_amplitude: Vec<f64>,
    pub(super) harmonics: Vec<Harmonic>,
    pub(super) static_map: bool,
    pub(super) gain_error_ratio: f64,
    pub(super) points_count: usize,
}

/// A point whose friction stands, as `conclude` sees it.
pub(super) struct Valid<'a> {
    pub(super) name: &'a str,
    pub(super) kind: Q,
    pub(super) velocity_rad_per_s: Option<f64>,
    /// `None` where only one direction was recorded.
    pub(super) friction: Option<f64>,
    /// Spread without what all points share.
    pub(super) own_u: f64,
    pub(super) scale_u_ratio: f64,
    /// What the drive's quantum leaves in a mean.
    pub(super) quantum_u: f64,
    pub(super) conditions: &'a [Condition],
    pub(super) evidence: &'a [Evidence],
    numbers: &'a Numbers,
}

/// Packs a finding.
pub(super) fn pack(numbers: &mut Numbers, record: &Record<'_>, finding: &Finding) {
    let mut put = |key: &str, values: Vec<f64>| {
        numbers.insert(key.to_owned(), values);
    };
    put(SHARED, vec![record.scale_u_ratio]);
    put(QUANTUM, vec![finding.quantum_u]);
    if let Some(estimate) = &finding.friction {
        put(OWN, vec![own_spread(finding, estimate).u]);
    }
    if finding.one_sided {
        put(ONE_SIDED, vec![1.0]);
    }
    if let Some(offset) = finding.offset {
        put(OFFSET, vec![offset]);
    }
    put(ANGLE, finding.half_sum.angle_rad.clone());
    put(COSINE, finding.half_sum.cosine_ratio.clone());
    put(TORQUE, finding.half_sum.torque_nm.clone());
    if let Some(spectrum) = &finding.spectrum {
        put(LINE_ORDER, spectrum.order_per_rev.clone());
        put(LINE_AMPLITUDE, spectrum.amplitude.clone());
        put(HARMONICS, spectrum.harmonics.iter().flat_map(flat).collect());
        let points = finding.forward[0].len() + finding.reverse[0].len();
        put(MAP, vec![f64::from(u8::from(finding.static_map)), finding.gain_error_ratio, points as f64]);
    }
}

fn flat(harmonic: &Harmonic) -> Vec<f64> {
    let amplitude =
        |a: &Amplitude| [a.amplitude, a.phase_rad, a.u, if a.dof.is_finite() { a.dof } else { -1.0 }];
    let side = |a: &Option<Amplitude>| a.as_ref().map_or([-1.0; OF_AMPLITUDE], amplitude);
    let mut all = vec![harmonic.order_per_rev, harmonic.order_u_per_rev, harmonic.at_order_per_rev];
    all.extend(amplitude(&harmonic.mean));
    all.extend(side(&harmonic.forward));
    all.extend(side(&harmonic.reverse));
    all
}

fn harmonic(numbers: &[f64]) -> Harmonic {
    let amplitude = |at: usize| Amplitude {
        amplitude: numbers[at],
        phase_rad: numbers[at + 1],
        u: numbers[at + 2],
        dof: if numbers[at + 3] < 0.0 { f64::INFINITY } else { numbers[at + 3] },
    };
    let side = |at: usize| (numbers[at] >= 0.0).then(|| amplitude(at));
    Harmonic {
        order_per_rev: numbers[0],
        order_u_per_rev: numbers[1],
        at_order_per_rev: numbers[2],
        mean: amplitude(3),
        forward: side(3 + OF_AMPLITUDE),
        reverse: side(3 + 2 * OF_AMPLITUDE),
    }
}

impl<'a> Valid<'a> {
    /// The point, if it stands: its friction is conclusive, or only one direction was recorded.
    pub(super) fn of(point: &'a PointResult) -> Option<Self> {
        let friction = point
            .measurements
            .iter()
            .find(|m| [FRICTION, FRICTION_CURRENT].contains(&m.measurand.as_str()))?;
        let one_sided = point.numbers.contains_key(ONE_SIDED);
        if point.inconclusive.is_some() || (friction.inconclusive.is_some() && !one_sided) {
            return None;
        }
        let first = |key: &str| point.numbers.get(key).and_then(|v| v.first()).copied();
        let velocity = friction.conditions.iter().find(|c| c.name == "velocity").and_then(|c| c.achieved);
        Some(Self {
            name: &point.point,
            kind: friction.kind,
            velocity_rad_per_s: velocity,
            friction: friction.value,
            own_u: first(OWN).unwrap_or(0.0),
            scale_u_ratio: first(SHARED)?,
            quantum_u: first(QUANTUM)?,
            conditions: &friction.conditions,
            evidence: &friction.evidence,
            numbers: &point.numbers,
        })
    }

    fn numbers(&self, key: &str) -> &'a [f64] {
        self.numbers.get(key).map_or(&[], Vec::as_slice)
    }

    /// Half-sum of both directions by cogging period.
    pub(super) fn half_sum(&self) -> HalfSum {
        HalfSum {
            angle_rad: self.numbers(ANGLE).to_vec(),
            cosine_ratio: self.numbers(COSINE).to_vec(),
            torque_nm: self.numbers(TORQUE).to_vec(),
        }
    }

    /// Half the sum of the means of both directions, of a static map.
    pub(super) fn offset(&self) -> Option<f64> {
        self.numbers(OFFSET).first().copied()
    }

    /// Whether the point has a spectrum.
    pub(super) fn has_cogging(&self) -> bool {
        self.numbers.contains_key(HARMONICS)
    }

    /// Its cogging.
    pub(super) fn cogging(&self) -> Option<Cogging> {
        let &[static_map, gain_error_ratio, points] = self.numbers(MAP) else { return None };
        Some(Cogging {
            line_order: self.numbers(LINE_ORDER).to_vec(),
            line_amplitude: self.numbers(LINE_AMPLITUDE).to_vec(),
            harmonics: self.numbers(HARMONICS).chunks_exact(OF_HARMONIC).map(harmonic).collect(),
            static_map: static_map > 0.5,
            gain_error_ratio,
            points_count: points as usize,
        })
    }

    /// The requested value of a condition.
    pub(super) fn requested(&self, name: &str) -> Option<f64> {
        self.conditions.iter().find(|c| c.name == name).map(|c| c.requested)
    }
}
