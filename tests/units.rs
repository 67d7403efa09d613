//! Units and controller parameters: bad files are refused with place and reason, good ones are documented.

use std::path::Path;

use controllers::parameter::PARAMETERS as GAINS;
use controllers::velocity::LAWS;
use sim_devices::unit::{CURVES, PARAMETERS};

use crate::bench::{folder, run_in, write};

const HEAD: &str = "schema = 1\nid = \"mine\"\ntitle = \"Mine\"\nbase = \"nominal\"\n";

/// What a check with the unit `unit.toml` of this folder says, without the folder's name.
fn refused(folder: &Path) -> String {
    let said = run_in(folder, &["check", "--unit", "./unit.toml"]);
    format!("exit {}\n{}{}", said.code, said.out, said.err)
}

/// The same for a unit on `nominal` with these further lines.
fn with(lines: &str) -> String {
    let folder = folder();
    write(folder.path(), "unit.toml", &format!("{HEAD}{lines}"));
    refused(folder.path())
}

/// An array of eleven of one value.
fn eleven(value: &str) -> String {
    format!("[{}]", [format!("\"{value}\"").as_str(); 11].join(", "))
}

#[test]
fn a_negative_inertia_and_other_impossible_values_come_at_once() {
    insta::assert_snapshot!(with(
        "[az]\ninertia = \"-1200 kg*m^2\"\ncoulomb-torque = \"NaN N*m\"\n[el]\ninertia = \"975 kg\"\ncurrent-limit = \"900 A\"\n[wiring]\ndropped-cycles = \"120 %\"\n"
    ));
}

#[test]
fn a_damping_ratio_of_one_and_a_negative_frequency_are_pointed_at() {
    let mut damping = eleven("0.03").replacen("0.03", "1", 1);
    damping = damping.replacen("0.03\"]", "-0.03\"]", 1);
    insta::assert_snapshot!(with(&format!(
        "[az-structure]\nmode-1-damping = {damping}\nmode-2-frequency = {}\nmode-1-encoder = {}\n",
        eleven("50 Hz").replacen("50 Hz", "-50 Hz", 1),
        eleven("1e-4 1/(kg*m^2)").replacen("1e-4", "-1e-4", 1),
    )));
}

#[test]
fn an_array_without_a_value_for_every_elevation_node_is_refused() {
    insta::assert_snapshot!(with(
        "[el-structure]\nmode-1-frequency = [\"17 Hz\", \"18 Hz\"]\nrigid-gain = [\"1\"]\n"
    ));
}

#[test]
fn nodes_that_go_back_or_miss_the_ends_of_the_travel_are_refused() {
    insta::assert_snapshot!(with(
        "[az-structure]\nelevation = [\"0 deg\", \"20 deg\", \"10 deg\", \"10 deg\", \"80 deg\"]\n"
    ));
}

#[test]
fn new_nodes_over_the_arrays_of_the_base_are_refused_where_the_nodes_stand() {
    insta::assert_snapshot!(with(
        "[el-structure]\nelevation = [\"-10 deg\", \"40 deg\", \"90 deg\"]\nrigid-gain = [\"1\", \"1\", \"1\"]\n"
    ));
}

#[test]
fn a_mode_that_is_not_whole_is_refused() {
    insta::assert_snapshot!(with(&format!("[az-structure]\nmode-5-frequency = {}\n", eleven("120 Hz"))));
}

#[test]
fn wrong_kinds_words_and_keys_of_curves_are_pointed_at() {
    insta::assert_snapshot!(with(
        "must-trip = \"polarty\"\n[az-structure]\nelevation = \"0 deg\"\nrigid-gain = [1.0]\nmode-1-frequency = [\"10 deg/s\", \"nan Hz\"]\nmode-9-gyro = []\n"
    ));
}

#[test]
fn a_wrong_array_in_a_base_is_pointed_at_in_the_base() {
    let folder = folder();
    write(folder.path(), "unit.toml", &HEAD.replace("nominal", "below.toml"));
    write(folder.path(), "below.toml", &format!("{HEAD}[az-structure]\nrigid-gain = [\"1\", \"1\"]\n"));
    insta::assert_snapshot!(refused(folder.path()));
}

#[test]
fn switches_signs_kinds_and_bit_rates_between_their_values_are_refused() {
    insta::assert_snapshot!(with(
        "[imu]\nbaud = \"100000\"\ngyro-sign-y = \"0\"\n[target]\nkind = \"1.5\"\n[mirror]\nnotch = \"0.4\"\nanalog-only = \"0.5\"\nstrain-gauge-loop = \"0.5\"\n[el]\nencoder-bits = \"20.5\"\nencoder-sign = \"0.5\"\n[wiring]\naxes-swapped = \"50 %\"\n"
    ));
}

#[test]
fn a_loss_that_leaves_no_capacitance_is_refused() {
    insta::assert_snapshot!(with("[mirror]\nloss-tangent = \"0.19\"\n"));
}

