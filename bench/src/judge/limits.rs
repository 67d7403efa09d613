//! Adds the limits of requirements to the plots of the measurands that they judge.

use procedures::condition::Meets;
use procedures::quantity::Limit;
use procedures::requirement::{Mask, Requirements, Where};
use procedures::trace::{LimitCurve, LimitLine, Plot, Side};

/// Adds the limits of all requirements on `axis` to the plots of one axis: a line for each bound, a curve for each mask.
///
/// A plot gets the limits of the measurand that its `limits_of` names. A requirement without axis holds for all axes.
pub(super) fn draw(plots: &mut [Plot], axis: &str, requirements: &Requirements) {
    for plot in plots {
        let Some(measurand) = plot.limits_of.clone() else { continue };
        for requirement in &requirements.all {
            if requirement.axis.as_deref().is_none_or(|required| required == axis) {
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

/// Adds a line for each bound of a limit, over the range of the abscissa in which its conditions hold.
///
/// Requirements with the same limit share one line: its label lists their ids.
fn add(plot: &mut Plot, id: &str, conditions: &[Where], limit: &Limit) {
    let x = abscissa_range(plot, conditions);
    let signs: &[f64] = if plot.limits_of_magnitude { &[1.0, -1.0] } else { &[1.0] };
    for bound_si in [limit.low, limit.high].into_iter().flatten() {
        let bound = in_unit(limit, bound_si, &plot.y.unit);
        for y in signs.iter().map(|sign| sign * bound) {
            // A label ends with the text of its limit; before it stand the ids.
            let drawn = plot
                .limits
                .iter_mut()
                .find(|line| line.y == y && line.x == x && line.label.ends_with(&limit.text));
            match drawn {
                Some(line) => line.label = format!("{id}, {}", line.label),
                None => plot.limits.push(LimitLine { label: format!("{id} {}", limit.text), y, x }),
            }
        }
    }
}

/// An SI bound in the unit of the plot's ordinate, or in the display unit of its kind if that unit does not fit.
fn in_unit(limit: &Limit, bound_si: f64, unit: &str) -> f64 {
    match limit.kind.parse(&format!("1 {unit}")) {
        Ok(unit_si) if unit_si > 0.0 && unit != limit.kind.display_unit() => bound_si / unit_si,
        _ => limit.kind.to_display(bound_si),
    }
}

/// The curve of a mask whose condition is the abscissa of the plot; `None` for other masks.
///
/// Where a corner has two bounds, only the upper one is drawn. Both coordinates are in display units.
fn curve(plot: &Plot, id: &str, mask: &Mask) -> Option<LimitCurve> {
    if mask.condition != plot.x.label {
        return None;
    }
    let abscissa = procedures::condition::kind_of(&mask.condition)?;
    let point = |(x_si, limit): &(f64, Limit)| {
        let bound_si = limit.high.or(limit.low)?;
        Some([abscissa.to_display(*x_si), in_unit(limit, bound_si, &plot.y.unit)])
    };
    let is_upper = mask.corners.iter().all(|(_, limit)| limit.high.is_some());
    Some(LimitCurve {
        label: format!("{id} {}", mask.text()),
        points: mask.corners.iter().map(point).collect::<Option<_>>()?,
        forbidden: if is_upper { Side::Above } else { Side::Below },
    })
}

/// The range of the abscissa to which the conditions of a limit restrict it, e.g. velocity ≤ 10 deg/s; `None` without
/// such a condition. An open end of the range is drawn up to the outermost point.
fn abscissa_range(plot: &Plot, conditions: &[Where]) -> Option<[f64; 2]> {
    let condition = conditions.iter().find(|w| w.condition == plot.x.label)?;
    let Meets::Limit(limit) = &condition.meets else { return None };
    let xs = || plot.series.iter().flat_map(|series| series.x.iter().copied());
    let smallest = xs().fold(f64::INFINITY, f64::min);
    let largest = xs().fold(f64::NEG_INFINITY, f64::max);
    let end = |bound: Option<f64>, open: f64| bound.map_or(open, |bound_si| limit.kind.to_display(bound_si));
    Some([end(limit.low, smallest), end(limit.high, largest)])
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
