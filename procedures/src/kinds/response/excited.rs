//! An axis that is excited while it slides: plan and record, shared by the kinds that read responses from it.
//!
//! Friction decides what a response shows: from rest the contact is a spring, while sliding it is a small damper
//! (director.md, section 8). So the axis goes back and forth, and the excitation never reverses it.

#![allow(clippy::result_large_err, reason = "a plan is refused once, before anything runs")]

use analysis::excitation::{Kind, Law, Sweep, expected_peak_error};

use crate::axis::Axes;
use crate::case::Case;
use crate::excitation::Injection;
use crate::kinds::position::positioned::Elevation;
use crate::log::Window;
use crate::measurement::{Condition, Evidence};
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, ResponseReason};
use crate::table::{Field, Shape, TableReader};

mod course;
mod level;
mod plan;
mod record;
mod windows;

pub(in crate::kinds) use course::Course;
pub(in crate::kinds) use level::{LEVEL, Level};
pub(in crate::kinds) use plan::{ELEVATION, GAINS, moved, plan};
pub(in crate::kinds) use record::{Channel, Record};
pub(in crate::kinds) use windows::{Measured, measure};

/// Keys of the table `[excitation]`.
pub(in crate::kinds) const EXCITATION: &[Field] = &[
    Field::default(
        "into",
        Shape::Choice(&["velocity", "torque"]),
        "velocity",
        "Injection point of the signal: the command of the velocity loop, or its torque.",
    ),
    Field::default(
        "signal",
        Shape::Choice(&["multisine", "sweep", "stepped"]),
        "multisine",
        "Type of signal: all lines at once; a sine that sweeps through the band in each window; or one \
         sine after the other.",
    ),
    Field::default(
        "grid",
        Shape::Choice(&["full", "odd", "odd-random"]),
        "full",
        "Harmonics of a multisine; distortion shows in those left out.",
    ),
    Field::default(
        "phases",
        Shape::Choice(&["random", "compressed"]),
        "random",
        "Phases of a multisine: drawn at random for each realisation, or optimised for the smallest peak.",
    ),
    Field::default(
        "level",
        Shape::QuantitiesOf(&[Q::Voltage, Q::AngularVelocity, Q::Current]),
        "4 V",
        "Levels of the signal, peak to peak, one point each. A rate is added to the velocity command, a motor current to \
         the torque. 1 V of the analog reference input is 1 deg/s or 1 A.",
    ),
    Field::required("from", Shape::Quantity(Q::Frequency), "Lowest line."),
    Field::required("to", Shape::Quantity(Q::Frequency), "Highest line, at most 0.4 of the loop rate."),
    Field::optional(
        "lines",
        Shape::Integer,
        "Approximate number of lines, log-spaced; default: every line of the grid.",
    ),
    Field::optional(
        "window",
        Shape::Quantity(Q::Time),
        "Longest window that is evaluated; the spacing of the lines is at least half of its inverse.",
    ),
    Field::default(
        "realisations",
        Shape::Integer,
        "4",
        "Number of signals with different phases; every second one has its lines between those of the one before.",
    ),
    Field::default(
        "duration",
        Shape::Quantity(Q::Time),
        "110 s",
        "Duration of a point, including approaches.",
    ),
    Field::optional(
        "gain-ratio",
        Shape::Quantities(Q::Ratio),
        "Gains of the velocity loop during the excitation, relative to the production gains, one point \
         each; 0 opens the loop.",
    ),
];

