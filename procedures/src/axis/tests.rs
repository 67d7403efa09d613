use super::*;
use crate::procedure::sample;

fn limits() -> AxisLimits {
    sample::sample_axes().all()[0].limits.clone()
}

fn stacked(names: &[&str]) -> Axes {
    Axes::stacked(names.iter().map(|name| ((*name).to_owned(), limits())))
}

fn uncoupled(names: &[&str]) -> Axes {
    Axes::new(names.iter().map(|name| Axis::on_the_ground((*name).to_owned(), limits())).collect())
}

fn read(text: &str) -> Axes {
    serde_json::from_str(text).expect("axes of a log")
}

#[test]
fn a_log_keeps_the_order_of_the_axes_and_what_carries_them() {
    let axes = stacked(&["yaw", "pitch"]);
    let text = serde_json::to_string(&axes).expect("axes become JSON");
    assert_eq!(read(&text), axes);
    assert_eq!(read(&text).names().collect::<Vec<_>>(), ["yaw", "pitch"], "not in the order of the alphabet");
}

#[test]
fn a_log_that_knows_no_geometry_is_of_elevation_over_azimuth() {
    let limits = serde_json::to_string(&limits()).expect("limits become JSON");
    let axes = read(&format!(r#"{{"el": {limits}, "az": {limits}}}"#));
    let gimbal = axes.gimbal().expect("two axes");
    assert_eq!(gimbal.names(), ["az", "el"]);
    let one = read(&format!(r#"{{"az": {limits}}}"#));
    assert!(one.gimbal().is_err());
    assert_eq!(one.all()[0].carried_by, None);
}

#[test]
fn a_gimbal_has_its_outer_axis_first_whatever_the_order_of_the_rig_file() {
    let mut axes = uncoupled(&["pitch", "focus", "yaw"]);
    axes.all_mut()[0].carried_by = Some("yaw".to_owned());
    let gimbal = axes.gimbal().expect("yaw carries pitch");
    assert_eq!(gimbal.names(), ["yaw", "pitch"]);
    assert_eq!(["pitch", "focus", "yaw"].map(|name| gimbal.index_of(name)), [Some(1), None, Some(0)]);
    assert_eq!([gimbal.other("pitch"), gimbal.other("yaw")], [Some("yaw"), Some("pitch")]);
    assert_eq!(axes.carries("yaw").map(|axis| axis.name.as_str()), Some("pitch"));
    assert_eq!(axes.carries("pitch"), None);
}

#[test]
fn a_rig_without_one_carried_axis_has_no_gimbal_and_says_what_it_has() {
    let told = |axes: &Axes| axes.gimbal().expect_err("no gimbal").to_string();
    let rigs = [Axes::default(), uncoupled(&["table"]), uncoupled(&["x", "y"]), stacked(&["a", "b", "c"])];
    insta::assert_snapshot!(rigs.map(|axes| told(&axes)).join("\n"), @r"
    two axes are needed, one carrying the other; the rig has no axis
    two axes are needed, one carrying the other; the rig has the axis `table` only
    two axes are needed, one carrying the other; the rig has the axes `x`, `y`
    two axes are needed, one carrying the other; the rig has the axes `a`, `b` on `a`, `c` on `b`
    ");
}

#[test]
fn torques_are_as_uncertain_as_the_constant_of_the_rig_file_until_a_gauge_has_measured_it() {
    let known = |measured_constant: Option<MeasuredConstant>| AxisLimits {
        torque_constant_u_ratio: 0.029,
        max_torque_nm: 2000.0,
        measured_constant,
        ..limits()
    };
    let by_rig = known(None).torque_scale();
    assert!((by_rig.of_torque(-200.0).u - 5.8).abs() < 1e-9);

    let gauge = MeasuredConstant::new(60.0, 0.12, None, 150.0).expect("a constant");
    let by_gauge = known(Some(gauge)).torque_scale();
    assert!((by_gauge.of_torque(-150.0).u - 0.3).abs() < 1e-9, "0.2 % where it was measured");
    assert!((by_gauge.relative_at(10.0).u - 0.002).abs() < 1e-9);
    // Iron saturates beyond it: a half-width of 5 % over the largest torque.
    let beyond = 0.05 / 3_f64.sqrt() * 1000.0 / 2000.0;
    assert!((by_gauge.relative_at(1150.0).u - beyond.hypot(0.002)).abs() < 1e-9);
}
