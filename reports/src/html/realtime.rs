//! Real time: what the loop's thread was granted, and how late its ticks came. Runs in virtual time have no such section.

use procedures::log::LatenessHistogram;
use procedures::trace::{Mark, Plot, Scale, Series, Style};

use super::{section, table_head, zoom};
use crate::markup::Markup;
use crate::number;
use crate::plot::{self, Figure};
use crate::record::{LatenessRecord, Results, RunRecord};

/// Whether there is anything to say.
pub(super) fn is_known(record: &RunRecord) -> bool {
    !record.grants.is_empty() || !record.lateness.is_empty()
}

/// The whole section.
pub(super) fn write(m: &mut Markup, results: &Results) {
    let record = &results.record;
    if !is_known(record) {
        return;
    }
    section(m, "real-time", "Real time");
    grants(m, record);
    lateness(m, record);
    m.close();
}

fn grants(m: &mut Markup, record: &RunRecord) {
    if record.grants.is_empty() {
        return;
    }
    m.open("table", &[]);
    table_head(m, &["The loop asked for", "Granted", "Found", "Remedy"].map(|head| ("", head)));
    m.open("tbody", &[]);
    for grant in &record.grants {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], &grant.what);
        m.element("td", &[], if grant.granted { "yes" } else { "NO" });
        m.element("td", &[], &grant.found);
        m.element("td", &[], grant.remedy.as_deref().unwrap_or("—"));
        m.close();
    }
    m.close();
    m.close();
}

/// The parts of a log together.
struct OfLog<'a> {
    log: &'a str,
    loop_rate_hz: f64,
    points: usize,
    histogram: LatenessHistogram,
}

/// Every log once, in the order of the record.
fn by_log(records: &[LatenessRecord]) -> Vec<OfLog<'_>> {
    let mut logs: Vec<OfLog<'_>> = Vec::new();
    for record in records {
        match logs.iter_mut().find(|known| known.log == record.log) {
            Some(known) => {
                known.points += 1;
                known.histogram.add(&record.histogram);
            }
            None => logs.push(OfLog {
                log: &record.log,
                loop_rate_hz: record.loop_rate_hz,
                points: 1,
                histogram: record.histogram,
            }),
        }
    }
    logs
}

const HEAD: [(&str, &str); 10] = [
    ("", "Log"),
    ("n", "Points"),
    ("n", "Rate"),
    ("n", "Ticks"),
    ("n", "Missed"),
    ("n", "p50"),
    ("n", "p99"),
    ("n", "p99.9"),
    ("n", "Largest"),
    ("n", "Longest stall"),
];

fn lateness(m: &mut Markup, record: &RunRecord) {
    let logs = by_log(&record.lateness);
    if logs.is_empty() {
        return;
    }
    m.element(
        "p",
        &[("class", "note")],
        "How late the ticks of the loop came. A quantile is the upper limit of its bin. A stall is a tick that missed periods of \
         the loop.",
    );
    m.open("table", &[("class", "result")]);
    table_head(m, &HEAD);
    m.open("tbody", &[]);
    for part in &logs {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], part.log);
        for cell in cells(part) {
            m.element("td", &[("class", "n")], &cell);
        }
        m.close();
    }
    m.close();
    m.close();
    let mut all = LatenessHistogram::default();
    logs.iter().for_each(|part| all.add(&part.histogram));
    if all.ticks() > 0 {
        let fastest_hz = logs.iter().map(|part| part.loop_rate_hz).fold(0.0, f64::max);
        picture(m, &figure(&all, fastest_hz));
    }
}

fn cells(part: &OfLog<'_>) -> [String; 9] {
    let histogram = &part.histogram;
    let quantile = |share| histogram.quantile_s(share).map_or_else(|| "—".to_owned(), time);
    let stall_s = histogram.longest_stall_s();
    [
        part.points.to_string(),
        format!("{} Hz", number::short(part.loop_rate_hz, 4)),
        number::grouped(histogram.ticks()),
        format!(
            "{} ({} %)",
            number::grouped(histogram.missed()),
            number::short(100.0 * histogram.missed_ratio(), 2)
        ),
        quantile(0.5),
        quantile(0.99),
        quantile(0.999),
        time(histogram.largest_s()),
        if stall_s > 0.0 { time(stall_s) } else { "none".to_owned() },
    ]
}

fn time(time_s: f64) -> String {
    match time_s {
        1e-3.. => format!("{} ms", number::short(1e3 * time_s, 3)),
        _ => format!("{} µs", number::short(1e6 * time_s, 3)),
    }
}

