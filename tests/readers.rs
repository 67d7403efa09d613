//! Instruments that a profile describes, and the DC supply, through the whole program.

use procedures::log::LogReader;

use crate::bench::{folder, run_in, write};

const RIG: &str = include_str!("../bench/rigs/sim.toml");

const SUPPLY: &str = "[[device]]\nname = \"aux-24v\"\ndriver = \"e36300\"\nports = { line = \"sim:dc-supply\" }\noutput = 2\n\
                      voltage = \"24 V\"\ncurrent-limit = \"2 A\"\n\n";

/// The shipped rig with readers in the place of its autocollimators and its force gauge on analog inputs, and a DC supply.
fn with_readers() -> String {
    let between = |text: &str, from: &str, to: &str, new: &str| {
        let begins = text.find(from).expect(from);
        let ends = begins + text[begins..].find(to).expect(to);
        format!("{}{new}{}", &text[..begins], &text[ends..])
    };
    let reference = "driver = \"reader\"\nports = { line = \"sim:autocollimator\" }\nprofile = \"scpi-autocollimator\"\n\
                     faces-uncertainty = \"1.5 urad\"\n";
    let text = between(RIG, "driver = \"polygons\"", "azimuth-faces", reference);
    let force = "driver = \"reader\"\nports = { line = \"sim:gauge\" }\nprofile = \"ascii-force-gauge\"\n\n";
    let text = between(&text, "driver = \"force-gauge\"", "[[device]]", force);
    text.replacen("# Measuring instruments", &format!("{SUPPLY}# Measuring instruments"), 1)
}

/// Values by measurand and axis in the `results.csv` of a run.
fn results(run: &std::path::Path) -> String {
    std::fs::read_to_string(run.join("results.csv")).expect("results")
}

/// Value and standard uncertainty of a measurand in `results.csv`.
fn measured(results: &str, measurand: &str) -> [f64; 2] {
    let mut rows = csv(results);
    let head = rows.remove(0);
    let column =
        |name: &str| head.iter().position(|own| own == name).unwrap_or_else(|| panic!("{name}: {head:?}"));
    let [name, value, u] = ["measurand", "value", "u"].map(column);
    let row =
        rows.iter().find(|row| row[name] == measurand).unwrap_or_else(|| panic!("{measurand}: {results}"));
    [&row[value], &row[u]].map(|text| text.parse().unwrap_or_else(|_| panic!("{measurand}: {row:?}")))
}

