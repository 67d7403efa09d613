//! Windows of an axis whose encoder is off centre, with and without a reference beside it.

use super::*;
use crate::axis::AngleReference;
use crate::diagnostic::SourceFile;
use crate::kinds::position::positioned::tests::{window_of, with_elevation};
use crate::log::{Channel, Rows, Topic, Width};
use crate::measurement::Measurement;
use crate::table::read_file;

const KEYS: &str = "targets = [\"-80 deg\", \"-40 deg\", \"0 deg\", \"40 deg\", \"80 deg\"]\nposes = [\"10 deg\"]\npose-cycles = 6";

fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "accuracy.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

fn polygon(axes: Axes) -> Axes {
    let faces_rad = (0..36)
        .map(|k| f64::from(k) * 10_f64.to_radians())
        .map(|a| if a > 3.2 { a - std::f64::consts::TAU } else { a });
    let reference = AngleReference { faces_rad: faces_rad.collect(), range_rad: 4e-4, u_rad: 2e-6 };
    let mut axes = axes;
    axes.get_mut("az").expect("azimuth").reference = Some(reference);
    axes
}

/// The servo brings the encoder to its command but for `backlash_rad` from below; the axis itself is `eccentric_rad`·sin θ
/// away from what the encoder says.
fn run(axes: &Axes, point: usize, eccentric_rad: f64, backlash_rad: f64) -> PointResult {
    let experiment = read(KEYS).expect("keys");
    let case = experiment.plan("az", axes).expect("a plan").remove(point);
    let mut from_below = false;
    let mut window = window_of(&case, 500.0, 2e-7, &mut |segment, t, before| {
        if segment.stimulus.duration_s(before).is_some() {
            from_below = segment.stimulus.at(before, 1e6).position_rad > before;
            return segment.stimulus.at(before, t).position_rad;
        }
        let target = (before.to_degrees()).round().to_radians();
        target - if from_below { backlash_rad } else { 0.0 }
    });
    if let Some(reference) = &axes.get("az").expect("azimuth").reference {
        let rows = &window.topics[0];
        let true_rad = rows.columns[0].iter().map(|place| place - eccentric_rad * place.sin());
        let off = true_rad.map(|place| place - reference.nearest_rad(place).expect("faces"));
        let (deviation, sees): (Vec<f64>, Vec<f64>) =
            off.map(|off| if off.abs() < reference.range_rad { (off, 1.0) } else { (0.0, 0.0) }).unzip();
        let channel = |name: &str| Channel { name: name.to_owned(), unit: String::new(), width: Width::F64 };
        let topic = Topic {
            name: "/reference".to_owned(),
            message: "bench_msgs/msg/Reference".to_owned(),
            channels: vec![channel("deviation_az_rad"), channel("sees_face_az")],
        };
        let time_s = rows.time_s.clone();
        window.topics.push(Rows { topic, time_s, columns: vec![deviation, sees] });
    }
    experiment.analyse(&case, &window, axes)
}

fn value<'a>(result: &'a PointResult, name: &str) -> &'a Measurement {
    result.measurements.iter().find(|m| m.measurand == name).expect("every measurand is there")
}

#[test]
fn an_encoder_off_centre_shows_against_the_reference_and_not_in_its_servo_error() {
    let result = run(&polygon(with_elevation()), 0, 150e-6, 0.0);
    let expected = 2.0 * 150e-6 * 80_f64.to_radians().sin();
    let accuracy = value(&result, ACCURACY);
    let found = accuracy.value.unwrap_or_else(|| panic!("{:?}", accuracy.inconclusive));
    assert!((found - expected).abs() < 3e-6, "{found:e} of {expected:e}");
    assert!(accuracy.u > 2e-6 * 2.0_f64.sqrt() && accuracy.u < 4e-6, "{:e}", accuracy.u);
    let servo = value(&result, SERVO).value.expect("the encoder is there");
    assert!(servo < 2e-6, "{servo:e}");
}

#[test]
fn backlash_is_a_reversal_and_counts_in_the_repeatability() {
    let result = run(&polygon(with_elevation()), 0, 0.0, 20e-6);
    let measured = |name| value(&result, name).value.expect("a value");
    assert!((measured(REVERSAL) - 20e-6).abs() < 1e-6, "{:e}", measured(REVERSAL));
    assert!((measured(REPEATABILITY) - 20e-6).abs() < 2e-6 && (measured(SYSTEMATIC) - 20e-6).abs() < 1e-6);
    assert!(measured(MEAN_RANGE) < 1e-6);
}

