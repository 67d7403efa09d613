//! The same bytes in give the same findings out: jobs, seeds, re-judging, changed samples and limits.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::bench::{content, findings, folder, procedure, run_in};

const SHORT: [&str; 4] = ["run", "quick/el-breakaway", "quick/az-breakaway", "--non-interactive"];

/// What a log holds, as [`content`] gives it.
type Content = Vec<(String, u64, Vec<u8>)>;

fn run(folder: &Path, out: &str, more: &[&str]) -> (String, Content) {
    let arguments: Vec<&str> = SHORT.iter().chain(["--out", out].iter()).chain(more).copied().collect();
    let said = run_in(folder, &arguments);
    assert!(matches!(said.code, 0 | 1 | 3), "{}\n{}", said.out, said.err);
    let run = folder.join(out);
    let log = content(&run.join("AZ-BREAKAWAY.mcap"));
    (findings(&run), log)
}

/// A run with one job that several tests look at: each copies what it needs.
fn first_run() -> &'static Path {
    static RUN: OnceLock<PathBuf> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rejudge");
        if folder.exists() {
            std::fs::remove_dir_all(&folder).expect("the folder of an earlier test");
        }
        std::fs::create_dir_all(&folder).expect("a folder for tests");
        run(&folder, "run", &["--jobs", "1"]);
        folder.join("run")
    })
}

/// Copies the first run into a folder, as `run`.
fn copy_of_first_run(folder: &Path) {
    let to = folder.join("run");
    std::fs::create_dir(&to).expect("a fresh folder");
    for file in files(first_run()) {
        std::fs::copy(&file, to.join(file.file_name().expect("a file has a name"))).expect("a copy");
    }
}

#[test]
fn same_seed_gives_the_same_bytes_with_one_job_and_with_two() {
    let folder = folder();
    let one = (findings(first_run()), content(&first_run().join("AZ-BREAKAWAY.mcap")));
    let two = run(folder.path(), "two", &["--jobs", "2"]);
    assert!(one.1 == two.1, "logs differ");
    assert_eq!(one.0, two.0);
    let other = run(folder.path(), "other", &["--seed", "2"]);
    assert!(one.1 != other.1, "another seed gives another log");
    assert_ne!(one.0, other.0);
}

/// How warm a point begins is a function of the plan: the same with one job and with two, and another where the plan has
/// nothing before it.
#[test]
fn a_unit_that_warms_up_over_a_campaign_is_as_warm_as_the_plan_says_whatever_ran_before() {
    let folder = folder();
    let log = |out: &str, procedures: &[&str], jobs: &str| {
        let first = ["run"].iter().chain(procedures);
        let more = ["--unit", "gyro-bias-warm", "--non-interactive", "--jobs", jobs, "--out", out];
        let said = run_in(folder.path(), &first.chain(&more).copied().collect::<Vec<_>>());
        assert!(matches!(said.code, 0 | 1 | 3), "{}\n{}", said.out, said.err);
        content(&folder.path().join(out).join("SELF-CHECK-OPEN.mcap"))
    };
    let after_another = ["quick/az-torque-constant", "quick/self-check-open"];
    let one = log("one", &after_another, "1");
    assert!(one == log("two", &after_another, "2"), "logs differ");
    assert!(one != log("alone", &["quick/self-check-open"], "1"), "nothing before it has warmed it");
}

/// One run for all that judging again says of it.
#[test]
fn rejudging_writes_nothing_unasked_gives_the_same_findings_and_a_changed_limit_changes_them() {
    let folder = folder();
    let at = folder.path();
    copy_of_first_run(at);
    let before = files(&at.join("run"));
    let said = run_in(at, &["rejudge", "run"]);
    assert!(said.out.contains("identical byte for byte"), "{}\n{}", said.out, said.err);
    assert_eq!(before, files(&at.join("run")), "without --out nothing is written");
    let shipped = include_str!("../procedures/requirements.toml");
    let tighter = shipped.replacen("<= 260 N*m", "<= 150 N*m", 1);
    assert_ne!(shipped, tighter, "FRC-AZ has a limit of 260 N*m");
    std::fs::write(at.join("tighter.toml"), tighter).expect("a writable folder");
    let said = run_in(at, &["rejudge", "run", "--requirements", "tighter.toml"]);
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    for told in
        ["findings differ: ", "\n  values are the same\n", "\n  verdicts: FRC-AZ inconclusive -> fail\n"]
    {
        assert!(said.out.contains(told), "{told}: {}", said.out);
    }
    // A log alone shows breakaway but no friction while sliding: FRC-AZ cannot pass on it.
    let said = run_in(at, &["rejudge", "run/AZ-BREAKAWAY.mcap", "--out", "again"]);
    assert_eq!(said.code, 3, "{}\n{}", said.out, said.err);
    assert!(at.join("again/report.html").is_file());
    // Its torques are as uncertain as in the run, where no log measured an inertia either: that of the rig file counts.
    let [alone, of_run] = ["again", "run"].map(|name| az_breakaways(&at.join(name)));
    assert!(alone.len() >= 4, "{alone:?}");
    assert_eq!(alone, of_run);
    a_word_changed_in_the_title_page_does_not_make_a_simulated_run_real(at);
}

