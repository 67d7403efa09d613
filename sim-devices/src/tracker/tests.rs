use super::*;
use crate::unit::UnitSettings;
use drivers::tracker::{LENGTH, decode};
use drivers::wire::DatagramPort;

fn address() -> SeedAddress {
    SeedAddress { seed: 5, procedure: "TEST".into(), point: "1".into() }
}

/// The coarse camera without the scale error that gives the nominal unit its loop gain, and with a true clock.
fn coarse() -> CameraSettings {
    CameraSettings {
        scale_ratio: 1.0,
        clock_offset_s: 0.0,
        clock_drift_ratio: 0.0,
        ..UnitSettings::default().trackers.coarse
    }
}

fn camera(settings: &CameraSettings) -> Camera {
    Camera::new(settings, Source::Coarse, &address())
}

/// All messages that have arrived.
fn arrived(camera: &mut Camera, now: Duration) -> Vec<Sample> {
    let mut bytes = [0; LENGTH];
    let mut samples = vec![];
    while camera.port().receive(now, &mut bytes).expect("the port is there").is_some() {
        samples.push(decode(&bytes).expect("the twin speaks the format").1);
    }
    samples
}

fn frames(settings: &CameraSettings, offset_rad: [f64; 2], count: u32) -> Vec<Sample> {
    let mut camera = camera(settings);
    (0..count)
        .flat_map(|_| {
            camera.expose(Some(offset_rad));
            arrived(&mut camera, Duration::from_secs(1000))
        })
        .collect()
}

#[test]
fn a_message_arrives_after_the_latency_and_tells_the_centre_of_the_shutter() {
    let mut camera = camera(&coarse());
    camera.expose(Some([0.0; 2]));
    camera.expose(Some([0.0; 2]));
    let centre = Duration::from_micros(20_500);
    assert!(arrived(&mut camera, Duration::from_micros(40_499)).is_empty());
    assert_eq!(arrived(&mut camera, Duration::from_micros(40_500)).len(), 1);
    let second = arrived(&mut camera, Duration::from_micros(60_500));
    assert_eq!((second[0].counter, second[0].stamp), (1, centre));
}

#[test]
fn a_camera_stamps_its_frames_with_a_clock_of_its_own() {
    let stamp_of_second = |clock_drift_ratio| {
        let settings = CameraSettings { clock_offset_s: 100.0, clock_drift_ratio, ..coarse() };
        frames(&settings, [0.0; 2], 2)[1].stamp
    };
    let offset = Duration::from_secs(100);
    // 20.5 ms are 205 ns more on a clock that is 10 ppm fast.
    assert_eq!(stamp_of_second(10e-6), offset + Duration::from_nanos(20_500_205));
    assert_eq!(stamp_of_second(-10e-6), offset + Duration::from_nanos(20_499_795));
}

/// E26: 100 µrad up are 3.67 px along the rows, 100 µrad aside 2.75 px along the columns.
#[test]
fn the_coarse_camera_is_rotated() {
    let still = CameraSettings { jitter_px: 0.0, centroid_step_px: 0.0, ..coarse() };
    let up = frames(&still, [0.0, 100e-6], 1)[0];
    let aside = frames(&still, [100e-6, 0.0], 1)[0];
    assert!((up.x_px - 3.667).abs() < 1e-3 && up.y_px == 0.0, "{up:?}");
    assert!((aside.y_px - 2.750).abs() < 1e-3 && aside.x_px == 0.0, "{aside:?}");
}

/// Uniform over half a pixel: standard deviation 0.5/√12, nothing outside ± 0.25.
#[test]
fn jitter_is_half_a_pixel_peak_to_peak_and_uniform() {
    let exact = CameraSettings { centroid_step_px: 0.0, ..coarse() };
    let values: Vec<f64> = frames(&exact, [0.0; 2], 20_000).iter().map(|s| f64::from(s.x_px)).collect();
    let deviation = (values.iter().map(|x| x * x).sum::<f64>() / 20_000.0).sqrt();
    assert!((deviation / (0.5 / 12.0_f64.sqrt()) - 1.0).abs() < 0.02, "{deviation}");
    let largest = values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!(largest <= 0.25 && largest > 0.249, "{largest}");
}

#[test]
fn centroids_come_in_sixteenths_and_scale_stretches_them() {
    let stretched = CameraSettings { scale_ratio: 2.0, ..coarse() };
    assert!(frames(&coarse(), [0.0; 2], 100).iter().all(|s| (s.x_px * 16.0).fract() == 0.0));
    let one = frames(&coarse(), [1e-3, 2e-3], 50);
    let two = frames(&stretched, [1e-3, 2e-3], 50);
    assert!(one.iter().zip(&two).all(|(a, b)| 2.0 * a.x_px == b.x_px && 2.0 * a.y_px == b.y_px));
}

