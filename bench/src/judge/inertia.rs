//! Inertias that the logs of a run show: by frequency responses of the sliding axis, and by the pulses of the polarity check.
//!
//! Both are J over the torque constant; with torque as the rig file tells it they are an inertia, whatever the constant is.

use std::collections::BTreeMap;

use procedures::measurement::Measurement;
use procedures::quantity::QuantityKind;

use super::JudgedLog;

/// Measurand of responses from torque to angle: inertia, with torque as the rig's constant tells it.
const BY_RESPONSE: &str = "apparent-inertia";
/// Measurand of the polarity check: the same by small motions about rest.
const BY_PULSES: &str = "small-motion-inertia";
/// Two inertias that are farther apart than so many of their combined standard uncertainties disagree.
const MOST_U: f64 = procedures::agreement::MOST_U;
/// Change of inertia with elevation: the director's azimuth has 1036 to 1431 kg·m² over 100°, its elevation 944 to 1021 kg·m²
/// (modes.md), 0.18 and 0.045 of their means per radian; half-widths of rectangular distributions over the angle between where
/// an inertia was measured and where it counts.
const OUTER_PER_RAD: f64 = 0.18;
const INNER_PER_RAD: f64 = 0.045;

/// Inertia at one pose, if an ampere were worth what the rig file says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Apparent {
    /// Angle of the axis that carries the payload.
    elevation_rad: f64,
    pub(super) kg_m2: f64,
    pub(super) u_kg_m2: f64,
}

/// Inertias of the axes of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Inertias {
    by_axis: BTreeMap<String, Vec<Apparent>>,
    /// Why the inertia of an axis is in doubt: the polarity check found another one.
    doubts: BTreeMap<String, String>,
}

impl Inertias {
    /// One inertia of one axis, measured at one elevation.
    #[cfg(test)]
    pub(super) fn one(axis: &str, elevation_rad: f64, kg_m2: f64, u_kg_m2: f64) -> Self {
        let found = Apparent { elevation_rad, kg_m2, u_kg_m2 };
        Self { by_axis: BTreeMap::from([(axis.to_owned(), vec![found])]), ..Self::default() }
    }

    /// What these logs found in the final build state: an earlier one has its own inertias.
    pub(super) fn found(judged: &[Option<JudgedLog>]) -> Self {
        let logs: Vec<&JudgedLog> =
            judged.iter().flatten().filter(|log| log.findings.state.is_none()).collect();
        let mut found = Self::default();
        for m in logs.iter().flat_map(|log| &log.findings.measurements).filter(|m| m.measurand == BY_RESPONSE)
        {
            if let Some(apparent) = Apparent::new(m) {
                found.by_axis.entry(m.axis.clone()).or_default().push(apparent);
            }
        }
        for log in logs {
            for m in log.findings.measurements.iter().filter(|m| m.measurand == BY_PULSES) {
                let is_outer = log.outer_axis.as_ref() == Some(&m.axis);
                if let Some(doubt) =
                    Apparent::new(m).and_then(|pulses| found.doubt(&m.axis, is_outer, &pulses))
                {
                    found.doubts.entry(m.axis.clone()).or_insert(doubt);
                }
            }
        }
        found
    }

    /// The best known inertia of an axis where elevation lies within `range_rad`; what was measured at other elevations is known less
    /// well.
    pub(super) fn best_over(
        &self,
        axis: &str,
        is_outer: bool,
        range_rad: Option<[f64; 2]>,
    ) -> Option<Apparent> {
        let per_rad = if is_outer { OUTER_PER_RAD } else { INNER_PER_RAD };
        let here = |a: &Apparent| {
            let away_rad = range_rad.map_or(0.0, |range_rad| mean_distance_rad(range_rad, a.elevation_rad));
            let of_pose = per_rad / 3_f64.sqrt() * away_rad * a.kg_m2;
            Apparent { u_kg_m2: a.u_kg_m2.hypot(of_pose), ..a.clone() }
        };
        let all = self.by_axis.get(axis)?;
        all.iter().map(here).min_by(|a, b| a.u_kg_m2.total_cmp(&b.u_kg_m2))
    }

    /// Why what the inertia of an axis takes from its torques is in doubt; `None` where nothing disagrees.
    pub(super) fn doubt_of(&self, axis: &str) -> Option<&str> {
        self.doubts.get(axis).map(String::as_str)
    }

    /// What disagrees, a sentence an axis.
    pub(super) fn doubts(&self) -> impl Iterator<Item = &str> {
        self.doubts.values().map(String::as_str)
    }

