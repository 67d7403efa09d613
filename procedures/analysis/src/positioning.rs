//! Accuracy and repeatability of positioning an axis, after ISO 230-2:2014.

use crate::estimate::Estimate;
use crate::uncertainty::{Component, combine};

mod pose;
mod spread;
#[cfg(test)]
mod tests;

pub use pose::{POSE_CYCLES, Pose, pose};
pub use spread::{Direction, deviation};

/// Runs in each direction that the standard asks for: a standard deviation of fewer says nothing.
pub const LEAST_RUNS: usize = 5;

/// Deviations at one target, actual place less target. One value a run; rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Target {
    /// Where the axis was sent.
    pub target_rad: f64,
    /// Deviations of runs that came from below.
    pub up_rad: Vec<f64>,
    /// Deviations of runs that came from above.
    pub down_rad: Vec<f64>,
}

/// What the runs at one target come to; rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtTarget {
    /// Where the axis was sent.
    pub target_rad: f64,
    /// From below.
    pub up: Direction,
    /// From above.
    pub down: Direction,
    /// Bidirectional mean, (x̄↑ + x̄↓)/2.
    pub mean_rad: f64,
    /// Reversal value B = x̄↑ − x̄↓.
    pub reversal_rad: f64,
    /// Bidirectional repeatability R = max(2s↑ + 2s↓ + |B|, 4s↑, 4s↓).
    pub repeatability_rad: f64,
}

/// Parameters of an axis (ISO 230-2:2014); rad.
#[derive(Clone, Debug, PartialEq)]
pub struct Positioning {
    /// Targets in ascending order.
    pub targets: Vec<AtTarget>,
    /// Reversal value B of the axis: the largest |B| of its targets.
    pub reversal_rad: f64,
    /// Mean of the reversal values, signed.
    pub mean_reversal_rad: f64,
    /// Unidirectional repeatability, up and down: the largest 4s.
    pub one_way_repeatability_rad: [f64; 2],
    /// Bidirectional repeatability R: the largest of the targets.
    pub repeatability_rad: f64,
    /// Unidirectional systematic deviation, up and down: the range of the means.
    pub one_way_systematic_rad: [f64; 2],
    /// Bidirectional systematic deviation E: the range of all means of both directions.
    pub systematic_rad: f64,
    /// Mean bidirectional deviation M: the range of the bidirectional means.
    pub mean_range_rad: f64,
    /// Unidirectional accuracy, up and down.
    pub one_way_accuracy_rad: [f64; 2],
    /// Bidirectional accuracy A = max(x̄ + 2s) − min(x̄ − 2s) over targets and directions.
    pub accuracy_rad: f64,
}

/// Why a record gives no parameters.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PositioningError {
    /// Too few runs in a direction.
    #[error(
        "{found} runs {way} at target {target_deg} deg, at least {LEAST_RUNS} are needed: run more cycles"
    )]
    FewRuns {
        /// Target.
        target_deg: f64,
        /// Direction or kind of run, in words.
        way: &'static str,
        /// How many there are.
        found: usize,
    },
    /// Too few targets for the travel that they span.
    #[error("{found} targets over {span_deg:.1} deg, at least {needed} are needed: add targets")]
    FewTargets {
        /// How many there are.
        found: usize,
        /// Angle from the first to the last.
        span_deg: f64,
        /// How many the standard asks for.
        needed: usize,
    },
    /// Targets that do not ascend.
    #[error("the target {target_deg} deg is not above the one before it: sort the targets")]
    NotAscending {
        /// The target.
        target_deg: f64,
    },
    /// A deviation that is no number.
    #[error("a deviation at target {target_deg} deg is not a number: look for gaps in the record")]
    NotANumber {
        /// The target.
        target_deg: f64,
    },
}

