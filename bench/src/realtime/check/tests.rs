use super::*;
use crate::realtime::facts::Interface;

fn measured(rate_hz: f64, loaded: bool, ticks: u32, stalls: &[(f64, u32)]) -> Measured {
    let mut histogram = LatenessHistogram::default();
    (0..ticks).for_each(|_| histogram.count(Duration::from_micros(20), 0));
    stalls.iter().for_each(|&(late_s, missed)| histogram.count(Duration::from_secs_f64(late_s), missed));
    Measured { rate_hz, loaded, histogram }
}

#[test]
fn a_rate_is_held_below_a_thousandth_of_missed_periods_and_five_milliseconds() {
    assert!(measured(1000.0, false, 10_000, &[(2.1e-3, 2)]).holds());
    assert!(!measured(1000.0, false, 1000, &[(2.1e-3, 2)]).holds(), "2 of 1003 periods");
    assert!(!measured(1000.0, false, 100_000, &[(5.0e-3, 5)]).holds(), "5 ms");
}

#[test]
fn a_rate_must_be_held_idle_and_loaded() {
    let report = |stalls: &[(f64, u32)]| Report {
        asked_hz: 1000.0,
        grants: Vec::new(),
        facts: Facts::default(),
        measured: vec![measured(1000.0, false, 10_000, &[]), measured(1000.0, true, 10_000, stalls)],
    };
    assert!(report(&[]).holds(1000.0));
    assert!(!report(&[(8e-3, 8)]).holds(1000.0));
    assert!(!report(&[]).holds(2000.0), "it was not measured");
    assert!((report(&[(8e-3, 8)]).longest_stall_s() - 8e-3).abs() < 1e-12);
}

#[test]
fn the_asked_rate_is_measured_once_among_the_others() {
    let each = Duration::from_secs(4);
    let rates = |asked_hz| rounds(asked_hz, each).iter().map(|round| round.rate_hz).collect::<Vec<_>>();
    assert_eq!(rates(4000.0), [1000.0, 1000.0, 2000.0, 2000.0, 4000.0, 4000.0, 8000.0, 8000.0]);
    assert_eq!(rates(500.0)[..4], [500.0, 500.0, 1000.0, 1000.0]);
    assert!(rounds(500.0, each).iter().all(|round| round.lasts == each / 2));
}

fn refused(what: &str) -> Grant {
    Grant {
        what: what.to_owned(),
        granted: false,
        found: "EPERM".to_owned(),
        remedy: Some("grant it".to_owned()),
    }
}

fn subjects(grants: &[Grant], facts: &Facts) -> Vec<String> {
    let subject =
        |line: &String| line.split_once(": ").map_or(line.as_str(), |(subject, _)| subject).to_owned();
    advice(grants, facts).iter().map(subject).collect()
}

#[test]
fn advice_begins_with_what_has_most_effect_and_ends_where_nothing_is_left() {
    let bare = Facts {
        online: vec![0, 1],
        is_virtual_machine: true,
        governors: vec!["powersave".to_owned()],
        wakes_within_us: Some(1034),
        clocksource: Some("hpet".to_owned()),
        ..Facts::default()
    };
    let grants = ["real-time priority", "processors that wake at once", "locked memory"].map(refused);
    let named = [
        "real-time priority",
        "hypervisor",
        "kernel",
        "kernel command line",
        "idle states",
        "governor",
        "locked memory",
        "clocksource",
    ];
    assert_eq!(subjects(&grants, &bare), named);
    let prepared = Facts {
        online: vec![0, 1, 2, 3],
        isolated: vec![3],
        without_tick: vec![3],
        is_realtime: true,
        governors: vec!["performance".to_owned()],
        clocksource: Some("tsc".to_owned()),
        ..Facts::default()
    };
    assert_eq!(advice(&[], &prepared), [""; 0]);
}

#[test]
fn interrupts_of_the_interface_are_named_where_they_interrupt_the_loop() {
    let interface = |processor: &str| Facts {
        online: vec![0, 1],
        isolated: vec![1],
        without_tick: vec![1],
        is_realtime: true,
        interface: Some(Interface {
            name: "eth1".to_owned(),
            exists: true,
            interrupts: vec![(44, processor.to_owned()), (45, "0".to_owned())],
        }),
        ..Facts::default()
    };
    assert_eq!(advice(&[], &interface("0")), [""; 0]);
    let advice = advice(&[], &interface("0-1"));
    assert!(
        advice.len() == 1 && advice[0].contains("eth1: 44 interrupt the loop on processor 1"),
        "{advice:?}"
    );
}

#[test]
fn a_loop_is_measured_with_whatever_rights_there_are() {
    let lasts = Duration::from_millis(20);
    let round = |loaded| Round { rate_hz: 1000.0, loaded, lasts };
    let (grants, measured) = measure(vec![round(false), round(true)]).expect("a thread");
    assert_eq!((grants.len(), measured.len()), (5, 2));
    for loop_ in measured {
        let periods = loop_.histogram.ticks() + loop_.histogram.missed();
        assert!(periods >= 19, "{periods} of 20 ms, however late the ticks came");
    }
}
