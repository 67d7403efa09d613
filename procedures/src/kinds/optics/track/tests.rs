//! Records of trackers with known truth.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;
use crate::case::{Mode, Tracks};
use crate::diagnostic::SourceFile;
use crate::log::{EndedBy, PointStatus, Rows, SegmentSpan};
use crate::measurement::Measurement;
use crate::procedure::Procedure;
use crate::synthetic::{azimuth_and_elevation as axes, rows};

mod files;

const DEG: f64 = std::f64::consts::PI / 180.0;
/// First lock on the log's time axis.
const LOCK_S: f64 = 7.0;
const SETTLE_S: f64 = 2.0;
const ELEVATION_RAD: f64 = 45.0 * DEG;

fn procedure(loops: &str, more: &str) -> Result<Procedure, Vec<Diagnostic>> {
    let text = format!(
        "schema = 1\nid = \"T\"\ntitle = \"t\"\nkind = \"track\"\naxis = \"az\"\ntarget = \"rail\"\nloops = [\"{loops}\"]\n\
         elevation = [\"45 deg\"]\nspan = \"-2 deg .. 26 deg\"\nsettle = \"2 s\"\nduration = \"60 s\"\n\
         window-threshold = \"0.015 rad/s^2\"\n{more}\n"
    );
    Procedure::parse(SourceFile { name: "t.toml".to_owned(), text })
}

type Errors = Box<dyn Fn(f64) -> [f64; 2]>;

/// What really happens; times since the first lock.
struct Truth {
    azimuth_rad: fn(f64) -> f64,
    /// Smooth errors of the gimbal, across elevation and in elevation.
    coarse_rad: Errors,
    fine_rad: Errors,
    shows: fn(f64) -> bool,
    saturated: fn(f64) -> bool,
    /// End of the track.
    lasts_s: f64,
}

/// Forty tones between 1 and 9 rad/s, 1 RMS: nothing that repeats within a minute.
fn tones(t: f64) -> f64 {
    let tone = |k: u32| {
        let k = f64::from(k);
        ((1.0 + 0.2 * k + 0.05 * k.sin()) * t + 2.4 * k * k).sin()
    };
    (0..40).map(tone).sum::<f64>() * (2.0_f64 / 40.0).sqrt()
}

/// 0.674 deg/s; 50 and 25 µrad RMS coarse, 2 and 1 µrad fine.
fn steady() -> Truth {
    Truth {
        azimuth_rad: |t| 0.0118 * t,
        coarse_rad: Box::new(|t| [50e-6 * tones(t), 25e-6 * tones(t + 500.0)]),
        fine_rad: Box::new(|t| [2e-6 * tones(8.0 * t), 1e-6 * tones(8.0 * t + 500.0)]),
        shows: |_| true,
        saturated: |_| false,
        lasts_s: SETTLE_S + 60.0,
    }
}

/// Root mean square over the record of what went in.
fn rms_of(truth: &Errors, axis: usize) -> f64 {
    let values: Vec<f64> = (0..12_000).map(|k| truth(SETTLE_S + 5e-3 * f64::from(k))[axis]).collect();
    (values.iter().map(|v| v * v).sum::<f64>() / 12_000.0).sqrt()
}