/// Ticks by lateness, both scales logarithmic: a single late tick among millions shows.
fn figure(histogram: &LatenessHistogram, loop_rate_hz: f64) -> Plot {
    /// Left edge of the picture: earlier bins have no lower limit on a logarithmic scale.
    const FROM_US: f64 = 0.5;
    let largest_us = 1e6 * histogram.largest_s();
    let (mut x, mut y, mut half) = (Vec::new(), Vec::new(), Vec::new());
    for ([from_s, to_s], count) in histogram.bins().filter(|(_, count)| *count > 0) {
        let from_us = (1e6 * from_s).max(FROM_US);
        let to_us = (1e6 * to_s).min(largest_us.max(1.25 * from_us));
        x.push(0.5 * (from_us + to_us));
        half.push(0.5 * (to_us - from_us));
        y.push(f64::from(count));
    }
    let most = y.iter().copied().fold(1.0, f64::max);
    let mark = |label: &str, at_s: f64| Mark { label: label.to_owned(), x: (1e6 * at_s).max(FROM_US) };
    let quantile = |(label, share): (&str, f64)| Some(mark(label, histogram.quantile_s(share)?));
    let mut marks: Vec<Mark> =
        [("p50", 0.5), ("p99", 0.99), ("p99.9", 0.999)].into_iter().filter_map(quantile).collect();
    marks.push(mark("largest", histogram.largest_s()));
    marks.push(mark("period", 1.0 / loop_rate_hz.max(1.0)));
    let end_us = marks.iter().map(|mark| mark.x).fold(10.0, f64::max);
    Plot {
        series: vec![Series::new("ticks", Style::Histogram, x, y).with_u(half)],
        marks,
        x_range: Some([FROM_US, 2.0 * end_us]),
        y_range: Some([0.5, 2.0 * most]),
        ..Plot::new(
            "lateness",
            "Ticks of all logs by lateness",
            Scale::logarithmic("lateness", "us"),
            Scale::logarithmic("ticks", ""),
        )
    }
}

fn picture(m: &mut Markup, plot: &Plot) {
    let figure = Figure::of(plot);
    m.open("figure", &[]);
    m.verbatim("\n");
    m.verbatim(plot::svg(&figure, "plot-lateness").trim_end());
    zoom::data(m, &figure);
    m.element("figcaption", &[], &plot.title);
    m.close();
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::markup::tests::malformed;
    use crate::record::Grant;
    use crate::{html, sample};

    fn record(log: &str, point: &str, late_us: &[(u64, u32)]) -> LatenessRecord {
        let mut histogram = LatenessHistogram::default();
        for &(late_us, missed) in late_us {
            histogram.count(Duration::from_micros(late_us), missed);
        }
        let (log, point) = (log.to_owned(), point.to_owned());
        LatenessRecord { log, point, loop_rate_hz: 1000.0, histogram, stalls: Vec::new() }
    }

    fn results() -> Results {
        let mut results = sample::results();
        results.record.grants = vec![Grant {
            what: "real-time priority".to_owned(),
            granted: false,
            found: "EPERM".to_owned(),
            remedy: Some("setcap".to_owned()),
        }];
        results.record.lateness = vec![
            record("A.mcap", "one", &[(0, 0), (12, 0), (12, 0), (700, 0)]),
            record("session.mcap", "between points", &[(70, 0); 50]),
            record("A.mcap", "two", &[(12, 0), (6200, 6)]),
            record("session-2.mcap", "between points", &[(321_000, 321)]),
        ];
        results
    }

    #[test]
    fn a_run_in_virtual_time_has_no_section() {
        let page = html::render(&sample::results());
        assert!(!page.contains("id=\"real-time\""));
    }

    #[test]
    fn every_log_has_a_row_and_all_ticks_a_picture() {
        let page = html::render(&results());
        let from = page.find("id=\"real-time\"").expect("the section is there");
        let section = page[from..].split("</section>").next().expect("a section ends");
        for text in ["setcap", "A.mcap", "session-2.mcap", "6.2 ms", "6 (50 %)", "321 ms", "<svg", "p99.9"] {
            assert!(section.contains(text), "{text} in {section}");
        }
        assert_eq!(section.matches("A.mcap").count(), 1, "the points of a log stand together");
    }

    #[test]
    fn the_picture_is_well_formed_and_holds_every_bin() {
        let mut all = LatenessHistogram::default();
        results().record.lateness.iter().for_each(|record| all.add(&record.histogram));
        let plot = figure(&all, 1000.0);
        assert_eq!(plot.series[0].y.iter().sum::<f64>(), all.ticks() as f64);
        let svg = plot::svg(&Figure::of(&plot), "lateness");
        assert_eq!(malformed(&svg), None);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