#[test]
fn stops_that_cross_and_a_breakaway_below_the_sliding_friction_are_refused() {
    insta::assert_snapshot!(with(
        "[az]\nstatic-torque = \"100 N*m\"\n[el]\nlower-stop = \"95 deg\"\nupper-stop = \"95 deg\"\ncoulomb-torque = \"50 N*m\"\n"
    ));
}

#[test]
fn a_sign_that_is_wrong_in_a_base_is_pointed_at_in_the_base() {
    let folder = folder();
    write(
        folder.path(),
        "unit.toml",
        &format!("{}[el]\nupper-stop = \"-20 deg\"\n", HEAD.replace("nominal", "below.toml")),
    );
    write(
        folder.path(),
        "below.toml",
        &format!("{HEAD}[el]\nlower-stop = \"-15 deg\"\nencoder-sign = \"0\"\n"),
    );
    insta::assert_snapshot!(refused(folder.path()));
}

#[test]
fn one_array_alone_may_differ_from_the_base() {
    let said = with(&format!("[el-structure]\nmode-1-frequency = {}\n", eleven("16 Hz")));
    assert!(said.starts_with("exit 0"), "{said}");
}

#[test]
fn an_unknown_base_names_the_nearest() {
    let folder = folder();
    write(folder.path(), "unit.toml", &HEAD.replace("nominal", "nominel"));
    insta::assert_snapshot!(refused(folder.path()));
}

#[test]
fn bases_that_lead_in_a_circle_are_named() {
    let folder = folder();
    write(folder.path(), "unit.toml", &HEAD.replace("nominal", "other.toml"));
    let inside = folder.path().file_name().expect("a name").to_string_lossy().into_owned();
    write(
        folder.path(),
        "other.toml",
        &HEAD.replace("nominal", &format!("../{inside}/third.toml")).replace("Mine", "Other"),
    );
    write(folder.path(), "third.toml", &HEAD.replace("nominal", "other.toml").replace("Mine", "Third"));
    insta::assert_snapshot!(refused(folder.path()).replace(&inside, "FOLDER"));
}

#[test]
fn a_unit_that_is_its_own_base_is_a_circle() {
    let folder = folder();
    write(folder.path(), "unit.toml", &HEAD.replace("nominal", "unit.toml"));
    insta::assert_snapshot!(refused(folder.path()));
}

#[test]
fn a_chain_of_bases_has_an_end() {
    let folder = folder();
    write(folder.path(), "unit.toml", &HEAD.replace("nominal", "1.toml"));
    for k in 1..12 {
        write(folder.path(), &format!("{k}.toml"), &HEAD.replace("nominal", &format!("{}.toml", k + 1)));
    }
    insta::assert_snapshot!(refused(folder.path()));
}

#[test]
fn a_file_of_another_schema_is_refused() {
    let folder = folder();
    write(folder.path(), "unit.toml", &HEAD.replace("schema = 1", "schema = 2"));
    insta::assert_snapshot!(refused(folder.path()));
}

#[test]
fn bad_controller_parameters_are_refused_with_place_and_reason() {
    let folder = folder();
    let rig = include_str!("../bench/rigs/sim.toml").replacen("\"director\"", "\"gains.toml\"", 1);
    write(folder.path(), "rig.toml", &rig);
    let text = "schema = 1\nid = \"gains\"\n[az]\nvelocity-kp = \"-1 N*m*s/rad\"\nvelocity-ki = \"5 N*m\"\n[el]\nposition-gian = \"4 1/s\"\n";
    write(folder.path(), "gains.toml", text);
    let said = run_in(folder.path(), &["run", "--rig", "./rig.toml", "--out", "run"]);
    insta::assert_snapshot!(format!("exit {}\n{}{}", said.code, said.out, said.err));
}

#[test]
fn the_law_of_a_velocity_loop_is_a_word_of_each_axis() {
    let folder = folder();
    let rig = include_str!("../bench/rigs/sim.toml").replacen("\"director\"", "\"gains.toml\"", 1);
    write(folder.path(), "rig.toml", &rig);
    let checked = |law: &str| {
        let gains = include_str!("../controllers/params/director.toml").replacen(
            "[el]",
            &format!("[el]\nvelocity-law = \"{law}\""),
            1,
        );
        write(folder.path(), "gains.toml", &gains);
        run_in(folder.path(), &["check", "quick/self-check-open", "--rig", "./rig.toml"])
    };
    let said = checked("pi");
    assert_eq!(said.code, 0, "{}", said.err);
    let said = checked("pie");
    assert!(said.code == 2 && said.err.contains("velocity-law") && said.err.contains("`pi`"), "{}", said.err);
    let said = run_in(folder.path(), &["explain", "director"]);
    let blocks = documented(&said.out);
    for key in ["az.velocity-law", "el.velocity-law"] {
        let (_, text) = blocks.iter().find(|(own, _)| own == key).expect("each axis has a law");
        assert!(text.starts_with("pi default pi one of `pi`"), "{text}");
        assert!(LAWS.iter().all(|law| text.contains(law.doc)), "{text}");
    }
    let schema = run_in(folder.path(), &["schema", "parameters"]);
    let schema: serde_json::Value = serde_json::from_str(&schema.out).expect("JSON");
    for section in ["/properties/az", "/properties/el", "/properties/axis/additionalProperties"] {
        let words = schema.pointer(&format!("{section}/properties/velocity-law/enum"));
        assert_eq!(words.and_then(|words| words.as_array()).map(Vec::len), Some(LAWS.len()), "{section}");
    }
}