/// 500 rows a second; frames every `period_ms` that come `latency_ms` later, with 3 µrad of white noise in coarse ones.
fn tracker(name: &str, truth: &Truth, [period_ms, latency_ms]: [i64; 2]) -> Rows {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut noise =
        || 3e-6 * 12.0_f64.sqrt() * ((random.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 0.5);
    let coarse = name == "/coarse";
    let mut columns: [Vec<f64>; 6] = Default::default();
    let mut time_s = Vec::new();
    let mut last = -1;
    let mut values = [0.0; 3];
    for k in 0..((truth.lasts_s + 1.0) * 500.0) as i64 {
        let frame = (2 * k - latency_ms).div_euclid(period_ms);
        let exposed_s = (frame * period_ms) as f64 * 1e-3;
        if frame != last {
            last = frame;
            let shows = (truth.shows)(exposed_s);
            let error = if coarse { (truth.coarse_rad)(exposed_s) } else { (truth.fine_rad)(exposed_s) };
            let lock = if shows { 2.0 } else { 0.0 };
            let jitter = if coarse { [noise(), noise()] } else { [0.0; 2] };
            values = [error[0] + jitter[0], error[1] + jitter[1], lock];
        }
        let t_s = 2e-3 * k as f64;
        time_s.push(LOCK_S + t_s);
        let row = [values[0], values[1], t_s - exposed_s, (frame + 100) as f64, values[2], 0.0];
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
    }
    let names = ["cross_elevation_rad", "elevation_rad", "age_s", "counter", "lock", "lost_frames"];
    rows(name, &time_s, names.into_iter().zip(columns).collect())
}

fn window(truth: &Truth) -> Window {
    let time: Vec<f64> =
        (0..((truth.lasts_s + 1.0) * 500.0) as u32).map(|k| 2e-3 * f64::from(k) - 0.1).collect();
    let on_log: Vec<f64> = time.iter().map(|t| LOCK_S + t).collect();
    let az = time.iter().map(|&t| (truth.azimuth_rad)(t) - (truth.coarse_rad)(t)[0] / ELEVATION_RAD.cos());
    let el = time.iter().map(|&t| ELEVATION_RAD - (truth.coarse_rad)(t)[1]);
    let stroke = time.iter().map(|&t| f64::from(u8::from((truth.saturated)(t)))).collect::<Vec<f64>>();
    let span = |segment, start: f64, end: f64, ended_by| SegmentSpan {
        segment,
        start_s: LOCK_S + start,
        end_s: LOCK_S + end,
        start_position_rad: 0.0,
        ended_by,
    };
    let segments = vec![
        span(0, -3.0, -1.0, EndedBy::Completed),
        span(1, -1.0, 0.0, EndedBy::Condition),
        span(2, 0.0, SETTLE_S, EndedBy::Completed),
        span(3, SETTLE_S, truth.lasts_s, EndedBy::Completed),
    ];
    let topics = vec![
        rows("/az", &on_log, vec![("position_rad", az.collect())]),
        rows("/el", &on_log, vec![("position_rad", el.collect())]),
        tracker("/coarse", truth, [20, 40]),
        tracker("/fine", truth, [5, 8]),
        rows("/track", &on_log, vec![("az_saturated", stroke.clone()), ("el_saturated", stroke)]),
    ];
    Window::completed(topics, segments)
}

fn judged(loops: &str, window: &Window) -> Vec<Measurement> {
    let procedure = procedure(loops, "").expect("a procedure");
    let axes = axes();
    let case = procedure.plan(&axes, &[]).expect("a plan").remove(0);
    procedure.analyse(&case, window, &axes, 4000.0).measurements
}

fn found<'a>(all: &'a [Measurement], name: &str, axis: &str) -> &'a Measurement {
    let is = |m: &&Measurement| m.measurand == name && m.axis == axis;
    all.iter().find(is).unwrap_or_else(|| panic!("no {name} of {axis}"))
}

fn near(all: &[Measurement], name: &str, axis: &str, expected: f64, within: f64) {
    let m = found(all, name, axis);
    let value = m.value.unwrap_or_else(|| panic!("{name}: {:?}", m.inconclusive));
    assert!((value - expected).abs() <= within, "{name} {axis}: {value:e}, expected {expected:e}");
}

fn reason<'a>(all: &'a [Measurement], name: &str, axis: &str) -> &'a str {
    found(all, name, axis).inconclusive.as_deref().unwrap_or("conclusive")
}

#[test]
fn errors_of_both_axes_are_what_went_in_across_the_elevation_axis() {
    let truth = steady();
    let all = judged("both", &window(&steady()));
    let noisy = |axis: usize| rms_of(&truth.coarse_rad, axis).hypot(3e-6);
    near(&all, "coarse-track-rms", "az", noisy(0), 0.5e-6);
    near(&all, "coarse-track-rms", "el", noisy(1), 0.5e-6);
    near(&all, "coarse-track-left-out", "az", 0.0, 0.0);
    near(&all, "fine-track-rms", "az", rms_of(&truth.fine_rad, 0), 0.02e-6);
    near(&all, "fine-track-rms", "el", rms_of(&truth.fine_rad, 1), 0.02e-6);
    near(&all, "fine-dwell", "az", 62.0, 0.1);
    let rms = found(&all, "coarse-track-rms", "az");
    let of_azimuth = format!(
        "in cross-elevation; {:.2} urad in azimuth",
        1e6 * 2.0_f64.sqrt() * rms.value.expect("a number")
    );
    assert!(rms.flags.contains(&of_azimuth), "{:?}", rms.flags);
    // 1.3 Hz wide for a minute: some 80 independent squares.
    assert!(rms.u > 1e-6 && rms.u < 8e-6, "{}", rms.u);
    assert!(reason(&all, "target-losses", "az").contains("was not tested"));
}

