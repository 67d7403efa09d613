//! An imported point: segments `forward` and `reverse`, each one branch of effort over angle.
//!
//! All rows of a static map count; time and velocity mean nothing there, so there is no inertia to take off. Angles may be unevenly
//! spaced.

use std::f64::consts::TAU;
use std::ops::Range;

use analysis::cogging::{Branch, Settings, Spectrum};
use analysis::estimate::Estimate;
use analysis::uncertainty::{Component, combine};

use super::point::{EffortCurve, Finding, Record};
use super::{cogging, strokes};
use crate::axis::AxisLimits;
use crate::case::Case;
use crate::log::Window;
use crate::reason::{FrictionReason, Reason};

/// Label of a branch with rising angle.
const FORWARD: &str = "forward";
/// Label of a branch with falling angle.
const REVERSE: &str = "reverse";
/// Least points of a branch.
const LEAST_POINTS: usize = 16;

/// Everything that the branches of a static map say.
pub(super) fn find(case: &Case, window: &Window, record: &Record<'_>, limits: &AxisLimits) -> Finding {
    let mut finding = Finding { static_map: true, ..Finding::default() };
    let mut branches = Vec::new();
    for span in &window.segments {
        let label = case.segments.get(span.segment).map_or("", |s| s.label.as_str());
        if label != FORWARD && label != REVERSE {
            continue;
        }
        let rows = record.range(span.start_s, span.end_s);
        finding.evidence.extend(record.evidence(&rows));
        finding.quantum_u = finding.quantum_u.max(record.quantum_u(rows.clone()));
        if rows.len() >= LEAST_POINTS {
            branches.push(branch(label == REVERSE, rows, record));
        }
    }
    if branches.is_empty() {
        finding.trouble =
            Some(FrictionReason::NoBranch { forward: FORWARD, reverse: REVERSE, least: LEAST_POINTS }.into());
        return finding;
    }
    finding.achieved_rad_per_s = case.requested("velocity");
    let outcome = if branches.iter().all(full_turn) {
        on_full_turn(&branches, limits, &mut finding)
    } else {
        on_part_turn(&branches, limits, &mut finding)
    };
    finding.trouble = outcome.err();
    finding
}

/// Rows by rising angle.
fn branch(reverse: bool, rows: Range<usize>, record: &Record<'_>) -> Branch {
    let motor = record.motor(rows.clone());
    let mut points: Vec<(f64, f64)> = record.angle_rad[rows].iter().copied().zip(motor).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (angle_rad, value): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
    let mut branch = Branch { reverse, weight: vec![1.0; value.len()], angle_rad, value };
    branch.weight = weights(&branch.angle_rad, full_turn(&branch));
    branch
}

/// Whether the branch closes on itself: its span and one spacing make a turn.
fn full_turn(branch: &Branch) -> bool {
    let [first, .., last] = branch.angle_rad[..] else { return false };
    let spacing = (last - first) / (branch.angle_rad.len() - 1) as f64;
    (last - first + spacing - TAU).abs() < 0.5 * spacing
}

/// Half the way to both neighbours, around the turn where it closes.
fn weights(angle: &[f64], closed: bool) -> Vec<f64> {
    let n = angle.len();
    (0..n)
        .map(|k| {
            let before = if k > 0 {
                angle[k - 1]
            } else if closed {
                angle[n - 1] - TAU
            } else {
                angle[0]
            };
            let after = if k + 1 < n {
                angle[k + 1]
            } else if closed {
                angle[0] + TAU
            } else {
                angle[n - 1]
            };
            (after - before) / 2.0
        })
        .collect()
}

fn on_full_turn(branches: &[Branch], limits: &AxisLimits, finding: &mut Finding) -> Result<(), Reason> {
    let settings = Settings {
        span_rad: TAU,
        full_turn: true,
        most_order_per_rev: cogging::most_order(limits),
        bin_width_rad: 0.0,
    };
    let spectrum = Spectrum::new(branches, &settings).ok_or(FrictionReason::TooFewPoints)?;
    let orders: Vec<f64> = spectrum.harmonics.iter().map(|h| h.at_order_per_rev).collect();
    finding.spectrum = Some(spectrum);
    finding.flags.push("static map; full turn".to_owned());
    let side = |reverse: bool| branches.iter().filter(move |b| b.reverse == reverse);
    let curve = |reverse: bool| {
        let first = side(reverse).next();
        first.map_or_else(EffortCurve::default, |b| EffortCurve {
            angle_rad: b.angle_rad.clone(),
            effort: b.value.clone(),
        })
    };
    finding.forward = curve(false);
    finding.reverse = curve(true);
    let mean = |reverse: bool| mean_over_turn(&side(reverse).collect::<Vec<_>>(), &orders);
    let (Some(forward), Some(reverse)) = (mean(false), mean(true)) else {
        finding.one_sided = true;
        return Err(FrictionReason::OneDirection.into());
    };
    let spread = combine(&[forward.spread, reverse.spread]);
    finding.friction = Some(Estimate {
        value: (forward.effort - reverse.effort) / 2.0,
        u: spread.u / 2.0,
        dof: spread.dof,
        n: branches.iter().map(|b| b.value.len()).sum(),
    });
    finding.offset = Some((forward.effort + reverse.effort) / 2.0);
    Ok(())
}

/// Mean effort of one direction.
struct MeanEffort {
    effort: f64,
    spread: Component,
}

/// Mean over all branches of one direction, freed of the harmonics at these orders; `None` without branches.
fn mean_over_turn(branches: &[&Branch], orders: &[f64]) -> Option<MeanEffort> {
    let each: Vec<(f64, Component)> =
        branches.iter().map(|b| b.mean_over_turn(orders)).collect::<Option<_>>()?;
    let count = each.len() as f64;
    if each.is_empty() {
        return None;
    }
    let spread = combine(&each.iter().map(|(_, c)| *c).collect::<Vec<_>>());
    let effort = each.iter().map(|(m, _)| m).sum::<f64>() / count;
    Some(MeanEffort { effort, spread: Component { u: spread.u / count, dof: spread.dof } })
}

fn on_part_turn(branches: &[Branch], limits: &AxisLimits, finding: &mut Finding) -> Result<(), Reason> {
    finding.flags.push("static map; part of a turn".to_owned());
    strokes::evaluate_branches(branches, limits, finding)
}
