//! Draws the limits of the requirements into the pictures of what they judge.

use procedures::condition::Meets;
use procedures::quantity::Limit;
use procedures::requirement::{Requirements, Where};
use procedures::trace::{LimitLine, Plot};

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

/// Where a requirement holds only for a stretch of what the picture has as abscissa, e.g. velocity ≤ 10 deg/s.
fn stretch(plot: &Plot, conditions: &[Where]) -> Option<[f64; 2]> {
    let only = conditions.iter().find(|w| w.condition == plot.x.label)?;
    let xs = || plot.series.iter().flat_map(|s| s.x.iter().copied());
    let (least, most) = (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max));
    let Meets::Limit(limit) = &only.meets else { return None };
    let edge = |bound: Option<f64>, otherwise: f64| bound.map_or(otherwise, |b| limit.kind.to_display(b));
    Some([edge(limit.low, least), edge(limit.high, most)])
}