/// Point, value and standard uncertainty of every breakaway of azimuth.
fn az_breakaways(run: &Path) -> Vec<(String, [Option<f64>; 2])> {
    let found = procedure(run, "AZ-BREAKAWAY");
    let all = found["measurements"].as_array().expect("measurements").iter();
    let one = |m: &serde_json::Value| (m["point"].to_string(), [m["value"].as_f64(), m["u"].as_f64()]);
    all.filter(|m| m["measurand"] == "breakaway-torque").map(one).collect()
}

/// Names of what is in a folder.
fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let all = std::fs::read_dir(folder).expect("a run folder");
    let mut names: Vec<_> = all.map(|e| e.expect("readable").path()).collect();
    names.sort();
    names
}

fn a_word_changed_in_the_title_page_does_not_make_a_simulated_run_real(folder: &Path) {
    let page = folder.join("run/run.json");
    let text = std::fs::read_to_string(&page).expect("a title page");
    let changed = text.replace("\"origin\": \"simulated\"", "\"origin\": \"real\"");
    assert_ne!(text, changed, "the title page says where it comes from");
    std::fs::write(&page, changed).expect("writable");
    run_in(folder, &["rejudge", "run", "--out", "changed"]);
    let html = std::fs::read_to_string(folder.join("changed/report.html")).expect("a report");
    assert!(html.contains("SIMULATED"));
}

#[test]
fn one_changed_sample_changes_the_findings() {
    let folder = folder();
    copy_of_first_run(folder.path());
    let log = folder.path().join("run/EL-BREAKAWAY.mcap");
    let original = judged(folder.path(), "run/EL-BREAKAWAY.mcap");
    for (name, more_a) in [("same/EL-BREAKAWAY.mcap", 0.0), ("changed/EL-BREAKAWAY.mcap", 1.0)] {
        let to = folder.path().join(name);
        std::fs::create_dir(to.parent().expect("below a folder")).expect("a fresh folder");
        rewritten(&log, &to, &Change { more_a, ..Change::default() });
        assert_eq!(judged(folder.path(), name) == original, more_a == 0.0, "{name}");
    }
}

/// The findings of a log.
fn judged(folder: &Path, log: &str) -> String {
    let said = run_in(folder, &["rejudge", log, "--json"]);
    assert!(said.out.contains("measurements"), "{}", said.err);
    said.out
}

/// Points belong to the plan by what their events say, whatever their order is.
#[test]
fn points_twice_reversed_missing_or_without_events_are_damage_and_what_is_whole_is_judged_the_same() {
    let folder = folder();
    copy_of_first_run(folder.path());
    let log = folder.path().join("run/EL-BREAKAWAY.mcap");
    let whole = points(folder.path(), "run/EL-BREAKAWAY.mcap", 0);
    let count = whole.len();
    assert!(count >= 3, "{count} points");
    let order = |change: &dyn Fn(&mut Vec<usize>)| {
        let mut order: Vec<usize> = (0..count).collect();
        change(&mut order);
        Change { order: Some(order), ..Change::default() }
    };
    let dumb = Change { without_segments: Some(1), ..Change::default() };
    let cases = [
        ("twice", order(&|o| o.insert(1, 0)), "more than once: none is judged", Some((0, "errored"))),
        ("twice-all", order(&|o| o.extend(0..count)), "more than once: none is judged", None),
        ("reversed", order(&|o| o.reverse()), "expected the plan's order", Some((count, ""))),
        (
            "missing",
            order(&|o| {
                o.remove(1);
            }),
            "is missing, although later points are there",
            Some((1, "lost")),
        ),
        ("dumb", dumb, "the log has no events of its segments", Some((1, "completed"))),
    ];
    for (name, change, expected, other) in cases {
        let to = folder.path().join(name).join("EL-BREAKAWAY.mcap");
        std::fs::create_dir(to.parent().expect("below a folder")).expect("a fresh folder");
        rewritten(&log, &to, &change);
        let file = format!("{name}/EL-BREAKAWAY.mcap");
        let said = run_in(folder.path(), &["rejudge", &file]);
        assert_eq!(said.code, 65, "{name}: {}{}", said.out, said.err);
        assert!(said.err.contains(expected), "{name}: {}", said.err);
        let Some((other, status)) = other else { continue };
        for (index, (found, before)) in points(folder.path(), &file, 65).iter().zip(&whole).enumerate() {
            if index == other {
                assert_eq!(found["status"], status, "{name}: {found}");
            } else {
                assert_eq!(found["point"], before["point"], "{name}");
                assert_eq!(found["status"], before["status"], "{name}: {found}");
            }
        }
    }
}

