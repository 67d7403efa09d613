//! Behind a target that sweeps: the track loop that is read is the one that was closed.

use super::*;
use crate::target::{Target, TargetCourse};

const GAIN_PER_S: f64 = 5.51;
const INTEGRAL_S: f64 = 0.543;

fn track_procedure(level: &str, background: &str) -> Result<Procedure, Vec<crate::diagnostic::Diagnostic>> {
    let text = format!(
        "schema = 1\nid = \"T\"\ntitle = \"t\"\nkind = \"frequency-response\"\naxis = \"el\"\n\
         elevation = [\"40 deg\"]\nresponses = [\"track-loop\"]\n\
         [excitation]\nlevel = [\"{level}\"]\nfrom = \"0.5 Hz\"\nto = \"60 Hz\"\nlines = 60\nwindow = \"2 s\"\n\
         realisations = 2\nduration = \"90 s\"\n\
         [background]\nsliding-from = \"0.03 rad/s\"\nhalf-width = \"42 deg\"\n{background}\n"
    );
    Procedure::parse(SourceFile { name: "t.toml".to_owned(), text })
}

const TARGET: &str = "by = \"target\"\nvelocity = \"0.10 rad/s\"\nturn = \"5 s\"";

/// Open track loop, exact: `Kt·(1 + Ts/Tt·z/(z − 1))·Ts·z/(z − 1)` around the closed velocity loop.
fn open_track_loop(hz: f64) -> C64 {
    let z = C64::from_polar(1.0, TAU * hz / RATE_HZ);
    let sum = z / (z - 1.0) / RATE_HZ;
    let velocity = open_loop(hz) / (open_loop(hz) + 1.0);
    GAIN_PER_S * (sum / INTEGRAL_S + 1.0) * sum * velocity
}

/// Rate of the target: constant, with turn-rounds of constant acceleration, from the middle of its sweep on.
fn target_rate(target: &Target, t_s: f64) -> f64 {
    let TargetCourse::Sweep { elevation_rad_per_s: rate, leg_s, turn_s, .. } = target.course else {
        panic!("a sweep is planned");
    };
    let ramp_s = 0.5 * turn_s;
    let t_s = t_s - target.stands_s;
    let first_s = 0.5 * (leg_s + ramp_s);
    let (leg, since_s) = if t_s < first_s {
        (0.0, t_s)
    } else {
        let legs = (t_s - first_s) / leg_s;
        (1.0 + legs.floor(), legs.fract() * leg_s)
    };
    let lasts_s = if leg == 0.0 { first_s } else { leg_s };
    let share = (since_s / ramp_s).min((lasts_s - since_s) / ramp_s).clamp(0.0, 1.0);
    if leg % 2.0 == 0.0 { rate * share } else { -rate * share }
}

/// The record of a case whose axis tracks; `acquired` ends the wait for the target.
fn tracked(case: &Case, acquired: bool, seed: u64) -> Window {
    let mut plant = Plant::new(seed);
    let target = case.target.expect("a target is planned");
    plant.angle = target.elevation_rad;
    let mut velocity_integral = 0.0;
    let mut line_of_sight = 0.0;
    let mut integral = 0.0;
    let mut columns = vec![Vec::new(); 7];
    let mut time_s = Vec::new();
    let mut segments = Vec::new();
    let mut target_rad = 0.0;
    let mut began = vec![None; case.excitations.len()];
    for (index, segment) in case.segments.iter().enumerate() {
        let start = time_s.len();
        let lasts_s =
            if segment.mode == Mode::Track && segment.until.is_some() { 1.0 } else { segment.at_most_s };
        for k in 0..(lasts_s * RATE_HZ).round() as usize {
            let t_s = (start + k) as f64 / RATE_HZ;
            let excitation = segment.excited.map_or(0.0, |e| {
                let began = *began[e].get_or_insert(start);
                case.excitations[e].at((start + k - began) as f64 / RATE_HZ)
            });
            let rate = plant.sensed();
            line_of_sight += rate / RATE_HZ;
            target_rad += target_rate(&target, t_s) / RATE_HZ;
            let error = target_rad - line_of_sight;
            let tracks = segment.mode == Mode::Track;
            integral += if tracks { error / RATE_HZ / INTEGRAL_S } else { 0.0 };
            let asked = if tracks { GAIN_PER_S * (error + integral) } else { 0.0 };
            let command = asked + excitation;
            velocity_integral += KI / RATE_HZ * (command - rate);
            let torque = KP * (command - rate) + velocity_integral;
            time_s.push(1.0 + t_s);
            let row = [plant.angle, torque / 52.0, torque, asked, command, rate, excitation];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            plant.step(torque);
        }
        let by = if segment.until.is_some() { EndedBy::Condition } else { EndedBy::Completed };
        let ended_by = if acquired || segment.until.is_none() { by } else { EndedBy::Timeout };
        let start_s = 1.0 + start as f64 / RATE_HZ;
        let end_s = 1.0 + time_s.len() as f64 / RATE_HZ;
        let start_position_rad = plant.angle;
        segments.push(SegmentSpan { segment: index, start_s, end_s, start_position_rad, ended_by });
        if ended_by == EndedBy::Timeout {
            break;
        }
    }
    let names = [
        "position_rad",
        "current_a",
        "torque_command_nm",
        "velocity_setpoint_rad_per_s",
        "velocity_command_rad_per_s",
        "velocity_feedback_rad_per_s",
        "excitation",
    ];
    let rows = synthetic::rows("/el", &time_s, names.into_iter().zip(columns).collect());
    Window::completed(vec![rows], segments)
}

