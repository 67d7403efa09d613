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
/// Rows come round again after one second: they lie in the cache, as those of the recorder's ring do.
const DISTINCT_ROWS: usize = 4000;
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

/// A slow stroke as a drive reports it: every measured value is a count with noise, scaled.
fn rows() -> Vec<[f64; 10]> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut noise_count = move |most: u32| f64::from(random.next_u32() % (2 * most + 1)) - f64::from(most);
    let quantum_rad = std::f64::consts::TAU / f64::from(1 << 26);
    let (rated_torque_nm, rated_current_a) = (900.0, 96.0);
    let row = |k: usize| {
        let commanded_rad = 0.1 * k as f64 / 4000.0;
        let count = (commanded_rad / quantum_rad).round() + noise_count(2);
        let velocity_count = (0.1 / quantum_rad).round() + noise_count(20);
        let torque_nm = (222.0 + noise_count(3)) * rated_torque_nm / 1000.0;
        let current_a = (222.0 + noise_count(3)) * rated_current_a / 1000.0;
        let velocity_rad_per_s = velocity_count * quantum_rad;
        let position_rad = count * quantum_rad;
        [
            position_rad,
            velocity_rad_per_s,
            torque_nm,
            current_a,
            commanded_rad,
            200.0,
            31.5,
            count,
            567.0,
            0.0,
        ]
    };
    (0..DISTINCT_ROWS).map(row).collect()
}

/// The same with noise in every bit of the measured doubles: as hard as it gets.
fn noisy_rows() -> Vec<[f64; 10]> {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut rows = rows();
    for value in rows.iter_mut().flat_map(|r| &mut r[..4]) {
        *value *= 1.0 + 1e-3 * f64::from(random.next_u32()) / f64::from(u32::MAX);
    }
    rows
}

fn write(rows: &[[f64; 10]], sink: Vec<u8>) -> Vec<u8> {
    let procedure = Attachment { name: "procedure.toml".to_owned(), text: "schema = 1\n".to_owned() };
    let sink = Cursor::new(sink);
    let mut log = LogWriter::new(sink, &plan(), &[topic()], &[procedure]).expect("memory takes everything");
    log.event(0, &Event::PointStarted { point: 0 }).expect("memory takes everything");
    for (k, row) in rows.iter().cycle().take(ROWS).enumerate() {
        log.row(0, k as u64 * 250_000, row).expect("memory takes everything");
    }
    let end = Event::PointEnded { point: 0, status: PointStatus::Completed };
    log.event(ROWS as u64 * 250_000, &end).expect("memory takes everything");
    log.finish().expect("memory takes everything").into_inner()
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn write_drive_rows(bencher: divan::Bencher<'_, '_>) {
    bench_writing(bencher, &rows());
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn write_noisy_rows(bencher: divan::Bencher<'_, '_>) {
    bench_writing(bencher, &noisy_rows());
}

/// The sink is memory that was touched before: the writer is measured, not the operating system.
fn bench_writing(bencher: divan::Bencher<'_, '_>, rows: &[[f64; 10]]) {
    let mut sink = write(rows, Vec::new());
    bencher.counter(ItemsCount::new(ROWS)).counter(BytesCount::new(ROWS * PAYLOAD_BYTES)).bench_local(|| {
        let mut reused = std::mem::take(&mut sink);
        reused.clear();
        sink = write(rows, reused);
    });
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn read_drive_rows(bencher: divan::Bencher<'_, '_>) {
    let path = written(&write(&rows(), Vec::new()));
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
