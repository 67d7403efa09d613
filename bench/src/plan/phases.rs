//! Sweeps over an angle that meet a periodic torque at one phase only: what they measure is that of this phase.

use std::f64::consts::TAU;

use procedures::case::Segment;
use procedures::quantity::QuantityKind;
use procedures::stimulus::Stimulus;

use super::PlannedProcedure;
use crate::model::rig::Rig;

/// Fewest angles that are a sweep.
const FEWEST: usize = 3;
/// Phases that differ by no more than this part of a period are one.
const TOLERANCE: f64 = 0.05;

/// A sentence for each sweep of an axis over an angle of its own, all of whose places are whole cogging periods apart.
pub(crate) fn one_phase(procedures: &[PlannedProcedure], rig: &Rig) -> Vec<String> {
    procedures.iter().filter_map(|planned| sweep(planned, rig)).collect()
}

fn sweep(planned: &PlannedProcedure, rig: &Rig) -> Option<String> {
    let procedure = &planned.procedure;
    let axis = rig.axes.iter().find(|axis| axis.name == procedure.axis)?;
    let own =
        if axis.carried_by.is_some() { &["pose", "target", "elevation"][..] } else { &["pose", "target"] };
    let period_rad = TAU / axis.limits.cogging_orders_per_rev;
    let swept = own.iter().map(|name| (format!("values of `{name}`"), places_rad(planned, name)));
    let moved = std::iter::once(("places that it moves to".to_owned(), ends_rad(planned)));
    let (name, places_rad) =
        swept.chain(moved).find(|(_, places_rad)| is_one_phase(places_rad, period_rad))?;
    Some(format!(
        "{}: all {} {name} lie at the same phase of the cogging (period {}); results that depend on the \
         phase are valid there alone",
        procedure.id,
        places_rad.len(),
        QuantityKind::Angle.format(period_rad)
    ))
}

/// Distinct places at which an axis rests after a move within a point, such as cues and the targets of an accuracy test.
fn ends_rad(planned: &PlannedProcedure) -> Vec<f64> {
    let end_rad = |segment: &Segment| match segment.stimulus {
        Stimulus::Move { target_rad, .. } | Stimulus::Step { target_rad } => Some(target_rad),
        _ => None,
    };
    let pairs = planned.cases.iter().flat_map(|case| case.segments.windows(2));
    let rests = pairs.filter(|pair| end_rad(&pair[1]).is_none());
    distinct(rests.filter_map(|pair| end_rad(&pair[0])).collect())
}

/// Distinct values of a condition over the points, with the offsets of points about a pose.
fn places_rad(planned: &PlannedProcedure, name: &str) -> Vec<f64> {
    let place =
        |case: &procedures::case::Case| Some(case.requested(name)? + case.requested("offset").unwrap_or(0.0));
    distinct(planned.cases.iter().filter_map(place).collect())
}

fn distinct(mut all: Vec<f64>) -> Vec<f64> {
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

fn is_one_phase(places_rad: &[f64], period_rad: f64) -> bool {
    let Some(first_rad) = places_rad.first() else { return false };
    let off = |place_rad: &f64| {
        let periods = (place_rad - first_rad) / period_rad;
        (periods - periods.round()).abs()
    };
    places_rad.len() >= FEWEST && places_rad.iter().all(|place_rad| off(place_rad) <= TOLERANCE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::rig::read_rig;
    use crate::files::shipped::{self, Folder};
    use crate::plan::{Wanted, plan};

    #[test]
    fn poses_that_are_whole_periods_apart_are_one_phase_and_thirds_are_three() {
        let period = 1.0 / 108.0;
        assert!(is_one_phase(&[0.0, 6.0 * period, 12.01 * period], period));
        assert!(!is_one_phase(&[0.0, 6.333 * period, 12.0 * period], period));
        assert!(!is_one_phase(&[0.0, 6.0 * period], period), "two places are no sweep");
    }

    #[test]
    fn the_campaign_tells_its_sweeps_over_one_phase_and_holding_is_none_of_them() {
        let rig = shipped::find(Folder::Rigs, "sim", None).and_then(read_rig).expect("the shipped rig");
        let wanted = Wanted { names: vec!["fat".to_owned()], ..Wanted::default() };
        let plan = plan(&wanted, &rig).expect("the campaign is right");
        let told = one_phase(&plan.procedures, &rig);
        assert!(told.iter().any(|text| text.starts_with("EL-STATIC: all 5 values of `pose`")), "{told:?}");
        // Places within a point: the faces of the polygons are whole periods of azimuth apart, 2.5 deg each, and so are its cues.
        for moved in ["AZ-ACCURACY: all 10 places", "AZ-CUE: all 4 places"] {
            assert!(told.iter().any(|text| text.starts_with(moved)), "{moved}: {told:?}");
        }
        assert!(!told.iter().any(|text| text.starts_with("EL-HOLD")), "{told:?}");
    }
}
