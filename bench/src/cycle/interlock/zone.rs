//! Restricted zones: one axis outside a zone's interval is enough to be outside the zone.

use procedures::case::Zone;

use crate::model::stopping::REST_RAD_PER_S;

/// An axis as it comes to a zone: where it is, how fast, and the angle that a stop takes from there.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Approach {
    pub(super) angle_rad: f64,
    pub(super) rate_rad_per_s: f64,
    pub(super) stop_rad: f64,
}

/// What an axis needs and has left in front of the first zone that neither axis could stop in front of any more; none
/// while it is at rest, because there is nothing that a stop would make better.
pub(super) fn entered(zones: &[Zone], axis: usize, axes: &[Approach; 2]) -> Option<(f64, f64)> {
    let this =
        axes.get(axis).filter(|a| a.rate_rad_per_s.is_nan() || a.rate_rad_per_s.abs() > REST_RAD_PER_S)?;
    let stops = |zone: &Zone, axis: usize| {
        let Approach { angle_rad, rate_rad_per_s, stop_rad } = axes[axis];
        let (gap_rad, towards) = zone.gap_rad(axis, angle_rad);
        gap_rad > 0.0 && (rate_rad_per_s * towards <= REST_RAD_PER_S || stop_rad < gap_rad)
    };
    let zone = zones.iter().find(|zone| !(0..2).any(|axis| stops(zone, axis)))?;
    Some((this.stop_rad, zone.gap_rad(axis, this.angle_rad).0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ZONE: Zone = Zone { lower_rad: [0.5, -0.2], upper_rad: [0.9, 0.3] };

    fn at(angle_rad: f64, rate_rad_per_s: f64, stop_rad: f64) -> Approach {
        Approach { angle_rad, rate_rad_per_s, stop_rad }
    }

    #[test]
    fn azimuth_must_stop_in_front_of_a_zone_that_elevation_points_into() {
        let inside = at(0.1, 0.0, 0.0);
        assert_eq!(entered(&[ZONE], 0, &[at(0.1, 1.0, 0.3), inside]), None, "0.3 rad of 0.4");
        let late = entered(&[ZONE], 0, &[at(0.25, 1.0, 0.3), inside]);
        assert!(late.is_some_and(|(needs, left)| needs == 0.3 && (left - 0.25).abs() < 1e-12), "{late:?}");
        assert_eq!(
            entered(&[ZONE], 1, &[at(0.25, 1.0, 0.3), inside]),
            None,
            "the axis at rest is not to blame"
        );
    }

    #[test]
    fn it_may_pass_where_elevation_points_elsewhere_or_where_it_goes_away() {
        assert_eq!(entered(&[ZONE], 0, &[at(0.6, 1.0, 0.3), at(0.8, 0.0, 0.0)]), None);
        assert_eq!(entered(&[ZONE], 0, &[at(0.45, -1.0, 0.3), at(0.1, 0.0, 0.0)]), None);
        assert_eq!(entered(&[], 0, &[at(0.45, 1.0, 0.3), at(0.1, 0.0, 0.0)]), None);
    }

    #[test]
    fn what_moves_inside_and_what_is_no_number_trips() {
        let inside = at(0.1, 0.0, 0.0);
        assert!(entered(&[ZONE], 0, &[at(0.6, 1.0, 0.3), inside]).is_some());
        assert!(entered(&[ZONE], 0, &[at(f64::NAN, f64::NAN, f64::NAN), inside]).is_some());
    }
}
