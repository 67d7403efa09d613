//! Truth in, truth out.

use super::synthetic_axis::{azimuth, elevation};
use super::*;
use crate::log::Channel;

const RATE_HZ: f64 = 4000.0;

#[test]
fn elevation_friction_unbalance_and_spring_come_back() {
    let truth = elevation();
    let text = "[sweep]\nvelocity = [\"5 deg/s\", \"10 deg/s\", \"20 deg/s\", \"40 deg/s\", \"60 deg/s\"]\nspan = \"-8 deg .. 88 deg\"\ncycles = 2\n";
    let found = run(text, &truth, RATE_HZ, 1);
    let friction: Vec<&Measurement> =
        found.measurements.iter().filter(|m| m.measurand == "friction-torque").collect();
    assert_eq!(friction.len(), 5);
    for one in friction {
        let velocity = one.conditions[0].achieved.expect("it slides");
        assert!((velocity / one.conditions[0].requested - 1.0).abs() < 0.01);
        near(one, truth.friction_nm(velocity), 0.01);
        assert!(one.dof.is_none_or(|dof| dof > 10.0), "{one:?}");
    }
    near(find(&found, "coulomb-torque"), truth.coulomb_nm, 0.02);
    near(find(&found, "viscous-coefficient"), truth.viscous_nm_s_per_rad, 0.02);
    near(find(&found, "unbalance-torque"), truth.unbalance_nm, 0.02);
    near(find(&found, "spring-stiffness"), truth.spring_nm_per_rad, 0.02);
    near(find(&found, "spring-torque"), truth.spring_nm_per_rad * 50_f64.to_radians(), 0.02);
    near(find(&found, "cogging-amplitude"), 5.07, 0.01);
    near(find(&found, "cogging-order"), 108.0, 0.001);
    let peak = find(&found, "cogging-peak");
    near(peak, peak_nm(&truth), 0.02);
    assert!(peak.u < 0.03 * peak_nm(&truth), "{peak:?}");
    assert!(
        found.remarks.iter().any(|r| r.contains("not determined (5 velocities, 15 needed)")),
        "{:?}",
        found.remarks
    );
    assert!(!found.measurements.iter().any(|m| m.measurand == "static-torque"));
    let ids: Vec<&str> = found.plots.iter().map(|p| p.id.as_str()).collect();
    assert_eq!(ids.len(), 8, "{ids:?}");
}

/// The loop still swings after each acceleration: at one end of the span in each direction, as a load would.
#[test]
fn what_a_stroke_begins_with_is_no_unbalance_of_elevation() {
    let truth = elevation();
    for velocity in [5, 10] {
        let text =
            format!("[sweep]\nvelocity = [\"{velocity} deg/s\"]\nspan = \"-8 deg .. 88 deg\"\ncycles = 1\n");
        for is_back in [false, true] {
            let found = run_spoiled(&text, &truth, RATE_HZ, 3, |window| {
                let strokes = window.segments.last().expect("strokes are the last segment");
                let half_s = if is_back { 0.5 * (strokes.end_s - strokes.start_s) } else { 0.0 };
                // The ramp lasts 2·√(v/j), 0.149 s to 5 deg/s and 0.211 s to 10 deg/s.
                let from_s = strokes.start_s + half_s + 2.0 * (f64::from(velocity) / 900.0).sqrt();
                let swing_nm = if is_back { -80.0 } else { 80.0 };
                for rows in &mut window.topics {
                    let times_s = rows.time_s.clone();
                    for (value, time_s) in
                        rows.columns[1].iter_mut().zip(times_s).filter(|(_, t)| *t > from_s)
                    {
                        let torque_nm = swing_nm * (-(time_s - from_s) / 0.12).exp();
                        *value += torque_nm / truth.torque_constant_nm_per_a;
                    }
                }
            });
            let unbalance = find(&found, "unbalance-torque");
            near(unbalance, truth.unbalance_nm, 0.015);
            let left_out: Vec<usize> = unbalance.excluded.iter().map(|e| e.count).collect();
            assert!(matches!(left_out[..], [1..=4]), "{left_out:?}");
        }
    }
}

