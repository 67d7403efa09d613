//! Against a linear plant in discrete time: what the kind reads must be what was put in.

use std::f64::consts::{PI, TAU};

use analysis::frf::C64;

use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Mode};
use crate::diagnostic::SourceFile;
use crate::excitation::Injection;
use crate::log::{EndedBy, SegmentSpan, Window};
use crate::measurement::{Measurement, PointResult};
use crate::procedure::Procedure;
use crate::procedure::sample::sample_axes;
use crate::stimulus::{Setpoint, Stimulus};
use crate::synthetic;
use crate::trace::Style;

mod closed;
mod honesty;
mod track;

const RATE_HZ: f64 = 4000.0;
const KP: f64 = 18_250.0;
const KI: f64 = 361_400.0;
const INERTIA: f64 = 975.0;
const VISCOUS: f64 = 68.4;
/// Samples out and back.
const DELAY: usize = 6;
/// modes.csv, elevation 0°, first mode in the gyro.
const MODE: [f64; 3] = [17.25, 0.035, -1.9e-4];

fn axes() -> Axes {
    let az = sample_axes().all()[0].limits.clone();
    let el = AxisLimits {
        soft_limits_rad: [-9.5_f64.to_radians(), 89.5_f64.to_radians()],
        max_torque_nm: 1882.0,
        torque_constant_nm_per_a: Some(52.0),
        inertia_kg_m2: INERTIA,
        log_rate_hz: 0.0,
        cogging_orders_per_rev: 108.0,
        expected_presliding_stiffness_nm_per_rad: 50_000.0,
        loop_rate_hz: RATE_HZ,
        ..az.clone()
    };
    Axes::stacked([("az".to_owned(), AxisLimits { loop_rate_hz: RATE_HZ, ..az }), ("el".to_owned(), el)])
}

fn procedure(excitation: &str, background: &str) -> Procedure {
    // Behind a torque there is no loop to read.
    let closed = if excitation.contains("torque") || excitation.contains("gain-ratio") {
        ""
    } else {
        "\"velocity-loop\", \"velocity-position\", "
    };
    let text = format!(
        "schema = 1\nid = \"T\"\ntitle = \"t\"\nkind = \"frequency-response\"\naxis = \"el\"\n\
         elevation = [\"20 deg\"]\nresponses = [\"plant\", \"torque-angle\", {closed}\"coaxiality\"]\n\
         [excitation]\n{excitation}\n[background]\nsliding-from = \"0.03 rad/s\"\n{background}\n"
    );
    Procedure::parse(SourceFile { name: "t.toml".to_owned(), text }).expect("a procedure")
}

const MULTISINE: &str = "level = [\"4 V\"]\nfrom = \"0.5 Hz\"\nto = \"60 Hz\"\nduration = \"60 s\"";
const SLIDING: &str = "velocity = \"0.05 rad/s\"\nhalf-width = \"2.5 deg\"";
const REST: &str = "velocity = \"0 rad/s\"\nhalf-width = \"2.5 deg\"";

/// A rigid body with one mode, zero-order hold, exact at the samples.
struct Plant {
    rate: f64,
    angle: f64,
    /// Mode: displacement and rate.
    mode: [f64; 2],
    /// exp(A·Ts) of the mode and what a unit torque adds.
    turn: [[f64; 2]; 2],
    push: [f64; 2],
    torques: [f64; DELAY],
    rates: [f64; DELAY],
    tick: usize,
    noise: u64,
}

impl Plant {
    fn new(seed: u64) -> Self {
        let ts = 1.0 / RATE_HZ;
        let w = TAU * MODE[0];
        let z = MODE[1];
        let sigma = z * w;
        let wd = w * (1.0 - z * z).sqrt();
        let decay = (-sigma * ts).exp();
        let c = (wd * ts).cos();
        let s = (wd * ts).sin();
        let turn = [
            [decay * (c + sigma / wd * s), decay * s / wd],
            [-decay * w * w / wd * s, decay * (c - sigma / wd * s)],
        ];
        // A⁻¹·(exp(A·Ts) − 1)·b with b = (0, 1).
        let push = [(1.0 - turn[0][0]) / (w * w), turn[0][1]];
        Self {
            rate: 0.0,
            angle: 0.0,
            mode: [0.0; 2],
            turn,
            push,
            torques: [0.0; DELAY],
            rates: [0.0; DELAY],
            tick: 0,
            noise: seed,
        }
    }

