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
    let signs: &[f64] = if plot.limits_of_magnitude { &[1.0, -1.0] } else { &[1.0] };
    for bound in [limit.low, limit.high].into_iter().flatten() {
        let shown = in_unit(limit, bound, &plot.y.unit);
        for y in signs.iter().map(|sign| sign * shown) {
            match plot
                .limits
                .iter_mut()
                .find(|l| l.y == y && l.x == stretch && l.label.ends_with(&limit.text))
            {
                Some(same) => same.label = format!("{id}, {}", same.label),
                None => plot.limits.push(LimitLine { label: format!("{id} {}", limit.text), y, x: stretch }),
            }
        }
    }
}

/// A bound in the unit of the picture's ordinate, or in that of its kind where this is no unit of it.
fn in_unit(limit: &Limit, bound: f64, unit: &str) -> f64 {
    match limit.kind.parse(&format!("1 {unit}")) {
        Ok(one) if one > 0.0 && unit != limit.kind.display_unit() => bound / one,
        _ => limit.kind.to_display(bound),
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
    let least = xs().fold(f64::INFINITY, f64::min);
    let most = xs().fold(f64::NEG_INFINITY, f64::max);
    let Meets::Limit(limit) = &only.meets else { return None };
    let edge = |bound: Option<f64>, otherwise: f64| bound.map_or(otherwise, |b| limit.kind.to_display(b));
    Some([edge(limit.low, least), edge(limit.high, most)])
}

#[cfg(test)]
mod tests {
    use procedures::diagnostic::SourceFile;
    use procedures::trace::Scale;

    use super::*;

    const TEXT: &str = r#"
schema = 1
[[requirement]]
id = "CUR"
text = "Peak current."
source = "1"
method = "test"
measurand = ["peak-current-az"]
limit = "<= 42.6 A"
[[requirement]]
id = "DUTY"
text = "The same under the duty cycle."
source = "1"
method = "test"
measurand = ["peak-current-az"]
limit = "<= 42.6 A"
[[requirement]]
id = "ACC"
text = "Accuracy."
source = "1"
method = "test"
measurand = ["positioning-accuracy"]
limit = "< 75 urad"
"#;

    fn drawn(plot: Plot) -> Vec<(String, f64)> {
        let source = SourceFile { name: "requirements.toml".to_owned(), text: TEXT.to_owned() };
        let requirements = Requirements::parse(&source).expect("they parse");
        let mut plots = [plot];
        draw(&mut plots, "az", &requirements);
        plots[0].limits.iter().map(|l| (l.label.clone(), l.y)).collect()
    }

    fn plot(measurand: &str, unit: &str) -> Plot {
        let plot = Plot::new("a", "a", Scale::linear("time", "s"), Scale::linear("value", unit));
        Plot { limits_of: Some(measurand.to_owned()), ..plot }
    }

    #[test]
    fn a_limit_is_drawn_in_the_unit_of_the_picture() {
        let line = |unit: &str| drawn(plot("positioning-accuracy", unit))[0].1;
        assert!((line("urad") - 75.0).abs() < 1e-9);
        assert!((line("deg") - 75e-6_f64.to_degrees()).abs() < 1e-12);
        assert!((line("no unit") - 75e-6_f64.to_degrees()).abs() < 1e-12, "that of the kind");
    }

    #[test]
    fn requirements_with_one_limit_share_its_line_and_a_magnitude_has_one_on_either_side() {
        let one = drawn(plot("peak-current-az", "A"));
        assert_eq!(one, [("DUTY, CUR <= 42.6 A".to_owned(), 42.6)]);
        let both = drawn(Plot { limits_of_magnitude: true, ..plot("peak-current-az", "A") });
        assert_eq!(both.iter().map(|(_, y)| *y).collect::<Vec<_>>(), [42.6, -42.6]);
    }
}
