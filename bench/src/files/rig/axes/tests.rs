use procedures::diagnostic::SourceFile;
use procedures::procedure::Procedure;

use crate::files::parameters;
use crate::files::rig::read_rig;
use crate::files::rig::tests::told;
use crate::files::shipped::{self, Folder};
use crate::model::rig::{Gimbal, Rig};

/// Where the axes of the shipped rig end.
const FIRST_DEVICE: &str = "\n[[device]]\nname = \"imu\"";

fn shipped_text() -> String {
    shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig").text
}

fn parsed(text: String) -> Result<Rig, String> {
    read_rig(SourceFile::new("rig.toml", text)).map_err(|mistakes| told(&mistakes))
}

/// What is said of the shipped rig after these replacements, each of every place where the text stands.
fn said(edits: &[[&str; 2]]) -> String {
    let mut text = shipped_text();
    for [old, new] in edits {
        assert!(text.contains(old), "the rig file no longer says {old}");
        text = text.replace(old, new);
    }
    parsed(text).err().unwrap_or_default()
}

/// The azimuth axis of the shipped rig as a rotary table: a drive, an encoder, nothing on it.
fn rotary_table() -> String {
    let text = shipped_text();
    let (axis, _) = text.split_once("[axis.el]").expect("azimuth stands before elevation");
    axis.replace("[axis.az]\n", "[axis.table]\ngains = \"az\"\n")
        .replace("[axis.az.", "[axis.table.")
        .replace("velocity-feedback = \"gyro\"", "velocity-feedback = \"encoder\"")
}

/// Tables of one more axis, made of the shipped azimuth.
fn one_more(name: &str, station: u16) -> String {
    let (_, table) =
        rotary_table().split_once("[axis.table]").map(|(a, b)| (a.to_owned(), b.to_owned())).expect("it");
    let table = table.replace("[axis.table.", &format!("[axis.{name}.")).replace("gains = \"az\"\n", "");
    format!("\n[axis.{name}]{}", table.replace("station = 1", &format!("station = {station}")))
}

#[test]
fn axes_are_in_the_order_of_the_file_and_know_what_carries_them() {
    let rig = parsed(shipped_text()).expect("the shipped rig");
    assert_eq!(rig.axis_names(), ["az", "el"]);
    assert_eq!(rig.gimbal(), Some(Gimbal { outer: 0, inner: 1 }));
    let text = shipped_text();
    let (head, axes) = text.split_once("[axis.az]").expect("azimuth");
    let (azimuth, rest) = axes.split_once("[axis.el]").expect("elevation");
    let (elevation, devices) = rest.split_once(FIRST_DEVICE).expect("devices");
    let turned = format!("{head}[axis.el]{elevation}[axis.az]{azimuth}{FIRST_DEVICE}{devices}");
    let rig = parsed(turned).expect("the same axes in another order");
    assert_eq!(rig.axis_names(), ["el", "az"]);
    assert_eq!(rig.gimbal(), Some(Gimbal { outer: 1, inner: 0 }));
    let gimbal = rig.limits();
    assert_eq!(gimbal.gimbal().expect("a gimbal").names(), ["az", "el"]);
    let faces = |name: &str| rig.limits().get(name).and_then(|l| l.reference.clone()).map(|r| r.faces_rad[0]);
    assert!(
        faces("az").is_some_and(|rad| (rad - 4.3e-6).abs() < 1e-9),
        "the polygon of azimuth stays on azimuth"
    );
}

#[test]
fn a_geometry_that_cannot_be_is_pointed_at() {
    let carried = "carried-by = \"az\"";
    insta::assert_snapshot!("unknown_carrier", said(&[[carried, "carried-by = \"azz\""]]));
    insta::assert_snapshot!("itself", said(&[[carried, "carried-by = \"el\""]]));
    insta::assert_snapshot!("circle", said(&[["[axis.az]\n", "[axis.az]\ncarried-by = \"el\"\n"]]));
    insta::assert_snapshot!("gyro_without_gimbal", said(&[[carried, ""]]));
    let roll = one_more("roll", 3).replace("[axis.roll]", "[axis.roll]\ncarried-by = \"az\"");
    insta::assert_snapshot!("two_on_one", said(&[[FIRST_DEVICE, &format!("{roll}{FIRST_DEVICE}")]]));
}