/// Targets that a rotary axis needs over a travel (ISO 230-2:2014, rotary axes up to 360°): 3 up to 90°, 5 up to 180°,
/// 8 beyond.
pub fn targets_needed(span_rad: f64) -> usize {
    // A span of 90° went through unit conversion.
    let span_deg = span_rad.to_degrees() * (1.0 - 1e-9);
    match span_deg {
        s if s <= 90.0 => 3,
        s if s <= 180.0 => 5,
        _ => 8,
    }
}

/// The parameters of an axis from its runs.
///
/// # Errors
/// Fewer than [`LEAST_RUNS`] runs in a direction, fewer targets than [`targets_needed`], targets that do not ascend,
/// values that are no numbers.
pub fn positioning(targets: &[Target]) -> Result<Positioning, PositioningError> {
    let all = targets.iter().map(at_target).collect::<Result<Vec<_>, _>>()?;
    for pair in targets.windows(2) {
        if pair[1].target_rad <= pair[0].target_rad || !pair[1].target_rad.is_finite() {
            return Err(PositioningError::NotAscending { target_deg: pair[1].target_rad.to_degrees() });
        }
    }
    let span_rad = match targets {
        [first, .., last] => last.target_rad - first.target_rad,
        _ => 0.0,
    };
    let needed = targets_needed(span_rad);
    if all.len() < needed {
        let span_deg = span_rad.to_degrees();
        return Err(PositioningError::FewTargets { found: all.len(), span_deg, needed });
    }
    Ok(of_targets(all))
}

fn at_target(target: &Target) -> Result<AtTarget, PositioningError> {
    let target_deg = target.target_rad.to_degrees();
    for (way, runs) in [("upwards", &target.up_rad), ("downwards", &target.down_rad)] {
        if runs.len() < LEAST_RUNS {
            return Err(PositioningError::FewRuns { target_deg, way, found: runs.len() });
        }
        if runs.iter().any(|x| !x.is_finite()) {
            return Err(PositioningError::NotANumber { target_deg });
        }
    }
    let up = Direction::of(&target.up_rad);
    let down = Direction::of(&target.down_rad);
    let reversal_rad = up.mean_rad - down.mean_rad;
    let both = 2.0 * up.deviation_rad + 2.0 * down.deviation_rad + reversal_rad.abs();
    Ok(AtTarget {
        target_rad: target.target_rad,
        up,
        down,
        mean_rad: 0.5 * (up.mean_rad + down.mean_rad),
        reversal_rad,
        repeatability_rad: both.max(up.repeatability_rad()).max(down.repeatability_rad()),
    })
}

