//! Records of other tools: a real motor's cogging map, responses of a real bench and of an analyser, and tables that are
//! broken.

use std::path::Path;

use crate::bench::{IMPORT_MAP, Said, fixture, folder, import_csv, run_in, write};

fn import(folder: &Path, map: &str) -> Said {
    run_in(folder, &["import", map, "--out", "log"])
}

/// All measurements of the first procedure that `rejudge --json` printed.
fn measurements(said: &Said) -> Vec<serde_json::Value> {
    let findings: serde_json::Value = serde_json::from_str(&said.out).expect("findings are JSON");
    findings["procedures"][0]["measurements"].as_array().expect("measurements").clone()
}

/// The value of the measurement with exactly these conditions.
fn value(all: &[serde_json::Value], measurand: &str, conditions: &[(&str, f64)]) -> f64 {
    let meets = |m: &&serde_json::Value| {
        let found = m["conditions"].as_array().expect("conditions");
        let holds = |(name, at): &(&str, f64)| {
            found.iter().any(|c| c["name"] == *name && c["requested"].as_f64() == Some(*at))
        };
        m["measurand"] == measurand && found.len() == conditions.len() && conditions.iter().all(holds)
    };
    let found = all.iter().find(meets).unwrap_or_else(|| panic!("no {measurand} {conditions:?}"));
    found["value"].as_f64().expect("a value")
}

/// Amplitudes in A from the record's README: order, forward map c_16, reverse map e_16r.
const README: [(f64, f64, f64); 6] = [
    (7.0, 1.0385, 1.0413),
    (12.0, 0.2637, 0.2708),
    (14.0, 0.3452, 0.3513),
    (28.0, 0.5611, 0.5614),
    (36.0, 0.2915, 0.301),
    (84.0, 0.1208, 0.1331),
];

