//! Motors that give less than the rig file says, and a DC link that takes nothing back.

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicU16;
use std::time::Duration;

use super::bed::{Bed, Ran, Wrap, case, segment};
use super::troubled::{Trouble, troubled};
use drivers::wire::{Fieldbus, SdoAbort, SdoRequest};
use procedures::case::{Case, Mode};
use procedures::log::StopManner;
use procedures::stimulus::{ProfileLimits, Stimulus};
use sim_devices::unit::UnitSettings;
use validation::intercepted::{Intercepted, Interceptor};

const DEG: f64 = PI / 180.0;

/// A drive that says of its current limit what the rig file says, whatever it really is.
struct Boasting {
    /// What it says, while it is asked for its current limit.
    boast: Option<u16>,
}

impl Interceptor for Boasting {
    fn start(&mut self, bus: &mut dyn Fieldbus, now: Duration, request: &SdoRequest<'_>) {
        self.boast = match (request.station, request.index) {
            (1, 0x6073) => Some(21_300),
            (2, 0x6073) => Some(18_100),
            _ => None,
        };
        bus.start(now, request);
    }

    fn poll(&mut self, bus: &mut dyn Fieldbus, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        let is_over = bus.poll(now, into)?;
        if let Some(permille) = self.boast.filter(|_| is_over) {
            into.clear();
            into.extend(permille.to_le_bytes());
        }
        Ok(is_over)
    }
}

fn honest() -> Wrap {
    Box::new(|bus| bus)
}

fn boasting() -> Wrap {
    Box::new(|bus| Intercepted::boxed(bus, Boasting { boast: None }))
}

/// A full move with the profile of the slews.
fn slew(axis: &str, start_deg: [f64; 2], target_deg: f64) -> Case {
    let limits = ProfileLimits {
        velocity_rad_per_s: 62.0 * DEG,
        acceleration_rad_per_s2: 93.0 * DEG,
        jerk_rad_per_s3: 900.0 * DEG,
    };
    let stimulus = Stimulus::Move { target_rad: target_deg * DEG, limits };
    case(axis, start_deg, vec![segment(Mode::Position, stimulus, 20.0)])
}

/// A bed whose following error may be 10 deg: nothing but the braking curve keeps the axis from its stop.
fn bed(case: Case, unit: UnitSettings, start_deg: [f64; 2], wrap: Wrap) -> Bed {
    let mut bed = Bed { unit, start_deg, wrap, ..Bed::new(case) };
    for axis in &mut bed.rig.axes {
        axis.guard.safety.max_following_error_rad = 10.0 * DEG;
    }
    bed
}

/// No contact, and every stop on record stayed inside the travel, where it was computed.
fn stops_well(ran: &Ran, what: &str) {
    assert_eq!(ran.contacts, 0, "{what}: {:?}", ran.outcome);
    for stop in &ran.window.as_ref().expect("this test keeps its log").stops {
        assert!(stop.room_rad > 0.0 && stop.standstill, "{what}: {stop:?}");
        assert!(stop.reached_angle_rad <= stop.computed_angle_rad, "{what}: {stop:?}");
    }
    assert!(ran.outcome.safe.standstill, "{what}");
}

/// At 28 A the command was 2.3 deg ahead of the axis when the braking curve tripped, and the stop began by catching up:
/// contact at 18 deg/s.
#[test]
fn an_elevation_at_77_percent_of_its_current_stops_inside_its_travel() {
    for (current_a, wrap) in [(28.0, honest as fn() -> Wrap), (28.0, boasting), (27.4, boasting)] {
        let mut unit = UnitSettings::default();
        unit.el.current_limit_a = current_a;
        let bed = bed(slew("el", [0.0, -5.0], 85.0), unit, [0.0, -5.0], wrap());
        stops_well(&bed.run(), &format!("{current_a} A"));
    }
}

