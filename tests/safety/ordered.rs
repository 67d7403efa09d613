//! Ordered stops at any speed: what was computed holds.

use std::sync::Arc;

use procedures::case::Mode;
use procedures::log::StopManner;
use procedures::stimulus::{ProfileLimits, Stimulus};
use sim_devices::unit::UnitSettings;

use super::bed::{Bed, Ran, case, segment};
use super::troubled::{Trouble, troubled};

/// A move from `from_deg` over `way_deg`; the order comes when it has passed two thirds of its acceleration and cruise.
fn stopped(unit: UnitSettings, axis: &str, from_deg: f64, way_deg: f64, rate_deg_per_s: f64) -> Ran {
    let limits = ProfileLimits {
        velocity_rad_per_s: rate_deg_per_s.to_radians(),
        acceleration_rad_per_s2: 80.0_f64.to_radians(),
        jerk_rad_per_s3: 900.0_f64.to_radians(),
    };
    let target_rad = (from_deg + way_deg).to_radians();
    let start_deg = if axis == "az" { [from_deg, 0.0] } else { [0.0, from_deg] };
    let move_there = segment(Mode::Position, Stimulus::Move { target_rad, limits }, 20.0);
    let mut bed = Bed::new(case(axis, start_deg, vec![move_there]));
    (bed.unit, bed.start_deg) = (unit, start_deg);
    let order = Trouble::Order(Arc::clone(&bed.stop), 130);
    // A move that reaches its rate has it half of the way.
    let half_s = 0.5 * way_deg.abs() / rate_deg_per_s + 0.5 * rate_deg_per_s / 80.0;
    bed.wrap = troubled(600 + (half_s * 4000.0) as u32, order);
    bed.run()
}

#[test]
fn an_ordered_stop_takes_no_more_than_was_computed() {
    for (axis, from_deg, way_deg) in
        [("az", -60.0, 120.0), ("az", 60.0, -120.0), ("el", 0.0, 80.0), ("el", 80.0, -80.0)]
    {
        for rate in [1.0, 5.0, 20.0, 40.0, 60.0] {
            let ran = stopped(UnitSettings::default(), axis, from_deg, way_deg * (rate / 60.0), rate);
            let stops = &ran.window.as_ref().expect("a log").stops;
            let stop = stops.iter().find(|stop| stop.axis == axis).expect("it moved");
            assert!(stop.from_rad_per_s.abs() > 0.9 * rate.to_radians(), "{stop:?}");
            assert!(stop.reached_angle_rad <= stop.computed_angle_rad, "{stop:?}");
            assert!(stop.computed_s.is_some_and(|s| stop.took_s <= s), "{stop:?}");
            assert_eq!(stop.manner, StopManner::Controlled, "{stop:?}");
            assert!(stop.standstill && ran.contacts == 0, "{stop:?}");
        }
    }
}
