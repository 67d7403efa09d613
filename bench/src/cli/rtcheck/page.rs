//! What `bench rtcheck` prints.

use procedures::log::LatenessHistogram;
use procedures::quantity::QuantityKind;
use serde_json::json;

use crate::cli::output;
use crate::realtime::check::{LONGEST_S, MISSED_RATIO, Measured, Report, WORK, advice};
use crate::realtime::facts::{Facts, Interface, processors_text};

/// The page for people.
pub(super) fn text(report: &Report) -> String {
    let mut parts = vec![rights(report), machine(&report.facts), loops(report)];
    parts.extend(report.asked().map(|asked| histogram(&asked.histogram, report.asked_hz)));
    parts.extend([changes(report), verdict(report)]);
    parts.retain(|part| !part.is_empty());
    parts.join("\n\n")
}

/// The same as data.
pub(super) fn json(report: &Report) -> String {
    let measured = report.measured.iter().map(|m| {
        let quantile_s = |share| m.histogram.quantile_s(share);
        json!({
            "rate_hz": m.rate_hz,
            "loaded": m.loaded,
            "holds": m.holds(),
            "missed_ratio": m.histogram.missed_ratio(),
            "p50_s": quantile_s(0.5),
            "p99_s": quantile_s(0.99),
            "p99_9_s": quantile_s(0.999),
            "lateness": m.histogram,
        })
    });
    let held: Vec<f64> = report.rates_hz().into_iter().filter(|&rate_hz| report.holds(rate_hz)).collect();
    let whole = json!({
        "asked_hz": report.asked_hz,
        "holds": report.holds(report.asked_hz),
        "held_hz": held,
        "longest_stall_s": report.longest_stall_s(),
        "grants": report.grants,
        "facts": report.facts,
        "measured": measured.collect::<Vec<_>>(),
        "advice": advice(&report.grants, &report.facts),
    });
    serde_json::to_string_pretty(&whole).expect("numbers and texts have a JSON form")
}

fn section(heading: &str, rows: &[Vec<String>]) -> String {
    let table = output::table(rows);
    let lines = table.lines().map(|line| format!("  {}", line.trim_end()));
    std::iter::once(heading.to_owned()).chain(lines).collect::<Vec<_>>().join("\n")
}

fn rights(report: &Report) -> String {
    let row = |grant: &reports::record::Grant| {
        let word = if grant.granted { "yes" } else { "NO" };
        vec![grant.what.clone(), word.to_owned(), grant.found.clone()]
    };
    section("Rights of the loop's thread", &report.grants.iter().map(row).collect::<Vec<_>>())
}

fn machine(facts: &Facts) -> String {
    let unknown = || "unknown".to_owned();
    let kernel = [facts.kernel.as_deref(), facts.preemption.as_deref()];
    let sort = if facts.is_realtime { "a real-time kernel" } else { "no real-time kernel" };
    let host = facts.is_virtual_machine.then_some("a virtual machine");
    let kernel: Vec<&str> = kernel.into_iter().flatten().chain([sort]).chain(host).collect();
    let governors = if facts.governors.is_empty() { "none".to_owned() } else { facts.governors.join(", ") };
    let idle = facts.wakes_within_us.map_or_else(unknown, |latency_us| format!("up to {latency_us} us"));
    let limit = facts.rt_runtime_us.map_or_else(unknown, |runtime_us| match runtime_us {
        ..0 => "no limit".to_owned(),
        _ => format!("{runtime_us} us of each second"),
    });
    let mut rows = vec![
        ("kernel", kernel.join(", ")),
        ("processors", processors_text(&facts.online)),
        ("isolcpus", processors_text(&facts.isolated)),
        ("nohz_full", processors_text(&facts.without_tick)),
        ("clocksource", facts.clocksource.clone().unwrap_or_else(unknown)),
        ("governor", governors),
        ("waking from idle", idle),
        ("real-time threads", limit),
    ];
    if let Some(interface) = &facts.interface {
        rows.push(("interrupts", interrupts(interface)));
    }
    let rows: Vec<Vec<String>> = rows.into_iter().map(|(name, value)| vec![name.to_owned(), value]).collect();
    section("Machine", &rows)
}