    /// Uniform noise of this standard deviation.
    fn noise(&mut self, sd: f64) -> f64 {
        self.noise =
            self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let uniform = (self.noise >> 11) as f64 / (1u64 << 53) as f64;
        sd * 12_f64.sqrt() * (uniform - 0.5)
    }

    /// What the sensor says now.
    fn sensed(&mut self) -> f64 {
        let noise = self.noise(3e-5);
        let sensed = self.rate + MODE[2] * self.mode[1] + noise;
        std::mem::replace(&mut self.rates[self.tick % DELAY], sensed)
    }

    fn step(&mut self, torque: f64) {
        let torque = std::mem::replace(&mut self.torques[self.tick % DELAY], torque);
        let decay = (-VISCOUS / INERTIA / RATE_HZ).exp();
        self.angle += self.rate / RATE_HZ;
        self.rate = decay * self.rate + (1.0 - decay) / VISCOUS * torque;
        let [x, v] = self.mode;
        self.mode = [
            self.turn[0][0] * x + self.turn[0][1] * v + self.push[0] * torque,
            self.turn[1][0] * x + self.turn[1][1] * v + self.push[1] * torque,
        ];
        self.tick += 1;
    }
}

/// Open velocity loop of the plant, exact.
fn open_loop(hz: f64) -> C64 {
    let z = C64::from_polar(1.0, TAU * hz / RATE_HZ);
    let controller = KP + KI / RATE_HZ * z / (z - 1.0);
    let decay = (-VISCOUS / INERTIA / RATE_HZ).exp();
    let rigid = (1.0 - decay) / VISCOUS / (z - decay);
    let plant = Plant::new(0);
    let ([[a, b], [c, d]], [p, q]) = (plant.turn, plant.push);
    // Second row of (z − A)⁻¹·b.
    let flexible = (c * p + (z - a) * q) / ((z - a) * (z - d) - b * c) * MODE[2];
    controller * (rigid + flexible) * z.powi(-2 * DELAY as i32)
}

/// Runs a case on the plant under position loop and velocity loop.
fn run(case: &Case, seed: u64) -> Window {
    let mut plant = Plant::new(seed);
    plant.angle = case.start_pose_rad["el"];
    let mut integral = 0.0;
    let mut columns = vec![Vec::new(); 6];
    let mut time_s = Vec::new();
    let mut segments = Vec::new();
    let mut began = vec![None; case.excitations.len()];
    for (index, segment) in case.segments.iter().enumerate() {
        let start = time_s.len();
        let from = plant.angle;
        let lasts = segment.stimulus.duration_s(from).unwrap_or(segment.at_most_s).min(segment.at_most_s);
        for k in 0..(lasts * RATE_HZ).round() as usize {
            let t = k as f64 / RATE_HZ;
            let at: Setpoint = segment.stimulus.at(from, t);
            let excitation = segment.excited.map_or(0.0, |e| {
                let began = *began[e].get_or_insert(start);
                case.excitations[e].at((start + k - began) as f64 / RATE_HZ)
            });
            let into = segment.excited.map(|e| case.excitations[e].into);
            let add = |place| if into == Some(place) { excitation } else { 0.0 };
            let rate = plant.sensed();
            let outer =
                if segment.mode == Mode::Position { 4.5 * (at.position_rad - plant.angle) } else { 0.0 };
            let command = at.velocity_rad_per_s + outer + add(Injection::Velocity);
            integral += KI / RATE_HZ * (command - rate);
            let torque = KP * (command - rate) + integral + add(Injection::Torque);
            time_s.push(1.0 + (start + k) as f64 / RATE_HZ);
            for (column, value) in
                columns.iter_mut().zip([plant.angle, torque / 52.0, torque, command, rate, excitation])
            {
                column.push(value);
            }
            plant.step(torque);
        }
        let start_s = 1.0 + start as f64 / RATE_HZ;
        let end_s = 1.0 + time_s.len() as f64 / RATE_HZ;
        let span = SegmentSpan {
            segment: index,
            start_s,
            end_s,
            start_position_rad: from,
            ended_by: EndedBy::Completed,
        };
        segments.push(span);
    }
    let names = [
        "position_rad",
        "current_a",
        "torque_command_nm",
        "velocity_command_rad_per_s",
        "velocity_feedback_rad_per_s",
        "excitation",
    ];
    let rows = synthetic::rows("/el", &time_s, names.into_iter().zip(columns).collect());
    Window::completed(vec![rows], segments)
}