/// The points of a log as they were judged.
fn points(folder: &Path, log: &str, code: i32) -> Vec<serde_json::Value> {
    let said = run_in(folder, &["rejudge", log, "--json"]);
    assert!(said.code == code || code == 0, "{}{}", said.out, said.err);
    let found: serde_json::Value = serde_json::from_str(&said.out).expect("findings");
    found["procedures"][0]["points"].as_array().expect("a list").clone()
}

/// How a copy of a log differs.
#[derive(Default)]
struct Change {
    /// Added to the current of one row in the middle of each point.
    more_a: f64,
    /// Points in this order.
    order: Option<Vec<usize>>,
    /// This point has no events of its segments.
    without_segments: Option<usize>,
}

/// Copies a log with something changed.
fn rewritten(from: &Path, to: &Path, change: &Change) {
    use procedures::log::{Event, LogReader, LogWriter};
    let mut reader = LogReader::open(from).expect("our log");
    let plan = reader.plan().clone();
    let attachments = reader.attachments().to_vec();
    let kept: Vec<_> = attachments.into_iter().filter(|a| a.name != "plan.json").collect();
    let mut windows: Vec<_> = std::iter::from_fn(|| reader.next_window()).collect();
    if let Some(order) = &change.order {
        windows = order.iter().map(|&index| windows[index].clone()).collect();
    }
    if let Some(point) = change.without_segments {
        windows[point].segments.clear();
    }
    let topics: Vec<_> = windows[0].topics.iter().map(|r| r.topic.clone()).collect();
    let file = std::fs::File::create(to).expect("a writable folder");
    let mut writer = LogWriter::new(std::io::BufWriter::new(file), &plan, &topics, &kept).expect("a log");
    let ns = |t_s: f64| (t_s * 1e9).round() as u64;
    for window in &windows {
        let starts = window.topics.iter().filter_map(|rows| rows.time_s.first());
        let point = window.point;
        let start_s = starts.fold(f64::INFINITY, |a, b| a.min(*b));
        writer.event(ns(start_s), &Event::PointStarted { point }).expect("written");
        let mut segments = window.segments.iter().peekable();
        // An axis that rests and devices on the gimbal have fewer rows than the axis that moves.
        let mut times: Vec<f64> = window.topics.iter().flat_map(|rows| rows.time_s.clone()).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let moving = window.topics.iter().find(|rows| rows.topic.name == "/el").expect("an axis");
        let middle_s = moving.time_s[moving.time_s.len() / 2];
        for t_s in times {
            while let Some(s) = segments.next_if(|s| s.start_s <= t_s) {
                let segment = s.segment;
                let position_rad = s.start_position_rad;
                writer
                    .event(ns(s.start_s), &Event::SegmentStarted { point, segment, position_rad })
                    .expect("written");
                // The end may lie ahead of the rows: its time stands in the event, not in the order of the file.
                writer
                    .event(ns(s.end_s), &Event::SegmentEnded { point, segment, by: s.ended_by })
                    .expect("written");
            }
            for (index, rows) in window.topics.iter().enumerate() {
                let Ok(row) = rows.time_s.binary_search_by(|t| t.total_cmp(&t_s)) else { continue };
                let mut values: Vec<f64> = rows.columns.iter().map(|c| c[row]).collect();
                let current = rows.topic.channels.iter().position(|c| c.name == "current_a");
                if let (Some(channel), true, "/el") = (current, t_s == middle_s, rows.topic.name.as_str()) {
                    values[channel] += change.more_a;
                }
                writer.row(index, ns(rows.time_s[row]), &values).expect("written");
            }
        }
        let end_s =
            window.topics.iter().filter_map(|rows| rows.time_s.last()).fold(0.0, |a: f64, b| a.max(*b));
        let stops = window.stops.iter().cloned().map(Event::Stopped);
        let left = window.left.iter().cloned().map(Event::Left);
        for event in stops.chain(left).chain([Event::PointEnded { point, status: window.status }]) {
            writer.event(ns(end_s), &event).expect("written");
        }
    }
    writer.finish().expect("written");
}
