use super::*;
use crate::case::Request;
use crate::measurement::Reduced;
use crate::reason::{Ending, Reason};

fn case(elevation_rad: f64, level: &str) -> Case {
    Case {
        point: format!("{elevation_rad} {level}"),
        axis: "az".to_owned(),
        requested: vec![Request { name: ELEVATION.to_owned(), value: elevation_rad, kind: Q::Angle }],
        ..Case::default()
    }
}

/// A point with parts: from, to, ratio, standard deviation of its square.
fn point(case: &Case, parts: &[[f64; 4]]) -> PointResult {
    let part = |&[from_hz, to_hz, ratio, sd]: &[f64; 4]| Part {
        band_hz: [from_hz, to_hz],
        square: ratio * ratio,
        variance: sd * sd,
        lines: 9,
    };
    let coupling = Coupling {
        elevation_rad: None,
        parts: parts.iter().map(part).collect(),
        frequency_hz: Vec::new(),
        ratio: Vec::new(),
    };
    let reduced = Reduced::to(Kept { coupling: Some(coupling), ..Kept::default() });
    PointResult { reduced, ..PointResult::of(case) }
}

fn lost_point(case: &Case) -> PointResult {
    let inconclusive = Some(Reason::BrokenOff { ending: Ending::Aborted, trips: Vec::new() });
    PointResult { point: case.point.clone(), inconclusive, ..PointResult::default() }
}

fn low(all: &[Measurement]) -> Vec<&Measurement> {
    all.iter().filter(|m| m.measurand == NAMES[0]).collect()
}

const QUIET: [f64; 4] = [2.5, 5.0, 5e-4, 4e-8];
const HIGH: [f64; 4] = [20.0, 25.0, 4e-3, 4e-7];

#[test]
fn an_elevation_whose_points_are_lost_is_inconclusive_and_does_not_vanish() {
    let cases = [case(0.0, "6 V"), case(0.5, "6 V"), case(0.5, "8 V"), case(1.0, "6 V"), case(1.0, "8 V")];
    let points = [
        point(&cases[0], &[QUIET, HIGH]),
        lost_point(&cases[1]),
        lost_point(&cases[2]),
        lost_point(&cases[3]),
        point(&cases[4], &[QUIET, HIGH]),
    ];
    let all = conclude(&cases, &points);
    let told: Vec<(f64, bool)> =
        low(&all).iter().map(|m| (m.conditions[0].requested, m.value.is_some())).collect();
    assert_eq!(told, [(0.0, true), (0.5, false), (1.0, true)]);
    let lost = low(&all)[1];
    assert_eq!(lost.inconclusive.as_deref(), Some("the point was aborted"));
}

#[test]
fn a_band_that_nobody_resolved_is_told_beside_the_one_that_surely_couples() {
    let cases = [case(0.0, "6 V")];
    // 0.05 % for sure in one octave, anything up to 0.5 % in the next.
    let all = conclude(&cases, &[point(&cases[0], &[QUIET, [5.25, 10.0, 2e-3, 1e-5], HIGH])]);
    let told = low(&all);
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told[0].flags[0].starts_with("worst from 2.50 Hz"), "{:?}", told[0].flags);
    assert!(told[1].flags[0].starts_with("least certain from 5.25 Hz"), "{:?}", told[1].flags);
    let upper = told[1].value.expect("a value") + 2.0 * told[1].u;
    assert!(upper > 3e-3, "the limit of 0.3 % is not met for sure: {upper}");
    assert_eq!(all.iter().filter(|m| m.measurand == NAMES[1]).count(), 1, "one part above 10 Hz");
}
