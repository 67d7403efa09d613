//! Margins of the track loop around the velocity loop of a rigid axis, in time domain, against the analytic loop.

use super::*;
use crate::AxisGains;
use crate::velocity::VelocityController;

const FAST_PERIOD_S: f64 = 250e-6;
/// 1.5 ms each way.
const LATE_TICKS: usize = 6;
const PROBE: Probe =
    Probe { period_s: FAST_PERIOD_S, operating_point: 0.0, amplitude: 1e-3, settle_s: 6.0, measure_s: 6.0 };

struct RigidAxis {
    velocity_kp: f64,
    velocity_ki: f64,
    inertia: f64,
    damping: f64,
    track: TrackGains,
}

const ELEVATION_AXIS: RigidAxis = RigidAxis {
    velocity_kp: 18_250.0,
    velocity_ki: 361_400.0,
    inertia: 1018.49,
    damping: 68.4,
    track: ELEVATION,
};

const AZIMUTH_AXIS: RigidAxis = RigidAxis {
    velocity_kp: 23_600.0,
    velocity_ki: 447_500.0,
    inertia: 1121.29,
    damping: 273.6,
    track: TrackGains { gain_per_s: 4.95, integral_time_s: 0.246, gyro_lead_s: 1e-3 },
};

impl RigidAxis {
    /// `Kt (1 + 1/(Tt s)) (1/s + Tp) V(s)`, V the closed velocity loop with 3.125 ms of delay.
    fn analytic(&self, frequency_hz: f64) -> Complex {
        let s = Complex::new(0.0, TAU * frequency_hz);
        let pi = Complex::real(self.velocity_kp) + Complex::real(self.velocity_ki) / s;
        let plant = Complex::ONE / (s * self.inertia + Complex::real(self.damping));
        let open = pi * plant * Complex::unit(-TAU * frequency_hz * 3.125e-3);
        // 1.5 ms of the delay stand behind the gyro: the true rate comes before them.
        let closed = open / (Complex::ONE + open) * Complex::unit(TAU * frequency_hz * 1.5e-3);
        let track = Complex::ONE + Complex::ONE / (s * self.track.integral_time_s);
        let angle = Complex::ONE / s + Complex::real(self.track.gyro_lead_s);
        track * angle * closed * self.track.gain_per_s
    }

    /// The loop opened at the rate command by injecting there: `L = inj/u − 1`.
    fn measured(&self, every: usize, late: usize, gyro_lead_s: f64, frequency_hz: f64) -> Complex {
        let mut rig = Rig::new(self, gyro_lead_s);
        let mut camera = Camera::new(every, late);
        opened(frequency_hz, |u| {
            let frame = rig.tracks().then(|| camera.update(-rig.angle_rad)).flatten();
            rig.step(u, frame)
        })
    }
}

fn opened(frequency_hz: f64, step: impl FnMut(f64) -> f64) -> Complex {
    let sensitivity = frequency_response(step, &PROBE, frequency_hz).expect("finite");
    Complex::ONE / sensitivity - Complex::ONE
}

/// Velocity loop at 4 kHz, track loop at 2 kHz, target at rest.
struct Rig {
    velocity_loop: VelocityController,
    track_loop: CoarseTracker,
    decay: f64,
    damping: f64,
    rate: f64,
    angle_rad: f64,
    tick: usize,
    command: f64,
    torques: VecDeque<f64>,
    gyro: VecDeque<f64>,
}

impl Rig {
    fn new(axis: &RigidAxis, gyro_lead_s: f64) -> Self {
        let gains = AxisGains {
            velocity_kp_nm_s_per_rad: axis.velocity_kp,
            velocity_ki_nm_per_rad: axis.velocity_ki,
            track: TrackGains { gyro_lead_s, ..axis.track },
            ..AxisGains::default()
        };
        Self {
            velocity_loop: VelocityController::new(&gains, 1e9, FAST_PERIOD_S),
            track_loop: CoarseTracker::new(&gains.track, &settings(Prediction::Off), FAST, PERIOD_S),
            decay: (-axis.damping / axis.inertia * FAST_PERIOD_S).exp(),
            damping: axis.damping,
            rate: 0.0,
            angle_rad: 0.0,
            tick: 0,
            command: 0.0,
            torques: VecDeque::from([0.0; LATE_TICKS]),
            gyro: VecDeque::from([0.0; LATE_TICKS]),
        }
    }