#[test]
fn the_elevation_of_a_track_is_where_the_log_has_it() {
    let mut window = window(&steady());
    let el = window.topics.iter_mut().find(|rows| rows.topic.name == "/el").expect("logged");
    // Later the target takes the axis elsewhere.
    let shift_rad = |t: f64| if t < LOCK_S { 0.05 } else { 0.3 };
    el.columns[0].iter_mut().zip(&el.time_s).for_each(|(rad, t)| *rad += shift_rad(*t));
    for m in judged("both", &window) {
        let elevation_rad = m.conditions[0].achieved.expect("the log holds it");
        assert!((elevation_rad - ELEVATION_RAD - 0.05).abs() < 1e-3, "{}: {elevation_rad}", m.measurand);
        assert!((m.conditions[0].requested - ELEVATION_RAD).abs() < 1e-3, "{}", m.measurand);
    }
}

/// Out at 0.0118 rad/s, back at the same from 30 s on within 1.8 s: 13 mrad/s² on average.
fn turned(t: f64) -> f64 {
    let v = 0.0118;
    let r = 1.8;
    let s = t - 30.0;
    match s {
        s if s < 0.0 => v * t,
        s if s < r => {
            v * t - 2.0 * v * (0.5 * s * s / r + r * ((std::f64::consts::TAU * s / r).cos() - 1.0) / 39.478)
        }
        s => v * 30.0 + v * s - 2.0 * v * (s - 0.5 * r),
    }
}

fn reversing() -> Truth {
    let swing = |t: f64| if (30.3..31.9).contains(&t) { (1.9635 * (t - 30.3)).sin() } else { 0.0 };
    Truth {
        azimuth_rad: turned,
        coarse_rad: Box::new(move |t| [50e-6 * tones(t) + 1400e-6 * swing(t), 25e-6 * tones(t + 500.0)]),
        ..steady()
    }
}

#[test]
fn a_reversal_opens_a_window_explains_its_peak_and_puts_the_lock_to_the_test() {
    let all = judged("coarse", &window(&reversing()));
    near(&all, "coarse-track-rms", "az", rms_of(&steady().coarse_rad, 0), 2e-6);
    near(&all, "coarse-track-peak", "az", 1400e-6, 150e-6);
    let share = found(&all, "coarse-track-left-out", "az").value.expect("a share");
    assert!(share > 0.025 && share < 0.04, "{share}");
    assert!(found(&all, "coarse-track-rms-whole", "az").value.is_some_and(|v| v > 150e-6));
    let flags = &found(&all, "coarse-track-peak", "az").flags;
    assert!(flags[1].ends_with("reversal") && flags[1].starts_with("1"), "{flags:?}");
    near(&all, "coarse-track-left-out", "el", 0.0, 0.0);
    near(&all, "target-losses", "az", 0.0, 0.0);
    assert_eq!(reason(&all, "target-losses", "az"), "conclusive");
    assert!(all.iter().all(|m| !m.measurand.starts_with("fine")), "the fine loop is open");
}

#[test]
fn more_than_a_twentieth_in_windows_is_no_verdict_but_a_number() {
    let procedure = procedure("coarse", "window-after = \"3 s\"").expect("a procedure");
    let axes = axes();
    let case = procedure.plan(&axes, &[]).expect("a plan").remove(0);
    let all = procedure.analyse(&case, &window(&reversing()), &axes, 4000.0).measurements;
    near(&all, "coarse-track-rms", "az", rms_of(&steady().coarse_rad, 0), 3e-6);
    assert!(reason(&all, "coarse-track-rms", "az").contains("of the record lies in windows, at most 5.0 %"));
    assert_eq!(reason(&all, "coarse-track-rms", "el"), "conclusive");
}