fn judge(procedure: &Procedure, spoil: impl Fn(&mut Window), seed: u64) -> PointResult {
    let axes = axes();
    let case = &procedure.plan(&axes, &[]).expect("a plan")[0];
    let mut window = run(case, seed);
    spoil(&mut window);
    procedure.analyse(case, &window, &axes, RATE_HZ)
}

fn of<'a>(result: &'a PointResult, name: &str) -> &'a Measurement {
    result.measurements.iter().find(|m| m.measurand == name).expect("it is yielded")
}

/// Bandwidth Hz, phase margin rad, gain margin dB of the exact open loop, by bisection.
fn truth() -> [f64; 3] {
    let root = |low: f64, high: f64, f: &dyn Fn(f64) -> f64| {
        let mut low = low;
        let mut high = high;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if f(low) * f(middle) <= 0.0 { high = middle } else { low = middle }
        }
        low
    };
    let bandwidth = root(2.0, 8.0, &|hz| open_loop(hz).norm() - 1.0);
    let phase = PI + open_loop(bandwidth).arg();
    let crossing = root(13.0, 17.2, &|hz| open_loop(hz).im);
    [bandwidth, phase, -20.0 * open_loop(crossing).norm().log10()]
}

#[test]
fn margins_of_a_linear_plant_are_those_of_its_open_loop() {
    let procedure = procedure(MULTISINE, SLIDING);
    let result = judge(&procedure, |_| {}, 1);
    let tolerances = [0.01, 0.2_f64.to_radians(), 0.02];
    let names = ["velocity-bandwidth", "velocity-phase-margin", "velocity-gain-margin"];
    for ((name, truth), tolerance) in names.iter().zip(truth()).zip(tolerances) {
        let m = of(&result, name);
        let value = m.value.unwrap_or_else(|| panic!("{name}: {:?}", m.inconclusive));
        assert!((value - truth).abs() < tolerance, "{name}: {value} ± {}, truth {truth}", m.u);
        assert!((value - truth).abs() < 4.0 * m.u, "{name}: {value} ± {}, truth {truth}", m.u);
    }
    assert!(of(&result, "distortion").value.is_some_and(|v| v < 0.01), "a linear plant does not distort");
}

#[test]
fn inertia_of_a_linear_plant_is_the_one_that_was_put_in() {
    let result = judge(&procedure(MULTISINE, SLIDING), |_| {}, 1);
    let inertia = of(&result, "apparent-inertia");
    let value = inertia.value.unwrap_or_else(|| panic!("{:?}", inertia.inconclusive));
    assert!((value - INERTIA).abs() < (3.0 * inertia.u).min(0.01 * INERTIA), "{value} ± {}", inertia.u);
}

#[test]
fn stepped_sines_read_the_same_loop() {
    let stepped = "signal = \"stepped\"\nlines = 40\nlevel = [\"4 V\"]\nfrom = \"1 Hz\"\nto = \"60 Hz\"\n\
                   duration = \"170 s\"";
    let result = judge(&procedure(stepped, SLIDING), |_| {}, 1);
    let bandwidth = of(&result, "velocity-bandwidth");
    let value = bandwidth.value.unwrap_or_else(|| panic!("{:?}", bandwidth.inconclusive));
    assert!((value - truth()[0]).abs() < 0.05, "{value}");
}

