//! How well `bench regress` uses two processors: the same comparison with one job, with two jobs, and as two shards of one job each
//! that run beside each other. The shards share nothing, so they show what the machine itself loses with both processors busy.
#![allow(clippy::print_stdout)]

use std::path::Path;
use std::process::{Child, Command, Stdio};

use bench::clock::Stopwatch;

const ROUNDS: usize = 3;
/// Pairs of each comparison; an even number, for two equal shards.
const UNITS: &str = "6";

fn comparison(folder: &Path, arguments: &[&str]) -> Child {
    let _ = std::fs::remove_dir_all(folder);
    Command::new(env!("CARGO_BIN_EXE_bench"))
        .args(["regress", "--candidate", "director", "--units", UNITS])
        .args(arguments)
        .arg("--out")
        .arg(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program was built")
}

/// Time of comparisons that are started together until the last one ends, s.
fn time_s(folder: &Path, arguments: &[&[&str]]) -> f64 {
    let watch = Stopwatch::start();
    let started = arguments.iter().enumerate();
    let running: Vec<Child> =
        started.map(|(k, arguments)| comparison(&folder.join(k.to_string()), arguments)).collect();
    for mut child in running {
        let status = child.wait().expect("a child of this process");
        assert!(status.success(), "a controller beside itself: {status}");
    }
    watch.elapsed_s()
}

/// Processor time of all children that have ended, s. From `/proc/self/stat`, fields 16 and 17.
fn children_cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    // The name of the program, in parentheses, may hold blanks.
    let fields = stat.rsplit_once(')').map_or("", |(_, after)| after);
    let ticks: Vec<f64> =
        fields.split_whitespace().skip(13).take(2).map(|field| field.parse().expect("a number")).collect();
    ticks.iter().sum::<f64>() / rustix::param::clock_ticks_per_second() as f64
}

fn main() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    println!(
        "{UNITS} pairs of the campaign `regression`; efficiency: time of one job over twice that of two"
    );
    for round in 1..=ROUNDS {
        let one_s = time_s(folder.path(), &[&["--jobs", "1"]]);
        let before_s = children_cpu_s();
        let two_s = time_s(folder.path(), &[&["--jobs", "2"]]);
        let busy = (children_cpu_s() - before_s) / (2.0 * two_s);
        let shards_s =
            time_s(folder.path(), &[&["--jobs", "1", "--shard", "1/2"], &["--jobs", "1", "--shard", "2/2"]]);
        println!(
            "round {round}: one job {one_s:.1} s, two jobs {two_s:.1} s, two shards {shards_s:.1} s; efficiency {:.1} %, of \
             separate shards {:.1} %; with two jobs both processors are busy for {:.1} % of the time",
            50.0 * one_s / two_s,
            50.0 * one_s / shards_s,
            100.0 * busy,
        );
    }
}