#[test]
fn the_real_motors_cogging_and_friction_are_those_of_its_readme() {
    let folder = folder();
    let map = fixture("odrive_cogging/import.toml");
    let said = import(folder.path(), &map.display().to_string());
    assert_eq!(said.code, 0, "{}", said.err);
    let said = run_in(folder.path(), &["rejudge", said.out.trim(), "--json"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    let all = measurements(&said);
    let friction_a = value(&all, "friction-current", &[]);
    assert!((friction_a - 0.171).abs() < 0.0005, "friction {friction_a} A");
    for (order, forward_a, reverse_a) in README {
        for (direction, printed_a) in [(1.0, forward_a), (-1.0, reverse_a)] {
            let conditions = [("order", order), ("direction", direction)];
            let found_a = value(&all, "cogging-harmonic-current", &conditions);
            assert!((found_a - printed_a).abs() < 1e-4, "{conditions:?}: {found_a} A, README {printed_a} A");
        }
    }
    // The eight largest orders, largest first, as the README lists them.
    let mean = |m: &&serde_json::Value| {
        m["measurand"] == "cogging-harmonic-current"
            && m["conditions"].as_array().is_some_and(|c| c.len() == 1)
    };
    let mut lines: Vec<(f64, f64)> = all
        .iter()
        .filter(mean)
        .map(|m| {
            (
                m["value"].as_f64().expect("a value"),
                m["conditions"][0]["requested"].as_f64().expect("an order"),
            )
        })
        .collect();
    lines.sort_by(|a, b| b.0.total_cmp(&a.0));
    let orders: Vec<f64> = lines.iter().take(8).map(|l| l.1).collect();
    assert_eq!(orders, [7.0, 28.0, 14.0, 36.0, 12.0, 84.0, 21.0, 56.0]);
}

fn broken(csv: &str) -> String {
    let folder = folder();
    let said = import_csv(folder.path(), IMPORT_MAP, csv);
    assert!(
        !folder.path().join("log").read_dir().is_ok_and(|mut d| d.next().is_some()),
        "no half log is left"
    );
    format!("exit {}\n{}{}", said.code, said.out, said.err)
}

#[test]
fn a_cell_that_is_no_number_is_pointed_at() {
    insta::assert_snapshot!(broken("t,angle,i\n0,1,2\n1,2,NaN\n2,3,4\n"));
}

#[test]
fn a_ragged_row_is_pointed_at() {
    insta::assert_snapshot!(broken("t,angle,i\n0,1,2\n1,2\n"));
}

#[test]
fn time_that_goes_back_is_pointed_at() {
    insta::assert_snapshot!(broken("t,angle,i\n0,1,2\n1,2,3\n0.5,2,3\n"));
}

#[test]
fn a_column_that_is_not_there_names_the_nearest() {
    insta::assert_snapshot!(broken("t,angel,i\n0,1,2\n1,2,3\n"));
}

#[test]
fn an_unknown_channel_in_a_map_names_those_there_are() {
    let folder = folder();
    write(folder.path(), "map.toml", &IMPORT_MAP.replacen("current_a", "curent_a", 1));
    let said = import(folder.path(), "map.toml");
    insta::assert_snapshot!(format!("exit {}\n{}", said.code, said.err));
}

#[test]
fn a_response_without_its_imaginary_part_is_pointed_at() {
    let folder = folder();
    let map = IMPORT_MAP.replacen("position_rad", "frequency_hz", 1).replacen("\"deg\"", "\"Hz\"", 1);
    write(
        folder.path(),
        "map.toml",
        &map.replacen("current_a", "response_real", 1).replacen("\"A\"", "\"1\"", 1),
    );
    let said = import(folder.path(), "map.toml");
    insta::assert_snapshot!(format!("exit {}\n{}", said.code, said.err));
}

#[test]
fn tables_side_by_side_must_be_of_the_same_rows() {
    let folder = folder();
    let map = IMPORT_MAP.replacen("file = \"d.csv\"", "file = \"d.csv\"\nbeside = \"e.csv\"", 1);
    write(folder.path(), "map.toml", &map);
    write(folder.path(), "d.csv", "t,angle\n0,1\n1,2\n2,3\n");
    let procedure = std::fs::read_to_string(fixture("odrive_cogging/cogging.toml")).expect("a fixture");
    write(folder.path(), "p.toml", &procedure);
    for (beside, code, expected) in [
        ("t,i\n0,1\n1,2\n", 2, "expected 3 rows as in d.csv, found 2"),
        ("t,i\n0,1\n1.5,2\n2,3\n", 2, "e.csv:3: expected the time 1 as in d.csv, found 1.5"),
        ("t,i\n0,1\n1,2\n2,3\n", 0, ""),
    ] {
        write(folder.path(), "e.csv", beside);
        let said = import(folder.path(), "map.toml");
        assert!(said.code == code && said.err.contains(expected), "{}: {}", said.code, said.err);
    }
}

/// A map of one direction on part of a turn ended in a panic (exit 70), and one stray angle made its grid as large as it
/// liked.
#[test]
fn a_map_of_one_direction_on_part_of_a_turn_is_judged_with_and_without_a_stray_angle() {
    let procedure = std::fs::read_to_string(fixture("odrive_cogging/cogging.toml")).expect("a fixture");
    let row = |k: u32| format!("{},{},{}\n", f64::from(k) / 100.0, f64::from(k) / 4.0, 0.5);
    let rows: String = (0..800).map(row).collect();
    for (stray, expected) in [
        ("", "one direction only"),
        ("8,1e9,0.5\n", "fewer than two points in one"),
        ("8,1e29,0.5\n", "fewer than two points in one"),
    ] {
        let folder = folder();
        write(folder.path(), "map.toml", &format!("{IMPORT_MAP}[axis]\ncogging-order = \"84 1/rev\"\n"));
        write(folder.path(), "p.toml", &procedure);
        write(folder.path(), "d.csv", &format!("t,angle,i\n{rows}{stray}"));
        let said = import(folder.path(), "map.toml");
        assert_eq!(said.code, 0, "{}", said.err);
        let said = run_in(folder.path(), &["rejudge", said.out.trim(), "--json"]);
        assert_eq!(said.code, 0, "{stray:?}: {}\n{}", said.out, said.err);
        let all = measurements(&said);
        let friction = all.iter().find(|m| m["measurand"] == "friction-current").expect("friction");
        let why = friction["inconclusive"].as_str().expect("why there is none");
        assert!(why.contains(expected), "{stray:?}: {why}");
    }
}

/// Imports a committed map, with tables from a folder of their own if one is given, and judges the log.
fn judged(map: &str, tables: Option<(&Path, &[&str])>) -> Vec<serde_json::Value> {
    let folder = folder();
    let mut path = fixture(map);
    if let Some((from, files)) = tables {
        let beside = path.parent().expect("a fixture has a folder").to_owned();
        let copy = |from: &Path, name: &str| {
            std::fs::copy(from.join(name), folder.path().join(name)).expect("a table to copy");
        };
        files.iter().for_each(|file| copy(from, file));
        let own = path.file_name().expect("a name").to_string_lossy().into_owned();
        for entry in std::fs::read_dir(&beside).expect("fixtures").filter_map(Result::ok) {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.ends_with(".toml") {
                copy(&beside, &name);
            }
        }
        path = folder.path().join(own);
    }
    let said = import(folder.path(), &path.display().to_string());
    assert_eq!(said.code, 0, "{}", said.err);
    let said = run_in(folder.path(), &["rejudge", said.out.trim(), "--json"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    measurements(&said)
}

/// Hz, gain and phase in degrees.
type Table = [(f64, f64, f64); 6];

/// Gain within half of `digit`, phase within 0.06 deg.
fn check_table(all: &[serde_json::Value], response: f64, table: &Table, digit: &dyn Fn(f64) -> f64) {
    for (hz, gain, phase_deg) in table {
        let conditions = [("response", response), ("frequency", *hz)];
        let found = 10_f64.powf(value(all, "response-gain", &conditions) / 20.0);
        assert!((found - gain).abs() <= 0.51 * digit(*gain), "{conditions:?}: {found}, README {gain}");
        let found = value(all, "response-phase", &conditions).to_degrees();
        assert!((found - phase_deg).abs() < 0.06, "{conditions:?}: {found} deg, README {phase_deg} deg");
    }
}

/// Resonance and anti-resonance within half a line of what the lines show.
fn check_peaks(all: &[serde_json::Value], response: f64, antiresonance: bool) {
    let at = [("response", response), ("peak", 1.0)];
    let resonance_hz = value(all, "resonance-frequency", &at);
    assert!((resonance_hz - 77.0).abs() < 0.75, "{resonance_hz} Hz");
    if antiresonance {
        let antiresonance_hz = value(all, "antiresonance-frequency", &at);
        assert!((antiresonance_hz - 53.0).abs() < 0.75, "{antiresonance_hz} Hz");
    }
}

fn check_deviation(all: &[serde_json::Value], response: f64, percent: f64, digit: f64) {
    let found = 100.0 * value(all, "relative-deviation", &[("response", response)]);
    assert!((found - percent).abs() <= 0.51 * digit, "response {response}: {found} %, README {percent} %");
}

#[test]
fn a_cut_of_a_real_bench_gives_the_figures_of_its_readme() {
    let all = judged("motorbench/import.toml", None);
    let motor: Table = [
        (11.0, 1.54697, -79.54),
        (25.0, 0.58686, -85.61),
        (53.0, 0.02861, -60.73),
        (77.0, 6.44402, -44.18),
        (100.0, 0.55792, -93.20),
        (200.0, 0.18061, -97.34),
    ];
    let load: Table = [
        (11.0, 1.61177, -80.26),
        (25.0, 0.74384, -86.97),
        (53.0, 0.58214, -90.25),
        (77.0, 6.16012, 140.53),
        (100.0, 0.22581, 88.69),
        (200.0, 0.01116, 78.46),
    ];
    check_table(&all, 1.0, &motor, &|_| 1e-5);
    check_table(&all, 2.0, &load, &|_| 1e-5);
    check_deviation(&all, 1.0, 0.6136, 1e-4);
    check_deviation(&all, 2.0, 2.3968, 1e-4);
    check_peaks(&all, 1.0, true);
    check_peaks(&all, 2.0, false);
    let excluded = all[0]["excluded"].to_string();
    assert!(excluded.contains("current_command_a: differs from the other periods"), "{excluded}");
}

/// Folder of the full records: in `DIRECTOR_DATA`, or beside the repository.
#[allow(clippy::print_stderr, reason = "who runs the tests is told what was left out")]
fn full_records(name: &str) -> Option<std::path::PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let data = std::env::var_os("DIRECTOR_DATA").map_or_else(beside, Into::into);
    let folder = data.join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no {} (set DIRECTOR_DATA to the folder of the records)", folder.display());
    None
}

#[test]
fn the_full_record_of_the_bench_gives_the_figures_of_its_readme_where_it_is_there() {
    let Some(folder) = full_records("fditools_motorbench") else { return };
    let all =
        judged("motorbench/full_a.toml", Some((&folder, &["multisine_a.csv", "multisine_a_speed.csv"])));
    let tables: [(f64, Table); 3] = [
        (
            1.0,
            [
                (11.0, 1.5499, -79.5),
                (25.0, 0.5850, -85.4),
                (53.0, 0.0262, -60.8),
                (77.0, 6.4546, -44.5),
                (100.0, 0.5546, -93.4),
                (200.0, 0.1781, -97.7),
            ],
        ),
        (
            2.0,
            [
                (11.0, 1.6149, -80.2),
                (25.0, 0.7418, -86.8),
                (53.0, 0.5806, -90.4),
                (77.0, 6.1655, 140.3),
                (100.0, 0.2278, 88.1),
                (200.0, 0.0139, 83.8),
            ],
        ),
        (
            3.0,
            [
                (11.0, 1.3647, -107.8),
                (25.0, 0.3700, -136.2),
                (53.0, 0.00955, -129.8),
                (77.0, 1.6536, -119.7),
                (100.0, 0.1110, -172.0),
                (200.0, 0.0181, 178.1),
            ],
        ),
    ];
    for (response, table) in &tables {
        check_table(&all, *response, table, &|gain| if gain < 0.01 { 1e-5 } else { 1e-4 });
    }
    for (response, percent) in [(1.0, 0.62), (2.0, 1.77), (3.0, 0.38), (4.0, 0.62)] {
        check_deviation(&all, response, percent, 0.01);
        check_peaks(&all, response, matches!(response as i32, 1 | 3));
    }
    for (hz, gain) in [(11.0, 1.022), (131.0, 0.949), (250.0, 0.860)] {
        let found = 10_f64.powf(value(&all, "response-gain", &[("response", 5.0), ("frequency", hz)]) / 20.0);
        assert!((found - gain).abs() < 6e-4, "current loop at {hz} Hz: {found}");
    }
}

#[test]
fn record_b_of_the_bench_shows_both_kinds_of_distortion_where_it_is_there() {
    let Some(folder) = full_records("fditools_motorbench") else { return };
    let all = judged("motorbench/full_b.toml", Some((&folder, &["multisine_b.csv"])));
    check_deviation(&all, 1.0, 0.39, 0.01);
    check_deviation(&all, 2.0, 1.25, 0.01);
    check_peaks(&all, 1.0, true);
    let odd =
        all.iter().find(|m| m["measurand"] == "odd-distortion").expect("record B has odd lines left out");
    let rms = odd["flags"].to_string();
    assert!(rms.contains("excited 1.8559e0, odd not excited 1.4027e-2, even 1.4714e-2"), "{rms}");
    // By numpy: what the current itself holds at those lines, times the response between the excited lines, taken off the
    // means, and the variance of the means taken off the squares. It is more than before: the two are not in phase.
    for (name, expected) in
        [("odd-distortion", 0.008120272606548355), ("even-distortion", 0.01142670410972222)]
    {
        let ratio = value(&all, name, &[("response", 1.0)]);
        assert!((ratio / expected - 1.0).abs() < 1e-9, "{name}: {ratio}, numpy {expected}");
    }
}

#[test]
fn an_analysers_response_of_poor_coherence_has_two_peaks_and_no_verdict() {
    let all = judged("impact_frf/import.toml", None);
    let peaks: Vec<&serde_json::Value> =
        all.iter().filter(|m| m["measurand"] == "resonance-frequency").collect();
    assert_eq!(peaks.len(), 2, "{peaks:?}");
    for (peak, (line_hz, coherence)) in peaks.iter().zip([(34.0625, 0.42), (212.1875, 0.33)]) {
        let found_hz = peak["value"].as_f64().expect("a place");
        let u_hz = peak["u"].as_f64().expect("an uncertainty");
        assert!((found_hz - line_hz).abs() < 0.3125 && u_hz >= 0.3125 / 12_f64.sqrt(), "{peak}");
        let reason = peak["inconclusive"].as_str().expect("a reason");
        assert_eq!(
            reason,
            format!("not certified: coherence {coherence} at {line_hz} Hz, at least 0.9 is needed")
        );
        let flags = peak["flags"].to_string();
        assert!(flags.contains(&format!("extreme at the line {line_hz} Hz")), "{flags}");
        assert!(flags.contains("the number of averages is not stated"), "{flags}");
    }
    let damping = all.iter().find(|m| m["measurand"] == "resonance-damping").expect("of the first peak");
    assert!(damping["value"].is_null(), "{damping}");
    assert!(
        damping["inconclusive"].as_str().is_some_and(|r| r.starts_with("damping not resolved")),
        "{damping}"
    );
    let excluded = peaks[0]["excluded"].to_string();
    for hz in ["0 Hz (1.246)", "3.4375 Hz", "4.0625 Hz", "8.75 Hz", "17.8125 Hz"] {
        assert!(excluded.contains(hz), "{hz} is impossible: {excluded}");
    }
    assert!(excluded.contains("\"count\":1573"), "1601 lines, 5 impossible, 23 of 0.9 … 1: {excluded}");
}