#[test]
fn a_target_that_left_the_field_is_a_loss_and_no_error_although_the_interlock_ended_the_point() {
    let mut lost = window(&Truth { shows: |t| t < 20.0, lasts_s: 20.1, ..steady() });
    lost.status = PointStatus::Aborted;
    lost.trips = vec!["tracker lost: 0.0625 s, limit 0.06 s".to_owned()];
    let all = judged("both", &lost);
    near(&all, "target-losses", "az", 1.0, 0.0);
    assert_eq!(reason(&all, "target-losses", "az"), "conclusive");
    for (name, axis) in [("coarse-track-rms", "az"), ("coarse-track-rms", "el"), ("fine-dwell", "az")] {
        assert!(reason(&all, name, axis).contains("aborted (tracker lost"), "{}", reason(&all, name, axis));
    }
}

#[test]
fn a_point_that_something_else_ended_says_nothing_of_losses() {
    let mut cut = window(&Truth { lasts_s: 20.0, ..steady() });
    cut.status = PointStatus::Aborted;
    cut.trips = vec!["temperature: az: 83.1 degC, limit 83.0 degC".to_owned()];
    assert!(reason(&judged("coarse", &cut), "target-losses", "az").contains("temperature"));
}

#[test]
fn a_single_frame_that_never_came_is_no_loss_and_four_are() {
    let dropping = |from: f64, count: usize| {
        let mut window = window(&reversing());
        let rows = window.topics.iter_mut().find(|r| r.topic.name == "/coarse").expect("a topic");
        // Its rows repeat the frame before, and the driver counts what is missing.
        let first = rows.time_s.partition_point(|&t| t < LOCK_S + from);
        let start = (first..).find(|&k| rows.columns[3][k] != rows.columns[3][k - 1]).expect("a frame");
        let end = start + 10 * count;
        for column in [0, 1, 3, 4] {
            let kept = rows.columns[column][start - 1];
            rows.columns[column][start..end].fill(kept);
        }
        (start..end).for_each(|k| rows.columns[2][k] = rows.columns[2][k - 1] + 2e-3);
        rows.columns[5][end..].iter_mut().for_each(|lost| *lost += count as f64);
        judged("coarse", &window)
    };
    let one = dropping(10.0, 1);
    near(&one, "target-losses", "az", 0.0, 0.0);
    near(&one, "longest-frame-gap", "az", 0.04, 1e-9);
    near(&one, "coarse-track-rms", "az", rms_of(&steady().coarse_rad, 0), 2e-6);
    let share = found(&one, "coarse-frames-missing", "az");
    let made = share.n as f64;
    near(&one, "coarse-frames-missing", "az", 1.0 / made, 1e-12);
    assert!(made > 2900.0 && share.flags == [format!("1 of {made} frames")], "{share:?}");
    near(&dropping(10.0, 4), "target-losses", "az", 1.0, 0.0);
}

#[test]
fn fine_errors_leave_out_what_the_stroke_cannot_reach_and_the_dwell_ends_there() {
    let truth = Truth {
        fine_rad: Box::new(|t| {
            let beyond = if (40.0..41.0).contains(&t) { 300e-6 } else { 0.0 };
            [2e-6 * tones(8.0 * t) + beyond, 1e-6 * tones(8.0 * t + 500.0)]
        }),
        saturated: |t| (40.0..41.0).contains(&t),
        ..steady()
    };
    let all = judged("both", &window(&truth));
    near(&all, "fine-track-rms", "az", rms_of(&steady().fine_rad, 0), 0.05e-6);
    near(&all, "fine-track-left-out", "az", 1.5 / 60.0, 0.002);
    near(&all, "fine-dwell", "az", 40.0, 0.1);
    let flags = &found(&all, "fine-track-peak", "az").flags;
    assert!(flags[0].contains("1 by stroke"), "{flags:?}");
    near(&all, "fine-target-losses", "az", 0.0, 0.0);
}

/// The joints of 7 m rails come every 7 s at 1 m/s; elevation heaves behind the second one and in between.
#[test]
fn a_heave_behind_a_joint_is_told_from_one_between_joints() {
    let truth = Truth {
        azimuth_rad: |t| 0.2436 + ((t - 21.0) / 85.0).atan(),
        coarse_rad: Box::new(|t| {
            let heave = [14.3, 32.5].iter().any(|from| (*from..from + 0.4).contains(&t));
            [20e-6 * tones(t), 20e-6 * tones(t + 500.0) + if heave { 300e-6 } else { 0.0 }]
        }),
        lasts_s: SETTLE_S + 38.0,
        ..steady()
    };
    let rails = "[rails]\ndistance = \"85 m\"\nrail = \"7 m\"\ncount = 6";
    let procedure = procedure("coarse", rails).expect("a procedure");
    let axes = axes();
    let case = procedure.plan(&axes, &[]).expect("a plan").remove(0);
    let all = procedure.analyse(&case, &window(&truth), &axes, 4000.0).measurements;
    let flags = &found(&all, "coarse-track-peak", "el").flags;
    assert!(flags[0].contains("1 by rail joint") && flags[0].contains("1 by unknown"), "{flags:?}");
}

