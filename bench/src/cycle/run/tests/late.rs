//! Ticks that come late, in the virtual tier.

use super::*;
use crate::clock::Lateness;

const PERIOD: Duration = Duration::from_micros(250);
/// Periods that the gap of a test misses: 8 ms, less than half of the drives' watchdog.
const GAP: u32 = 32;

/// As fast as the rig lets it: 60 deg/s, 90 deg/s².
fn slew(target_rad: f64) -> Case {
    let limits = ProfileLimits {
        velocity_rad_per_s: 60_f64.to_radians(),
        acceleration_rad_per_s2: 90_f64.to_radians(),
        jerk_rad_per_s3: 900_f64.to_radians(),
    };
    case(vec![segment(Mode::Position, Stimulus::Move { target_rad, limits }, 8.0, Then::Hold)])
}

/// One tick is late by the gap, so long after the first.
fn gap(ready: Duration, after: Duration) -> Clock {
    let from = ready + after;
    Clock::Late(Lateness {
        seed: 1,
        period: PERIOD,
        from,
        until: from + PERIOD,
        one_in: 1,
        periods: [GAP; 2],
    })
}

fn tolerant() -> Rig {
    Rig { max_missed_periods: GAP, ..sim() }
}

/// Time from the first tick to the one in which the drive shows the least torque.
fn hardest_braking(window: &Window) -> Duration {
    let torque = column(window, "/az", "torque_nm");
    let rows = window.rows("/az").expect("azimuth");
    let least = (0..torque.len()).min_by(|&a, &b| torque[a].total_cmp(&torque[b])).expect("rows");
    Duration::from_secs_f64(((rows.time_s[least] - rows.time_s[0]) / 250e-6).round() * 250e-6)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

fn following_error(window: &Window) -> f64 {
    let wanted = column(window, "/az", "position_setpoint_rad");
    let is = column(window, "/az", "position_rad");
    let errors: Vec<f64> = wanted.iter().zip(is).map(|(wanted, is)| wanted - is).collect();
    largest(&errors)
}

#[test]
fn thirty_two_missed_periods_in_full_braking_are_no_acceleration_and_no_fault() {
    let unit = UnitSettings::default();
    let (_, undisturbed) = run_case(&slew(2.0), &unit, &[], 0);
    let at = hardest_braking(&undisturbed);
    let clock = |ready| gap(ready, at);
    let bed = Bed { rig_file: tolerant(), clock: &clock, ..Bed::on(&unit) };
    let (outcome, window) = run_on(&slew(2.0), &bed);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    assert_eq!(largest(column(&window, "/bench", "missed_periods")), f64::from(GAP));
    let last = *column(&window, "/az", "position_rad").last().expect("rows");
    assert!((last - 2.0).abs() < 2e-3, "ended at {last} rad");
}

#[test]
fn a_stop_goes_on_in_time_over_the_periods_that_it_missed() {
    let unit = UnitSettings::default();
    let ordered = |window: &Window| {
        let rate = column(window, "/az", "velocity_rad_per_s");
        rate.iter().position(|rate| *rate > 0.5).expect("it was fast")
    };
    // The trip of a fence would begin the stop anywhere; a segment that is cut off begins it at 60 deg/s.
    let mut cut = slew(2.0);
    cut.segments[0].at_most_s = 1.4;
    cut.segments[0].then = Then::Stop;
    let (_, undisturbed) = run_case(&cut, &unit, &[], 0);
    assert!(ordered(&undisturbed) > 0);
    let at = hardest_braking(&undisturbed);
    let clock = |ready| gap(ready, at);
    let bed = Bed { rig_file: tolerant(), clock: &clock, ..Bed::on(&unit) };
    let (outcome, window) = run_on(&cut, &bed);
    assert_eq!(outcome.status, PointStatus::Completed, "{outcome:?}");
    let [lost, whole] = [&window, &undisturbed].map(following_error);
    assert!(lost < whole + 0.1_f64.to_radians(), "{lost} rad behind, {whole} rad without a gap");
}

#[test]
fn slews_with_as_many_missed_periods_as_the_rig_allows_arrive_without_a_trip() {
    let unit = UnitSettings::default();
    for seed in 0..3 {
        let clock = |from| {
            Clock::Late(Lateness {
                seed,
                period: PERIOD,
                from,
                until: Duration::MAX,
                one_in: 60,
                periods: [1, sim().max_missed_periods],
            })
        };
        let (outcome, window) = run_on(&slew(1.5), &Bed { clock: &clock, ..Bed::on(&unit) });
        assert_eq!(outcome.status, PointStatus::Completed, "seed {seed}: {outcome:?}");
        let missed: f64 = column(&window, "/bench", "missed_periods").iter().sum();
        assert!(missed > 500.0, "seed {seed}: {missed} periods");
        let last = *column(&window, "/az", "position_rad").last().expect("rows");
        assert!((last - 1.5).abs() < 2e-3, "seed {seed}: ended at {last} rad");
    }
}

#[test]
fn a_gyro_that_waited_for_the_loop_says_how_old_its_message_is() {
    let rig_file = sim();
    let unit = UnitSettings::default();
    let address = SeedAddress { seed: 1, procedure: "TEST".to_owned(), point: "one".to_owned() };
    let start = StartState { az_rad: 0.0, el_rad: 0.0, heat_sink_degc: 40.0 };
    let simulated = SimulatedRig::new(&unit, &address, start);
    let gains = parameters::load(&rig_file).expect("shipped parameters");
    let mut rig = OpenRig::open(Wires::simulated(&simulated), &rig_file, &gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("a healthy rig");
    let mut ages = |periods: &[u32]| {
        let mut now = rig.ready();
        let mut age = |&passed: &u32| {
            now += PERIOD * passed;
            rig.exchange(now);
            (rig.age_ticks(0), rig.feedback(0).1)
        };
        periods.iter().map(&mut age).collect::<Vec<_>>()
    };
    let ages = ages(&[0, 1, 1, 1, 1, 1, 33, 1, 1]);
    assert_eq!(ages[4..], [(0, 0), (0, 0), (0, 32), (0, 0), (0, 0)], "{ages:?}");
}

#[test]
fn a_stall_from_one_to_five_hundred_milliseconds_is_one_event_of_its_length() {
    let unit = UnitSettings::default();
    for missed_periods in [4, 40, 400, 2000] {
        let after = Duration::from_secs(1);
        let clock = |ready| match gap(ready, after) {
            Clock::Late(lateness) => Clock::Late(Lateness { periods: [missed_periods; 2], ..lateness }),
            other => other,
        };
        let rig_file = Rig { max_missed_periods: 2000, ..sim() };
        let (_, window) = run_on(&slew(0.5), &Bed { rig_file, clock: &clock, ..Bed::on(&unit) });
        let forced_s = (missed_periods * PERIOD).as_secs_f64();
        assert_eq!(window.stalls.len(), 1, "{forced_s} s: {:?}", window.stalls);
        let stall = window.stalls[0];
        assert!((stall.length_s - forced_s).abs() <= PERIOD.as_secs_f64(), "{forced_s} s: {stall:?}");
        assert_eq!(stall.missed_periods, missed_periods);
        let lateness = window.lateness.expect("time is not virtual");
        assert_eq!(lateness.missed(), u64::from(missed_periods));
        assert!((lateness.longest_stall_s() - forced_s).abs() <= PERIOD.as_secs_f64());
    }
}

#[test]
fn a_loop_that_stalls_all_the_time_tells_a_thousand_stalls_and_longer_ones_and_counts_all() {
    let unit = UnitSettings::default();
    let clock = |from| {
        Clock::Late(Lateness {
            seed: 3,
            period: PERIOD,
            from,
            until: Duration::MAX,
            one_in: 2,
            periods: [1, 8],
        })
    };
    let (_, window) = run_on(&slew(1.5), &Bed { clock: &clock, ..Bed::on(&unit) });
    let lateness = window.lateness.expect("time is not virtual");
    assert!(lateness.missed() > 5000, "{}", lateness.missed());
    assert_eq!(window.stalls.len(), 1000, "the longest is among the first");
    assert!((lateness.longest_stall_s() - 2e-3).abs() < 1e-9, "{}", lateness.longest_stall_s());
}

#[test]
fn virtual_time_tells_no_lateness() {
    let (_, window) = run_case(&slew(0.5), &UnitSettings::default(), &[], 0);
    assert_eq!((window.lateness, window.stalls), (None, Vec::new()));
}
