use std::time::Duration;

use drivers::tracker::{LENGTH, decode};
use drivers::wire::DatagramPort;

use crate::motion::Motion;
use crate::physics::noise::SeedAddress;
use crate::scene::Scene;
use crate::unit::UnitSettings;

/// Where the camera's offset in pixels comes from: a mirror that turns by its optical gain takes away an angle of one.
#[test]
fn mirror_angles_count_by_the_optical_gains() {
    let unit = UnitSettings::default();
    let address = SeedAddress { seed: 1, procedure: "TEST".into(), point: "1".into() };
    let mut scene = Scene::new(&unit, &address);
    let motion = Motion::default();
    let mut error = |mirror_rad| scene.truth(Duration::ZERO, &motion, mirror_rad).fine_error_rad;
    let still = error([0.0; 2]).expect("ahead");
    let turned = error([3.5355e-4, 2.5e-4]).expect("ahead");
    assert!((0..2).all(|k| (still[k] - turned[k] - 1e-4).abs() < 1e-15), "{still:?}, {turned:?}");
}

/// At 80° a degree of azimuth is 0.174° in the camera, and the far side of the sky is behind it.
#[test]
fn cross_elevation_shrinks_with_the_cosine_of_elevation() {
    let mut unit = UnitSettings::default();
    unit.target.elevation_rad = 80.0_f64.to_radians();
    let address = SeedAddress { seed: 1, procedure: "TEST".into(), point: "1".into() };
    let mut scene = Scene::new(&unit, &address);
    let mut error = |frame_rad| {
        let motion = Motion { frame_rad, ..Default::default() };
        scene.truth(Duration::ZERO, &motion, [0.0; 2]).coarse_error_rad
    };
    let [cross, up] = error([-1e-3, unit.target.elevation_rad - 2e-3]).expect("ahead");
    assert!((cross - 1e-3 * 80.0_f64.to_radians().cos()).abs() < 1e-6, "{cross}");
    assert!((up - 2e-3).abs() < 1e-6, "{up}");
    assert_eq!(error([0.0, -0.5]), None);
}

/// The structure turns at 0.1 rad/s; whether the World steps at 20 kHz or 3 kHz, a frame shows the same pixels, taken
/// back from the step to the centre of its shutter.
#[test]
fn a_frame_shows_the_centre_of_its_shutter_whatever_the_step() {
    let mut unit = UnitSettings::default();
    (unit.trackers.fine.frame_rate_hz, unit.trackers.fine.jitter_px) = (173.0, 0.0);
    unit.trackers.fine.centroid_step_px = 0.0;
    let frames = |steps_per_s: u64| {
        let address = SeedAddress { seed: 1, procedure: "TEST".into(), point: "1".into() };
        let mut scene = Scene::new(&unit, &address);
        for step in 0..steps_per_s / 200 {
            let now = Duration::from_nanos(step * 1_000_000_000 / steps_per_s);
            let angle = 0.1 * now.as_secs_f64();
            let motion = Motion { frame_rad: [angle; 2], frame_rad_per_s: [0.1; 2], ..Motion::default() };
            scene.advance(now, &motion, [0.0; 2]);
        }
        let mut bytes = [0; LENGTH];
        let end = Duration::from_secs(1);
        scene.fine_port().receive(end, &mut bytes).expect("the port is there").expect("a frame was taken");
        decode(&bytes).expect("the twin speaks the format").1
    };
    let fast = frames(20_000);
    let slow = frames(3_000);
    assert_eq!(fast.stamp, slow.stamp);
    assert!(
        (fast.x_px - slow.x_px).abs() < 1e-3 && (fast.y_px - slow.y_px).abs() < 1e-3,
        "{fast:?}, {slow:?}"
    );
}
