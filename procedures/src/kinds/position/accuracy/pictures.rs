//! The graph of ISO 230-2: deviations at the targets, means of both directions with two standard deviations, and A.

use analysis::positioning::{AtTarget, Direction, Positioning, Target};

use crate::case::Case;
use crate::quantity::QuantityKind as Q;
use crate::trace::{Note, Plot, Scale, Series, Style};

const URAD: f64 = 1e6;

/// One picture; `runs` are the single deviations of which `found` was made.
pub(super) fn picture(case: &Case, (id, title): (&str, &str), runs: &[Target], found: &Positioning) -> Plot {
    let mut series: Vec<Series> = Vec::new();
    for (label, upwards) in [("from below", true), ("from above", false)] {
        series.extend(direction(label, upwards, runs, found));
    }
    series.push(Series::new("mean of both", Style::Fit, degrees(found), over(found, |t| t.mean_rad)));
    series.extend(extent(found));
    let title = format!("{title}, {} (ISO 230-2): {}", case.axis, parameters(found));
    let plot = Plot::new(id, title, Scale::linear("target", "deg"), Scale::linear("deviation", "urad"));
    Plot { series, notes: widest(found).into_iter().collect(), ..plot }
}

fn degrees(found: &Positioning) -> Vec<f64> {
    found.targets.iter().map(|t| Q::Angle.to_display(t.target_rad)).collect()
}

fn over(found: &Positioning, value: impl Fn(&AtTarget) -> f64) -> Vec<f64> {
    found.targets.iter().map(|t| URAD * value(t)).collect()
}

/// Two standard deviations around the means of a direction, the means, and the single deviations.
fn direction(label: &str, upwards: bool, runs: &[Target], found: &Positioning) -> [Series; 3] {
    let direction = |t: &AtTarget| -> Direction { if upwards { t.up } else { t.down } };
    let mean = over(found, |t| direction(t).mean_rad);
    let spread = over(found, |t| 2.0 * direction(t).deviation_rad);
    let single = |t: &Target| -> Vec<(f64, f64)> {
        let all = if upwards { &t.up_rad } else { &t.down_rad };
        all.iter().map(|d| (Q::Angle.to_display(t.target_rad), URAD * d)).collect()
    };
    let (x, y) = runs.iter().flat_map(single).unzip();
    [
        Series::new(format!("{label}, mean ± 2 s"), Style::Band, degrees(found), mean.clone()).with_u(spread),
        Series::new(format!("{label}, mean"), Style::Line, degrees(found), mean),
        Series::new(format!("{label}, each run"), Style::Markers, x, y),
    ]
}

/// Both ends of the accuracy A: the largest mean + 2s and the smallest mean − 2s.
fn extent(found: &Positioning) -> [Series; 2] {
    let ways = || found.targets.iter().flat_map(|t| [t.up, t.down]);
    let high = ways().map(|d| d.mean_rad + 2.0 * d.deviation_rad).fold(f64::NEG_INFINITY, f64::max);
    let low = ways().map(|d| d.mean_rad - 2.0 * d.deviation_rad).fold(f64::INFINITY, f64::min);
    let x = degrees(found);
    let ends = [x.first().copied().unwrap_or(0.0), x.last().copied().unwrap_or(0.0)];
    [high, low].map(|at| {
        let label = format!("A = {:.1} µrad, from end to end", URAD * found.accuracy_rad);
        Series::new(label, Style::Fit, ends.into(), vec![URAD * at; 2])
    })
}

fn parameters(found: &Positioning) -> String {
    let all = [
        ("A", found.accuracy_rad),
        ("R", found.repeatability_rad),
        ("E", found.systematic_rad),
        ("M", found.mean_range_rad),
        ("B", found.reversal_rad),
    ];
    all.map(|(name, rad)| format!("{name} {:.1}", URAD * rad)).join(", ") + " µrad"
}

/// Names the target whose bidirectional repeatability is the axis' R.
fn widest(found: &Positioning) -> Option<Note> {
    let worst = found.targets.iter().max_by(|a, b| a.repeatability_rad.total_cmp(&b.repeatability_rad))?;
    let label = format!("R {:.1} µrad", URAD * worst.repeatability_rad);
    Some(Note { label, at: [Q::Angle.to_display(worst.target_rad), URAD * worst.mean_rad] })
}
