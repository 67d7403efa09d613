//! Plans that cannot do harm, and records with known truth.

use super::plan::{HIGH_END, LOW_END};
use super::*;
use crate::case::{Condition, Mode};
use crate::kinds::position::positioned::tests::with_elevation;
use crate::measurement::Measurement;
use crate::synthetic;

const DEG: f64 = std::f64::consts::PI / 180.0;
const ALL: [Stage; 5] = [Stage::Ends, Stage::FullSpeed, Stage::SoftBench, Stage::SoftDrive, Stage::Zone];

fn keys(stages: &[Stage]) -> Keys {
    Keys {
        stages: stages.to_vec(),
        creep_rad_per_s: 5.0 * DEG,
        full_rad_per_s: 60.0 * DEG,
        fence_rad: [-30.0 * DEG, 30.0 * DEG],
        beyond_rad: 15.0 * DEG,
    }
}

fn cases(stages: &[Stage]) -> Vec<Case> {
    keys(stages).plan("az", &with_elevation()).expect("a plan")
}

/// Segments of 2 s each; angles by a function of the segment's index and the time in it.
fn window(case: &Case, trips: &[&str], angle_rad: impl Fn(usize, f64) -> f64) -> Window {
    let mut segments = Vec::new();
    let mut time_s = Vec::new();
    let mut position = Vec::new();
    let mut rate = Vec::new();
    for segment in 0..case.segments.len() {
        let start_s = 3.0 + 2.0 * segment as f64;
        segments.push(synthetic::span(segment, start_s, start_s + 2.0));
        for k in 0..200 {
            let t_s = 0.01 * f64::from(k);
            time_s.push(start_s + t_s);
            position.push(angle_rad(segment, t_s));
            rate.push(0.5);
        }
    }
    let rows =
        synthetic::rows("/az", &time_s, vec![("position_rad", position), ("velocity_rad_per_s", rate)]);
    let trips = trips.iter().map(|&trip| trip.to_owned()).collect();
    Window { trips, ..Window::completed(vec![rows], segments) }
}

fn analysed(case: &Case, window: &Window) -> PointResult {
    keys(&ALL).analyse(case, window, &with_elevation())
}

fn value(all: &[Measurement], name: &str) -> f64 {
    let found = all.iter().find(|m| m.measurand == name).unwrap_or_else(|| panic!("no {name}"));
    found.value.unwrap_or_else(|| panic!("{name}: {:?}", found.inconclusive))
}

/// A limit stands at the end itself: what overshoots by a count there, or only seems to, would trip it.
#[test]
fn the_axis_is_sent_to_its_ends_with_room_for_overshoot_and_less_than_the_requirement_allows() {
    let axes = with_elevation();
    let travel = axes.get("az").expect("azimuth").travel_rad;
    let crawls: Vec<f64> = cases(&[Stage::Ends])[0]
        .segments
        .iter()
        .filter(|segment| segment.label == "crawl")
        .map(|segment| match segment.stimulus {
            crate::stimulus::Stimulus::Move { target_rad, .. } => target_rad,
            _ => f64::NAN,
        })
        .collect();
    let room = [crawls[0] - travel[0], travel[1] - crawls[1]];
    assert!(room.iter().all(|room| (10e-6..50e-6).contains(room)), "{room:?} of 75 urad");
}

#[test]
fn every_speed_and_direction_has_its_point() {
    let names: Vec<String> = cases(&ALL).into_iter().map(|c| c.point).collect();
    assert_eq!(names.len(), 2 + 4 + 4 + 3, "{names:?}");
    assert!(names.contains(&"soft-drive, velocity=-60 deg/s".to_owned()), "{names:?}");
    assert!(names.contains(&"zone, velocity=60 deg/s, beside".to_owned()), "{names:?}");
}

#[test]
fn whatever_is_ordered_past_a_limit_ends_inside_the_soft_limits_of_the_rig() {
    let axes = with_elevation();
    let [low, high] = axes.get("az").expect("azimuth").soft_limits_rad;
    for case in cases(&[Stage::FullSpeed, Stage::SoftBench, Stage::SoftDrive, Stage::Zone]) {
        let [from, to] = case.envelope().position_rad;
        assert!(from > low && to < high, "{}: {} .. {} deg", case.point, from / DEG, to / DEG);
    }
}

