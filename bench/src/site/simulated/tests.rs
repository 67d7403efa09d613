use crate::files::rig::read_rig;
use crate::files::unit::load_unit;
use procedures::pull::Pull;
use procedures::target::{Target, TargetCourse};

use super::*;

fn table() -> Unit {
    load_unit("table").expect("a shipped unit")
}

/// A point that shows a target, one that is pulled at, one with a frame rate of its own.
fn cases_with_scenery() -> [Case; 3] {
    let target = Target { course: TargetCourse::Star, azimuth_rad: 0.0, elevation_rad: 0.5, stands_s: 1.0 };
    let pull = Pull { rate_rad_per_s: 0.1, begins_s: 1.0, way_rad: 0.01, at_most_nm: 10.0 };
    let point = || "1".to_owned();
    [
        Case { point: point(), target: Some(target), ..Case::default() },
        Case { point: point(), pull: Some(pull), ..Case::default() },
        Case { point: point(), fine_frame_rate_hz: Some(100.0), ..Case::default() },
    ]
}

#[test]
fn a_point_that_needs_scenery_is_refused_on_a_table_and_served_on_a_director() {
    let director = load_unit("nominal").expect("a shipped unit");
    let mut refusals = Vec::new();
    for case in cases_with_scenery() {
        assert_eq!(check_scenery(&director, &case), Ok(()));
        refusals.push(check_scenery(&table(), &case).expect_err("a table has no surroundings").to_string());
    }
    insta::assert_snapshot!(refusals.join("\n"));
    assert_eq!(check_scenery(&table(), &Case::default()), Ok(()));
}

#[test]
fn a_rig_with_axes_that_the_table_does_not_have_is_refused() {
    let source =
        crate::files::shipped::find(crate::files::shipped::Folder::Rigs, "sim", None).expect("shipped");
    let rig = read_rig(source).expect("a shipped rig parses");
    let error = check_names(&TableSettings::with_axes(&["table"]), &rig).expect_err("az is not table");
    insta::assert_snapshot!(error.to_string());
}
