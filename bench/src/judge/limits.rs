//! Draws the limits of the requirements into the pictures of what they judge.

use procedures::condition::Meets;
use procedures::quantity::Limit;
use procedures::requirement::{Mask, Requirements, Where};
use procedures::trace::{LimitCurve, LimitLine, Plot, Side};

/// Adds a line for each bound of each requirement on the measurand that a picture shows, on this axis.
pub(super) fn draw(plots: &mut [Plot], axis: &str, requirements: &Requirements) {
    for plot in plots {
        let Some(measurand) = plot.limits_of.clone() else { continue };
        for requirement in &requirements.all {
            if requirement.axis.as_deref().is_none_or(|a| a == axis) {
                let Some(judged) = requirement.judged(&measurand) else { continue };
                if let Some(limit) = &judged.limit {
                    add(plot, &requirement.id, &requirement.conditions, limit);
                }
                for band in &judged.bands {
                    add(plot, &requirement.id, &band.conditions, &band.limit);
                }
                plot.masks.extend(judged.mask.as_ref().and_then(|mask| curve(plot, &requirement.id, mask)));
            }
        }
    }
}

fn add(plot: &mut Plot, id: &str, conditions: &[Where], limit: &Limit) {
    let stretch = stretch(plot, conditions);
    for bound in [limit.low, limit.high].into_iter().flatten() {
        let label = format!("{id} {}", limit.text);
        plot.limits.push(LimitLine { label, y: limit.kind.to_display(bound), x: stretch });
    }
}

/// A limit along the condition that a picture has as abscissa; one with two bounds shows the upper one.
fn curve(plot: &Plot, id: &str, mask: &Mask) -> Option<LimitCurve> {
    let of = procedures::condition::kind_of(&mask.condition).filter(|_| mask.condition == plot.x.label)?;
    let corner = |(x, limit): &(f64, Limit)| {
        let bound = limit.high.or(limit.low)?;
        Some([of.to_display(*x), limit.kind.to_display(bound)])
    };
    let above = mask.corners.iter().all(|(_, limit)| limit.high.is_some());
    Some(LimitCurve {
        label: format!("{id} {}", mask.text()),
        points: mask.corners.iter().map(corner).collect::<Option<_>>()?,
        forbidden: if above { Side::Above } else { Side::Below },
    })
}

/// Where a requirement holds only for a stretch of what the picture has as abscissa, e.g. velocity ≤ 10 deg/s.
fn stretch(plot: &Plot, conditions: &[Where]) -> Option<[f64; 2]> {
    let only = conditions.iter().find(|w| w.condition == plot.x.label)?;
    let xs = || plot.series.iter().flat_map(|s| s.x.iter().copied());
    let (least, most) = (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max));
    let Meets::Limit(limit) = &only.meets else { return None };
    let edge = |bound: Option<f64>, otherwise: f64| bound.map_or(otherwise, |b| limit.kind.to_display(b));
    Some([edge(limit.low, least), edge(limit.high, most)])
}
