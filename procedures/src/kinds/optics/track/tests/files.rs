//! What a procedure file says, and what is planned of it.

use super::*;

fn mistakes(loops: &str, more: &str) -> String {
    let all = match procedure(loops, more) {
        Err(all) => all,
        Ok(procedure) => procedure.plan(&axes(), &[]).expect_err("it is refused"),
    };
    all.iter().map(|d| d.message.clone()).collect::<Vec<_>>().join("; ")
}

#[test]
fn a_plan_brings_its_target_bounds_the_axes_and_logs_every_frame() {
    let case = procedure("both", "").expect("a procedure").plan(&axes(), &[]).expect("a plan").remove(0);
    assert_eq!(case.point, "rail, both, elevation=45 deg");
    let bounds = case.bounds.expect("bounds");
    let target = case.target.expect("a target");
    assert!((bounds.displacement_rad / DEG - 17.0).abs() < 1e-9 && bounds.speed_rad_per_s < 0.2);
    assert_eq!((target.azimuth_rad, target.elevation_rad), (0.0, ELEVATION_RAD));
    assert!((case.start_pose_rad["az"] / DEG - 12.0).abs() < 1e-9, "the middle of the course");
    assert!(target.stands_s > case.segments[0].at_most_s && case.logs_payload_fully);
    let tracks = Some(Tracks { others: true, fine: true, off_load: true });
    assert!(case.segments[1..].iter().all(|s| s.mode == Mode::Track && s.tracks == tracks));
    assert!(case.is_tracked("az") && case.is_tracked("el"));
}

#[test]
fn a_coarse_loop_leaves_the_mirror_alone_and_a_fine_one_the_gimbal() {
    let coarse = procedure("coarse", "").expect("a procedure").plan(&axes(), &[]).expect("a plan").remove(0);
    assert!(coarse.segments.iter().all(|s| !s.is_fine()));
    let text = procedure("fine", "").expect_err("a rail moves");
    assert!(text[0].message.contains("cannot follow a target that moves"), "{}", text[0].message);
    let source = "schema = 1\nid = \"T\"\ntitle = \"t\"\nkind = \"track\"\naxis = \"az\"\ntarget = \"star\"\nloops = [\"fine\"]\n\
                  elevation = [\"45 deg\"]\nduration = \"20 s\"\nwindow-threshold = \"0.015 rad/s^2\"\n";
    let source = SourceFile { name: "t.toml".to_owned(), text: source.to_owned() };
    let star = Procedure::parse(source).expect("a procedure");
    let case = star.plan(&axes(), &[]).expect("a plan").remove(0);
    assert!(!case.is_tracked("az") && case.segments[3].is_fine());
    assert_eq!(star.yields.iter().filter(|name| name.starts_with("coarse")).count(), 0);
    let all = star.analyse(&case, &window(&steady()), &axes(), 4000.0).measurements;
    near(&all, "fine-track-rms", "el", rms_of(&steady().fine_rad, 1), 0.02e-6);
    assert!(all.iter().all(|m| m.measurand != "target-losses"));
}

#[test]
fn what_cannot_be_measured_is_refused_in_the_file() {
    assert!(mistakes("both", "azimuth = \"40 deg\"").contains("does not start inside `span`"));
    assert!(mistakes("cross", "").contains("unknown loops `cross`"));
    assert!(mistakes("both", "window-before = \"-1 s\"").contains("before it begins"));
    assert!(mistakes("both", "[rails]\ndistance = \"85 m\"").contains("rail"));
}