    /// The disagreement of an inertia by pulses with the responses of the same axis.
    fn doubt(&self, axis: &str, is_outer: bool, pulses: &Apparent) -> Option<String> {
        let response = self.best_over(axis, is_outer, Some([pulses.elevation_rad; 2]))?;
        let apart_u = (response.kg_m2 - pulses.kg_m2).abs() / response.u_kg_m2.hypot(pulses.u_kg_m2);
        let text = |value| QuantityKind::Inertia.format(value);
        (apart_u > MOST_U || apart_u.is_nan()).then(|| {
            format!(
                "inertia of {axis}: pulses of the polarity check show {} ± {}, responses of the sliding axis {} ± {}: \
                 {apart_u:.1} of their combined standard uncertainties apart, {MOST_U} allowed",
                text(pulses.kg_m2),
                text(pulses.u_kg_m2),
                text(response.kg_m2),
                text(response.u_kg_m2)
            )
        })
    }
}

/// Mean distance of a range from an angle, over the range.
fn mean_distance_rad([low_rad, high_rad]: [f64; 2], from_rad: f64) -> f64 {
    let [below_rad, above_rad] = [from_rad - low_rad, high_rad - from_rad];
    if below_rad > 0.0 && above_rad > 0.0 {
        0.5 * (below_rad * below_rad + above_rad * above_rad) / (below_rad + above_rad)
    } else {
        0.5 * (above_rad - below_rad).abs()
    }
}

impl Apparent {
    /// A measured inertia; `None` where there is no number or no elevation.
    fn new(m: &Measurement) -> Option<Self> {
        let elevation = m.conditions.iter().find(|c| c.name == "elevation")?.requested;
        let value = m.value.filter(|kg_m2| kg_m2.is_finite() && *kg_m2 > 0.0)?;
        m.inconclusive.is_none().then_some(Self { elevation_rad: elevation, kg_m2: value, u_kg_m2: m.u })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apparent(elevation_deg: f64, kg_m2: f64, u_kg_m2: f64) -> Apparent {
        Apparent { elevation_rad: elevation_deg.to_radians(), kg_m2, u_kg_m2 }
    }

    fn azimuth(all: Vec<Apparent>) -> Inertias {
        Inertias { by_axis: BTreeMap::from([("az".to_owned(), all)]), ..Inertias::default() }
    }

    #[test]
    fn an_inertia_counts_where_it_was_measured_and_is_less_certain_elsewhere() {
        let all = azimuth(vec![
            apparent(0.0, 1121.0, 10.0),
            apparent(60.0, 1240.0, 10.0),
            apparent(60.0, 1238.0, 12.0),
        ]);
        let at = |elevation_deg: f64| {
            all.best_over("az", true, Some([elevation_deg.to_radians(); 2])).expect("three were measured")
        };
        assert_eq!((at(0.0).kg_m2, at(0.0).u_kg_m2), (1121.0, 10.0));
        assert_eq!((at(60.0).kg_m2, at(60.0).u_kg_m2), (1240.0, 10.0));
        // 0.18 of 1240 over 30 deg, rectangular: 67 kg*m^2; it lies between.
        let between = at(30.0);
        assert!((between.u_kg_m2 - 61.0).abs() < 8.0, "{between:?}");
        assert!(all.best_over("el", false, None).is_none());
    }

    /// Strokes over -8 … 88 deg are 24 deg from their middle on average, and 48 deg from either end.
    #[test]
    fn over_a_span_an_inertia_is_less_certain_even_if_it_was_measured_in_its_middle() {
        let span_rad = [-8_f64, 88.0].map(f64::to_radians);
        let u_ratio = |elevation_deg: f64| {
            let elevation = Inertias::one("el", elevation_deg.to_radians(), 980.0, 0.0);
            elevation.best_over("el", false, Some(span_rad)).expect("it was measured").u_kg_m2 / 980.0
        };
        let per_deg = INNER_PER_RAD / 3_f64.sqrt() * 1_f64.to_radians();
        for (elevation_deg, mean_deg) in
            [(40.0, 24.0), (-8.0, 48.0), (88.0, 48.0), (-10.0, 50.0), (0.0, 40.67)]
        {
            assert!((u_ratio(elevation_deg) / per_deg - mean_deg).abs() < 0.01, "{elevation_deg} deg");
        }
    }

    #[test]
    fn pulses_that_show_another_inertia_than_responses_put_it_in_doubt_and_the_elevation_between_them_counts()
    {
        let all = azimuth(vec![apparent(40.0, 1245.0, 12.0)]);
        assert_eq!(all.doubt("az", true, &apparent(40.0, 1210.0, 16.0)), None);
        let doubt = all.doubt("az", true, &apparent(40.0, 1150.0, 16.0)).expect("4.8 u apart");
        assert!(doubt.starts_with("inertia of az: pulses of the polarity check show 1150"), "{doubt}");
        assert_eq!(all.doubt("az", true, &apparent(0.0, 1121.0, 16.0)), None, "0.18 per radian of elevation");
        assert_eq!(all.doubt("el", false, &apparent(40.0, 900.0, 1.0)), None, "nothing to compare with");
    }
}