/// A motor that loses torque while it warms up needs more current from period to period, whichever way it goes: as a spring in both
/// directions.
#[test]
fn a_motor_that_warms_up_during_the_strokes_is_no_spring() {
    let truth = azimuth();
    let text = "[sweep]\nvelocity = [\"2 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\ncycles = 1\n";
    let warm = |window: &mut Window| {
        for rows in &mut window.topics {
            let start_s = rows.time_s[0];
            let kelvin: Vec<f64> = rows.time_s.iter().map(|t| (t - start_s) / 60.0).collect();
            for (current_a, kelvin) in rows.columns[1].iter_mut().zip(&kelvin) {
                *current_a *= 1.0 + 0.001 * kelvin;
            }
            let channel = Channel { name: "heat_sink_degc".to_owned(), ..rows.topic.channels[0].clone() };
            rows.topic.channels.push(channel);
            rows.columns.push(kelvin.iter().map(|kelvin| 30.0 + kelvin).collect());
        }
    };
    let sound = run(text, &truth, RATE_HZ, 5);
    let warm = run_spoiled(text, &truth, RATE_HZ, 5, warm);
    for measurand in ["spring-stiffness", "spring-torque"] {
        let [sound, warm] = [&sound, &warm].map(|found| find(found, measurand));
        let value = warm.value.expect("a value");
        assert!(
            (value - sound.value.expect("a value")).abs() > 4.0 * sound.u,
            "{measurand}: it shows: {value}"
        );
        assert!(value.abs() < 2.0 * warm.u, "{measurand}: {value} ± {}, and there is none", warm.u);
    }
}

/// The rate ripples against the second line of cogging, as the loop lets it, and friction with the rate: by 3 % of the line.
#[test]
fn the_ripple_of_friction_with_the_rate_is_no_cogging() {
    let truth = elevation();
    let text = "[sweep]\nvelocity = [\"5 deg/s\", \"10 deg/s\"]\nspan = \"-8 deg .. 88 deg\"\ncycles = 2\n";
    let [order, amplitude_nm, phase_rad] = truth.cogging[1];
    let slope_nm_s_per_rad = (truth.friction_nm(0.088) - truth.friction_nm(0.086)) / 0.002;
    let ripple_rad_per_s = 0.03 * amplitude_nm / slope_nm_s_per_rad;
    let ripple = |window: &mut Window| {
        for rows in &mut window.topics {
            let angles = rows.columns[0].clone();
            for k in 20..angles.len() - 20 {
                let rate_rad_per_s = (angles[k + 20] - angles[k - 20]) / (40.0 / RATE_HZ);
                if (rate_rad_per_s.abs() / 5_f64.to_radians() - 1.0).abs() > 0.01 {
                    continue;
                }
                let (sin, cos) = (order * angles[k] + phase_rad).sin_cos();
                let passes_rad_per_s = order * rate_rad_per_s;
                rows.columns[0][k] -= ripple_rad_per_s / passes_rad_per_s * sin;
                let inertial_nm = truth.inertia_kg_m2 * ripple_rad_per_s * passes_rad_per_s * sin;
                let friction_nm = -slope_nm_s_per_rad * ripple_rad_per_s * cos;
                rows.columns[1][k] += (inertial_nm + friction_nm) / truth.torque_constant_nm_per_a;
            }
        }
    };
    let last_line = |found: &Conclusion| {
        let mut lines = found.measurements.iter().filter(|m| m.measurand == "cogging-harmonic");
        lines.next_back().expect("two lines").clone()
    };
    let second = last_line(&run_spoiled(text, &truth, RATE_HZ, 4, ripple));
    assert_eq!(second.conditions.last().map(|c| c.requested), Some(order));
    near(&second, amplitude_nm, 0.01);
    assert!(second.u > 0.015 * amplitude_nm && second.u < 0.02 * amplitude_nm, "{second:?}");
    // The slope that was taken is the chord to the next velocity, and it may be as far off as it is.
    let single = run_spoiled(&text.replace(", \"10 deg/s\"", ""), &truth, RATE_HZ, 4, ripple);
    let second = last_line(&single);
    let off_nm = second.value.expect("a line") - 0.97 * amplitude_nm;
    assert!(
        off_nm.abs() < 0.003 && second.u > 0.03 * amplitude_nm && second.u < 0.1 * amplitude_nm,
        "{second:?}"
    );
}

