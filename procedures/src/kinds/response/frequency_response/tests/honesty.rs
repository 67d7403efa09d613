//! What a record does not hold is not said: limits of the drive, levels, elevations, lines that are left out.

use super::*;
use crate::log::{Channel, Width};

/// A drive that says that it was limited did not do what it was sent.
#[test]
fn windows_in_which_the_drive_was_at_a_limit_of_its_own_do_not_count() {
    let procedure = procedure(MULTISINE, SLIDING);
    let with = |limited: std::ops::Range<usize>| {
        judge(
            &procedure,
            |window| {
                let rows = &mut window.topics[0];
                let name = "statusword".to_owned();
                rows.topic.channels.push(Channel { name, unit: String::new(), width: Width::U16 });
                let word = |row| if limited.contains(&row) { f64::from(0x1A37) } else { f64::from(0x1237) };
                rows.columns.push((0..rows.time_s.len()).map(word).collect());
            },
            1,
        )
    };
    let windows = |result: &PointResult| -> Vec<usize> {
        result.excluded.iter().filter(|e| e.of == "windows").map(|e| e.count).collect()
    };
    let never = with(0..0);
    assert!(of(&never, "velocity-bandwidth").value.is_some());
    assert_eq!(windows(&never), [0; 0]);
    assert_eq!(windows(&with(40_000..40_001)), [1]);
    let always = with(0..1_000_000);
    let bandwidth = of(&always, "velocity-bandwidth");
    let reason = bandwidth.inconclusive.as_deref().unwrap_or_default();
    assert!(bandwidth.value.is_none() && reason.contains("a limit of its own"), "{reason}");
}

#[test]
fn the_level_is_that_of_the_log_and_another_elevation_is_none() {
    let procedure = procedure(MULTISINE, SLIDING);
    let weak = judge(&procedure, |w| w.topics[0].columns[5].iter_mut().for_each(|v| *v *= 0.8), 1);
    let level = &of(&weak, "velocity-bandwidth").conditions[1];
    assert!((level.achieved.expect("it was read") - 3.2).abs() < 0.01, "{level:?}");
    let away = judge(&procedure, |w| w.topics[0].columns[0].iter_mut().for_each(|v| *v += 0.2), 1);
    let reason = of(&away, "velocity-bandwidth").inconclusive.clone().unwrap_or_default();
    assert!(
        reason.contains("measured at an elevation of 31.4") && reason.contains("requested 20 deg"),
        "{reason}"
    );
}

#[test]
fn at_rest_an_axis_starts_where_its_point_is() {
    let axes = axes();
    let case = &procedure(MULTISINE, REST).plan(&axes, &[]).expect("a plan")[0];
    assert!((case.start_pose_rad["el"].to_degrees() - 20.0).abs() < 1e-9, "{:?}", case.start_pose_rad);
}

/// Every other line of an odd grid is left out, and the same ones in all realisations.
#[test]
fn an_odd_random_grid_gives_one_loop_and_shows_what_it_leaves_out() {
    let odd = format!("{MULTISINE}\ngrid = \"odd-random\"");
    let procedure = procedure(&odd, SLIDING);
    let result = judge(&procedure, |_| {}, 1);
    let bandwidth = of(&result, "velocity-bandwidth");
    let value = bandwidth.value.unwrap_or_else(|| panic!("{:?}", bandwidth.inconclusive));
    assert!((value - truth()[0]).abs() < 4.0 * bandwidth.u.max(0.003), "{value} ± {}", bandwidth.u);
    let distortion = of(&result, "distortion");
    let told = distortion.flags.iter().find(|flag| flag.starts_with("lines left out")).expect("it is told");
    assert!(told.contains("odd") && told.contains("even") && !told.contains("none left out"), "{told}");
    // A rate that bends shows at the even lines.
    let bent = judge(&procedure, |w| w.topics[0].columns[4].iter_mut().for_each(|v| *v += 2.0 * *v * *v), 1);
    let even = |result: &PointResult| -> f64 {
        let flags = &of(result, "distortion").flags;
        let told = flags.iter().find(|flag| flag.starts_with("lines left out")).expect("it is told");
        let after = told.split("even ").nth(1).expect("even lines");
        after.split(" dB").next().and_then(|db| db.parse().ok()).unwrap_or(f64::NEG_INFINITY)
    };
    assert!(even(&bent) > even(&result) + 6.0 && even(&bent) > -40.0, "{} {}", even(&bent), even(&result));
}