#[test]
fn a_rig_has_one_to_four_axes_of_their_own() {
    let four: String = [3, 4].map(|k| one_more(&format!("x{k}"), k)).concat();
    let four = four.replace("velocity-feedback = \"gyro\"", "velocity-feedback = \"encoder\"");
    assert_eq!(said(&[[FIRST_DEVICE, &format!("{four}{FIRST_DEVICE}")]]), "");
    let five = four + &one_more("x5", 5);
    insta::assert_snapshot!("five", said(&[[FIRST_DEVICE, &format!("{five}{FIRST_DEVICE}")]]));
    let (head, _) =
        shipped_text().split_once("[axis.az]").map(|(a, b)| (a.to_owned(), b.to_owned())).expect("axes");
    insta::assert_snapshot!("none", parsed(format!("{head}[axis]\n")).expect_err("no axis"));
    insta::assert_snapshot!("same_drive", said(&[["station = 2", "station = 1"]]));
    insta::assert_snapshot!("same_gains", said(&[["[axis.el]\n", "[axis.el]\ngains = \"az\"\n"]]));
    insta::assert_snapshot!("taken_name", said(&[["axis.el", "axis.imu"]]));
    insta::assert_snapshot!("odd_name", said(&[["axis.el", "axis.El_1"]]));
}

#[test]
fn an_axis_without_a_section_of_gains_is_told_which_there_are() {
    let text = rotary_table().replace("gains = \"az\"\n", "");
    let rig = parsed(text).expect("a rig may be read without its gains");
    let told = parameters::load(&rig).expect_err("no section `table`");
    insta::assert_snapshot!("no_gains", told[0]);
}

/// A procedure for the rotary table.
fn procedure(kind: &str, keys: &str) -> Procedure {
    let text = format!("schema = 1\nid = 'P'\ntitle = 'P'\nkind = '{kind}'\naxis = 'table'\n{keys}");
    Procedure::parse(SourceFile::new("p.toml", text)).expect("a right file")
}

fn refused(procedure: &Procedure, rig: &Rig) -> String {
    let told = procedure.plan(&rig.limits(), &[]).expect_err("this rig cannot do it");
    told.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n\n")
}

#[test]
fn a_rotary_table_is_planned_with_and_told_what_it_cannot_do() {
    let rig = parsed(rotary_table()).expect("one axis is a rig");
    assert!(parameters::load(&rig).is_ok() && rig.gimbal().is_none());
    let steps = procedure("step", "").plan(&rig.limits(), &[]).expect("steps");
    assert_eq!(steps.len(), 1);
    assert!(steps[0].requested.iter().all(|asked| asked.name != "elevation"), "{:?}", steps[0].requested);
    assert_eq!(steps[0].start_pose_rad.keys().collect::<Vec<_>>(), ["table"]);
    let friction = "[sweep]\nvelocity = ['2 deg/s']\nspan = '-60 deg .. 60 deg'\ncycles = 2\n";
    assert!(procedure("hysteresis", friction).plan(&rig.limits(), &[]).is_ok());
    let track =
        include_str!("../../../../../procedures/quick/track-rail.toml").replace("\"az\"", "\"table\"");
    let track = Procedure::parse(SourceFile::new("track.toml", track)).expect("a shipped procedure");
    insta::assert_snapshot!("track_refused", refused(&track, &rig));
    insta::assert_snapshot!(
        "elevation_refused",
        refused(&procedure("step", "elevation = ['20 deg']\n"), &rig)
    );
}
