use procedures::log::{Attachment, FinalState, PointStatus, StopManner, StopRecord, Window};
use reports::record::{DeviceRecord, Origin, SafetyFindings};

use super::{origin, safety};
use crate::record::log::{COMPUTED, DEVICES};

fn window(point: usize, trips: &[&str], stops: Vec<StopRecord>, left: Vec<FinalState>) -> Window {
    Window {
        point,
        status: PointStatus::Aborted,
        trips: trips.iter().map(|&t| t.to_owned()).collect(),
        stops,
        left,
        ..Window::completed(Vec::new(), Vec::new())
    }
}

fn stop(reached_rad: f64, took_s: f64) -> StopRecord {
    StopRecord {
        point: 0,
        axis: "az".to_owned(),
        manner: StopManner::Controlled,
        from_rad: 0.1,
        from_rad_per_s: 0.5,
        computed_angle_rad: 0.2,
        computed_s: Some(0.6),
        reached_angle_rad: reached_rad,
        took_s,
        to_rad: 0.1 + reached_rad,
        room_rad: 1.0,
        standstill: true,
    }
}

fn left(position_rad: f64) -> FinalState {
    FinalState {
        point: 0,
        axis: "az".to_owned(),
        state: "quick stop active".to_owned(),
        held: true,
        position_rad,
        swing_to_rad: None,
        swing_rad_per_s: None,
    }
}

#[test]
fn the_first_trip_of_a_point_is_first_out_and_the_last_point_tells_how_the_axes_were_left() {
    let mut found = SafetyFindings::default();
    safety::take(&mut found, "one", &window(0, &[], Vec::new(), vec![left(0.1)]));
    safety::take(
        &mut found,
        "two",
        &window(1, &["bus: a", "position: b"], vec![stop(0.1, 0.5)], vec![left(0.3)]),
    );
    safety::take(&mut found, "lost", &window(2, &["bus: c"], Vec::new(), Vec::new()));
    let order: Vec<(&str, bool)> = found.trips.iter().map(|t| (t.point.as_str(), t.first_out)).collect();
    assert_eq!(order, [("two", true), ("two", false), ("lost", true)]);
    assert_eq!(found.left, vec![left(0.3)]);
    assert_eq!(found.stops[0].point, "two");
}

#[test]
fn a_stop_beyond_what_was_computed_is_a_finding_by_angle_time_travel_and_rest() {
    let exceeds = |record: StopRecord| {
        let mut found = SafetyFindings::default();
        safety::take(&mut found, "p", &window(0, &[], vec![record], Vec::new()));
        found.stops[0].exceeds()
    };
    assert!(!exceeds(stop(0.2, 0.6)));
    assert!(exceeds(stop(0.2001, 0.5)), "angle");
    assert!(exceeds(stop(0.1, 0.6001)), "time");
    assert!(exceeds(StopRecord { room_rad: -1e-6, ..stop(0.1, 0.5) }), "travel");
    assert!(exceeds(StopRecord { standstill: false, ..stop(0.1, 0.5) }), "rest");
    assert!(!exceeds(StopRecord { computed_s: None, ..stop(0.1, 60.0) }), "friction has no time limit");
}

#[test]
fn what_was_computed_before_a_run_is_read_from_its_log_as_it_stands() {
    let log = |text: &str| vec![Attachment { name: COMPUTED.to_owned(), text: text.to_owned() }];
    // No rig file of ours gives these: whoever computes again, finds others.
    let text = r#"{"stop_angle_rad":7.0,"stop_s":1.5,"room_rad":-3.0,"coast_to_rad":null,"impact_energy_j":null,
        "impact_rad_per_s":null,"risks":["as the run said"]}"#;
    let found = safety::computed(&log(text)).expect("it is whole").expect("it is there");
    assert_eq!((found.stop_angle_rad, found.stop_s, found.room_rad), (7.0, Some(1.5), -3.0));
    assert_eq!(found.risks, ["as the run said"]);
    assert_eq!(safety::computed(&[]).expect("nothing is wrong with none"), None);
    assert!(safety::computed(&log("{\"stop_angle_rad\":7.0")).is_err());
}

#[test]
fn a_log_is_what_its_devices_prove_and_simulated_where_they_prove_nothing() {
    let device = |proven_real: bool| DeviceRecord {
        name: "az-drive".to_owned(),
        identity: "servo drive".to_owned(),
        // Somebody may stand beside it all the same.
        may_be_real: true,
        proven_real,
        grounds: String::new(),
    };
    let made_of = |mode: &str, devices: &[DeviceRecord]| {
        let text = serde_json::to_string(devices).expect("it has a JSON form");
        origin(mode, &[Attachment { name: DEVICES.to_owned(), text }]).expect("it is whole")
    };
    assert_eq!(made_of("simulated", &[device(false)]), Origin::Simulated);
    // The word in the plan proves nothing.
    assert_eq!(made_of("real", &[device(false)]), Origin::Simulated);
    assert_eq!(made_of("real", &[device(true), device(false)]), Origin::Mixed);
    assert_eq!(made_of("real", &[device(true)]), Origin::Real);
    assert_eq!(made_of("imported", &[device(true)]), Origin::Imported);
    assert_eq!(origin("real", &[]).expect("nothing is wrong with none"), Origin::Simulated);
}