fn of_targets(targets: Vec<AtTarget>) -> Positioning {
    let over = |f: &dyn Fn(&AtTarget) -> f64| targets.iter().map(f).collect::<Vec<_>>();
    let directions = [over(&|t| t.up.mean_rad), over(&|t| t.down.mean_rad)];
    let highs = [over(&|t| t.up.high_rad()), over(&|t| t.down.high_rad())];
    let lows = [over(&|t| t.up.low_rad()), over(&|t| t.down.low_rad())];
    let repeats = [over(&|t| t.up.repeatability_rad()), over(&|t| t.down.repeatability_rad())];
    let reversals = over(&|t| t.reversal_rad);
    let one_way_accuracy_rad = [0, 1].map(|way| most(&highs[way]) - least(&lows[way]));
    Positioning {
        reversal_rad: most(&over(&|t| t.reversal_rad.abs())),
        mean_reversal_rad: reversals.iter().sum::<f64>() / reversals.len() as f64,
        one_way_repeatability_rad: repeats.map(|r| most(&r)),
        repeatability_rad: most(&over(&|t| t.repeatability_rad)),
        one_way_systematic_rad: [0, 1].map(|way| most(&directions[way]) - least(&directions[way])),
        systematic_rad: most(&directions.concat()) - least(&directions.concat()),
        mean_range_rad: most(&over(&|t| t.mean_rad)) - least(&over(&|t| t.mean_rad)),
        one_way_accuracy_rad,
        accuracy_rad: most(&highs.concat()) - least(&lows.concat()),
        targets,
    }
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

impl Positioning {
    /// Accuracy A with its uncertainty: at both of its ends the scatter of a mean and of twice a standard deviation of n
    /// runs, s·√(1/n + 2/(n − 1)), and what the instrument leaves uncertain of a place.
    ///
    /// `instrument_u_rad`: standard uncertainty of the instrument at one target, independent from target to target.
    pub fn accuracy(&self, instrument_u_rad: f64) -> Estimate {
        let ways = || self.targets.iter().flat_map(|t| [&t.up, &t.down]);
        let high = ways().max_by(|a, b| a.high_rad().total_cmp(&b.high_rad()));
        let low = ways().min_by(|a, b| a.low_rad().total_cmp(&b.low_rad()));
        let ends = [high, low].into_iter().flatten();
        let mut parts = vec![Component::known(instrument_u_rad); 2];
        parts.extend(ends.map(|end| {
            let n = end.runs as f64;
            Component { u: end.deviation_rad * (1.0 / n + 2.0 / (n - 1.0)).sqrt(), dof: n - 1.0 }
        }));
        self.estimate(self.accuracy_rad, combine(&parts))
    }

    /// Repeatability R with its uncertainty: that of the standard deviations it consists of (of n runs: s/√(2(n − 1))), of
    /// the reversal value, and of the instrument from run to run at one place.
    pub fn repeatability(&self, instrument_u_rad: f64) -> Estimate {
        let worst = self.targets.iter().max_by(|a, b| a.repeatability_rad.total_cmp(&b.repeatability_rad));
        let Some(worst) = worst else { return self.estimate(self.repeatability_rad, Component::known(0.0)) };
        let spread = |d: &Direction, factor: f64| {
            let n = d.runs as f64;
            Component { u: factor * d.deviation_rad / (2.0 * (n - 1.0)).sqrt(), dof: n - 1.0 }
        };
        let mut parts = vec![Component::known(instrument_u_rad)];
        let one_way =
            [worst.up, worst.down].into_iter().find(|d| d.repeatability_rad() >= worst.repeatability_rad);
        match one_way {
            Some(direction) => parts.push(spread(&direction, 4.0)),
            None => {
                for direction in [&worst.up, &worst.down] {
                    let n = direction.runs as f64;
                    parts.push(spread(direction, 2.0));
                    parts.push(Component { u: direction.deviation_rad / n.sqrt(), dof: n - 1.0 });
                }
            }
        }
        self.estimate(self.repeatability_rad, combine(&parts))
    }

    /// Range of the means E with its uncertainty: two means and two places of the instrument.
    pub fn systematic(&self, instrument_u_rad: f64) -> Estimate {
        let ways = || self.targets.iter().flat_map(|t| [&t.up, &t.down]);
        // Of equal means the one that scatters more counts.
        let spread = |a: &Direction, b: &Direction| a.deviation_rad.total_cmp(&b.deviation_rad);
        let high = ways().max_by(|a, b| a.mean_rad.total_cmp(&b.mean_rad).then(spread(a, b)));
        let low = ways().min_by(|a, b| a.mean_rad.total_cmp(&b.mean_rad).then(spread(b, a)));
        let mut parts = vec![Component::known(instrument_u_rad); 2];
        parts.extend([high, low].into_iter().flatten().map(|end| {
            let n = end.runs as f64;
            Component { u: end.deviation_rad / n.sqrt(), dof: n - 1.0 }
        }));
        self.estimate(self.systematic_rad, combine(&parts))
    }

    fn estimate(&self, value: f64, spread: Component) -> Estimate {
        let n = self.targets.iter().map(|t| t.up.runs + t.down.runs).sum();
        Estimate { value, u: spread.u, dof: spread.dof, n }
    }
}