/// Keys of the table `[background]`.
pub(in crate::kinds) const BACKGROUND: &[Field] = &[
    Field::required(
        "velocity",
        Shape::Quantity(Q::AngularVelocity),
        "Rate at which the axis slides meanwhile; 0 excites it from rest. It is raised for a level that \
         would reverse the motion.",
    ),
    Field::required(
        "sliding-from",
        Shape::Quantity(Q::AngularVelocity),
        "Mean rate from which the axis counts as sliding (0.20 rad/s azimuth, 0.03 rad/s elevation).",
    ),
    Field::required("half-width", Shape::Quantity(Q::Angle), "Half width of the strokes about their middle."),
    Field::default(
        "by",
        Shape::Choice(&["axis", "target"]),
        "axis",
        "Source of the sliding motion: strokes of the position loop, or tracking of a sweeping target.",
    ),
    Field::default(
        "turn",
        Shape::Quantity(Q::Time),
        "8 s",
        "Time in which a target reverses; long enough for it to stay in the field of the coarse camera.",
    ),
    Field::default(
        "middle",
        Shape::Quantity(Q::Angle),
        "0 deg",
        "Middle of the strokes of azimuth; those of elevation are centred on the elevation of the point.",
    ),
];

/// Form of the signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::kinds) enum Form {
    /// A multisine on these harmonics; whether its phases are compressed.
    Multisine { grid: Kind, compressed: bool },
    /// A sweep through the band in each window.
    Sweep,
    /// One sine after the other.
    Stepped,
}

/// What it says, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::kinds) struct Excited {
    pub(in crate::kinds) elevations_rad: Vec<f64>,
    pub(in crate::kinds) into: Injection,
    pub(in crate::kinds) form: Form,
    pub(in crate::kinds) levels: Vec<Level>,
    pub(in crate::kinds) band_hz: [f64; 2],
    pub(in crate::kinds) lines: Option<u32>,
    pub(in crate::kinds) window_s: Option<f64>,
    pub(in crate::kinds) realisations: u32,
    pub(in crate::kinds) duration_s: f64,
    /// Of a point; the first of [`Self::gain_ratios`] in what was read.
    pub(in crate::kinds) gain_ratio: Option<f64>,
    pub(in crate::kinds) gain_ratios: Vec<f64>,
    pub(in crate::kinds) background: Background,
}

/// How the axis slides meanwhile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::kinds) struct Background {
    pub(in crate::kinds) velocity_rad_per_s: f64,
    pub(in crate::kinds) sliding_from_rad_per_s: f64,
    pub(in crate::kinds) half_width_rad: f64,
    pub(in crate::kinds) middle_rad: f64,
    /// Time of a turn-round where a target makes the axis slide.
    pub(in crate::kinds) target_turn_s: Option<f64>,
}

/// What a realisation counts for: it has a signal and strokes of its own.
const SIGNAL_STEPS: usize = 10;

impl Excited {
    /// A target needs a rate; behind it only the command of the velocity loop can be excited, at its usual gains.
    fn check_target(&self, table: &mut TableReader<'_>) {
        if self.background.target_turn_s.is_none() {
            return;
        }
        let wrong = [
            (self.background.velocity_rad_per_s == 0.0, "give the target a `velocity`"),
            (self.into != Injection::Velocity, "add the signal `into = \"velocity\"`"),
            (self.gain_ratio.is_some(), "leave out `gain-ratio`"),
            (!matches!(self.form, Form::Multisine { .. }), "use a multisine"),
        ];
        for (_, help) in wrong.into_iter().filter(|(wrong, _)| *wrong) {
            table.mistake("background", "not possible while a target is tracked", Some(help.to_owned()));
        }
    }

    /// Reads `elevation`, `[excitation]` and `[background]`; mistakes stay in the reader.
    pub(in crate::kinds) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let elevations_rad = table.quantities("elevation");
        let background = table.table("background", background);
        let unplaced = table.table("excitation", excitation);
        let all = Self { elevations_rad: elevations_rad?, background: background?, ..unplaced? };
        let signals = all.realisations as usize * all.gain_ratios.len().max(1);
        table.check_steps("excitation", &[all.elevations_rad.len(), all.levels.len(), signals, SIGNAL_STEPS]);
        all.check_target(table);
        Some(all)
    }
}