#[test]
fn explain_documents_every_setting_and_curve_of_a_unit() {
    let folder = folder();
    for unit in ["nominal", "as-measured", "azimuth-retainer"] {
        let said = run_in(folder.path(), &["explain", unit]);
        assert_eq!(said.code, 0, "{}", said.err);
        let blocks = documented(&said.out);
        for p in PARAMETERS.iter() {
            let block =
                blocks.iter().find(|(key, _)| key == p.key).unwrap_or_else(|| panic!("{unit}: {}", p.key));
            for part in [p.doc, p.source, &format!("default {}", p.default), "range "] {
                assert!(block.1.contains(part), "{unit}, {}: no `{part}` in\n{}", p.key, block.1);
            }
        }
        for c in CURVES.iter() {
            let key = format!("{}.{}", c.table, c.key);
            let block = blocks.iter().find(|(k, _)| *k == key).unwrap_or_else(|| panic!("{unit}: {key}"));
            for part in [c.doc, c.source, "default ", "range "] {
                assert!(block.1.contains(part), "{unit}, {key}: no `{part}` in\n{}", block.1);
            }
        }
    }
}

#[test]
fn explain_documents_every_controller_parameter() {
    let folder = folder();
    let said = run_in(folder.path(), &["explain", "director"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let blocks = documented(&said.out);
    for p in GAINS {
        let block = blocks.iter().find(|(key, _)| key == p.key).unwrap_or_else(|| panic!("{}", p.key));
        for part in [p.doc, p.source, &format!("default {}", p.default), "range "] {
            assert!(block.1.contains(part), "{}: no `{part}` in\n{}", p.key, block.1);
        }
    }
}

/// The dotted keys of a page of `bench explain` with what stands under each, blanks taken together.
fn documented(page: &str) -> Vec<(String, String)> {
    let mut table = String::new();
    let mut blocks: Vec<(String, String)> = Vec::new();
    for line in page.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            table = format!("{name}.");
        } else if line.starts_with("    ") {
            if let Some((_, text)) = blocks.last_mut() {
                text.push(' ');
                text.push_str(line.trim());
            }
        } else if let Some((key, rest)) = line.get(2..).and_then(|l| l.split_once(" = ")) {
            let words: Vec<&str> = rest.split_whitespace().collect();
            blocks.push((format!("{table}{}", key.trim()), words.join(" ")));
        }
    }
    blocks
}

#[test]
fn the_schema_of_units_knows_every_setting_and_curve() {
    let folder = folder();
    let said = run_in(folder.path(), &["schema", "unit"]);
    let schema: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    for p in PARAMETERS.iter() {
        let path = p.key.split('.').fold(String::new(), |path, part| format!("{path}/properties/{part}"));
        assert_eq!(schema.pointer(&path).map(|s| &s["type"]), Some(&"string".into()), "{path}");
    }
    for c in CURVES.iter() {
        let path = format!("/properties/{}/properties/{}", c.table, c.key);
        assert_eq!(schema.pointer(&path).map(|s| &s["type"]), Some(&"array".into()), "{path}");
    }
}

#[test]
fn explain_marks_what_differs_from_the_nominal_unit() {
    let folder = folder();
    let said = run_in(folder.path(), &["explain", "azimuth-retainer"]);
    let marked: Vec<&str> = said.out.lines().filter(|l| l.starts_with("* ")).collect();
    insta::assert_snapshot!(marked.join("\n"));
}

#[test]
fn explain_of_a_file_that_is_wrong_says_what_is_wrong_with_it() {
    let folder = folder();
    write(folder.path(), "unit.toml", &format!("{HEAD}[az]\ninertia = \"-1 kg*m^2\"\n"));
    let said = run_in(folder.path(), &["explain", "./unit.toml"]);
    insta::assert_snapshot!(format!("exit {}\n{}{}", said.code, said.out, said.err));
}

#[test]
fn a_delay_between_two_steps_of_the_simulation_is_refused_and_not_rounded() {
    insta::assert_snapshot!(with("[az]\ncommand-delay = \"0.83 ms\"\n[el]\nsensor-delay = \"1262.5 us\"\n"));
    let finer = with(
        "step-rate = \"40 kHz\"\n[az]\ncommand-delay = \"0.825 ms\"\n[el]\nsensor-delay = \"1262.5 us\"\n",
    );
    assert!(finer.contains("sensor-delay") && !finer.contains("command-delay"), "{finer}");
}