#[test]
fn a_target_that_left_the_field_is_lost_and_must_be_seen_for_a_while() {
    let mut camera = camera(&coarse());
    let mut locks = vec![];
    for frame in 0..40 {
        // Half of 640 px is 8726 µrad; the image itself has a radius of 8 px.
        let up = if (10..15).contains(&frame) { 320.0 * 27.27e-6 + 9.0 * 27.27e-6 } else { 0.0 };
        camera.expose(Some([0.0, up]));
        locks.extend(arrived(&mut camera, Duration::from_secs(9)).iter().map(|sample| sample.lock));
    }
    let count = |lock| locks.iter().filter(|found| **found == lock).count();
    assert!(locks[..10].iter().all(|lock| *lock == Lock::Tracking));
    assert!(locks[10..15].iter().all(|lock| *lock == Lock::Lost));
    // 200 ms at 50 Hz.
    assert!(locks[15..25].iter().all(|lock| *lock == Lock::Reacquiring));
    assert_eq!((count(Lock::Tracking), count(Lock::Lost)), (25, 5));
}

#[test]
fn quality_falls_at_the_edge() {
    let edge = |px: f64| frames(&coarse(), [0.0, px * 27.27e-6], 1)[0].quality;
    assert_eq!(edge(300.0), 1.0);
    assert!((edge(320.0) - 0.5).abs() < 0.01);
    assert_eq!(edge(330.0), 0.0);
}

#[test]
fn dropped_frames_leave_gaps_in_the_counter() {
    let lossy = CameraSettings { dropped_ratio: 0.1, ..coarse() };
    let samples = frames(&lossy, [0.0; 2], 10_000);
    assert!((samples.len() as f64 - 9000.0).abs() < 4.0 * 30.0, "{}", samples.len());
    assert!(samples.windows(2).all(|pair| pair[1].counter > pair[0].counter));
    assert!(samples.iter().all(|sample| sample.stamp.as_millis() == 20 * u128::from(sample.counter)));
}

#[test]
fn a_port_nobody_reads_keeps_the_newest() {
    let mut camera = camera(&coarse());
    (0..1000).for_each(|_| camera.expose(None));
    let waiting = arrived(&mut camera, Duration::from_secs(1000));
    assert_eq!((waiting.len(), waiting.last().map(|sample| sample.counter)), (256, Some(999)));
}

#[test]
fn every_fifth_frame_is_not_sent_where_the_link_loses_them_in_turn() {
    let settings = CameraSettings { drop_period_count: 5.0, ..coarse() };
    let counters: Vec<u32> = frames(&settings, [0.0; 2], 12).iter().map(|sample| sample.counter).collect();
    assert_eq!(counters, [0, 1, 2, 3, 5, 6, 7, 8, 10, 11]);
}

#[test]
fn messages_arrive_up_to_the_spread_after_the_latency_and_evenly_within_it() {
    let settings = CameraSettings { latency_spread_s: 5e-3, ..coarse() };
    let mut camera = camera(&settings);
    let mut late_us: Vec<u64> = Vec::new();
    for frame in 0..400 {
        camera.expose(Some([0.0; 2]));
        // The latency is 40 ms after the centre of the shutter.
        let due_us = 20_000 * frame + 40_500;
        let has_come = |late: &u64| !arrived(&mut camera, Duration::from_micros(due_us + late)).is_empty();
        late_us.extend((0..=5000).step_by(100).find(has_come));
    }
    assert_eq!(late_us.len(), 400);
    let mean_us = late_us.iter().sum::<u64>() as f64 / 400.0;
    // Looked at every 100 us; 5 ms / sqrt(12) over 400 frames are 72 us.
    assert!((mean_us - 2550.0).abs() < 4.0 * 72.0, "{mean_us}");
    assert!(late_us.iter().any(|late| *late < 200) && late_us.iter().any(|late| *late > 4800));
}

#[test]
fn every_fourth_frame_is_without_the_target_where_the_tracker_is_blind_in_turn() {
    let settings = CameraSettings { blank_period_count: 4.0, reacquisition_s: 0.0, ..coarse() };
    let locks: Vec<Lock> = frames(&settings, [0.0; 2], 9).iter().map(|sample| sample.lock).collect();
    let lost: Vec<usize> = (0..9).filter(|&k| locks[k] == Lock::Lost).collect();
    assert_eq!(lost, [3, 7]);
    assert!((0..9).all(|k| lost.contains(&k) || locks[k] == Lock::Tracking), "{locks:?}");
}
