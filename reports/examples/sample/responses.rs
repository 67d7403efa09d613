//! Pictures of frequency responses: what each kind of figure looks like. Made-up plants, made-up scatter.

use procedures::trace::{Circle, LimitCurve, LimitLine, Mark, Note, Plot, Scale, Series, Side, Style};

/// Real and imaginary part.
type Complex = (f64, f64);

fn times(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

fn over(a: Complex, b: Complex) -> Complex {
    let square = b.0 * b.0 + b.1 * b.1;
    ((a.0 * b.0 + a.1 * b.1) / square, (a.1 * b.0 - a.0 * b.1) / square)
}

fn absolute(a: Complex) -> f64 {
    a.0.hypot(a.1)
}

/// From `low` to `high` in equal ratios.
fn frequencies_hz(low: f64, high: f64, count: u32) -> Vec<f64> {
    (0..count).map(|i| low * (high / low).powf(f64::from(i) / f64::from(count - 1))).collect()
}

/// Numbers between −1 and 1 without a rhythm that the eye finds.
fn scatter(i: usize) -> f64 {
    (12.9898 * i as f64).sin() * (78.233 * i as f64 + 1.0).cos()
}

/// An open loop: gain, integrator, lag, delay and a mode at 31 Hz.
fn open_loop(hz: f64) -> Complex {
    let s = (0.0, std::f64::consts::TAU * hz);
    let second = |hz0: f64, damping: f64| {
        let ratio = hz / hz0;
        (1.0 - ratio * ratio, 2.0 * damping * ratio)
    };
    let lag = (1.0, hz / 60.0);
    let delay = (-s.1 * 0.8e-3).sin_cos();
    let plant = over((std::f64::consts::TAU * 9.0, 0.0), times(s, lag));
    times(times(plant, (delay.1, delay.0)), over(second(27.0, 0.05), second(31.0, 0.05)))
}

/// Phase in degrees, unwrapped downward from the first.
fn phase_deg(values: &[Complex]) -> Vec<f64> {
    let mut last = None;
    values
        .iter()
        .map(|z| {
            let raw = z.1.atan2(z.0).to_degrees();
            let turns = last.map_or(0.0, |l: f64| ((l - raw) / 360.0).round());
            last = Some(raw + 360.0 * turns);
            raw + 360.0 * turns
        })
        .collect()
}

fn decibels(values: &[Complex]) -> Vec<f64> {
    values.iter().map(|z| 20.0 * absolute(*z).log10()).collect()
}

/// `measured`, its band, `fit` and the excluded lines, of a quantity that the fit says and scatter disturbs.
fn measured(x: &[f64], fit: &[f64], half_width: f64, is_out: impl Fn(f64) -> bool) -> Vec<Series> {
    let u: Vec<f64> = x.iter().map(|hz| half_width * (0.4 + hz / 120.0)).collect();
    let y: Vec<f64> = fit.iter().zip(&u).enumerate().map(|(i, (y, u))| y + 0.6 * u * scatter(i)).collect();
    let pick = |out: bool, values: &[f64]| -> Vec<f64> {
        let both = x.iter().zip(values).filter(|(hz, _)| is_out(**hz) == out);
        both.map(|(_, v)| *v).collect()
    };
    let off: Vec<f64> = pick(true, &y).iter().map(|y| y + 4.0 * half_width).collect();
    vec![
        Series::new("fit, 95 %", Style::Band, x.to_vec(), fit.to_vec()).with_u(u),
        Series::new("rational fit", Style::Fit, x.to_vec(), fit.to_vec()),
        Series::new("measured lines", Style::Markers, pick(false, x), pick(false, &y)),
        Series::new("excluded: coherence below 0.9", Style::Excluded, pick(true, x), off),
    ]
}

fn is_mains(hz: f64) -> bool {
    (46.0..54.0).contains(&hz)
}

/// Gain with masks, phase and coherence of a closed loop.
pub(crate) fn bode() -> Vec<Plot> {
    let hz = frequencies_hz(0.5, 200.0, 90);
    let closed: Vec<Complex> = hz.iter().map(|&f| open_loop(f)).map(|l| over(l, (1.0 + l.0, l.1))).collect();
    let frequency = || Scale::logarithmic("frequency", "Hz");
    let mut gain = Plot::new(
        "closed-loop",
        "Closed loop, position reference to position, elevation at 40°",
        frequency(),
        Scale::linear("gain", "dB"),
    );
    gain.series = measured(&hz, &decibels(&closed), 1.5, is_mains);
    gain.masks = vec![
        LimitCurve {
            label: "BW-EL >= -3 dB to 6 Hz".to_owned(),
            points: vec![[0.1, -3.0], [6.0, -3.0]],
            forbidden: Side::Below,
        },
        LimitCurve {
            label: "ATT-EL <= 6 dB, -40 dB/decade from 25 Hz".to_owned(),
            points: vec![[0.1, 6.0], [25.0, 6.0], [1000.0, -58.1]],
            forbidden: Side::Above,
        },
    ];
    gain.marks = vec![Mark { label: "bandwidth 14 Hz".to_owned(), x: 14.0 }];
    let mut phase = Plot::new("closed-loop-phase", "Phase", frequency(), Scale::linear("phase", "deg"));
    phase.series = measured(&hz, &phase_deg(&closed), 8.0, is_mains);
    let mut coherence = Plot {
        y_range: Some([0.0, 1.05]),
        ..Plot::new("closed-loop-coherence", "Coherence", frequency(), Scale::linear("coherence γ²", ""))
    };
    let value = |(i, &f): (usize, &f64)| {
        if is_mains(f) { 0.62 + 0.1 * scatter(i) } else { 1.0 - 0.0004 * f * (1.0 + 0.5 * scatter(i)) }
    };
    let y = hz.iter().enumerate().map(value).collect();
    coherence.series = vec![Series::new("coherence", Style::Line, hz, y)];
    coherence.limits = vec![LimitLine { label: "excluded below 0.9".to_owned(), y: 0.9, x: None }];
    let phase = phase.panel_of(&gain);
    let coherence = coherence.panel_of(&gain);
    vec![gain, phase, coherence]
}

/// Open loop in the complex plane, with the disk that it keeps out of.
pub(crate) fn nyquist() -> Plot {
    let hz = frequencies_hz(4.0, 300.0, 700);
    let locus: Vec<Complex> = hz.iter().map(|&f| open_loop(f)).collect();
    let split = |points: &[Complex]| -> (Vec<f64>, Vec<f64>) { points.iter().copied().unzip() };
    let lines_hz = frequencies_hz(4.0, 90.0, 36);
    let lines: Vec<Complex> = lines_hz.iter().map(|&f| open_loop(f)).collect();
    let (x, y) = split(&lines);
    let radii = lines.iter().map(|z| 0.02 + 0.05 * absolute(*z)).collect();
    let mut plot = Plot::nyquist("nyquist", "Open loop in the complex plane, elevation at 40°");
    let ((fit_x, fit_y), regions) = (split(&locus), Style::Circles);
    plot.series = vec![
        Series::new("95 % of a line", regions, x.clone(), y.clone()).with_u(radii),
        Series::new("rational fit", Style::Fit, fit_x, fit_y),
        Series::new("measured lines", Style::Markers, x, y),
    ];
    plot.circles.push(Circle::forbidden("MOD-EL: |1 + L| >= 0.5", [-1.0, 0.0], 0.5));
    for at in [5.0, 10.0, 40.0] {
        let (re, im) = open_loop(at);
        plot.notes.push(Note { label: format!("{at} Hz"), at: [re, im] });
    }
    plot
}

/// Phase and gain margin over elevation, each with its limit.
pub(crate) fn margins() -> Vec<Plot> {
    let poses_deg: Vec<f64> = (0..=10).map(|i| f64::from(i) * 10.0 - 10.0).collect();
    let picture = |id: &str, y: Scale, value: fn(f64) -> f64, u: f64, limit: (&str, f64)| {
        let y_values = poses_deg.iter().map(|&e| value(e.to_radians())).collect();
        let series = Series::new("margin, k = 2", Style::Markers, poses_deg.clone(), y_values);
        let line = poses_deg.iter().map(|&e| value(e.to_radians())).collect();
        Plot {
            series: vec![
                Series::new("between the poses", Style::Line, poses_deg.clone(), line),
                series.with_u(vec![u; poses_deg.len()]),
            ],
            limits: vec![LimitLine { label: limit.0.to_owned(), y: limit.1, x: None }],
            ..Plot::new(id, "Stability margins over elevation", Scale::linear("elevation", "deg"), y)
        }
    };
    let degrees = Scale::linear("phase margin", "deg");
    let decibels = Scale::linear("gain margin", "dB");
    let phase = picture("phase-margin", degrees, |e| 52.0 - 9.0 * e.sin(), 1.6, ("PM-EL >= 40 deg", 40.0));
    let gain = picture("gain-margin", decibels, |e| 9.5 - 2.6 * e.sin(), 0.4, ("GM-EL >= 6 dB", 6.0));
    let gain = gain.panel_of(&phase);
    vec![phase, gain]
}

/// Natural frequencies over elevation beside those that were computed.
pub(crate) fn modes() -> Plot {
    let mut plot = Plot::new(
        "mode-map",
        "Modes over elevation, measured and computed",
        Scale::linear("elevation", "deg"),
        Scale::linear("natural frequency", "Hz"),
    );
    for (index, (name, at_zero_hz, change_hz)) in
        [("first mode", 21.0, 3.0), ("second mode", 31.5, -4.0), ("third mode", 54.0, 1.5)].iter().enumerate()
    {
        let curve = |deg: f64| at_zero_hz + change_hz * deg.to_radians().sin();
        let fine: Vec<f64> = (0..=36).map(|i| f64::from(i) * 2.5).collect();
        let computed: Vec<f64> = fine.iter().map(|&d| curve(d)).collect();
        let u = computed.iter().map(|f| 0.04 * f).collect();
        let poses: Vec<f64> = (0..=6).map(|i| f64::from(i) * 15.0).collect();
        let measured: Vec<f64> = poses
            .iter()
            .enumerate()
            .map(|(i, &d)| curve(d) * (1.0 + 0.025 * scatter(i + 7 * index)))
            .collect();
        let half = measured.iter().map(|f| 0.012 * f).collect();
        plot.series.push(
            Series::new(format!("{name}, FEA ± 4 %"), Style::Band, fine.clone(), computed.clone()).with_u(u),
        );
        plot.series.push(Series::new(format!("{name}, FEA"), Style::Fit, fine, computed));
        plot.series.push(Series::new(*name, Style::Markers, poses, measured).with_u(half));
    }
    plot.notes = vec![Note { label: "modes meet".to_owned(), at: [90.0, 25.75] }];
    plot
}

/// Impedance of a winding with the circuit that was fitted.
pub(crate) fn impedance() -> Vec<Plot> {
    let hz = frequencies_hz(10.0, 20_000.0, 34);
    // Resistance and inductance in series, eddy currents as a resistance beside a part of the inductance.
    let circuit = |f: f64| {
        let w = std::f64::consts::TAU * f;
        let eddy = over((0.0, w * 1.1e-3 * 14.0), (14.0, w * 1.1e-3));
        (0.82 + eddy.0, w * 2.4e-3 + eddy.1)
    };
    let fit: Vec<Complex> = hz.iter().map(|&f| circuit(f)).collect();
    let magnitude: Vec<f64> = fit.iter().map(|z| absolute(*z)).collect();
    let frequency = || Scale::logarithmic("frequency", "Hz");
    let picture = |id: &str, y: Scale, values: Vec<f64>, u: Vec<f64>| {
        let measured =
            values.iter().zip(&u).enumerate().map(|(i, (v, u))| v + 0.7 * u * scatter(i)).collect();
        Plot {
            series: vec![
                Series::new("R + L with eddy branch", Style::Fit, hz.clone(), values),
                Series::new("measured, k = 2", Style::Markers, hz.clone(), measured).with_u(u),
            ],
            ..Plot::new(id, "Impedance of phase U, fitted circuit", frequency(), y)
        }
    };
    let u = magnitude.iter().map(|z| 0.05 * z).collect();
    let size = picture("impedance", Scale::logarithmic("|Z|", "ohm"), magnitude, u);
    let phase =
        picture("impedance-phase", Scale::linear("phase", "deg"), phase_deg(&fit), vec![3.0; hz.len()]);
    let phase = phase.panel_of(&size);
    vec![size, phase]
}

/// How often which latency was seen.
pub(crate) fn latency() -> Plot {
    let mut plot = Plot::new(
        "latency",
        "Latency from set-point to feedback",
        Scale::linear("latency", "us"),
        Scale::logarithmic("count", ""),
    );
    let classes: Vec<f64> = (0..60).map(|i| 205.0 + 10.0 * f64::from(i)).collect();
    let tail = |x: f64| 40_000.0 * (-((x - 290.0) / 32.0).powi(2)).exp() + 60.0 * (-(x - 290.0) / 95.0).exp();
    let counts = classes.iter().map(|&x| if x > 240.0 { tail(x).floor() } else { 0.0 }).collect();
    let widths = vec![5.0; classes.len()];
    plot.series = vec![Series::new("cycles", Style::Histogram, classes, counts).with_u(widths)];
    plot.marks = vec![
        Mark { label: "median 290 µs".to_owned(), x: 290.0 },
        Mark { label: "99.9 % 352 µs".to_owned(), x: 352.0 },
        Mark { label: "limit 750 µs".to_owned(), x: 750.0 },
    ];
    plot
}
