use super::*;
use crate::diagnostic::SourceFile;
use crate::log::{EndedBy, SegmentSpan};
use crate::measurement::Measurement;
use crate::procedure::sample::sample_axes;
use crate::synthetic;
use crate::table::read_file;

const FILE: &str = "duration = \"3 s\"\n[drift]\ngyro-offset = \"0.002 deg/s\"\n";

fn read(text: &str) -> Result<Box<dyn Experiment>, Vec<Diagnostic>> {
    let source = SourceFile { name: "procedure.toml".to_owned(), text: text.to_owned() };
    read_file(&source, KIND.fields, KIND.read)
}

/// Three seconds at 1 kHz: a drive, the inertial unit (a new message every other row), an autocollimator, the clock.
fn window(counts: fn(usize) -> f64, sees: f64) -> Window {
    let n = 3000;
    let time: Vec<f64> = (0..n).map(|k| k as f64 / 1000.0).collect();
    let column = |value: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..n).map(value).collect() };
    let grain = |k: usize| (k as f64 * 2.399_963).sin();
    let az = synthetic::rows(
        "/az",
        &time,
        vec![
            ("position_rad", column(&|k| 0.3 + 1e-7 * k as f64)),
            ("current_a", column(&|k| 0.04 + 0.01 * grain(k))),
        ],
    );
    let imu = synthetic::rows(
        "/imu",
        &time,
        vec![("rate_x_rad_per_s", column(&|k| 5e-5 + 1e-4 * grain(k / 2))), ("sequence", column(&counts))],
    );
    let reference = synthetic::rows(
        "/reference",
        &time,
        vec![("deviation_az_rad", column(&|k| 2e-6 + 1e-7 * k as f64)), ("sees_face_az", column(&|_| sees))],
    );
    let bench = synthetic::rows(
        "/bench",
        &time,
        vec![
            ("missed_periods", column(&|k| f64::from(u8::from(k % 1000 == 7)))),
            ("lateness_s", column(&|k| 1e-6 * k as f64)),
        ],
    );
    let ended_by = EndedBy::Completed;
    let span = SegmentSpan { segment: 1, start_s: 0.0, end_s: 3.0, start_position_rad: 0.3, ended_by };
    Window::completed(vec![az, imu, reference, bench], vec![span])
}

fn analysed(window: &Window) -> PointResult {
    let check = read(FILE).expect("the keys are right");
    let cases = check.plan("az", &sample_axes()).expect("a plan");
    check.analyse(&cases[0], window, &sample_axes())
}

fn of<'a>(result: &'a PointResult, name: &str) -> &'a Measurement {
    result.measurements.iter().find(|m| m.measurand == name).unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn nothing_moves_and_no_loop_is_closed() {
    let check = read(FILE).expect("the keys are right");
    let case = check.plan("az", &sample_axes()).expect("a plan").remove(0);
    assert!(case.open_loop && case.logs_payload_fully && case.planned_s() <= 5.0);
    let envelope = case.envelope();
    assert_eq!((envelope.velocity_rad_per_s, envelope.torque_nm), (0.0, 0.0));
}

#[test]
fn every_channel_that_is_there_is_measured_and_names_itself() {
    let found = analysed(&window(|k| (k / 2) as f64, 1.0));
    let value = |name: &str| of(&found, name).value.expect("a number");
    assert!((value("current-offset") - 0.04).abs() < 1e-4);
    assert!((value("current-noise") - 0.01 / 2_f64.sqrt()).abs() < 1e-4);
    assert!(value("encoder-noise") < 1e-9, "a creeping axis is no noise: {}", value("encoder-noise"));
    assert!((value("gyro-offset") - 5e-5).abs() < 4.0 * of(&found, "gyro-offset").u);
    assert!((value("autocollimator-offset") - (2e-6 - 0.3)).abs() < 1e-12, "less the encoder");
    assert_eq!((value("missed-periods"), value("lateness")), (3.0, 2999e-6));
    let gyro = of(&found, "gyro-offset");
    assert_eq!(gyro.evidence[0].channels, ["/imu rate_x_rad_per_s"]);
    assert!((gyro.conditions[0].requested - 0.002_f64.to_radians()).abs() < 1e-12, "{gyro:?}");
    assert!(of(&found, "gyro-noise").conditions.is_empty());
    assert!(found.measurements.iter().all(|m| m.measurand != "clamp-offset"), "no such topic");
}

#[test]
fn a_unit_that_sends_nothing_new_and_an_autocollimator_without_a_face_say_so() {
    let found = analysed(&window(|_| 7.0, 0.0));
    for (name, reason) in [
        ("gyro-offset", "/imu rate_x_rad_per_s: no new message came"),
        ("autocollimator-noise", "/reference deviation_az_rad: nothing is in view"),
    ] {
        assert_eq!(of(&found, name).inconclusive.as_deref(), Some(reason));
        assert_eq!(of(&found, name).value, None);
    }
    assert!(of(&found, "current-offset").value.is_some());
    let nothing = analysed(&Window::completed(Vec::new(), Vec::new()));
    assert!(nothing.inconclusive.is_some() && nothing.measurements.is_empty());
}

#[test]
fn what_cannot_drift_is_refused_with_the_nearest_word() {
    let wrong = FILE.replace("gyro-offset", "gyro-ofset");
    let mistakes = read(&wrong).expect_err("no such measurand");
    assert!(mistakes[0].help.as_deref().is_some_and(|h| h.contains("gyro-offset")), "{mistakes:?}");
    let unit = read(&FILE.replace("0.002 deg/s", "0.002 A")).expect_err("no rate");
    assert!(!unit.is_empty());
}