/// At 2 deg/s motion up to 5 Hz counts, and 20 ms are bridged; at 10 deg/s twice the cogging frequency of 4 Hz counts, and 12.5 ms are.
#[test]
fn rows_that_a_stall_cuts_out_of_a_stroke_are_bridged_and_flagged_or_leave_no_friction() {
    for (velocity, rate_hz, [bridged_s, torn_s]) in
        [("2", RATE_HZ, [0.01, 0.03]), ("10", 250.0, [0.009, 0.015])]
    {
        let text =
            format!("[sweep]\nvelocity = [\"{velocity} deg/s\"]\nspan = \"-20 deg .. 20 deg\"\ncycles = 1\n");
        let stalled = |lasted_s: f64| {
            let conclusion = run_spoiled(&text, &azimuth(), rate_hz, 1, |window| {
                let span = window.segments.last().expect("the strokes").clone();
                let from_s = span.start_s + 0.2 * (span.end_s - span.start_s);
                window.topics.iter_mut().for_each(|rows| rows.cut(from_s, from_s + lasted_s));
            });
            find(&conclusion, "friction-torque").clone()
        };
        let [whole, bridged, torn] = [0.0, bridged_s, torn_s].map(stalled);
        let [whole_nm, bridged_nm] = [&whole, &bridged].map(|m| m.value.expect("slid"));
        assert!((bridged_nm - whole_nm).abs() < 0.02 * whole.u.max(0.5), "{bridged_nm} against {whole_nm}");
        let is_flagged =
            |m: &Measurement| m.flags.iter().any(|flag| flag.starts_with("rows missing for up to 1"));
        assert!(is_flagged(&bridged) && !is_flagged(&whole), "{:?}", bridged.flags);
        assert!(torn.value.is_none(), "{torn:?}");
    }
}

#[test]
fn levelled_azimuth_has_neither_unbalance_nor_spring() {
    let found = run(
        "[sweep]\nvelocity = [\"10 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\ncycles = 1\n",
        &azimuth(),
        RATE_HZ,
        2,
    );
    for name in ["unbalance-torque", "spring-torque"] {
        let null = find(&found, name);
        let value = null.value.expect("a wide span");
        assert!(value <= 4.0 * null.u && null.u < 1.0, "{name}: {value} ± {}", null.u);
    }
    let harmonics: Vec<f64> = found
        .measurements
        .iter()
        .filter(|m| m.measurand == "cogging-harmonic")
        .filter_map(|m| m.conditions.iter().find(|c| c.name == "order").map(|c| c.requested))
        .collect();
    assert_eq!(harmonics, [144.0, 288.0]);
}

/// Over the 45 whole cogging periods of the plateau, ± 56.25°, a load of 14 N·m·cos θ has the mean 14·sin x/x = 11.858 N·m: of
/// it, friction by direction is not told apart.
#[test]
fn friction_of_a_levelled_axis_is_even_by_direction_and_angle_and_a_load_is_in_its_difference() {
    let text = "[sweep]\nvelocity = [\"10 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\ncycles = 1\n";
    let level = run(text, &azimuth(), RATE_HZ, 8);
    let difference = find(&level, "friction-difference");
    let value = difference.value.expect("two directions");
    assert!(value <= 4.0 * difference.u && difference.u < 1.0, "{difference:?}");
    let uneven = find(&level, "friction-unevenness");
    let value = uneven.value.expect("two directions");
    // 2 % (half-width) for the ends of the strokes and a load along them.
    assert!(value < 0.02 && uneven.u < 0.012 && uneven.conditions.len() == 1, "{uneven:?}");
    let mut leaning = azimuth();
    leaning.unbalance_nm = 14.0;
    near(find(&run(text, &leaning, RATE_HZ, 9), "friction-difference"), 11.858, 0.01);
}

/// Points of a Stribeck curve pass two periods each: a scatter of two says nothing, and blocked FRC-EVEN of the whole campaign.
#[test]
fn a_span_of_two_cogging_periods_says_nothing_of_how_even_friction_is() {
    let text = "[sweep]\nvelocity = [\"10 deg/s\"]\nperiods = 2\ncentre = \"0 deg\"\ncycles = 1\n";
    let found = run(text, &azimuth(), RATE_HZ, 8);
    assert!(find(&found, "friction-torque").value.is_some());
    assert!(!found.measurements.iter().any(|m| m.measurand == "friction-unevenness"));
}

#[test]
fn a_narrow_span_is_refused_with_its_inflation() {
    let found = run(
        "[sweep]\nvelocity = [\"10 deg/s\"]\nspan = \"10 deg .. 70 deg\"\ncycles = 1\n",
        &elevation(),
        RATE_HZ,
        3,
    );
    let unbalance = find(&found, "unbalance-torque");
    assert_eq!(unbalance.value, None);
    let reason = unbalance.inconclusive.as_deref().unwrap_or("");
    assert!(reason.contains("variance inflation") && reason.contains("above 30"), "{reason}");
}