fn interrupts(interface: &Interface) -> String {
    let name = &interface.name;
    if !interface.exists {
        return format!("no interface `{name}`");
    }
    let one = |(number, list): &(u32, String)| format!("{number} on {list}");
    let all: Vec<String> = interface.interrupts.iter().map(one).collect();
    if all.is_empty() { format!("{name} has none") } else { format!("{name}: {}", all.join(", ")) }
}

fn microseconds(time_s: Option<f64>) -> String {
    time_s.map_or_else(|| "-".to_owned(), |time_s| format!("{:.0} us", 1e6 * time_s))
}

fn percent(ratio: f64) -> String {
    format!("{:.3} %", 100.0 * ratio)
}

fn rate(rate_hz: f64) -> String {
    match rate_hz {
        1000.0.. => format!("{} kHz", rate_hz / 1000.0),
        _ => QuantityKind::Frequency.format(rate_hz),
    }
}

fn loops(report: &Report) -> String {
    let head = ["rate", "tick", "ticks", "missed", "p50", "p99", "p99.9", "largest", "longest stall", "held"];
    let row = |m: &Measured| {
        let Measured { rate_hz, loaded, histogram } = m;
        vec![
            rate(*rate_hz),
            if *loaded { format!("{} us of work", WORK.as_micros()) } else { "empty".to_owned() },
            histogram.ticks().to_string(),
            format!("{} ({})", histogram.missed(), percent(histogram.missed_ratio())),
            microseconds(histogram.quantile_s(0.5)),
            microseconds(histogram.quantile_s(0.99)),
            microseconds(histogram.quantile_s(0.999)),
            microseconds(Some(histogram.largest_s())),
            microseconds(Some(histogram.longest_stall_s()).filter(|stall_s| *stall_s > 0.0)),
            if m.holds() { "yes" } else { "NO" }.to_owned(),
        ]
    };
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    rows.extend(report.measured.iter().map(row));
    section("Lateness of ticks", &rows)
}

/// Bins from the first that is not empty to the last; the bars are logarithmic, so that a single late tick shows.
fn histogram(histogram: &LatenessHistogram, rate_hz: f64) -> String {
    const LONGEST_BAR: f64 = 40.0;
    let bins: Vec<([f64; 2], u32)> = histogram.bins().collect();
    let first = bins.iter().position(|(_, count)| *count > 0);
    let last = bins.iter().rposition(|(_, count)| *count > 0);
    let Some((first, last)) = first.zip(last) else { return String::new() };
    let bar = |count: u32| match count {
        0 => String::new(),
        _ => "#".repeat((LONGEST_BAR * f64::from(count).log2().max(0.5) / 32.0).ceil() as usize),
    };
    let limits = |[from_s, to_s]: [f64; 2]| match to_s.is_finite() {
        true => format!("{} .. {}", short(from_s), short(to_s)),
        false => format!("from {}", short(from_s)),
    };
    let row = |(edges, count): &([f64; 2], u32)| vec![limits(*edges), count.to_string(), bar(*count)];
    let rows: Vec<Vec<String>> = bins[first..=last].iter().map(row).collect();
    section(&format!("Ticks by lateness at {} with work (logarithmic bars)", rate(rate_hz)), &rows)
}

/// A limit of a bin: three digits say all of it.
fn short(time_s: f64) -> String {
    if time_s < 1e-3 {
        format!("{} us", rounded(1e6 * time_s))
    } else {
        format!("{} ms", rounded(1e3 * time_s))
    }
}

fn rounded(value: f64) -> f64 {
    (100.0 * value).round() / 100.0
}

fn changes(report: &Report) -> String {
    let advice = advice(&report.grants, &report.facts);
    if advice.is_empty() {
        return String::new();
    }
    let numbered = advice.iter().enumerate().map(|(k, line)| format!("  {}. {line}", k + 1));
    let lines = numbered.collect::<Vec<_>>().join("\n");
    format!("What to change, in order of effect (docs/realtime.md)\n{lines}")
}