#[test]
fn what_is_missing_or_no_number_is_named() {
    let of = |change: &dyn Fn(&mut Window)| {
        let mut window = window(&reversing());
        change(&mut window);
        let all = judged("coarse", &window);
        assert!(all.iter().all(|m| m.value.is_none()), "{all:?}");
        reason(&all, "coarse-track-rms", "el").to_owned()
    };
    let topic = |w: &Window, name: &str| w.topics.iter().position(|r| r.topic.name == name).expect("a topic");
    assert_eq!(of(&|w| drop(w.topics.remove(topic(w, "/coarse")))), "the log has no topic /coarse");
    assert_eq!(of(&|w| drop(w.topics.remove(topic(w, "/el")))), "the log has no topic /el");
    let k = 2;
    assert!(
        of(&|w| w.topics[k].columns[0][5000] = f64::NAN)
            .contains("cross_elevation_rad contains a value that is not a number")
    );
    // Every other frame is in no row although none was lost on its way.
    assert!(
        of(&|w| w.topics[k].columns[3].iter_mut().for_each(|c| *c *= 2.0)).contains("are not in the log")
    );
    assert!(of(&|w| w.topics[k].columns[4].fill(0.0)).contains("no coarse frame shows the target"));
    let never = of(&|w| {
        w.segments.truncate(2);
        w.segments[1].ended_by = EndedBy::Timeout;
    });
    assert!(never.starts_with("target never acquired"), "{never}");
}

#[test]
fn a_mirror_that_never_comes_to_rest_on_a_target_that_is_there_has_no_dwell() {
    let wild =
        || Truth { fine_rad: Box::new(|t| [60e-6 * tones(8.0 * t), 0.0]), azimuth_rad: |_| 0.0, ..steady() };
    let never = |truth: &Truth| {
        let mut window = window(truth);
        window.segments.truncate(2);
        let acquire = &mut window.segments[1];
        (acquire.start_s, acquire.end_s, acquire.ended_by) = (LOCK_S + 1.0, LOCK_S + 9.0, EndedBy::Timeout);
        judged("both", &window)
    };
    let all = never(&wild());
    near(&all, "fine-dwell", "az", 0.0, 0.0);
    assert_eq!(reason(&all, "fine-dwell", "az"), "conclusive");
    assert!(reason(&all, "coarse-track-rms", "az").contains("/coarse showed it in 400 of 400 frames"));
    // Without a target in sight nothing is known of the mirror.
    let dark = never(&Truth { shows: |t| t < 5.0, ..wild() });
    assert!(reason(&dark, "fine-dwell", "az").starts_with("target never acquired"));
}

#[test]
fn a_standing_target_that_is_lost_while_it_is_acquired_is_a_loss() {
    let mut lost = window(&steady());
    lost.segments.truncate(2);
    lost.segments[1].ended_by = EndedBy::Stopped;
    lost.status = PointStatus::Aborted;
    lost.trips = vec!["tracker lost: 0.0625 s, limit 0.06 s".to_owned()];
    let all = judged("both", &lost);
    near(&all, "target-losses", "az", 1.0, 0.0);
    assert_eq!(reason(&all, "target-losses", "az"), "conclusive");
    assert!(reason(&all, "fine-dwell", "az").contains("aborted (tracker lost"));
    // And one that is lost before a record of frames is there.
    let mut soon = window(&Truth { lasts_s: 0.1, ..steady() });
    soon.segments.truncate(3);
    soon.segments[2].end_s = LOCK_S + 0.1;
    (soon.status, soon.trips) = (PointStatus::Aborted, lost.trips);
    let all = judged("both", &soon);
    near(&all, "target-losses", "az", 1.0, 0.0);
    assert!(reason(&all, "coarse-track-rms", "az").contains("at least 16 are needed"));
}
