//! A test bed for tracking: scene, tracker drivers and, as closures, whatever plant and laws are put in.

use std::time::Duration;

use drivers::tracker::{Actuals, DeclaredDelay, Source, Tracker, TrackerSettings};
use sim_devices::motion::Motion;
use sim_devices::physics::noise::SeedAddress;
use sim_devices::scene::{Scene, SceneTruth};
use sim_devices::unit::{CameraSettings, UnitSettings};

/// Rate of plant and scene.
pub(super) const STEP_RATE_HZ: u32 = 4000;

/// A coarse law: rate command from time, the coarse tracker (with whether its frame is new) and the structure.
type CoarseLaw<'a> = dyn FnMut(Duration, (&Actuals, bool), &Motion) -> [f64; 2] + 'a;

/// What is under test: each is called once per step, in this order.
pub(super) struct Parts<'a> {
    /// One step with the rate command of both axes.
    pub(super) plant: &'a mut dyn FnMut([f64; 2]) -> Motion,
    /// Mirror angles of this step for a commanded line-of-sight correction.
    pub(super) mirror: &'a mut dyn FnMut([f64; 2]) -> [f64; 2],
    /// Rate command.
    pub(super) coarse: &'a mut CoarseLaw<'a>,
    /// Commanded mirror angles from the fine tracker, at each new frame.
    pub(super) fine: &'a mut dyn FnMut(&Actuals) -> [f64; 2],
}

/// One step's truth.
pub(super) struct Row {
    pub(super) time_s: f64,
    pub(super) truth: SceneTruth,
    pub(super) mirror_rad: [f64; 2],
}

fn driver(name: &str, source: Source, camera: &CameraSettings) -> Tracker {
    // Maps are permutations here: their inverse is the transpose.
    let map = [
        [camera.x_of_cross_elevation_ratio, camera.y_of_cross_elevation_ratio],
        [camera.x_of_elevation_ratio, camera.y_of_elevation_ratio],
    ];
    let ifov_rad = [camera.ifov_x_rad, camera.ifov_y_rad];
    let declared_delay = DeclaredDelay { delay_s: camera.latency_s, u_s: 0.0 };
    let poll_period = Duration::from_secs(1) / STEP_RATE_HZ;
    Tracker::new(TrackerSettings { name: name.into(), source, ifov_rad, map, declared_delay, poll_period })
        .expect("nominal settings are good")
}

/// Runs for a time; keeps every tenth step.
pub(super) fn run(unit: &UnitSettings, seed: u64, seconds: u32, parts: Parts<'_>) -> Vec<Row> {
    let address = SeedAddress { seed, procedure: "TRACKING".into(), point: "1".into() };
    let mut scene = Scene::new(unit, &address);
    let mut coarse = driver("coarse", Source::Coarse, &unit.trackers.coarse);
    let mut fine = driver("fine", Source::Fine, &unit.trackers.fine);
    let mut rate_command = [0.0; 2];
    let mut mirror_command = [0.0; 2];
    let mut rows = vec![];
    for step in 0..u64::from(seconds * STEP_RATE_HZ) {
        let now = Duration::from_nanos(step * 1_000_000_000 / u64::from(STEP_RATE_HZ));
        let motion = (parts.plant)(rate_command);
        let mirror_rad = (parts.mirror)(mirror_command);
        scene.advance(now, &motion, mirror_rad);
        let (seen, fresh) = coarse.poll(scene.coarse_port(), now).expect("the port is there");
        rate_command = (parts.coarse)(now, (&seen, fresh), &motion);
        let (seen, fresh) = fine.poll(scene.fine_port(), now).expect("the port is there");
        if fresh {
            mirror_command = (parts.fine)(&seen);
        }
        if step % 10 == 0 {
            let truth = scene.truth(now, &motion, mirror_rad);
            rows.push(Row { time_s: now.as_secs_f64(), truth, mirror_rad });
        }
    }
    rows
}