#[test]
fn without_a_reference_accuracy_is_inconclusive_and_the_encoder_shows_the_rest() {
    let axes = with_elevation();
    let result = run(&axes, 0, 150e-6, 20e-6);
    for name in [ACCURACY, SYSTEMATIC, MEAN_RANGE] {
        assert_eq!(
            value(&result, name).inconclusive.as_deref(),
            Some("reference instrument missing"),
            "{name}"
        );
    }
    let repeatability = value(&result, REPEATABILITY);
    assert!(repeatability.value.is_some() && repeatability.flags[0].contains("by the encoder"));
    assert!(read(KEYS).expect("keys").notes("az", &axes)[0].contains("reference instrument missing"));
}

/// The autocollimator sees 0.4 mrad, the encoder is 2 mrad off at the ends.
#[test]
fn an_encoder_that_is_off_by_more_than_the_reference_sees_finds_no_face_and_says_where() {
    let result = run(&polygon(with_elevation()), 0, 2e-3, 0.0);
    let accuracy = value(&result, ACCURACY);
    let reason = accuracy.inconclusive.as_deref().unwrap_or_default();
    assert!(
        accuracy.value.is_none() && reason.starts_with("no face of the polygon in view at 80.00 deg"),
        "{reason}"
    );
    assert!(
        reason.contains("the error of the encoder's zero exceeds the range of the autocollimator"),
        "{reason}"
    );
    assert!(value(&result, SERVO).value.is_some(), "the encoder alone needs no face");
}

#[test]
fn poses_say_how_many_cycles_they_rest_on() {
    let result = run(&polygon(with_elevation()), 1, 0.0, 0.0);
    let repeatability = value(&result, POSE_REPEATABILITY);
    assert!(repeatability.value.is_some_and(|rp| rp < 2e-6), "{repeatability:?}");
    assert!(repeatability.flags[0].contains("6 cycles, but ISO 9283 requires 30"));
    assert!(value(&result, POSE_ACCURACY).value.is_some_and(|ap| ap < 2e-6));
}

#[test]
fn too_few_runs_targets_off_the_faces_and_on_the_soft_limit_are_refused() {
    let few = read("targets = [\"0 deg\", \"10 deg\", \"20 deg\"]\nruns = 4").expect_err("four runs");
    assert!(few[0].to_string().contains("at least 5"), "{}", few[0]);
    let wide = read("targets = [\"-100 deg\", \"0 deg\", \"100 deg\"]").expect_err("three targets");
    assert!(wide[0].to_string().contains("requires 8"), "{}", wide[0]);
    let axes = polygon(with_elevation());
    let between = read("targets = [\"0 deg\", \"15 deg\", \"20 deg\"]").expect("keys").plan("az", &axes);
    assert!(between.is_err_and(|all| all[0].to_string().contains("not a face of the polygon")));
    let limit = read("targets = [\"140 deg\", \"150 deg\", \"159 deg\"]")
        .expect("keys")
        .plan("az", &with_elevation());
    assert!(limit.is_err_and(|all| all.iter().any(|m| m.to_string().contains("soft limits"))));
}

#[test]
fn the_graph_shows_every_run_and_is_as_high_as_the_accuracy() {
    let result = run(&polygon(with_elevation()), 0, 150e-6, 0.0);
    let plot = result.plots.iter().find(|p| p.id == "positioning").expect("the graph of ISO 230-2");
    let ends: Vec<f64> = plot.series.iter().filter(|s| s.label.starts_with("A = ")).map(|s| s.y[0]).collect();
    let accuracy = value(&result, ACCURACY).value.expect("a reference is there");
    assert!((ends[0] - ends[1] - 1e6 * accuracy).abs() < 1e-6, "{ends:?}");
    let runs = plot.series.iter().find(|s| s.label == "from below, each run").expect("single runs");
    assert_eq!(runs.x.len(), 5 * 5, "five runs to five targets");
    assert!(runs.y.iter().all(|y| (ends[1]..=ends[0]).contains(y)), "two standard deviations hold them here");
}