/// A drive that keeps no limits is left to its velocity for five degrees, one that keeps them has time to arrive.
#[test]
fn a_velocity_leads_past_the_drives_limit_by_way_and_not_by_time() {
    for case in cases(&[Stage::SoftDrive]) {
        let segment = &case.segments[0];
        assert_eq!(segment.mode, Mode::DriveVelocity);
        let Some(Condition::Displacement { above_rad }) = segment.until else { panic!("it ends by its way") };
        let start = case.start_pose_rad["az"];
        let ahead = case.requested("velocity").expect("a rate").signum();
        let past = ahead * start + above_rad - 30.0 * DEG;
        assert!(past > 0.9 * DEG && past < 5.1 * DEG, "{}: {} deg past", case.point, past / DEG);
    }
}

#[test]
fn beyond_the_rigs_own_soft_limits_the_axis_creeps() {
    let case = cases(&[Stage::Ends]).remove(0);
    for segment in &case.segments {
        let crate::stimulus::Stimulus::Move { target_rad, limits } = &segment.stimulus else { continue };
        if target_rad.abs() > 159.0 * DEG {
            assert!(limits.velocity_rad_per_s <= DEG * (1.0 + 1e-9), "{}", segment.label);
        }
    }
    let last = case.segments.last().expect("segments");
    assert_eq!(last.label, "back", "the point ends inside");
}

#[test]
fn a_fence_whose_beyond_leaves_the_soft_limits_is_refused() {
    let far = Keys { beyond_rad: 140.0 * DEG, ..keys(&ALL) };
    let refused = far.plan("az", &with_elevation()).expect_err("170 deg are beyond 159");
    assert!(refused[0].message.contains("does not fit into the soft limits"), "{refused:?}");
    assert!(keys(&ALL).plan("roll", &with_elevation()).is_err());
}

#[test]
fn the_ends_are_where_the_axis_rests_and_not_where_it_was_sent() {
    let case = cases(&[Stage::Ends]).remove(0);
    let index = |label: &str| case.segments.iter().position(|s| s.label == label).expect("a segment");
    let low = index(LOW_END);
    let high = index(HIGH_END);
    let place = |short: f64| {
        move |segment: usize, _t: f64| match segment {
            s if s == low => -160.0 * DEG + 2e-6,
            s if s == high => 160.0 * DEG - short,
            _ => 0.0,
        }
    };
    let whole = analysed(&case, &window(&case, &[], place(1e-6))).measurements;
    assert!((value(&whole, SPAN) - (320.0 * DEG - 3e-6)).abs() < 1e-9);
    assert!((value(&whole, LOWER) - (-160.0 * DEG + 2e-6)).abs() < 1e-9);
    assert!((value(&whole, UPPER) - (160.0 * DEG - 1e-6)).abs() < 1e-9);
    let short = analysed(&case, &window(&case, &[], place(0.5 * DEG))).measurements;
    assert!((value(&short, SPAN) - (319.5 * DEG - 2e-6)).abs() < 1e-9);
}

#[test]
fn what_stops_short_of_a_limit_is_negative_and_what_goes_past_positive_in_either_direction() {
    for case in cases(&[Stage::SoftBench]) {
        let ahead = case.requested("velocity").expect("a rate").signum();
        for (past_deg, trips) in
            [(-1.5, vec!["braking curve: az: …"]), (0.5, vec!["position: az: …"]), (4.0, vec![])]
        {
            let stops_at = ahead * (30.0 + past_deg) * DEG;
            let window = window(&case, &trips, |_, t| stops_at * (t / 1.5).min(1.0));
            let found = value(&analysed(&case, &window).measurements, PAST);
            assert!((found - past_deg * DEG).abs() < 1e-9, "{}: {} deg", case.point, found / DEG);
        }
    }
}