/// Whatever the level: the axis does not slide, so the crossing lies where the contact shows itself.
#[test]
fn from_rest_every_level_is_inconclusive_below_seven_hertz_with_the_reason() {
    for (into, level, what) in [
        ("velocity", "1 V", "velocity-bandwidth"),
        ("velocity", "10 V", "velocity-bandwidth"),
        ("torque", "1 V", "apparent-inertia"),
        ("torque", "10 V", "apparent-inertia"),
    ] {
        let excitation = format!(
            "into = \"{into}\"\nlevel = [\"{level}\"]\nfrom = \"0.5 Hz\"\nto = \"60 Hz\"\nduration = \"60 s\""
        );
        let result = judge(&procedure(&excitation, REST), |_| {}, 1);
        let found = of(&result, what);
        let reason = found.inconclusive.as_deref().unwrap_or_default();
        assert!(found.value.is_none() && reason.starts_with("presliding"), "{into} {level}: {reason}");
        if into != "velocity" {
            continue;
        }
        let gain = result.plots.iter().find(|plot| plot.id.starts_with("loop-")).expect("it is drawn");
        let counts = |style| gain.series.iter().filter(move |s| s.style == style).flat_map(|s| s.x.clone());
        assert!(counts(Style::Excluded).any(|hz| hz < 1.0), "lines below the contact's corner are hollow");
        assert!(counts(Style::Line).all(|hz| hz >= 7.0), "no line below it counts");
    }
    assert!(super::point::presliding_hz(axes().get("el").expect("elevation")) >= 7.0);
}

#[test]
fn a_level_that_would_reverse_the_axis_gets_more_background_or_is_refused() {
    let axes = axes();
    let with = |level: &str| procedure(&MULTISINE.replace("4 V", level), SLIDING).plan(&axes, &[]);
    let fast = |cases: &[Case]| match &cases[0].segments[1].stimulus {
        Stimulus::Reversals { limits, .. } => limits.velocity_rad_per_s,
        other => panic!("strokes expected, found {other:?}"),
    };
    let low = with("4 V").expect("a plan");
    let high = with("8 V").expect("a plan");
    assert!(fast(&high) > 1.25 * 0.069 && fast(&low) < 0.06, "{} {}", fast(&low), fast(&high));
    let refused = with("30 V").expect_err("no time for a window");
    assert!(refused[0].message.contains("less than the shortest window"), "{}", refused[0].message);
}

/// A period of 12 Hz is shorter than the shortest window, which is then the one that is taken.
#[test]
fn lines_from_twelve_hertz_on_are_planned_and_measured() {
    let result = judge(&procedure(&MULTISINE.replace("0.5 Hz", "12 Hz"), SLIDING), |_| {}, 1);
    let bandwidth = of(&result, "velocity-bandwidth");
    assert!(bandwidth.value.is_some_and(|hz| (12.0..16.5).contains(&hz)), "{bandwidth:?}");
    assert!(bandwidth.bound.is_some(), "it crosses 0 dB at {:.1} Hz, below its lowest line", truth()[0]);
}

#[test]
fn a_level_in_its_own_unit_is_the_signal_that_volts_would_be() {
    let axes = axes();
    let with =
        |signal: &str| procedure(&MULTISINE.replace("level = [\"4 V\"]", signal), SLIDING).plan(&axes, &[]);
    let same = [
        ("level = [\"4 V\"]", "level = [\"4 deg/s\"]", "elevation=20 deg, level=4 deg/s"),
        (
            "level = [\"4 V\"]\ninto = \"torque\"",
            "level = [\"4 A\"]\ninto = \"torque\"",
            "elevation=20 deg, level=4 A",
        ),
    ];
    for (volts, own, point) in same {
        let [volts, own] = [volts, own].map(|signal| with(signal).expect("a plan"));
        assert_eq!(own[0].point, point);
        let sines = |cases: &[Case]| -> Vec<[f64; 3]> {
            let all = cases[0].excitations.iter().flat_map(|e| e.signal.sines());
            all.map(|sine| [sine.frequency_hz, sine.amplitude, sine.phase_rad]).collect()
        };
        let pairs = sines(&volts).into_iter().zip(sines(&own));
        assert!(pairs.clone().count() > 50);
        for (a, b) in pairs {
            assert_eq!([a[0], a[2]], [b[0], b[2]]);
            assert!((a[1] - b[1]).abs() < 1e-12 * a[1], "{} {}", a[1], b[1]);
        }
    }
}