fn verdict(report: &Report) -> String {
    let (held, not_held): (Vec<f64>, Vec<f64>) =
        report.rates_hz().into_iter().partition(|&rate_hz| report.holds(rate_hz));
    let names = |rates_hz: &[f64]| match rates_hz {
        [] => "none".to_owned(),
        _ => rates_hz.iter().map(|&rate_hz| rate(rate_hz)).collect::<Vec<_>>().join(", "),
    };
    let word = if report.holds(report.asked_hz) { "is held" } else { "is NOT held" };
    format!(
        "Held with less than {} missed and every stall below {}: {}; not held: {}\nlongest stall of all \
         loops: {}\n{} {word}",
        QuantityKind::Ratio.format(MISSED_RATIO),
        short(LONGEST_S),
        names(&held),
        names(&not_held),
        match report.longest_stall_s() {
            0.0 => "none".to_owned(),
            stall_s => short(stall_s),
        },
        rate(report.asked_hz),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    use reports::record::Grant;

    fn measured(rate_hz: f64, loaded: bool, late_us: &[(u64, u32)], stalls_us: &[u64]) -> Measured {
        let mut histogram = LatenessHistogram::default();
        for &(late_us, ticks) in late_us {
            (0..ticks).for_each(|_| histogram.count(Duration::from_micros(late_us), 0));
        }
        for &late_us in stalls_us {
            let missed = (1e-6 * late_us as f64 * rate_hz) as u32;
            histogram.count(Duration::from_micros(late_us), missed);
        }
        Measured { rate_hz, loaded, histogram }
    }

    fn report() -> Report {
        let grant = |what: &str, found: &str, remedy: Option<&str>| Grant {
            what: what.to_owned(),
            granted: remedy.is_none(),
            found: found.to_owned(),
            remedy: remedy.map(str::to_owned),
        };
        let facts = Facts {
            kernel: Some("6.12.8".to_owned()),
            preemption: Some("PREEMPT_DYNAMIC".to_owned()),
            online: vec![0, 1, 2, 3],
            governors: vec!["powersave".to_owned()],
            clocksource: Some("tsc".to_owned()),
            wakes_within_us: Some(133),
            rt_runtime_us: Some(950_000),
            interface: Some(Interface {
                name: "enp3s0".to_owned(),
                exists: true,
                interrupts: vec![(44, "0-3".to_owned()), (131, "2".to_owned())],
            }),
            ..Facts::default()
        };
        let grants = vec![
            grant("real-time priority", "SCHED_FIFO 80", None),
            grant("locked memory", "cannot allocate", Some("`ulimit -l unlimited`")),
        ];
        let measured = vec![
            measured(1000.0, false, &[(3, 4900), (20, 100)], &[]),
            measured(1000.0, true, &[(3, 4900), (70, 99)], &[1200]),
            measured(4000.0, false, &[(3, 19_000), (70, 990)], &[]),
            measured(4000.0, true, &[(3, 19_000), (20, 700), (70, 200), (200, 7)], &[6800, 900]),
        ];
        Report { asked_hz: 4000.0, grants, facts, measured }
    }

    #[test]
    fn the_page_of_a_machine_that_does_not_hold_the_rate() {
        insta::assert_snapshot!(text(&report()));
    }

    #[test]
    fn the_data_say_what_the_page_says() {
        let value: serde_json::Value = serde_json::from_str(&json(&report())).expect("it is JSON");
        assert_eq!(value["holds"], false);
        assert_eq!(value["held_hz"], serde_json::json!([1000.0]));
        assert_eq!(value["measured"][3]["lateness"]["missed_periods"], 30);
        assert_eq!(value["grants"][1]["remedy"], "`ulimit -l unlimited`");
        assert!(value["advice"].as_array().is_some_and(|all| all.len() == 5), "{}", value["advice"]);
    }

    #[test]
    fn a_rate_that_is_held_and_nothing_measured_are_said_as_well() {
        let held = Report { asked_hz: 1000.0, ..report() };
        assert!(text(&held).ends_with("1 kHz is held"));
        let nothing = Report { measured: Vec::new(), ..report() };
        assert!(text(&nothing).ends_with("4 kHz is NOT held"));
    }
}
