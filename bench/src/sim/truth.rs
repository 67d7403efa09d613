//! Ground truth of a served simulator: where the axes really are, row by row, in a log of its own, written by its own thread.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::thread::JoinHandle;
use std::time::Duration;

use procedures::axis::MAX_AXES;
use procedures::log::{Channel, LogError, LogWriter, PLAN_SCHEMA, Plan, Topic, Width};
use rtrb::{Consumer, Producer, RingBuffer};

use crate::clock;
use crate::model::rig::Rig;

/// Rows a second.
pub(super) const RATE_HZ: u32 = 1000;
/// Rows that wait while the disk stalls: eight seconds.
const ROWS: usize = 8192;
/// Angle and rate of each axis.
const VALUES: usize = 2 * MAX_AXES;

#[derive(Clone, Copy, Debug)]
struct Row {
    time_ns: u64,
    values: [f64; VALUES],
}

/// The simulator's end of the ring.
pub(super) struct TruthLog {
    ring: Producer<Row>,
    thread: JoinHandle<Result<(), LogError>>,
    /// Rows that the disk was too slow for.
    lost: u64,
}

impl TruthLog {
    /// Creates the log of these axes.
    ///
    /// # Errors
    /// When the file cannot be created or its head cannot be written.
    pub(super) fn create(path: &Path, rig: &Rig, axes: &[String], seed: u64) -> Result<Self, LogError> {
        let failed = |source| LogError::Io { file: path.display().to_string(), source };
        let file = File::create_new(path).map_err(failed)?;
        let topic = topic(axes);
        let plan = Plan {
            schema: PLAN_SCHEMA,
            procedure: "SIM".to_owned(),
            axis: axes.first().cloned().unwrap_or_default(),
            seed,
            loop_rate_hz: rig.loop_rate_hz,
            log_rate_hz: f64::from(RATE_HZ),
            command_delay_ticks: 0,
            axes: rig.limits(),
            cases: Vec::new(),
            mode: "simulated".to_owned(),
        };
        let about = BTreeMap::from([("what".to_owned(), "ground truth of a simulated rig".to_owned())]);
        let count = topic.channels.len();
        let writer = LogWriter::about(BufWriter::new(file), &plan, &[topic], &[], &about)?;
        let (ring, rows) = RingBuffer::new(ROWS);
        let write = move || write(writer, rows, count);
        let thread = std::thread::Builder::new().name("truth".to_owned()).spawn(write).map_err(failed)?;
        Ok(Self { ring, thread, lost: 0 })
    }

    /// Hands over a row: angle and rate of each axis. Never waits.
    pub(super) fn row(&mut self, at: Duration, axes: &[sim_devices::rig::AxisTruth]) {
        let mut values = [0.0; VALUES];
        let count = axes.len().min(MAX_AXES);
        for (k, axis) in axes.iter().take(count).enumerate() {
            (values[k], values[count + k]) = (axis.angle_rad, axis.rate_rad_per_s);
        }
        let time_ns = u64::try_from(at.as_nanos()).unwrap_or(u64::MAX);
        if self.ring.push(Row { time_ns, values }).is_err() {
            self.lost += 1;
        }
    }

    /// Closes the log; how many rows were lost.
    ///
    /// # Errors
    /// What the writer ran into.
    pub(super) fn finish(self) -> Result<u64, LogError> {
        let Self { ring, thread, lost } = self;
        drop(ring);
        let gone =
            || LogError::Damaged { file: "truth log".to_owned(), reason: "its writer panicked".to_owned() };
        thread.join().map_err(|_| gone())??;
        Ok(lost)
    }
}

/// Angles first: equal widths stand together.
fn topic(axes: &[String]) -> Topic {
    let channel = |name: String, unit: &str, width| Channel { name, unit: unit.to_owned(), width };
    let angles = axes.iter().map(|axis| channel(format!("{axis}_angle_rad"), "rad", Width::F64));
    let rates = axes.iter().map(|axis| channel(format!("{axis}_rate_rad_per_s"), "rad/s", Width::F64));
    Topic {
        name: "/truth".to_owned(),
        message: "bench_msgs/msg/Truth".to_owned(),
        channels: angles.chain(rates).collect(),
    }
}

fn write(
    mut writer: LogWriter<BufWriter<File>>,
    mut rows: Consumer<Row>,
    count: usize,
) -> Result<(), LogError> {
    loop {
        let is_over = rows.is_abandoned();
        match rows.pop() {
            Ok(Row { time_ns, values }) => writer.row(0, time_ns, &values[..count])?,
            Err(_) if is_over => break,
            Err(_) => clock::nap(),
        }
    }
    writer.finish().map(|_| ())
}
