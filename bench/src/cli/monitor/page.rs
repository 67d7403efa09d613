//! How a device is shown: a table that stays in its place on a terminal, lines elsewhere, JSON where that is asked for.

use console::Term;
use reports::printable;
use serde_json::{Map, Value, json};

use super::watch::{Report, Watched};
use crate::cli::output;
use crate::model::device::DeviceEntry;

/// Shows reports of one device.
pub(super) struct Page {
    device: String,
    form: Form,
}

enum Form {
    Json,
    Lines,
    /// Rows that stand on the terminal.
    Table {
        terminal: Term,
        rows: usize,
    },
}

impl Page {
    /// Begins to show a device, with who it is.
    pub(super) fn new(watched: &mut Watched, entry: &DeviceEntry, json: bool, is_terminal: bool) -> Self {
        let device = entry.name.clone();
        let form = match (json, is_terminal) {
            (true, _) => Form::Json,
            (false, false) => Form::Lines,
            (false, true) => Form::Table { terminal: Term::stdout(), rows: 0 },
        };
        if !json {
            let who = watched.device(&device).and_then(|device| device.identity());
            let who = who.unwrap_or_else(|| format!("driver `{}`", entry.driver));
            output::say(&format!("{device}: {who}, at {}", entry.addresses()));
        }
        Self { device, form }
    }

    /// Shows a report.
    pub(super) fn show(&mut self, report: &Report) {
        match &mut self.form {
            Form::Json => output::say(&json_line(&self.device, report)),
            Form::Lines => output::say(&line(report)),
            Form::Table { terminal, rows } => {
                let text = table(report);
                // A terminal that does not take it shows the next one.
                let _ = terminal.clear_last_lines(*rows);
                let _ = terminal.write_line(&printable::text(&text));
                *rows = text.lines().count();
            }
        }
    }
}

fn json_line(device: &str, report: &Report) -> String {
    let values = report.values.iter().map(|(channel, value)| (channel.name.to_owned(), json!(value)));
    let units = report.values.iter().map(|(channel, _)| (channel.name.to_owned(), json!(channel.unit)));
    let counts = report.counts.iter().map(|(name, count)| ((*name).to_owned(), json!(count)));
    json!({
        "device": device,
        "time_s": report.time_s,
        "rate_hz": report.rate_hz,
        "age_s": report.age_s,
        "values": Value::Object(values.collect::<Map<_, _>>()),
        "units": Value::Object(units.collect::<Map<_, _>>()),
        "counts": Value::Object(counts.collect::<Map<_, _>>()),
    })
    .to_string()
}

fn head(report: &Report) -> String {
    let age = report.age_s.map_or("no sample yet".to_owned(), |age_s| format!("age {:.1} ms", age_s * 1e3));
    format!("{:.2} s  {:.1}/s  {age}", report.time_s, report.rate_hz)
}

fn line(report: &Report) -> String {
    let values = report.values.iter().map(|(channel, value)| format!("{} {}", channel.name, shown(*value)));
    let counts = report.counts.iter().map(|(name, count)| format!("{name} {count}"));
    std::iter::once(head(report)).chain(values).chain(counts).collect::<Vec<_>>().join("  ")
}

fn table(report: &Report) -> String {
    let value = |(channel, value): &(drivers::device::Channel, f64)| {
        vec![channel.name.to_owned(), shown(*value), channel.unit.to_owned()]
    };
    let count = |(name, count): &(&str, u64)| vec![(*name).to_owned(), count.to_string()];
    let rows: Vec<_> = report.values.iter().map(value).chain(report.counts.iter().map(count)).collect();
    format!("{}\n{}", head(report), output::table(&rows))
}

/// A value with six digits, whole numbers as such.
fn shown(value: f64) -> String {
    /// Below this a whole number is shown with all its digits.
    const MOST_WHOLE: f64 = 1e9;
    match () {
        () if value.is_nan() => "none".to_owned(),
        () if value == value.trunc() && value.abs() < MOST_WHOLE => format!("{value:.0}"),
        () if (1e-3..1e6).contains(&value.abs()) => format!("{value:.6}"),
        () => format!("{value:.5e}"),
    }
}

#[cfg(test)]
mod tests {
    use drivers::device::{Channel, Width};

    use super::*;

    fn report() -> Report {
        let channel = |name, unit| Channel { name, unit, width: Width::F64 };
        Report {
            time_s: 1.0,
            rate_hz: 49.98,
            age_s: Some(0.0123),
            values: vec![(channel("force_n", "N"), 650.25), (channel("other_n", "N"), f64::NAN)],
            counts: vec![("readings", 50), ("received_bytes", 700)],
        }
    }

    #[test]
    fn a_line_has_everything_and_a_value_that_is_none_says_so() {
        let expected =
            "1.00 s  50.0/s  age 12.3 ms  force_n 650.250000  other_n none  readings 50  received_bytes 700";
        assert_eq!(line(&report()), expected);
        let silent = Report { age_s: None, ..report() };
        assert!(line(&silent).contains("no sample yet"));
    }

    #[test]
    fn a_table_has_units_in_columns() {
        let text = table(&report());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "force_n         650.250000  N");
        assert_eq!(lines[2], "other_n         none        N");
        assert_eq!(lines[3], "readings        50");
    }

    #[test]
    fn json_is_one_line_and_never_not_a_number() {
        let text = json_line("force", &report());
        let value: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!((text.lines().count(), &value["values"]["other_n"]), (1, &Value::Null));
        assert_eq!((&value["values"]["force_n"], &value["units"]["force_n"]), (&json!(650.25), &json!("N")));
        assert_eq!(value["counts"]["readings"], json!(50));
    }

    #[test]
    fn numbers_are_shown_with_six_digits() {
        let all = [0.0, 3.0, -24.0012346, 1.25e-7, 4e9].map(shown);
        assert_eq!(all, ["0", "3", "-24.001235", "1.25000e-7", "4.00000e9"]);
    }
}
