//! A trip in each state of the loop: it is recorded, the command changes, nothing is enabled any more, the axes stand.

use std::time::Duration;

use bench::cycle::prompt::{Answer, Question};
use procedures::case::{Mode, Then};
use procedures::log::PointStatus;
use procedures::procedure::PromptClass;
use procedures::stimulus::Stimulus;
use sim_devices::rig::Fault;

use super::bed::{Bed, Ran, case, go_to, rig, segment};

/// Long enough to trip, short enough for the drives to be seen again.
const SILENT: Fault = Fault::BusSilent { lasting: Some(Duration::from_millis(300)) };
/// Above the rig's limit, below the drive's own.
const HOT: Fault = Fault::HeatSink { drive: 0, degc: 84.5 };
const PRESSED: Fault = Fault::EmergencyStop { pressed: true };

const HALF_TICK_S: f64 = 125e-6;

/// States of the log's `state` channel.
const OP_REQUEST: u16 = 1;
const ENABLING: u16 = 2;
const MOVING: u16 = 3;
const ARRESTING: u16 = 4;
const STOPPING: u16 = 5;
const FINISHED: u16 = 6;
const TEARDOWN: u16 = 7;
const FAULT_RESET: u16 = 8;
const ASKING: u16 = 9;
const HOMING: u16 = 10;
const PARKING: u16 = 11;
const DISABLING: u16 = 12;

/// A short point with everything in it: homing, a question, a move, an arrest, a hold, parking, disabling.
fn everything() -> Bed {
    let mut there = go_to(6.0, 4.0);
    there.then = Then::Hold;
    let hold = segment(Mode::Position, Stimulus::Hold { torque_nm: 0.0 }, 0.4);
    let mut bed = Bed::new(case("az", [0.0, 38.0], vec![there, hold]));
    bed.rig = rig(&[("safe-state", "\"release\""), ("safe-pose", "\"40 deg\"")]);
    bed.start_deg = [-3.0, 38.0];
    bed.questions = [Question::new(PromptClass::Info)].into();
    bed.questions[0].give(Answer::Confirmed);
    bed.parks = true;
    bed
}

/// Time since the first tick, just before an exchange, in the middle of the longest stay in a state of the undisturbed
/// point.
fn middle_of(state: u16, undisturbed: &Ran) -> Duration {
    let window = undisturbed.window.as_ref().expect("a log");
    let times = &window.rows("/bench").expect("the loop's topic").time_s;
    let states = undisturbed.column("/bench", "state");
    let is = |k: usize| states[k] == f64::from(state);
    let stays = (0..states.len()).filter(|&k| is(k) && (k == 0 || !is(k - 1))).map(|first| {
        let last = (first..states.len()).take_while(|&k| is(k)).last().unwrap_or(first);
        (first, last)
    });
    let (first, last) = stays.max_by_key(|(first, last)| last - first).expect("it comes to this state");
    // A row carries the state after its tick: what shows in the next row is met in this state.
    Duration::from_secs_f64(times[(first + last) / 2] - times[0] + HALF_TICK_S)
}

/// How far a controlword is on the way to torque.
fn rank(controlword: f64) -> u8 {
    match controlword as u16 & 0x0F {
        0x0F => 3,
        0x07 => 2,
        0x06 => 1,
        _ => 0,
    }
}

/// First row in which the fault shows at the wire.
fn shown(ran: &Ran, fault: Fault) -> usize {
    let first = |topic, channel, is: &dyn Fn(f64) -> bool| {
        ran.column(topic, channel).iter().position(|v| is(*v)).expect("the fault shows")
    };
    match fault {
        Fault::HeatSink { .. } => first("/az", "heat_sink_degc", &|v| v > 83.0),
        Fault::EmergencyStop { .. } => first("/az", "digital_inputs", &|v| v as u32 & 8 != 0),
        _ => first("/bench", "working_counter", &|v| v != 6.0) + 2,
    }
}

/// What every trip must bring about, whatever the state; `ran` logged every tick.
fn is_acted_on(ran: &Ran, fault: Fault, trip: &str, during: u16) {
    let found = ran.outcome.trip.map(|t| t.interlock);
    assert_eq!(found, Some(trip), "state {during}: {:?}", ran.outcome);
    assert_ne!(ran.outcome.status, PointStatus::Completed, "state {during}");
    assert!(ran.outcome.safe.standstill, "state {during}: {:?}", ran.outcome);
    assert_eq!(ran.contacts, 0, "state {during}");
    let first = ran.window.as_ref().and_then(|w| w.trips.first()).expect("the log has it");
    assert!(first.starts_with(trip), "state {during}: {first}");
    let row = shown(ran, fault);
    let states = ran.column("/bench", "state");
    assert_eq!(if row == 0 { during } else { states[row - 1] as u16 }, during, "the fault fell elsewhere");
    let after = states[row] as u16;
    assert!([STOPPING, FINISHED, TEARDOWN].contains(&after), "state {during}: still {after} in its tick");
    for topic in ["/az", "/el"] {
        let words = &ran.column(topic, "controlword")[row..];
        let enabled = words.windows(2).position(|pair| rank(pair[1]) > rank(pair[0]));
        assert_eq!(enabled, None, "state {during}: {topic} was brought nearer to torque after the trip");
        let torques = ran.column(topic, "torque_command_nm");
        let done = states.iter().position(|s| *s as u16 >= FINISHED && *s as u16 <= TEARDOWN);
        let asked = torques[done.expect("it ends")..].iter().fold(0.0_f64, |most, t| most.max(t.abs()));
        assert_eq!(asked, 0.0, "state {during}: {topic} is asked for torque by a loop that has ended");
    }
}