#[test]
fn an_azimuth_that_may_fall_behind_by_ten_degrees_stops_inside_its_travel() {
    for current_a in [24.0, 30.0] {
        let mut unit = UnitSettings::default();
        unit.az.current_limit_a = current_a;
        let bed = bed(slew("az", [-100.0, 0.0], 158.0), unit, [-100.0, 0.0], boasting());
        stops_well(&bed.run(), &format!("{current_a} A"));
    }
}

/// The command waits for the motor, so that a slew ends where it was to end, late, and not in a trip.
#[test]
fn a_slew_of_a_motor_at_its_limit_ends_late_at_its_target() {
    let mut unit = UnitSettings::default();
    unit.az.current_limit_a = 30.0;
    let ran = bed(slew("az", [-60.0, 0.0], 60.0), unit, [-60.0, 0.0], honest()).run();
    assert_eq!(ran.outcome.trip, None);
    let end_rad = *ran.column("/az", "position_rad").last().expect("rows");
    assert!((end_rad - 60.0 * DEG).abs() < 0.01 * DEG, "{} deg", end_rad / DEG);
    let window = ran.window.as_ref().expect("this test keeps its log");
    let rows = window.rows("/az").expect("the axis' rows");
    let moving = &window.segments[0];
    let runs = |k: &usize| (moving.start_s + 0.001..moving.end_s).contains(&rows.time_s[*k]);
    let setpoint = ran.column("/az", "position_setpoint_rad");
    let position = ran.column("/az", "position_rad");
    let behind = (0..position.len()).filter(runs).map(|k| (setpoint[k] - position[k]).abs());
    let most = behind.fold(0.0, f64::max);
    assert!(most < 1.5 * DEG, "{} deg behind", most / DEG);
}

/// Full braking would drive the link to the drives' own shutdown, and the axis would coast from there.
#[test]
fn a_stop_does_not_feed_a_link_whose_shunt_is_open() {
    for capacitance_f in [0.5e-3, 1e-3, 2e-3] {
        let mut unit = UnitSettings::default();
        unit.supply.capacitance_f = capacitance_f;
        unit.supply.shunt_on_v = 1e6;
        let order = Arc::new(AtomicU16::new(0));
        let slew = slew("az", [-150.0, 0.0], 150.0);
        let tripped = Bed { unit, start_deg: [-150.0, 0.0], ..Bed::new(slew) };
        // In the cruise at 62 deg/s, 200 deg in front of the end.
        let wrap = troubled(8_000, Trouble::Order(Arc::clone(&order), 130));
        let ran = Bed { stop: order, wrap, ..tripped }.run();
        let most_v = ran.largest("/az", "bus_v");
        assert!(most_v < 720.0, "{capacitance_f} F: {most_v} V, the drive shuts down at 760 V");
        let stops = &ran.window.as_ref().expect("this test keeps its log").stops;
        let manner = if most_v > 680.0 { StopManner::LinkLimited } else { StopManner::Controlled };
        assert_eq!(stops.iter().map(|s| s.manner).collect::<Vec<_>>(), [manner], "{capacitance_f} F");
        assert!(capacitance_f > 1e-3 || manner == StopManner::LinkLimited, "{capacitance_f} F: {most_v} V");
        stops_well(&ran, &format!("{capacitance_f} F"));
    }
}

/// Nothing of this costs an axis anything that has what its rig file says.
#[test]
fn a_move_of_a_whole_motor_waits_for_nothing() {
    let slew = slew("el", [0.0, -5.0], 85.0);
    let planned_s = slew.segments[0].stimulus.duration_s(-5.0 * DEG).expect("a move ends");
    let ran = bed(slew, UnitSettings::default(), [0.0, -5.0], honest()).run();
    assert_eq!(ran.outcome.trip, None);
    let moved = &ran.window.as_ref().expect("this test keeps its log").segments[0];
    let lasted_s = moved.end_s - moved.start_s;
    let tick_s = 250e-6;
    assert!((lasted_s - planned_s).abs() <= tick_s, "{lasted_s} s, planned {planned_s} s");
}
