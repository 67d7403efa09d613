//! Sweeps over an angle that meet a periodic torque at one phase only: what they measure is that of this phase.

use std::f64::consts::TAU;

use procedures::quantity::QuantityKind;

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
    let mut places = own.iter().map(|name| (name, places_rad(planned, name)));
    let (name, places_rad) = places.find(|(_, places_rad)| is_one_phase(places_rad, period_rad))?;
    Some(format!(
        "{}: all {} values of `{name}` lie at the same phase of the cogging (period {}); results that \
         depend on the phase are valid there alone",
        procedure.id,
        places_rad.len(),
        QuantityKind::Angle.format(period_rad)
    ))
}

/// Distinct values of a condition over the points, with the offsets of points about a pose.
fn places_rad(planned: &PlannedProcedure, name: &str) -> Vec<f64> {
    let place =
        |case: &procedures::case::Case| Some(case.requested(name)? + case.requested("offset").unwrap_or(0.0));
    let mut all: Vec<f64> = planned.cases.iter().filter_map(place).collect();
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
        assert!(!told.iter().any(|text| text.starts_with("EL-HOLD")), "{told:?}");
    }
}
