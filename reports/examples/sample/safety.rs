//! Trips, stops and final states of the sample: one stop within what was computed, one beyond it.

use procedures::log::{FinalState, StopManner};
use reports::record::{ComputedWorst, NotEnforcedFinding, SafetyFindings, StopFinding, TripFinding};

fn stop(point: &str, axis: &str, manner: StopManner, deg: [f64; 5], took_s: f64) -> StopFinding {
    let [from, rate, computed, reached, room] = deg.map(f64::to_radians);
    StopFinding {
        point: point.to_owned(),
        axis: axis.to_owned(),
        manner,
        from_rad: from,
        from_rad_per_s: rate,
        computed_angle_rad: computed,
        computed_s: (manner == StopManner::Controlled).then_some(0.82),
        reached_angle_rad: reached,
        took_s,
        to_rad: from + reached,
        room_rad: room,
        standstill: true,
    }
}

fn left(axis: &str, deg: f64, swing: Option<[f64; 2]>) -> FinalState {
    FinalState {
        point: 3,
        axis: axis.to_owned(),
        state: "quick stop active".to_owned(),
        held: true,
        position_rad: deg.to_radians(),
        swing_to_rad: swing.map(|[to, _]| to.to_radians()),
        swing_rad_per_s: swing.map(|[_, speed]| speed.to_radians()),
    }
}

pub(super) fn azimuth() -> SafetyFindings {
    let point = "velocity=80 deg/s";
    let trip = |first_out, reason: &str| TripFinding {
        point: point.to_owned(),
        first_out,
        reason: reason.to_owned(),
    };
    SafetyFindings {
        computed: Some(ComputedWorst {
            stop_angle_rad: 33.6_f64.to_radians(),
            stop_s: Some(0.82),
            room_rad: 78.95_f64.to_radians(),
            coast_to_rad: Some(151.2_f64.to_radians()),
            impact_energy_j: None,
            impact_rad_per_s: None,
            risks: vec!["mirror: it has no watchdog".to_owned()],
        }),
        trips: vec![
            trip(true, "following error: az: following error 1.310 deg, limit 1.000 deg"),
            trip(false, "drive state: az: drive state 0218h, limit 0027h"),
        ],
        stops: vec![
            stop(point, "az", StopManner::TorqueOff, [31.2, 78.4, 96.0, 101.5, 27.3], 2.31),
            stop(point, "el", StopManner::Controlled, [0.0, 0.12, 0.06, 0.02, 10.0], 0.03),
        ],
        left: vec![left("az", 132.7, None), left("el", 0.0, Some([39.1, 5.2]))],
    }
}

pub(super) fn elevation() -> SafetyFindings {
    SafetyFindings {
        computed: Some(ComputedWorst {
            stop_angle_rad: 2.3_f64.to_radians(),
            stop_s: Some(0.22),
            room_rad: 2.98_f64.to_radians(),
            coast_to_rad: Some(90.0_f64.to_radians()),
            impact_energy_j: Some(41.9),
            impact_rad_per_s: Some(16.8_f64.to_radians()),
            risks: vec![
                "el: without torque from 20 deg/s at 79 deg it meets its end stop with 41.9 J at 16.8 deg/s; \
                 the stops take 800 J"
                    .to_owned(),
                "mirror: it has no watchdog".to_owned(),
            ],
        }),
        left: vec![left("az", 0.0, None), left("el", 59.3, None)],
        ..SafetyFindings::default()
    }
}

pub(super) fn not_enforced() -> Vec<NotEnforcedFinding> {
    vec![NotEnforcedFinding {
        what: "soft limits (607Dh)".to_owned(),
        watched_by: "position, braking curve".to_owned(),
        why: "CST has no position demand to limit".to_owned(),
    }]
}