/// Phases that are compressed are the same in every realisation: nothing can be told of distortion.
#[test]
fn realisations_that_are_the_same_signal_tell_nothing_of_distortion() {
    let same = format!("{MULTISINE}\nphases = \"compressed\"");
    let result = judge(&procedure(&same, SLIDING), |_| {}, 1);
    assert!(of(&result, "velocity-bandwidth").value.is_some());
    let distortion = of(&result, "distortion");
    let reason = distortion.inconclusive.as_deref().unwrap_or_default();
    assert!(distortion.value.is_none() && reason.contains("different phases"), "{distortion:?}");
}

#[test]
fn a_velocity_loop_behind_a_torque_or_with_loose_gains_is_refused_and_a_mirror_is_sent_on() {
    let refused = |responses: &str, excitation: &str| {
        let text = format!(
            "schema = 1\nid = \"T\"\ntitle = \"t\"\nkind = \"frequency-response\"\naxis = \"el\"\n\
             elevation = [\"20 deg\"]\nresponses = [{responses}]\n\
             [excitation]\n{MULTISINE}\n{excitation}\n[background]\nsliding-from = \"0.03 rad/s\"\n{SLIDING}\n"
        );
        let wrong = Procedure::parse(SourceFile { name: "t.toml".to_owned(), text }).expect_err("refused");
        wrong.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    for excitation in ["into = \"torque\"", "gain-ratio = [\"10 %\"]"] {
        let text = refused("\"velocity-loop\"", excitation);
        assert!(text.contains("with its production gains"), "{text}");
    }
    let text = refused("\"mirror-loop\"", "");
    assert!(text.contains("`kind = \"fsm-response\"`"), "{text}");
}

/// The loop is below 0 dB at its lowest line: the crossing lies below it, and fails a limit above it.
#[test]
fn a_bandwidth_below_the_lowest_line_is_bounded_by_that_line() {
    let high = MULTISINE.replace("0.5 Hz", "6 Hz") + "\nwindow = \"1 s\"";
    let result = judge(&procedure(&high, SLIDING), |_| {}, 1);
    let bandwidth = of(&result, "velocity-bandwidth");
    let value = bandwidth.value.unwrap_or_else(|| panic!("{:?}", bandwidth.inconclusive));
    assert!((6.0..7.0).contains(&value) && bandwidth.flags[0].starts_with("at most"), "{bandwidth:?}");
    let margin = of(&result, "velocity-phase-margin");
    assert!(margin.value.is_none() && margin.inconclusive.is_some(), "{margin:?}");
}

#[test]
fn several_gains_are_points_of_their_own_with_the_same_signal_and_are_compared() {
    let axes = axes();
    let text = format!("into = \"torque\"\n{MULTISINE}\ngain-ratio = [\"25 %\", \"0 %\"]");
    let procedure = procedure(&text, SLIDING);
    let cases = procedure.plan(&axes, &[]).expect("a plan");
    let gains = |case: &Case| case.segments.iter().find_map(|s| s.gain_ratio);
    assert_eq!(cases.iter().map(gains).collect::<Vec<_>>(), [Some(0.25), Some(0.0)]);
    assert!(cases[1].point.ends_with("gains=0 %"), "{}", cases[1].point);
    assert_eq!(cases[0].excitations, cases[1].excitations);
    assert!(procedure.yields.contains(&"gains-departure"), "{:?}", procedure.yields);
}
