//! Pictures of a point: responses with the fit over them, and the stabilisation diagram.

use analysis::frf::{C64, Frf, Line};
use analysis::modal::DiagramPole;

use super::expected::Expected;
use super::fit::{self, Fitted};
use super::responses::{Responses, SENSORS};
use crate::trace::{Mark, Plot, Scale, Series, Style};

/// Abscissae and ordinates.
type Points = (Vec<f64>, Vec<f64>);

/// Expanded uncertainty in pictures: k = 2.
const COVERAGE: f64 = 2.0;
/// 20·lg e: what a relative deviation is in dB.
const DB_PER_NEPER: f64 = 8.685_889_638;
/// Points of a fitted curve.
const FIT_POINTS: usize = 400;

/// Id of every stabilisation diagram begins with this.
pub(super) const DIAGRAM: &str = "stabilisation-";

fn frequency() -> Scale {
    Scale::logarithmic("frequency", "Hz")
}

fn slug(point: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '.') { c } else { '-' };
    point.chars().map(plain).collect()
}

/// All pictures of a point.
pub(super) fn of_point(
    point: &str,
    responses: &Responses,
    fitted: &Fitted,
    expected: &[Expected],
) -> Vec<Plot> {
    let marks = marks(fitted, expected);
    let mut plots = Vec::new();
    for sensor in 0..SENSORS.len() {
        plots.extend(bode(point, sensor, responses, fitted, &marks));
    }
    plots.push(diagram(point, fitted, &marks));
    plots
}

/// Every visible mode, with its number if it was expected.
fn marks(fitted: &Fitted, expected: &[Expected]) -> Vec<Mark> {
    let mark = |&k: &usize| {
        let hz = fitted.modal.modes[k].frequency_hz;
        let label = match fitted.pairs.iter().position(|pair| *pair == Some(k)) {
            Some(i) => format!("mode {}, {hz:.2} Hz", expected[i].mode),
            None => format!("{hz:.2} Hz, not expected"),
        };
        Mark { label, x: hz }
    };
    fitted.visible.iter().map(mark).collect()
}

fn bode(point: &str, sensor: usize, responses: &Responses, fitted: &Fitted, marks: &[Mark]) -> [Plot; 2] {
    let lines = &responses.sensors[sensor];
    let hollow = &responses.hollow[sensor];
    let name = SENSORS[sensor];
    let id = format!("{name}-{}", slug(point));
    let title = format!("Torque to rate of the {name}, {point}");
    // The delay is turned out of both: what is left is the structure.
    let turned = |hz: f64, value: C64| {
        value * C64::from_polar(1.0, std::f64::consts::TAU * hz * fitted.modal.fit.delay_s)
    };
    let phase = |hz: f64, value: C64| turned(hz, value).arg().to_degrees();
    let curve = curve(lines, fitted, sensor);
    let column = |all: &Frf, value: &dyn Fn(&Line) -> f64| -> Vec<f64> { all.iter().map(value).collect() };
    let hz = |l: &Line| l.frequency_hz;
    let fit_hz: Vec<f64> = curve.iter().map(|(hz, _)| *hz).collect();
    let series = |y: &dyn Fn(f64, C64) -> f64, u: &dyn Fn(&Line) -> f64| {
        let modelled = |l: &Line| y(l.frequency_hz, l.value);
        let mut all = vec![
            Series::new("measured, U (k = 2)", Style::Markers, column(lines, &hz), column(lines, &modelled))
                .with_u(column(lines, u)),
            Series::new("fit", Style::Fit, fit_hz.clone(), curve.iter().map(|(hz, v)| y(*hz, *v)).collect()),
        ];
        if !hollow.is_empty() {
            all.push(Series::new(
                "does not count",
                Style::Excluded,
                column(hollow, &hz),
                column(hollow, &modelled),
            ));
        }
        all
    };
    let gain = Plot {
        series: series(&|_, v| 20.0 * v.norm().log10(), &|l| COVERAGE * DB_PER_NEPER * l.relative_sd()),
        marks: marks.to_vec(),
        ..Plot::new(&id, &title, frequency(), Scale::linear("gain, dB re rad/s/(N*m)", "dB"))
    };
    let phase = Plot {
        series: series(&phase, &|l| COVERAGE * l.relative_sd().to_degrees()),
        ..Plot::new(
            format!("{id}-phase"),
            format!("{title}: phase, {:.2} ms of delay removed", 1e3 * fitted.modal.fit.delay_s),
            frequency(),
            Scale::linear("phase", "deg"),
        )
    }
    .panel_of(&gain);
    [gain, phase]
}

/// The fit over the band of the lines.
fn curve(lines: &Frf, fitted: &Fitted, sensor: usize) -> Vec<(f64, C64)> {
    let (Some(first), Some(last)) = (lines.first(), lines.last()) else { return Vec::new() };
    let ratio = last.frequency_hz / first.frequency_hz;
    (0..FIT_POINTS)
        .map(|k| first.frequency_hz * ratio.powf(k as f64 / (FIT_POINTS - 1) as f64))
        .map(|hz| (hz, fit::response(fitted, sensor, hz)))
        .collect()
}

fn diagram(point: &str, fitted: &Fitted, marks: &[Mark]) -> Plot {
    let points = |wanted: &dyn Fn(&DiagramPole) -> bool| -> Points {
        let orders = &fitted.modal.diagram.orders;
        let all = orders.iter().flat_map(|o| o.poles.iter().map(move |p| (o.order as f64, p)));
        all.filter(|(_, p)| wanted(p)).map(|(order, p)| (p.frequency_hz, order)).unzip()
    };
    let classes: [(&str, Style, Points); 2] = [
        (
            "stable in frequency and damping",
            Style::Markers,
            points(&|p| p.stable_frequency && p.stable_damping),
        ),
        ("not stable", Style::Excluded, points(&|p| !(p.stable_frequency && p.stable_damping))),
    ];
    let series = classes.into_iter().filter(|(.., (x, _))| !x.is_empty());
    Plot {
        series: series.map(|(label, style, (x, y))| Series::new(label, style, x, y)).collect(),
        marks: marks.to_vec(),
        ..Plot::new(
            format!("{DIAGRAM}{}", slug(point)),
            format!("Stabilisation diagram, {point}"),
            Scale::linear("frequency", "Hz"),
            Scale::linear("order", ""),
        )
    }
}