fn judged(acquired: bool, seed: u64) -> PointResult {
    let procedure = track_procedure("4 V", TARGET).expect("a procedure");
    let axes = axes();
    let case = &procedure.plan(&axes, &[]).expect("a plan")[0];
    procedure.analyse(case, &tracked(case, acquired, seed), &axes, RATE_HZ)
}

#[test]
fn margins_behind_a_sweeping_target_are_those_of_the_track_loop() {
    let result = judged(true, 3);
    let mut low = 0.5;
    let mut high = 3.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if open_track_loop(middle).norm() > 1.0 { low = middle } else { high = middle }
    }
    let phase = PI + open_track_loop(low).arg();
    let bandwidth = of(&result, "track-bandwidth");
    let found = bandwidth.value.unwrap_or_else(|| panic!("{:?}", bandwidth.inconclusive));
    assert!((found - low).abs() < 0.005, "{found} ± {}, truth {low}", bandwidth.u);
    assert!((found - low).abs() < 4.0 * bandwidth.u, "{found} ± {}, truth {low}", bandwidth.u);
    let margin = of(&result, "track-phase-margin").value.expect("it crosses 0 dB");
    assert!((margin - phase).abs() < 0.5_f64.to_radians(), "{margin} against {phase}");
    assert!(of(&result, "track-gain-margin").value.is_some());
    assert!(bandwidth.flags.iter().any(|f| f.starts_with("sliding")), "{:?}", bandwidth.flags);
}

#[test]
fn a_target_that_is_never_acquired_is_said_to_be_so() {
    let result = judged(false, 3);
    let reason = of(&result, "track-bandwidth").inconclusive.clone().expect("no windows");
    assert!(reason.starts_with("target never acquired"), "{reason}");
}

/// The bench must know how far the axis may go: the plan holds target and bounds.
#[test]
fn a_plan_behind_a_target_brings_it_and_bounds_the_axis() {
    let procedure = track_procedure("4 V", TARGET).expect("a procedure");
    let axes = axes();
    let case = &procedure.plan(&axes, &[]).expect("a plan")[0];
    let bounds = case.bounds.expect("bounds");
    let target = case.target.expect("a target");
    assert!((target.elevation_rad.to_degrees() - 40.0).abs() < 0.5 && target.azimuth_rad == 0.0);
    assert!((bounds.displacement_rad.to_degrees() - 45.0).abs() < 0.5, "{bounds:?}");
    assert!(bounds.speed_rad_per_s < 0.3 && case.is_tracked("el") && !case.is_tracked("az"));
    assert!((case.start_pose_rad["el"].to_degrees() - 39.0).abs() < 0.5);
}

#[test]
fn what_cannot_be_done_behind_a_target_is_refused() {
    let level = track_procedure("12 V", TARGET).expect("it parses").plan(&axes(), &[]).expect_err("too much");
    assert!(level[0].message.contains("would reverse the axis"), "{}", level[0].message);
    let still = track_procedure("4 V", "by = \"target\"\nvelocity = \"0 rad/s\"").expect_err("no rate");
    assert!(still[0].message.contains("while a target is tracked"), "{}", still[0].message);
    let none = track_procedure("4 V", "velocity = \"0.1 rad/s\"").expect_err("no target");
    assert!(none[0].message.contains("while a target is tracked"), "{}", none[0].message);
}