fn excitation(t: &mut TableReader<'_>) -> Option<Excited> {
    let into = t.text("into");
    let form = form(t);
    let levels = t.quantities_of("level");
    let from_hz = t.positive("from");
    let to_hz = t.positive("to");
    let lines = if t.has("lines") { Some(t.count("lines", 5)?) } else { None };
    let window_s = if t.has("window") { Some(t.positive("window")?) } else { None };
    let realisations = t.count("realisations", 1);
    let duration_s = t.positive("duration");
    let gain_ratios = if t.has("gain-ratio") { t.quantities("gain-ratio")? } else { Vec::new() };
    if gain_ratios.iter().any(|ratio| !(0.0..=1.0).contains(ratio)) {
        t.mistake(
            "gain-ratio",
            "`gain-ratio` is relative to the production gains",
            Some("0 to 1".to_owned()),
        );
    }
    if let (Some(from), Some(to)) = (from_hz, to_hz)
        && from >= to
    {
        t.mistake("to", "the highest line is below the lowest", Some("`from` below `to`".to_owned()));
    }
    let into = if into? == "torque" { Injection::Torque } else { Injection::Velocity };
    let levels = levels?.into_iter().map(|(kind, value)| Level { kind, value }).collect::<Vec<_>>();
    level::check(t, &levels, into);
    Some(Excited {
        elevations_rad: Vec::new(),
        into,
        form: form?,
        levels,
        band_hz: [from_hz?, to_hz?],
        lines,
        window_s,
        realisations: realisations?,
        duration_s: duration_s?,
        gain_ratio: gain_ratios.first().copied(),
        gain_ratios,
        background: Background {
            velocity_rad_per_s: 0.0,
            sliding_from_rad_per_s: 0.0,
            half_width_rad: 0.0,
            middle_rad: 0.0,
            target_turn_s: None,
        },
    })
}

fn form(t: &mut TableReader<'_>) -> Option<Form> {
    let signal = t.text("signal");
    let grid = t.text("grid");
    let phases = t.text("phases");
    let grid = match grid?.as_str() {
        "odd" => Kind::Odd,
        "odd-random" => Kind::OddRandom,
        _ => Kind::Full,
    };
    let compressed = phases? == "compressed";
    Some(match signal?.as_str() {
        "sweep" => Form::Sweep,
        "stepped" => Form::Stepped,
        _ => Form::Multisine { grid, compressed },
    })
}

fn background(t: &mut TableReader<'_>) -> Option<Background> {
    let velocity = t.quantity("velocity");
    let sliding = t.quantity("sliding-from");
    let half_width = t.positive("half-width");
    let middle = t.quantity("middle");
    let by = t.text("by");
    let turn_s = t.positive("turn");
    Some(Background {
        velocity_rad_per_s: velocity?.abs(),
        sliding_from_rad_per_s: sliding?.abs(),
        half_width_rad: half_width?,
        middle_rad: middle?,
        target_turn_s: turn_s.filter(|_| by.as_deref() == Some("target")),
    })
}

/// Damping of the lightest modes of the structure.
const LIGHT_DAMPING: f64 = 0.03;

/// Background, windows and cogging for each level, and what a sweep's rate would do to a tracking filter.
pub(in crate::kinds) fn notes(keys: &Excited, axis: &str, axes: &Axes) -> Vec<String> {
    let Some(limits) = axes.get(axis) else { return Vec::new() };
    let mut all = Vec::new();
    for level in &keys.levels {
        let middle = match Elevation::of(axis, axes).is_own() {
            true => keys.elevations_rad.first().copied().unwrap_or(0.0),
            false => keys.background.middle_rad,
        };
        let Ok(course) = Course::new(keys, limits, middle, level) else { continue };
        let window = Q::Time.format(course.window_s);
        if course.velocity_rad_per_s == 0.0 {
            all.push(format!("{level}: from rest, windows of {window}"));
            continue;
        }
        let cogging: Vec<String> = course.cogging_hz(limits).iter().map(|hz| format!("{hz:.2}")).collect();
        if keys.background.target_turn_s.is_some() {
            all.push(format!(
                "{level}: follows a target that sweeps by {} about its middle, {:.1} s between reversals",
                Q::Angle.format(0.5 * (course.ends_rad[1] - course.ends_rad[0])),
                course.stroke_s
            ));
        }
        all.push(format!(
            "{level}: slides at {:.3} rad/s, windows of {window}; cogging at {} Hz, no lines within 0.3 Hz of it",
            course.velocity_rad_per_s,
            cogging.join(", ")
        ));
        all.extend((keys.form == Form::Sweep).then(|| sweep(keys, &course)));
    }
    all
}