#[test]
fn a_trip_in_each_state_is_acted_on_in_its_tick() {
    let undisturbed = everything().run();
    assert_eq!(undisturbed.outcome.status, PointStatus::Completed, "{:?}", undisturbed.outcome);
    let states = [OP_REQUEST, ENABLING, HOMING, MOVING, ARRESTING, PARKING, DISABLING, TEARDOWN];
    for state in states {
        let at = middle_of(state, &undisturbed);
        for (fault, trip) in [(HOT, "temperature"), (PRESSED, "emergency stop")] {
            let mut bed = everything();
            bed.faults = vec![(at, fault)];
            is_acted_on(&bed.run(), fault, trip, state);
        }
    }
}

/// Three frames take three ticks: states that are shorter than that are left meanwhile.
#[test]
fn a_silent_bus_in_each_lasting_state_is_acted_on_with_the_third_frame() {
    // Drives whose watchdog has bitten are in SAFE-OP and hold: nothing can be released there.
    let held = || Bed { rig: rig(&[("safe-pose", "\"40 deg\"")]), ..everything() };
    let undisturbed = held().run();
    for state in [ENABLING, HOMING, MOVING, ARRESTING, PARKING, TEARDOWN] {
        let mut bed = held();
        bed.faults = vec![(middle_of(state, &undisturbed), SILENT)];
        is_acted_on(&bed.run(), SILENT, "bus", state);
    }
}

/// Nothing is known of drives that never answered: the loop does not leave SAFE-OP for anything with torque.
#[test]
fn a_bus_that_is_silent_from_the_beginning_ends_the_point_before_op() {
    let mut bed = everything();
    bed.faults = vec![(Duration::ZERO, SILENT)];
    let ran = bed.run();
    // No sample ever came: that is what shows first.
    assert_eq!(ran.outcome.trip.map(|t| t.interlock), Some("stale data"), "{:?}", ran.outcome);
    assert_ne!(ran.outcome.status, PointStatus::Completed);
    assert!(
        ["/az", "/el"].iter().all(|topic| ran.column(topic, "controlword").iter().all(|w| rank(*w) == 0))
    );
    assert!(ran.outcome.safe.standstill, "{:?}", ran.outcome);
}

#[test]
fn a_trip_while_the_operator_is_asked_is_acted_on() {
    for class in [PromptClass::Safety, PromptClass::Info] {
        for (fault, trip) in [(HOT, "temperature"), (SILENT, "bus"), (PRESSED, "emergency stop")] {
            let mut bed = everything();
            bed.questions = [Question::new(class)].into();
            bed.faults = vec![(Duration::from_secs_f64(2.5), fault)];
            is_acted_on(&bed.run(), fault, trip, ASKING);
        }
    }
}

/// A drive that cannot be reset keeps the loop there until its time is over.
#[test]
fn a_trip_while_a_fault_is_being_reset_is_acted_on() {
    let broken = Fault::Encoder { drive: 1, fault: Some(sim_devices::rig::EncoderFault::Error) };
    for (fault, trip) in [(HOT, "temperature"), (SILENT, "bus"), (PRESSED, "emergency stop")] {
        let mut bed = everything();
        bed.faults = vec![(Duration::ZERO, broken), (Duration::from_secs_f64(0.5), fault)];
        is_acted_on(&bed.run(), fault, trip, FAULT_RESET);
    }
}

/// A drive that is enabled at the second when its partner fails must not stay enabled.
#[test]
fn a_drive_that_fails_while_enabling_takes_the_other_with_it() {
    let undisturbed = everything().run();
    let mut bed = everything();
    bed.faults = vec![(middle_of(ENABLING, &undisturbed), Fault::Drive { drive: 1, code: 0x2310 })];
    let ran = bed.run();
    assert_ne!(ran.outcome.status, PointStatus::Completed, "{:?}", ran.outcome);
    assert!(ran.outcome.safe.standstill, "{:?}", ran.outcome);
    assert!(!ran.states().contains(&MOVING), "{:?}", ran.states());
    let last = *ran.column("/az", "controlword").last().expect("rows");
    assert_eq!(rank(last), 0, "controlword {last}");
}
