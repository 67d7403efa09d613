//! The bench and the axes at rest, and the model of friction: from the procedure file to the findings.

use std::path::Path;

use crate::bench::{Said, findings, folder, run_in, verdict, write};

fn shipped(name: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../procedures/quick").join(name);
    file.to_str().expect("a path of ours").to_owned()
}

fn run(folder: &Path, unit: &str, file: &str, out: &str) -> Said {
    run_in(folder, &["run", file, "--unit", unit, "--out", out, "--non-interactive"])
}

/// Measurements of a measurand in a results file.
fn measured(results: &Path, measurand: &str) -> Vec<serde_json::Value> {
    let text = std::fs::read_to_string(results).expect("a folder with results");
    let results: serde_json::Value = serde_json::from_str(&text).expect("results are JSON");
    let procedures = results["findings"]["procedures"].as_array().expect("a list of procedures").clone();
    let all = procedures.iter().flat_map(|p| p["measurements"].as_array().cloned().unwrap_or_default());
    all.filter(|m| m["measurand"] == measurand).collect()
}

fn values(run: &Path, measurand: &str) -> Vec<f64> {
    measured(&run.join("results.json"), measurand).iter().filter_map(|m| m["value"].as_f64()).collect()
}

#[test]
fn the_identified_model_predicts_a_run_that_no_fit_has_seen_and_not_the_one_of_a_rougher_axis() {
    let folder = folder();
    let said = run(folder.path(), "nominal", &shipped("az-model-check.toml"), "sound");
    let means = values(&folder.path().join("sound"), "model-error-mean");
    assert!(
        means.len() == 2 && means.iter().all(|nm| nm.abs() < 3.0),
        "{means:?}\n{}\n{}",
        said.out,
        said.err
    );
    run(folder.path(), "friction-az", &shipped("az-model-check.toml"), "rough");
    let means = values(&folder.path().join("rough"), "model-error-mean");
    assert!(means.len() == 2 && means[0] > 20.0 && means[1] < -20.0, "{means:?}");
}

#[test]
fn a_friction_spot_at_100_degrees_is_seen_by_strokes_over_the_whole_travel_and_others_pass_nothing() {
    let folder = folder();
    let at = folder.path();
    let spot = "friction-spot = \"60 %\"\nfriction-spot-angle = \"100 deg\"\n";
    let unit = format!(
        "schema = 1\nid = \"spot\"\ntitle = \"spot\"\nbase = \"nominal\"\nmust-flip = []\nreason = \"far spot\"\n[az]\n{spot}"
    );
    write(at, "spot.toml", &unit);
    let part = |campaign: &str, procedure: &str, unit: &str| {
        let out = format!("{campaign}-{}", unit.trim_start_matches("./"));
        run_in(
            at,
            &["run", campaign, "--select", procedure, "--unit", unit, "--out", &out, "--non-interactive"],
        );
        at.join(out)
    };
    assert_eq!(verdict(&part("fat", "AZ-FRICTION-TRAVEL", "./spot.toml"), "FRC-EVEN"), "fail");
    assert_eq!(verdict(&part("fat", "AZ-FRICTION-TRAVEL", "nominal"), "FRC-EVEN"), "pass");
    let near = part("quick", "AZ-FRICTION", "./spot.toml");
    assert_eq!(verdict(&near, "FRC-EVEN"), "pass", "the spot lies outside of its strokes");
    let outcome = findings(&near);
    let told = "friction-unevenness on az: angle -148 deg .. 148 deg, reached -57.5 deg to 57.5 deg";
    assert!(outcome.contains(told), "where nothing was seen, nothing passes");
}

#[test]
fn elevation_is_held_still_and_holds_itself_where_its_spring_is_weak() {
    let folder = folder();
    let said = run(folder.path(), "nominal", &shipped("el-static.toml"), "run");
    let run = folder.path().join("run");
    let noise = values(&run, "position-noise");
    assert!(noise.len() == 1 && noise[0] < 2e-6 && noise[0] > 1e-8, "{noise:?}\n{}\n{}", said.out, said.err);
    assert!(values(&run, "drift-rate")[0].abs() < 1e-6);
    let movements = measured(&run.join("results.json"), "self-hold-movement");
    assert_eq!(movements.len(), 2, "{}\n{}", said.out, said.err);
    for movement in movements {
        let words = movement["flags"][0].as_str().expect("a flag");
        assert!(words.starts_with("holds itself"), "{movement}");
    }
}