/// ISO 7626-2 against the sweep where it is worst, at its lowest frequency, and what that does here.
fn sweep(keys: &Excited, course: &Course) -> String {
    let [from_hz, to_hz] = keys.band_hz;
    let duration_s = course.window_s;
    let law = Law::Logarithmic;
    let amplitude = 1.0;
    let sweep = Sweep { from_hz, to_hz, duration_s, law, amplitude };
    let lowest_hz = from_hz.min(to_hz);
    let eta = sweep.eta(LIGHT_DAMPING, lowest_hz);
    let verdict = match sweep.within_iso_limit(LIGHT_DAMPING, lowest_hz) {
        true => "within",
        false => "faster than",
    };
    let error = match expected_peak_error(eta) {
        Some(ratio) => format!("{:+.1} %", 100.0 * ratio),
        None => "more than -10 %".to_owned(),
    };
    format!(
        "sweep of {lowest_hz:.1} Hz at damping {LIGHT_DAMPING}: {verdict} ISO 7626-2 (eta {eta:.2}); a \
         tracking filter would misread its peak by {error}, so whole windows are evaluated instead"
    )
}

/// A point whose elevation is off by more than this, beyond its strokes, says nothing of the one that was asked for.
const ELSEWHERE_RAD: f64 = 1.0 * std::f64::consts::PI / 180.0;

/// What a record of a point holds before any response is computed of it.
#[derive(Clone, Debug)]
pub(in crate::kinds) struct Reading {
    pub(in crate::kinds) measured: Measured,
    /// Mean over time; `None` where the log does not say.
    pub(in crate::kinds) elevation_rad: Option<f64>,
    pub(in crate::kinds) evidence: Vec<Evidence>,
}

/// Reads a point.
pub(in crate::kinds) fn read(
    keys: &Excited,
    case: &Case,
    window: &Window,
    axes: &Axes,
) -> Result<Reading, Reason> {
    let axis = case.axis.as_str();
    let limits = axes.limits(axis)?;
    let record = Record::new(axis, window, axes)?;
    let elevation = Elevation::of(axis, axes);
    // Middle of the strokes that were planned.
    let middle_rad = match elevation.is_own() {
        true => case.requested(ELEVATION).unwrap_or(0.0),
        false => keys.background.middle_rad,
    };
    let level = Level::requested(case).ok_or(ResponseReason::NoLevel)?;
    let course =
        Course::new(keys, limits, middle_rad, &level).map_err(|d| ResponseReason::Refused(d.message))?;
    let measured = measure(keys, case, window, &record, &course, limits)?;
    let elevation_rad = match elevation {
        Elevation::Own(_) => Some(measured.angle_rad[2]),
        Elevation::Carried(held) => window
            .rows(&format!("/{}", held.name))
            .and_then(|rows| rows.column("position_rad"))
            .map(windows::mean),
        Elevation::Nobody => None,
    };
    let asked = case.requested(ELEVATION);
    let reached = elevation_rad;
    if let Some((asked, reached)) = asked.zip(reached)
        && (reached - asked).abs() > keys.background.half_width_rad + ELSEWHERE_RAD
    {
        return Err(ResponseReason::Elsewhere { reached_rad: reached, asked_rad: asked }.into());
    }
    Ok(Reading { measured, elevation_rad, evidence: record.evidence() })
}

/// The conditions that were asked for, with what was reached of them.
pub(in crate::kinds) fn conditions(
    case: &Case,
    elevation_rad: Option<f64>,
    measured: Option<&Measured>,
) -> Vec<Condition> {
    Condition::reached(case, |request| match request.name.as_str() {
        ELEVATION => elevation_rad,
        LEVEL => measured.map(|measured| request.value * measured.reached_ratio),
        // The bench sets them.
        _ => Some(request.value),
    })
}
