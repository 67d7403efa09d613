//! Figures of a tracking test: errors with events and windows that are left out, their histogram, their spectrum; and
//! a list of approaches to a limit. Made-up numbers without chance.

use procedures::trace::{LimitLine, Mark, Note, Plot, Scale, Series, Span, Style};

const RATE_HZ: f64 = 25.0;
const DURATION_S: f64 = 24.0;
/// The target jumps here, and the record has a hole there.
const JUMP_S: f64 = 6.0;
const HOLE_S: [f64; 2] = [14.0, 15.2];

fn error_urad(time_s: f64) -> f64 {
    let sway = 38.0 * (1.3 * time_s).sin() + 11.0 * (7.9 * time_s).sin() + 6.0 * (23.0 * time_s).cos();
    let jump = if time_s >= JUMP_S { 260.0 * (-(time_s - JUMP_S) / 0.5).exp() } else { 0.0 };
    sway + jump
}

fn times_s() -> Vec<f64> {
    let count = (DURATION_S * RATE_HZ) as usize;
    let all = (0..count).map(|k| k as f64 / RATE_HZ);
    all.filter(|t| !(HOLE_S[0]..HOLE_S[1]).contains(t)).collect()
}

/// Error over time: in two pieces, with the event, the window around it, the hole, and the limit on either side; and
/// the acceleration of the target as a panel.
pub(crate) fn errors() -> Vec<Plot> {
    let piece = |within: &dyn Fn(f64) -> bool| {
        let x: Vec<f64> = times_s().into_iter().filter(|t| within(*t)).collect();
        let y = x.iter().map(|t| error_urad(*t)).collect();
        Series::new("elevation", Style::Line, x, y)
    };
    let limit = |y: f64| LimitLine { label: format!("3 sigma {y} urad"), y, x: None };
    let head = Plot {
        series: vec![piece(&|t| t < HOLE_S[0]), piece(&|t| t >= HOLE_S[1])],
        limits: vec![limit(300.0), limit(-300.0)],
        marks: vec![
            Mark { label: "el jump".to_owned(), x: JUMP_S },
            Mark { label: "lost".to_owned(), x: HOLE_S[0] },
        ],
        spans: vec![
            Span { label: "left out: target accelerates".to_owned(), x: [JUMP_S - 0.2, JUMP_S + 1.8] },
            Span { label: "left out: target accelerates".to_owned(), x: [HOLE_S[0] - 0.3, HOLE_S[1] + 0.4] },
        ],
        ..Plot::new("track-error", "Track error", Scale::linear("time", "s"), Scale::linear("error", "urad"))
    };
    let x = times_s();
    let y = x.iter().map(|t| 4.0 * (-((t - JUMP_S) / 0.3).powi(2)).exp()).collect();
    let panel = Plot {
        series: vec![Series::new("acceleration of the target", Style::Line, x, y)],
        ..Plot::new("target", "Target", Scale::linear("time", "s"), Scale::linear("acceleration", "mrad/s^2"))
    };
    let panel = panel.panel_of(&head);
    vec![head, panel]
}

/// The histogram of the errors outside the window, with the normal distribution of the same variance.
pub(crate) fn histogram() -> Plot {
    let kept: Vec<f64> = times_s().into_iter().filter(|t| !(5.8..7.8).contains(t)).map(error_urad).collect();
    let classes = 24;
    let width = 5.0;
    let centre: Vec<f64> = (0..classes).map(|k| (f64::from(k) - 11.5) * width).collect();
    let share = 100.0 / kept.len() as f64;
    let inside = |c: f64| kept.iter().filter(|e| (**e - c).abs() <= 0.5 * width).count() as f64;
    let y = centre.iter().map(|c| share * inside(*c)).collect();
    let sigma = (kept.iter().map(|e| e * e).sum::<f64>() / kept.len() as f64).sqrt();
    let normal =
        |e: f64| 100.0 * width / (sigma * std::f64::consts::TAU.sqrt()) * (-0.5 * (e / sigma).powi(2)).exp();
    let at: Vec<f64> = (0..=120).map(|k| f64::from(k) - 60.0).collect();
    let curve = at.iter().map(|e| normal(*e)).collect();
    let plot = Plot::new(
        "track-histogram",
        "Errors outside the windows",
        Scale::linear("error", "urad"),
        Scale::linear("share", "%"),
    );
    Plot {
        series: vec![
            Series::new("elevation", Style::Histogram, centre, y).with_u(vec![0.5 * width; classes as usize]),
            Series::new("normal distribution of the same variance", Style::Fit, at, curve),
        ],
        marks: vec![Mark { label: "1 sigma".to_owned(), x: sigma }],
        ..plot
    }
}

/// Power spectral density over five decades, both scales logarithmic, with the interval of its estimate.
pub(crate) fn spectrum() -> Plot {
    let hz: Vec<f64> = (1..=200).map(|k| 0.05 * 1.035_f64.powi(k)).collect();
    let density =
        |f: f64| 900.0 / (1.0 + (f / 0.4).powi(4)) + 40.0 / (1.0 + ((f - 3.0) / 0.2).powi(2)) + 2e-3;
    let y: Vec<f64> = hz.iter().map(|f| density(*f)).collect();
    let u = y.iter().map(|d| 0.35 * d).collect();
    let x = Scale::logarithmic("frequency", "Hz");
    let ordinate = Scale::logarithmic("density", "urad^2/Hz");
    Plot {
        series: vec![
            Series::new("95 % interval", Style::Band, hz.clone(), y.clone()).with_u(u),
            Series::new("elevation", Style::Line, hz, y),
        ],
        marks: vec![Mark { label: "3 Hz joint of the rails".to_owned(), x: 3.0 }],
        ..Plot::new("track-spectrum", "Spectrum of the error", x, ordinate)
    }
}

/// A list: how far past its limit each approach came.
pub(crate) fn approaches() -> Plot {
    let names = ["soft-bench, 60 deg/s", "soft-bench, -60 deg/s", "soft-drive, 1 deg/s"];
    let rows: Vec<f64> = vec![1.0, 2.0, 3.0];
    let past = vec![-1.9, -1.8, 0.02];
    Plot {
        series: vec![
            Series::new("way", Style::Line, vec![-3.0, -1.9], vec![1.0; 2]),
            Series::new("way", Style::Line, vec![-2.8, -1.8], vec![2.0; 2]),
            Series::new("reached", Style::Bars, past, rows.clone()),
            Series::new("ordered", Style::Markers, vec![3.0, 3.0, 1.0], rows),
        ],
        marks: vec![Mark { label: "limit".to_owned(), x: 0.0 }],
        notes: vec![Note { label: "0.02°".to_owned(), at: [0.02, 3.0] }],
        rows: names.map(str::to_owned).into(),
        ..Plot::new(
            "past-the-limit",
            "From the limit",
            Scale::linear("past the limit", "deg"),
            Scale::default(),
        )
    }
}