/// Gyros that read 36 deg/h more about x.
const DRIFTED: &str = "schema = 1\nid = \"drifted\"\ntitle = \"Gyro x reads 36 deg/h more\"\nbase = \"nominal\"\n\
    must-flip = []\nreason = \"To be told from the unit before.\"\n[imu]\ngyro-bias-x = \"0.01 deg/s\"\n";

const SPIN: &str = "schema = 1\nid = \"SPIN\"\ntitle = \"Gyros against the encoder\"\nkind = \"imu-consistency\"\n\
    axis = \"az\"\nlog-rate = \"500 Hz\"\nelevation = [\"40 deg\"]\nvelocity = \"10 deg/s\"\nspan = \"-5 deg .. 5 deg\"\n\
    cycles = 1\n";

#[test]
fn a_gyro_that_drifts_between_the_self_checks_puts_in_doubt_what_was_measured_with_it() {
    let folder = folder();
    let campaign = format!(
        "schema = 1\nid = \"bracketed\"\ntitle = \"Between two self-checks\"\nrequirements = \"shipped:requirements.toml\"\n\
         must-measure = []\n[[procedure]]\nfile = \"{}\"\n[[procedure]]\nfile = \"spin.toml\"\n[[procedure]]\nfile = \"{}\"\n",
        shipped("self-check-open.toml"),
        shipped("self-check-close.toml"),
    );
    write(folder.path(), "spin.toml", SPIN);
    write(folder.path(), "campaign.toml", &campaign);
    write(folder.path(), "drifted.toml", DRIFTED);
    let said = run(folder.path(), "nominal", "./campaign.toml", "run");
    let sound = folder.path().join("run");
    let scale = measured(&sound.join("results.json"), "gyro-scale-error");
    assert_eq!(scale.len(), 1, "{}\n{}", said.out, said.err);
    assert!(scale[0]["inconclusive"].is_null(), "{}", scale[0]);
    for offset in measured(&sound.join("results.json"), "gyro-offset").iter().skip(3) {
        assert!(offset["conditions"][0]["achieved"].as_f64().expect("compared") < 3e-5, "{offset}");
    }
    // The same campaign, its last self-check taken from a unit whose gyro reads more.
    run(folder.path(), "./drifted.toml", &shipped("self-check-close.toml"), "later");
    let log = "SELF-CHECK-CLOSE.mcap";
    std::fs::copy(folder.path().join("later").join(log), sound.join(log)).expect("both logs are there");
    let said = run_in(folder.path(), &["rejudge", "run", "--out", "again"]);
    let again = folder.path().join("again");
    let scale = measured(&again.join("results.json"), "gyro-scale-error");
    assert_eq!(scale.len(), 1, "{}\n{}", said.out, said.err);
    let reason = scale[0]["inconclusive"].as_str().expect("a reason");
    assert!(reason.contains("rate_x_rad_per_s drifted between the self-checks"), "{reason}");
    assert!(scale[0]["value"].is_number(), "what was seen stays");
}

#[test]
fn the_gauge_finds_the_torque_constant_and_a_motor_that_is_weaker_than_the_rig_file_says() {
    let folder = folder();
    let said = run(folder.path(), "nominal", &shipped("az-torque-constant.toml"), "sound");
    let sound = values(&folder.path().join("sound"), "torque-constant");
    // The gauge's own errors: 0.3 % of scale and 1 mm of arm.
    assert!(
        sound.len() == 1 && (sound[0] / 60.0 - 1.0).abs() < 0.008,
        "{sound:?}\n{}\n{}",
        said.out,
        said.err
    );
    run(folder.path(), "torque-scale", &shipped("az-torque-constant.toml"), "weak");
    let weak = values(&folder.path().join("weak"), "torque-constant-error");
    assert!(weak.len() == 1 && (weak[0] + 0.18).abs() < 0.01, "{weak:?}");
}