#[test]
fn places_beyond_the_travel_are_refused_and_those_at_its_ends_are_moved_with_a_word() {
    let axes = axes();
    let at = |elevation: &str, background: &str| {
        let mut text = procedure(MULTISINE, background).source.text;
        text = text.replace("[\"20 deg\"]", elevation);
        Procedure::parse(SourceFile { name: "t.toml".to_owned(), text }).expect("a procedure")
    };
    let refused =
        |procedure: &Procedure| procedure.plan(&axes, &[]).expect_err("no such place")[0].message.clone();
    assert_eq!(
        refused(&at("[\"300 deg\"]", SLIDING)),
        "elevation 300 deg is outside the travel -160 deg .. 160 deg of axis `el`"
    );
    let wide = SLIDING.replace("2.5 deg", "60 deg");
    assert!(
        refused(&at("[\"20 deg\"]", &wide))
            .starts_with("half-width 60 deg is more than half of what axis `el` has")
    );
    let end = at("[\"20 deg\", \"89 deg\"]", SLIDING);
    assert_eq!(end.plan(&axes, &[]).expect("a plan").len(), 2);
    assert_eq!(
        end.experiment.cuts("el", &axes),
        ["elevation 89 deg is measured at 87 deg, inside the soft limits"]
    );
}

#[test]
fn lines_keep_away_from_the_first_four_orders_of_cogging() {
    let case = &procedure(MULTISINE, SLIDING).plan(&axes(), &[]).expect("a plan")[0];
    let cogging_hz = 108.0 * 0.05 / TAU;
    for line in case.excitations.iter().flat_map(|e| e.signal.sines()) {
        for order in 1..=4 {
            let away = (line.frequency_hz - f64::from(order) * cogging_hz).abs();
            assert!(away > 0.3, "{} Hz", line.frequency_hz);
        }
    }
}

#[test]
fn a_reversal_a_gap_and_the_torque_limit_cost_their_windows_only() {
    let procedure = procedure(MULTISINE, SLIDING);
    let spoil = |window: &mut Window| {
        let rows = &mut window.topics[0];
        let row = |s: f64| (s * RATE_HZ) as usize;
        rows.columns[4][row(9.0)] = 0.0;
        rows.columns[2][row(20.0)] = 1882.0;
        rows.time_s[row(30.0)..].iter_mut().for_each(|t| *t += 0.01);
    };
    let result = judge(&procedure, spoil, 1);
    assert!(of(&result, "velocity-bandwidth").value.is_some());
    assert!(!result.excluded.is_empty(), "what was left out is said");
}

#[test]
fn bad_records_give_a_reason_and_never_a_number() {
    type Spoil = fn(&mut Window);
    let table: [(&str, Spoil, &str); 5] = [
        ("not a number", |w| w.topics[0].columns[4][5000] = f64::NAN, "not a number in row 5000"),
        ("constant", |w| w.topics[0].columns[4].iter_mut().for_each(|v| *v = 0.01), "same value"),
        ("no excitation", |w| w.topics[0].columns[5].iter_mut().for_each(|v| *v = 0.0), "same value"),
        (
            "missing channel",
            |w| w.topics[0].topic.channels[5].name = "something".to_owned(),
            "no channel excitation",
        ),
        (
            "too short",
            |w| {
                let rows = &mut w.topics[0];
                rows.time_s.truncate(4000);
                rows.columns.iter_mut().for_each(|c| c.truncate(4000));
            },
            "fewer than two windows",
        ),
    ];
    let procedure = procedure(MULTISINE, SLIDING);
    for (name, spoil, expected) in table {
        let result = judge(&procedure, spoil, 1);
        for m in &result.measurements {
            let reason = m.inconclusive.as_deref().unwrap_or_default();
            assert!(m.value.is_none() && reason.contains(expected), "{name}: {} {reason}", m.measurand);
        }
    }
}
