use super::*;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};
use crate::plan::Wanted;

fn planned(names: &[&str], points: bool) -> String {
    let rig = shipped::find(Folder::Rigs, "sim", None).expect("shipped");
    let rig = read_rig(rig).expect("a shipped rig parses");
    let wanted = Wanted { names: names.iter().map(|&n| n.to_owned()).collect(), ..Wanted::default() };
    let plan = crate::plan::plan(&wanted, &rig).expect("a shipped procedure plans");
    text(&plan, &rig, points)
}

#[test]
fn what_a_run_would_do_and_what_happens_at_its_worst_instant() {
    insta::assert_snapshot!(planned(&["quick/el-breakaway"], false));
}

#[test]
fn every_point_on_request() {
    insta::assert_snapshot!(planned(&["quick/el-friction"], true));
}