#[test]
fn a_velocity_that_the_span_cannot_reach_is_refused_before_anything_moves() {
    let text = "[sweep]\nvelocity = [\"10 deg/s\", \"60 deg/s\"]\nspan = \"0 deg .. 40 deg\"\ncycles = 1\n";
    let truth = elevation();
    let refused = read(text).expect("the keys are right").plan("el", &rig(&[&truth])).expect_err("too short");
    let [refused] = refused.as_slice() else { panic!("{refused:?}") };
    assert!(
        refused.message.starts_with("span 0 deg .. 40 deg is too short for velocity 60 deg/s"),
        "{refused:?}"
    );
    let help = refused.help.as_deref().unwrap_or_default();
    assert!(help.starts_with("use a span of at least 71.8333 deg"), "{help}");
    // What the help asks for is enough, and little less is not.
    let planned = |span: &str| {
        let text = text.replace("0 deg .. 40 deg", span);
        read(&text).expect("the keys are right").plan("el", &rig(&[&truth])).is_ok()
    };
    assert!(planned("0 deg .. 71.9 deg") && !planned("0 deg .. 71.7 deg"));
}

#[test]
fn stribeck_sweeps_of_both_axes_give_all_five_parameters() {
    for (mut truth, from) in [(azimuth(), "0.344 deg/s"), (elevation(), "0.0344 deg/s")] {
        truth.noise_nm *= 2.0;
        let text = format!(
            "[sweep]\nfrom = \"{from}\"\nto = \"60 deg/s\"\ncount = 30\nperiods = 2\ncentre = \"40 deg\"\ncycles = 1\n"
        );
        let found = run(&text, &truth, 500.0, 5);
        let unreached: Vec<_> = found
            .measurements
            .iter()
            .filter(|m| m.measurand == "friction-torque" && m.value.is_none())
            .map(|m| (m.point.clone(), m.inconclusive.clone()))
            .collect();
        assert_eq!(unreached, [], "{}", truth.name);
        near(find(&found, "coulomb-torque"), truth.coulomb_nm, 0.01);
        near(find(&found, "static-torque"), truth.static_nm, 0.02);
        near(find(&found, "stribeck-velocity"), truth.stribeck_rad_per_s, 0.10);
        near(find(&found, "viscous-coefficient"), truth.viscous_nm_s_per_rad, 0.02);
        near(find(&found, "stribeck-shape"), truth.shape_ratio, 0.15);
    }
}

/// Friction falls between 0.344 and 7 deg/s: a line through those velocities is not that of the viscous branch.
#[test]
fn a_sweep_that_ended_among_slow_velocities_gives_no_coulomb_torque() {
    let truth = azimuth();
    let text = "[sweep]\nfrom = \"0.344 deg/s\"\nto = \"60 deg/s\"\ncount = 14\nperiods = 2\ncentre = \"0 deg\"\ncycles = 1\n";
    let experiment = read(text).expect("the keys are right");
    let axes = rig(&[&truth]);
    let cases = experiment.plan(truth.name, &axes).expect("the axis can do it");
    let measured: Vec<PointResult> = cases
        .iter()
        .zip(5000..)
        .map(|(case, k)| experiment.analyse(case, &truth.run(case, 500.0, k), &axes))
        .collect();
    let whole = experiment.conclude(&cases, &measured, &axes);
    near(find(&whole, "coulomb-torque"), truth.coulomb_nm, 0.02);

    let mut aborted = measured;
    aborted[8..].fill_with(PointResult::default);
    let found = experiment.conclude(&cases, &aborted, &axes);
    for name in ["coulomb-torque", "viscous-coefficient"] {
        let one = find(&found, name);
        let why = one.inconclusive.as_deref().unwrap_or_default();
        assert!(one.value.is_none() && why.contains("a line through slow velocities alone"), "{one:?}");
    }
}

#[test]
fn opposite_poses_add_an_unbalance_from_their_difference() {
    let mut truth = azimuth();
    truth.unbalance_nm = 14.0;
    truth.spring_nm_per_rad = 10.0;
    let text = "[sweep]\nvelocity = [\"10 deg/s\"]\nspan = \"-155 deg .. -25 deg\"\nopposite-span = \"25 deg .. 155 deg\"\ncycles = 1\n";
    let found = run(text, &truth, RATE_HZ, 6);
    let poses = found.measurements.iter().find(|m| m.estimator == "opposite-poses/2").expect("two poses");
    near(poses, 14.0, 0.05);
}

#[test]
fn the_same_window_gives_the_same_bytes() {
    let text = "[sweep]\nvelocity = [\"10 deg/s\"]\nspan = \"-20 deg .. 20 deg\"\ncycles = 1\n";
    let json = || serde_json::to_string(&run(text, &azimuth(), 1000.0, 7)).expect("plain numbers");
    assert_eq!(json(), json());
}

