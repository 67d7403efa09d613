//! The pictures of the sample: lines, fits, bands, markers, bars, linear and logarithmic scales, limits and marks.

use procedures::trace::{LimitLine, Mark, Plot, Scale, Series, Style};

fn scale(label: &str, unit: &str, log: bool) -> Scale {
    Scale { label: label.to_owned(), unit: unit.to_owned(), log }
}

fn series(label: &str, style: Style, points: Vec<(f64, f64)>) -> Series {
    let (x, y) = points.into_iter().unzip();
    Series::new(label, style, x, y)
}

fn plot(id: &str, title: &str, x: Scale, y: Scale, series: Vec<Series>) -> Plot {
    Plot { series, ..Plot::new(id, title, x, y) }
}

/// Torque over angle, both ways.
pub(super) fn loops() -> Plot {
    let branch = |sign: f64| -> Vec<(f64, f64)> {
        (0..=480)
            .map(|i| {
                let angle = -60.0 + 0.25 * f64::from(i);
                let ripple = 9.0 * (144.0 * angle.to_radians()).sin();
                (angle, sign * 529.9 + ripple + 1.4 * (angle - 40.0).to_radians())
            })
            .collect()
    };
    plot(
        "loop-10-deg-s",
        "Torque over angle at 10 °/s, azimuth",
        scale("angle", "deg", false),
        scale("torque", "N*m", false),
        vec![
            series("forward", Style::Line, branch(1.0)),
            series("backward", Style::Line, branch(-1.0)),
            series("friction, half the difference", Style::Fit, vec![(-55.0, 529.9), (55.0, 529.9)]),
        ],
    )
}

/// Friction over velocity with fit, band, an excluded point and a limit that applies to part of it.
pub(super) fn friction() -> Plot {
    let curve = |v: f64| 380.0 + 15.0 * v + 25.0 * (-(v / 0.5).powi(2)).exp();
    let velocities = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 60.0];
    let fit: Vec<(f64, f64)> = (0..60).map(|i| 0.08 * 1.12f64.powi(i)).map(|v| (v, curve(v))).collect();
    let mut band = series("95 % band of the fit", Style::Band, fit.clone());
    band.u = fit.iter().map(|(v, _)| 8.0 + 0.4 * v).collect();
    let mut measured =
        series("measured, U", Style::Markers, velocities.iter().map(|&v| (v, curve(v) * 1.004)).collect());
    measured.u = velocities.iter().map(|v| 10.0 + 0.3 * v).collect();
    let mut picture = plot(
        "friction-velocity",
        "Friction over velocity, azimuth",
        scale("velocity", "deg/s", true),
        scale("friction torque", "N*m", false),
        vec![
            band,
            series("Stribeck fit", Style::Fit, fit),
            measured,
            series("excluded: stuck in presliding", Style::Excluded, vec![(0.05, 310.0)]),
        ],
    );
    picture.limits =
        vec![LimitLine { label: "FRC-AZ <= 260 N*m".to_owned(), y: 260.0, x: Some([0.0, 10.0]) }];
    picture.limits_of = Some("friction-torque".to_owned());
    picture
}

/// Cogging amplitude over order.
pub(super) fn spectrum() -> Plot {
    let mut lines: Vec<(f64, f64)> = (0..=100)
        .map(|i| f64::from(i) * 4.0)
        .map(|order| (order, 0.05 + 0.04 * (order * 0.7).sin().abs()))
        .collect();
    lines[36].1 = 8.9;
    lines[72].1 = 2.1;
    let mut picture = plot(
        "cogging",
        "Cogging over order, azimuth",
        scale("order", "1/rev", false),
        scale("amplitude", "N*m", false),
        vec![series("amplitude", Style::Bars, lines)],
    );
    picture.limits = vec![LimitLine { label: "COG-AZ <= 12 N*m".to_owned(), y: 12.0, x: None }];
    picture.marks = vec![Mark { label: "order 144".to_owned(), x: 144.0 }];
    picture
}

/// A torque ramp with the detected onset.
pub(super) fn ramp() -> Plot {
    let torque = |t: f64| if t < 1.95 { 52.0 * t } else { 101.4 - 4.0 * (1.0 - (-(t - 1.95) * 9.0).exp()) };
    let points = (0..=300).map(|i| f64::from(i) * 0.01).map(|t| (t, torque(t))).collect();
    let mut picture = plot(
        "ramp",
        "Torque ramp at 1 A/s, elevation at 40°",
        scale("time", "s", false),
        scale("torque", "N*m", false),
        vec![series("effort", Style::Line, points)],
    );
    picture.marks = vec![
        Mark { label: "3 z_ss".to_owned(), x: 1.93 },
        Mark { label: "onset".to_owned(), x: 1.95 },
        Mark { label: "8 z_ss".to_owned(), x: 2.02 },
    ];
    picture.limits = vec![LimitLine { label: "FRC-EL <= 130 N*m".to_owned(), y: 130.0, x: None }];
    picture
}
