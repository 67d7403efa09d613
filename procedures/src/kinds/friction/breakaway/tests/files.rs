use super::*;
use crate::diagnostic::SourceFile;
use crate::procedure::Procedure;

fn parsed(name: &str, text: &str) -> Result<Procedure, String> {
    let source = SourceFile { name: name.to_owned(), text: text.to_owned() };
    Procedure::parse(source).map_err(|all| all.iter().map(|d| format!("{d}\n")).collect())
}

#[test]
fn shipped_files_read_plan_and_yield_what_the_campaigns_must_measure() {
    let rig = |plant: &Plant, constant: f64| bench::limits(plant, constant);
    let axes =
        Axes::stacked([("az".to_owned(), rig(&AZIMUTH, 60.0)), ("el".to_owned(), rig(&ELEVATION, 52.0))]);
    let files = [
        ("quick/az-breakaway.toml", include_str!("../../../../../quick/az-breakaway.toml"), 6),
        ("quick/el-breakaway.toml", include_str!("../../../../../quick/el-breakaway.toml"), 17),
        ("fat/az-breakaway.toml", include_str!("../../../../../fat/az-breakaway.toml"), 78),
        ("fat/el-breakaway.toml", include_str!("../../../../../fat/el-breakaway.toml"), 78),
        ("fat/el-hold.toml", include_str!("../../../../../fat/el-hold.toml"), 16),
    ];
    let yields = |name: &str| {
        let (_, text, _) = files.iter().find(|f| f.0 == name).expect("listed above");
        parsed(name, text).expect("reads").yields
    };
    for (name, text, points) in files {
        let procedure = parsed(name, text).unwrap_or_else(|e| panic!("{e}"));
        let cases = procedure.experiment.plan(&procedure.axis, &axes).expect("plans");
        assert_eq!(cases.len(), points, "{name}");
        let names: std::collections::BTreeSet<&str> = cases.iter().map(|c| c.point.as_str()).collect();
        assert_eq!(names.len(), points, "{name}: points have names of their own");
    }
    assert!(yields("quick/el-breakaway.toml").contains(&"hold-margin"));
    assert!(!yields("quick/az-breakaway.toml").contains(&"dwell-slope"));
    assert_eq!(
        yields("fat/el-breakaway.toml"),
        ["breakaway-torque", "bristle-stiffness", "presliding-damping", "dwell-slope"]
    );
    assert_eq!(yields("fat/el-hold.toml"), ["hold-margin"]);
}

#[test]
fn mistakes_in_the_kinds_own_keys_come_all_at_once() {
    let text = "\
schema = 1
id = \"X\"
title = \"x\"
kind = \"breakaway\"
axis = \"el\"
displacement = \"0.6 Hz\"
[[ramp]]
rate = [\"1 A\"]
dwel = [\"1 s\"]
[multisine]
to = \"0.1 Hz\"
periods = 2
";
    insta::assert_snapshot!(parsed("x.toml", text).expect_err("wrong in many places"), @r#"
    error: missing table `map`, which ramps and the multisine need
     --> x.toml:1:1
      |
    1 | schema = 1
      | ^
      = help: add [map]: a slow stroke that measures cogging, unbalance and spring, which are subtracted from the ramps
    error: `displacement`: expected an angle such as `10 deg`, found `0.6 Hz`, a frequency
     --> x.toml:6:16
      |
    6 | displacement = "0.6 Hz"
      |                ^^^^^^^^
    error: `rate`: expected a current rate such as `0.1 A/s`, found `1 A`, a current
     --> x.toml:8:9
      |
    8 | rate = ["1 A"]
      |         ^^^^^
    error: unknown key `dwel`
     --> x.toml:9:1
      |
    9 | dwel = ["1 s"]
      | ^^^^
      = help: did you mean `dwell`?
    error: `to` must be at least twice `from`
      --> x.toml:11:6
       |
    11 | to = "0.1 Hz"
       |      ^^^^^^^^
    error: `periods` must be at least 5, found 2
      --> x.toml:12:11
       |
    12 | periods = 2
       |           ^
    "#);
}