fn csv(text: &str) -> Vec<Vec<String>> {
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn accuracy_and_torque_constant_say_the_same_by_readers_as_by_analog_inputs() {
    let folder = folder();
    write(folder.path(), "rig.toml", &with_readers());
    let named = ["--select", "AZ-ACCURACY", "AZ-TORQUE-CONSTANT", "--non-interactive", "--yes", "--out"];
    let [analog, text] = [("sim", "analog"), ("rig.toml", "text")].map(|(rig, out)| {
        let said = run_in(folder.path(), &[&["run", "--rig", rig], &named[..], &[out]].concat());
        assert!([0, 3].contains(&said.code), "{rig}: {}\n{}{}", said.code, said.out, said.err);
        results(&folder.path().join(out))
    });
    for measurand in ["positioning-accuracy", "positioning-repeatability", "torque-constant"] {
        let [by_analog, by_text] = [&analog, &text].map(|results| measured(results, measurand));
        let within = 2.0 * by_analog[1].hypot(by_text[1]);
        assert!((by_analog[0] - by_text[0]).abs() <= within, "{measurand}: {by_analog:?}, {by_text:?}");
        assert!(by_text[1] > 0.0 && by_analog != by_text, "{measurand}: {by_text:?}");
    }
    let mut log = LogReader::open(&folder.path().join("text/AZ-ACCURACY.mcap")).expect("a log");
    let window = log.next_window().expect("a point");
    let supply = window.topic("/dc_supply").expect("the supply is recorded");
    let [volts, amperes] = ["voltage_v", "current_a"].map(|name| supply.channel(name).expect("a channel"));
    let read = volts.iter().zip(amperes).skip(1000);
    assert!(volts.len() > 10_000, "{} rows", volts.len());
    for (volts, amperes) in read {
        assert!((volts - 24.0).abs() < 0.01 && (amperes - 1.0).abs() < 0.005, "{volts} V, {amperes} A");
    }
}

#[test]
fn devices_names_readers_supply_and_trackers_with_their_configurations() {
    let folder = folder();
    write(folder.path(), "rig.toml", &with_readers());
    let said = run_in(folder.path(), &["devices", "--rig", "rig.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for expected in [
        "reference: Simulated READER-SIM, serial SIM0004, firmware 1.0",
        "force: reader `ascii-force-gauge`, which has no query for its identity",
        "aux-24v: Simulated E36313A-SIM, serial SIM0003, firmware 1.0",
        "set points compared: 24 V, 2 A, over-voltage protection any",
        "configuration: BAUD 4147200, OUTPUTFMT A, ROTFMT RATE, ROTUNITS RAD",
        "coarse: driver `coarse-tracker`, no identity of its own",
        "datagrams of version 1, Coarse camera",
    ] {
        assert!(said.out.contains(expected), "{expected}: {}", said.out);
    }
}

#[test]
fn a_supply_that_is_set_otherwise_is_refused_when_the_rig_is_opened() {
    let folder = folder();
    let rig = with_readers().replacen("voltage = \"24 V\"\n", "voltage = \"12 V\"\n", 1);
    write(folder.path(), "rig.toml", &rig);
    let said = run_in(folder.path(), &["devices", "--rig", "rig.toml"]);
    assert_eq!(said.code, 4, "{}", said.out);
    assert!(said.err.contains("voltage set point: expected 12 V, found 24 V"), "{}", said.err);
}

#[test]
fn mistakes_of_readers_and_supplies_are_pointed_at_in_their_own_files() {
    let folder = folder();
    let gauge = include_str!("../drivers/readers/ascii-force-gauge.toml").replacen("{force}", "{forse}", 1);
    write(folder.path(), "gauge.toml", &gauge);
    let rig = with_readers()
        .replacen("profile = \"ascii-force-gauge\"", "profile = \"gauge.toml\"", 1)
        .replacen("faces-uncertainty = \"1.5 urad\"\n", "", 1)
        .replacen("output = 2\n", "output = 4\n", 1);
    write(folder.path(), "rig.toml", &rig);
    let said = run_in(folder.path(), &["check", "--rig", "rig.toml"]);
    assert_eq!(said.code, 2);
    insta::assert_snapshot!(said.err);
}

#[test]
fn two_supplies_would_share_a_topic_and_are_refused() {
    let folder = folder();
    let second = SUPPLY.replace("aux-24v", "second").replace("sim:dc-supply", "sim:other");
    let rig = with_readers().replacen("# Measuring instruments", &format!("{second}# Measuring"), 1);
    write(folder.path(), "rig.toml", &rig);
    let said = run_in(folder.path(), &["check", "--rig", "rig.toml"]);
    assert!(
        said.code == 2 && said.err.contains("`aux-24v` and `second` have the same driver"),
        "{}",
        said.err
    );
}

#[test]
fn monitor_shows_one_device_in_lines_and_as_json_and_refuses_what_it_cannot_show() {
    let folder = folder();
    write(folder.path(), "rig.toml", &with_readers());
    let monitor = |device: &str, more: &[&str]| {
        let fixed = ["monitor", device, "--rig", "rig.toml", "--for", "300 ms", "--every", "100 ms"];
        run_in(folder.path(), &[&fixed[..], more].concat())
    };
    let said = monitor("force", &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    let lines: Vec<&str> = said.out.lines().collect();
    assert!(lines[0].starts_with("force: reader `ascii-force-gauge`"), "{}", said.out);
    assert!((2..=5).contains(&lines.len()), "{}", said.out);
    assert!(lines[1].contains("force_n ") && lines[1].contains("received_bytes "), "{}", said.out);
    let json = monitor("aux-24v", &["--json"]);
    let last: serde_json::Value =
        json.out.lines().last().and_then(|line| serde_json::from_str(line).ok()).expect("JSON");
    let volts = last["values"]["voltage_v"].as_f64().expect("a voltage");
    assert!((volts - 24.0).abs() < 0.01, "{}", json.out);
    assert_eq!((&last["units"]["voltage_v"], &last["values"]["regulation"]), (&"V".into(), &1.0.into()));
    let refused = monitor("scope", &[]);
    assert_eq!(refused.code, 2);
    assert!(refused.err.contains("given tasks"), "{}", refused.err);
    let unknown = monitor("forse", &[]);
    assert!(unknown.code == 2 && unknown.err.contains("did you mean `force`?"), "{}", unknown.err);
}