/// Largest cogging on a grid of 2000 points in a period of azimuth and 2667 in one of elevation.
fn peak_nm(truth: &Truth) -> f64 {
    let angle_rad = |k: i32| std::f64::consts::TAU * f64::from(k) / 288_000.0;
    (0..288_000).map(|k| truth.cogging_nm(angle_rad(k)).abs()).fold(0.0, f64::max)
}

/// With the second line half of the first, phases decide whether the peak is a tenth or a half above the first line.
#[test]
fn the_peak_of_cogging_depends_on_the_phases_of_its_lines() {
    let text =
        "[sweep]\nvelocity = [\"0.5 deg/s\", \"1 deg/s\"]\nperiods = 24\ncentre = \"0 deg\"\ncycles = 1\n";
    let mut peaks_nm = Vec::new();
    for phase_rad in [0.8, 0.8 + std::f64::consts::FRAC_PI_2] {
        let mut truth = azimuth();
        truth.cogging = vec![[144.0, 8.45, 0.4], [288.0, 4.2, phase_rad], [24.0, 2.0, 1.0]];
        let found = run(text, &truth, RATE_HZ, 5);
        let peak = find(&found, "cogging-peak");
        near(peak, peak_nm(&truth), 0.03);
        assert!(peak.flags.iter().any(|flag| flag.starts_with("sum of 3 lines")), "{:?}", peak.flags);
        peaks_nm.extend(peak.value);
    }
    assert!(peaks_nm[0] > 14.2 && peaks_nm[1] < 13.7, "{peaks_nm:?}");
}

/// Adds a torque that depends on angle and direction to every row.
fn add_torque(window: &mut Window, truth: &Truth, torque_nm: impl Fn(f64, f64) -> f64) {
    for rows in &mut window.topics {
        let angles_rad = rows.columns[0].clone();
        for k in 1..angles_rad.len() {
            let direction = (angles_rad[k] - angles_rad[k - 1]).signum();
            rows.columns[1][k] += torque_nm(angles_rad[k], direction) / truth.torque_constant_nm_per_a;
        }
    }
}

/// Half of what friction differs by in both directions is a constant of the half-sum, which counted as a spring of 5 N·m.
#[test]
fn friction_that_is_larger_in_one_direction_is_no_spring() {
    let text = "[sweep]\nvelocity = [\"2 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\ncycles = 1\n";
    let truth = azimuth();
    let found = run_spoiled(text, &truth, RATE_HZ, 11, |window| add_torque(window, &truth, |_, _| 5.0));
    near(find(&found, "friction-difference"), 5.0, 0.05);
    let spring = find(&found, "spring-torque");
    assert!(spring.value.is_some_and(|value| value < 1.0 && value < 3.0 * spring.u), "{spring:?}");
    assert!(spring.flags.iter().any(|flag| flag.contains("belongs to no spring")), "{:?}", spring.flags);
}

/// The contact takes 2 mrad to follow a spot, on either side of it: half the sum of both directions has a part of it left.
#[test]
fn a_spot_of_friction_is_uneven_and_what_it_leaves_in_the_ripple_is_in_its_uncertainty() {
    let text = "[sweep]\nvelocity = [\"2 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\ncycles = 1\n";
    let truth = azimuth();
    // 12 N·m in the middle, 3 deg wide at half its height; over one period of 2.5 deg 84 % of it.
    let spot = |angle_rad: f64, direction: f64| {
        let off = ((angle_rad - direction * 2e-3 - 0.6) / 3_f64.to_radians()).abs();
        if off < 1.0 { direction * 6.0 * (1.0 + (std::f64::consts::PI * off).cos()) } else { 0.0 }
    };
    let found = run_spoiled(text, &truth, RATE_HZ, 12, |window| add_torque(window, &truth, spot));
    let friction_nm = find(&found, "friction-torque").value.expect("it slides");
    let uneven = find(&found, "friction-unevenness");
    let expected = 12.0 * 0.869 / friction_nm - 12.0 * 3.0 / 115.0 / friction_nm;
    assert!((uneven.value.expect("46 periods") - expected).abs() < uneven.u, "{expected}: {uneven:?}");
    let peak = find(&found, "cogging-peak");
    let off_nm = peak.value.expect("lines") - peak_nm(&truth);
    assert!(off_nm > 0.3 && off_nm < 2.0 * peak.u, "{off_nm} N·m off: {peak:?}");
    assert!(peak.flags.iter().any(|flag| flag.starts_with("friction has a spot")), "{:?}", peak.flags);
}
