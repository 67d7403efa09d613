//! Messages per second into and out of a log: rows of 64 bytes, zstd level 1, one core.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use divan::counter::{BytesCount, ItemsCount};
use procedures::log::{
    Attachment, Channel, Event, LogReader, LogWriter, PLAN_SCHEMA, Plan, PointStatus, Topic, Width,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

const ROWS: usize = 500_000;
const PAYLOAD_BYTES: usize = 64;

fn main() {
    divan::main();
}

fn topic() -> Topic {
    let channel = |(name, unit, width): (&str, &str, Width)| Channel {
        name: name.to_owned(),
        unit: unit.to_owned(),
        width,
    };
    let channels = [
        ("position_rad", "rad", Width::F64),
        ("velocity_rad_per_s", "rad/s", Width::F64),
        ("torque_nm", "N*m", Width::F64),
        ("current_a", "A", Width::F64),
        ("commanded_position_rad", "rad", Width::F64),
        ("commanded_torque_nm", "N*m", Width::F64),
        ("heat_sink_temperature_degc", "degC", Width::F32),
        ("position_count", "count", Width::I32),
        ("status_word", "", Width::U16),
        ("error_code", "", Width::U16),
    ];
    let channels = channels.into_iter().map(channel).collect();
    Topic { name: "/az".to_owned(), message: "bench_msgs/msg/Axis".to_owned(), channels }
}

fn plan() -> Plan {
    Plan {
        schema: PLAN_SCHEMA,
        procedure: "AZ-FRICTION".to_owned(),
        axis: "az".to_owned(),
        seed: 1,
        loop_rate_hz: 4000.0,
        log_rate_hz: 4000.0,
        command_delay_ticks: 1,
        axes: procedures::axis::Axes::default(),
        cases: Vec::new(),
        mode: "simulated".to_owned(),
    }
}

/// A slow stroke with noise on every measured channel: neither all zeros nor all entropy.
fn rows() -> Vec<[f64; 10]> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut noise =
        move |amplitude: f64| amplitude * (f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5);
    let quantum_rad = std::f64::consts::TAU / f64::from(1 << 26);
    let row = |k: usize| {
        let commanded_rad = 0.1 * k as f64 / 4000.0;
        let count = ((commanded_rad + noise(1e-6)) / quantum_rad).round();
        let torque_nm = 200.0 + noise(2.0);
        let current_a = (torque_nm / 9.4 * 1000.0).round() / 1000.0;
        let velocity = 0.1 + noise(1e-4);
        [count * quantum_rad, velocity, torque_nm, current_a, commanded_rad, 200.0, 31.5, count, 567.0, 0.0]
    };
    (0..ROWS).map(row).collect()
}

fn write(rows: &[[f64; 10]]) -> Vec<u8> {
    let procedure = Attachment { name: "procedure.toml".to_owned(), text: "schema = 1\n".to_owned() };
    let sink = Cursor::new(Vec::with_capacity(64 << 20));
    let mut log = LogWriter::new(sink, &plan(), &[topic()], &[procedure]).expect("memory takes everything");
    log.event(0, &Event::PointStarted { point: 0 }).expect("memory takes everything");
    for (k, row) in rows.iter().enumerate() {
        log.row(0, k as u64 * 250_000, row).expect("memory takes everything");
    }
    let end = Event::PointEnded { point: 0, status: PointStatus::Completed };
    log.event(rows.len() as u64 * 250_000, &end).expect("memory takes everything");
    log.finish().expect("memory takes everything").into_inner()
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn write_messages(bencher: divan::Bencher<'_, '_>) {
    let rows = rows();
    bencher
        .counter(ItemsCount::new(ROWS))
        .counter(BytesCount::new(ROWS * PAYLOAD_BYTES))
        .bench_local(|| write(&rows));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn read_messages(bencher: divan::Bencher<'_, '_>) {
    let path = written(&write(&rows()));
    bencher
        .counter(ItemsCount::new(ROWS))
        .counter(BytesCount::new(ROWS * PAYLOAD_BYTES))
        .bench_local(|| read(&path));
    std::fs::remove_file(&path).expect("the file was written above");
}

fn written(bytes: &[u8]) -> PathBuf {
    let path = std::env::temp_dir().join(format!("bench-log-{}.mcap", std::process::id()));
    std::fs::write(&path, bytes).expect("the folder of temporary files takes a file");
    path
}

fn read(path: &Path) -> usize {
    let mut log = LogReader::open(path).expect("the file was written above");
    let mut rows = 0;
    while let Some(window) = log.next_window() {
        rows += window.topics[0].time_s.len();
    }
    assert!(log.damage().is_none(), "{:?}", log.damage());
    assert_eq!(rows, ROWS);
    rows
}