#[test]
fn a_limit_that_nothing_came_near_or_something_else_kept_was_not_put_to_the_test() {
    let bench = cases(&[Stage::SoftBench]).remove(0);
    let drive = cases(&[Stage::SoftDrive]).remove(0);
    let short = |_: usize, t: f64| 20.0 * DEG * (t / 1.5).min(1.0);
    for (case, trips) in [(&bench, vec![]), (&bench, vec!["following error: az: …"]), (&drive, vec![])] {
        let result = analysed(case, &window(case, &trips, short));
        let reason = result.inconclusive.map_or_else(String::new, |reason| reason.to_string());
        assert!(reason.contains("was not tested"), "{}: {reason}", case.point);
        assert!(result.measurements.iter().all(|m| m.value.is_none()));
    }
}

#[test]
fn a_zone_is_entered_where_the_angle_lies_inside_and_must_not_hinder_what_passes_beside_it() {
    let all = cases(&[Stage::Zone]);
    let reaches = |deg: f64| move |_: usize, t: f64| deg * DEG * (t / 1.5).min(1.0);
    let held = window(&all[1], &["restricted zone: az: …"], reaches(28.0));
    assert!((value(&analysed(&all[1], &held).measurements, INTO) + 2.0 * DEG).abs() < 1e-9);
    let entered = window(&all[1], &[], reaches(33.0));
    assert!((value(&analysed(&all[1], &entered).measurements, INTO) - 3.0 * DEG).abs() < 1e-9);
    let beside = all.last().expect("three points");
    assert_eq!(analysed(beside, &window(beside, &[], reaches(45.0))).inconclusive, None);
    let hindered = analysed(beside, &window(beside, &["restricted zone: az: …"], reaches(28.0)));
    assert!(hindered.inconclusive.is_some_and(|reason| reason.to_string().contains("is not restricted")));
}

#[test]
fn an_angle_that_is_no_number_and_a_log_without_the_axis_are_inconclusive() {
    let case = cases(&[Stage::SoftBench]).remove(0);
    let broken = window(&case, &["braking curve: az: …"], |_, t| if t > 1.0 { f64::NAN } else { 0.0 });
    assert!(
        analysed(&case, &broken)
            .inconclusive
            .is_some_and(|reason| reason.to_string().contains("is not a number in row 101"))
    );
    let mut empty = window(&case, &[], |_, _| 0.0);
    empty.topics.clear();
    assert!(
        analysed(&case, &empty)
            .inconclusive
            .is_some_and(|reason| reason.to_string().contains("no topic /az"))
    );
}

#[test]
fn the_map_shows_travel_limits_orders_and_where_the_axis_came_to_in_every_direction() {
    let cases = cases(&[Stage::SoftBench, Stage::Zone]);
    let axes = with_elevation();
    let points: Vec<PointResult> = cases
        .iter()
        .map(|case| {
            let stops_at = case.requested("velocity").expect("a rate").signum() * 28.5 * DEG;
            let trips = ["braking curve: az: …"];
            analysed(case, &window(case, &trips, |_, t| stops_at * (t / 1.5).min(1.0)))
        })
        .collect();
    let plots = keys(&ALL).conclude(&cases, &points, &axes).plots;
    let picture = |id: &str| plots.iter().find(|p| p.id == id).unwrap_or_else(|| panic!("no picture {id}"));
    let map = picture("soft-limits");
    assert_eq!(map.rows.len(), 6, "what passes beside a zone is no approach: {:?}", map.rows);
    assert_eq!(map.rows[3], "soft-bench, −60\u{a0}°/s");
    let series = |label: &str| map.series.iter().find(|s| s.label == label).expect("a series");
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} of {expected}");
    near(series("limit").x[3], -30.0);
    near(series("ordered to").x[3], -45.0);
    near(series("reached").x[3], -28.5);
    let marks: Vec<f64> = map.marks.iter().map(|m| m.x.round()).collect();
    assert_eq!(marks, [-160.0, 160.0, -159.0, 159.0]);
    assert!(
        picture("past-the-limit").series[0].x.iter().all(|past| (past + 1.5).abs() < 1e-9),
        "short of it"
    );
    let approaches = picture("approaches");
    assert_eq!(approaches.series.len(), 6);
    assert!(approaches.series.iter().all(|s| s.x.len() <= 400 && s.x.len() == s.y.len() && s.y.len() > 10));
}