    /// Whether the track loop runs in this tick.
    fn tracks(&self) -> bool {
        self.tick.is_multiple_of(2)
    }

    /// One tick of the velocity loop; returns what goes into it.
    fn step(&mut self, injected: f64, frame: Option<Frame>) -> f64 {
        self.gyro.push_back(self.rate);
        let gyro = self.gyro.pop_front().expect("just pushed");
        if self.tracks() {
            self.command = self.track_loop.update(frame, gyro);
        }
        self.tick += 1;
        let wanted = self.command + injected;
        self.torques.push_back(self.velocity_loop.update(wanted, gyro, 0.0));
        let steady = self.torques.pop_front().expect("just pushed") / self.damping;
        let before = self.rate;
        let time_constant_s = -FAST_PERIOD_S / self.decay.ln();
        // Rate and angle are exact between the samples.
        self.rate = steady + (before - steady) * self.decay;
        self.angle_rad += steady * FAST_PERIOD_S + (before - self.rate) * time_constant_s;
        wanted
    }
}

/// Frequency where the loop's gain falls through 1, and its phase margin in degrees.
fn margin(gain: impl Fn(f64) -> Complex) -> (f64, f64) {
    let mut low = 0.7;
    let mut high = 1.4;
    for _ in 0..10 {
        let middle = (low + high) / 2.0;
        if gain(middle).magnitude() > 1.0 { low = middle } else { high = middle }
    }
    (low, 180.0 + gain(low).phase_rad().to_degrees())
}

/// Bandwidth and phase margin of the published tables.
fn assert_published(axis: &RigidAxis, measured: (f64, f64), published_deg: f64) {
    let (analytic_hz, analytic_deg) = margin(|f| axis.analytic(f));
    let (bandwidth_hz, margin_deg) = measured;
    assert!((bandwidth_hz - analytic_hz).abs() < 0.005, "{bandwidth_hz} {analytic_hz}");
    assert!((margin_deg - analytic_deg).abs() < 0.3, "{margin_deg} {analytic_deg}");
    assert!((1.0..1.055).contains(&bandwidth_hz), "{bandwidth_hz}");
    assert!((margin_deg - published_deg).abs() < 0.3, "{margin_deg}");
}

#[test]
fn camera_without_latency_gives_the_published_bandwidth_and_margin() {
    for (axis, published_deg) in [(&ELEVATION_AXIS, 72.7), (&AZIMUTH_AXIS, 56.5)] {
        assert_published(axis, margin(|f| axis.measured(1, 0, 1e-3, f)), published_deg);
    }
}

#[test]
fn camera_of_50_hz_and_40_ms_with_the_gyro_gives_the_same_margin() {
    for (axis, published_deg) in [(&ELEVATION_AXIS, 72.7), (&AZIMUTH_AXIS, 56.5)] {
        assert_published(axis, margin(|f| axis.measured(40, 80, 2.5e-3, f)), published_deg);
        // Where the gain margin is read.
        for frequency_hz in [3.0, 5.0, 6.0] {
            let ratio = axis.measured(40, 80, 2.5e-3, frequency_hz) / axis.measured(1, 0, 1e-3, frequency_hz);
            let apart_db = 20.0 * ratio.magnitude().log10();
            assert!(apart_db.abs() < 0.1, "{frequency_hz} Hz: {apart_db}");
        }
    }
}

#[test]
fn same_camera_without_the_gyros_help_costs_the_phase_of_its_latency() {
    // Age 0 is claimed: the tracker takes the late error for a fresh one.
    let mut rig = Rig::new(&ELEVATION_AXIS, 1e-3);
    let mut camera = Camera::new(1, 0);
    let mut late: VecDeque<Option<Frame>> = std::iter::repeat_n(None, 80).collect();
    let raw = opened(1.02, |u| {
        let frame = rig.tracks().then(|| {
            late.push_back(camera.update(-rig.angle_rad));
            late.pop_front().expect("just pushed")
        });
        rig.step(u, frame.flatten())
    });
    let lost_deg = (ELEVATION_AXIS.analytic(1.02) / raw).phase_rad().to_degrees();
    assert!((lost_deg - 360.0 * 1.02 * 0.04).abs() < 0.5, "{lost_deg}");
}
