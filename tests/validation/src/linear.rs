//! The unit linearised in sliding: transfer functions of its loops as the discrete controllers see them.
//!
//! Structure and friction's viscous part make the plant, the current loop and the transport delays stand before and
//! after it, the controllers are discrete. Nothing here is simulated: what the simulation shows is compared with it.

mod margins;
mod plant;
mod step;
mod track;

pub use margins::{Margins, margins};
pub(crate) use plant::jitter_s;
pub use plant::{Plant, Sensor};
pub use step::{StepResponse, step_figures, step_response};
pub use track::{CoarseCamera, coarse_open_loop};

use controllers::AxisGains;
use num_complex::Complex64;
use sim_devices::unit::UnitSettings;

/// Images of the sampled spectrum on each side that are summed: what is left out is below 10⁻⁵ of the response.
const IMAGES: i32 = 30;

/// The velocity loop of one axis, closed by a discrete controller at `1/period_s`.
#[derive(Clone, Debug)]
pub struct VelocityLoop {
    /// What it controls.
    pub plant: Plant,
    /// Gains of the production controller.
    pub gains: AxisGains,
    /// Period of controller and hold.
    pub period_s: f64,
    /// Images of the sampled spectrum on each side that are summed.
    pub images_count: i32,
}

impl VelocityLoop {
    /// The loop of an axis (0 azimuth, 1 elevation) at an elevation, fed back from a sensor.
    pub fn new(
        unit: &UnitSettings,
        axis: usize,
        elevation_rad: f64,
        sensor: Sensor,
        gains: &AxisGains,
        loop_rate_hz: f64,
    ) -> Self {
        let period_s = 1.0 / loop_rate_hz;
        let plant = Plant::new(unit, axis, elevation_rad, sensor, period_s);
        Self { plant, gains: *gains, period_s, images_count: IMAGES }
    }

    /// Open loop at a frequency: error in, what the sensor reports out.
    ///
    /// `C(z)·z⁻¹·Σ_k H(s_k)·P(s_k)`, `H` the zero-order hold, `s_k` the images of the sampled spectrum (Franklin,
    /// Powell & Workman, *Digital Control of Dynamic Systems*, §5.3); the tick is the loop's own, row to frame.
    pub fn open(&self, frequency_hz: f64) -> Complex64 {
        self.controller(frequency_hz) * self.sampled(frequency_hz, |plant, s| plant.sensed(s))
    }

    /// Closed loop: command in, sensed rate out, its delay included.
    pub fn closed(&self, frequency_hz: f64) -> Complex64 {
        let open = self.open(frequency_hz);
        open / (1.0 + open)
    }

    /// Command in, true rate of the frame out.
    pub fn command_to_frame(&self, frequency_hz: f64) -> Complex64 {
        self.command_to(frequency_hz, Plant::frame)
    }

    /// Command in, true rate of the shaft out.
    pub fn command_to_shaft(&self, frequency_hz: f64) -> Complex64 {
        self.command_to(frequency_hz, Plant::shaft)
    }

    /// `L/(1 + L)` with the baseband response of another output for that of the sensor; images do not reach it.
    fn command_to(&self, frequency_hz: f64, output: fn(&Plant, Complex64) -> Complex64) -> Complex64 {
        let torque = self.controller(frequency_hz) / (1.0 + self.open(frequency_hz));
        let s = Complex64::new(0.0, std::f64::consts::TAU * frequency_hz);
        torque * self.tick(s) * hold(s * self.period_s) * self.plant.actuated(s) * output(&self.plant, s)
    }

    /// The production PI: `Kp + Ki·T·z/(z − 1)`.
    fn controller(&self, frequency_hz: f64) -> Complex64 {
        let z = Complex64::from_polar(1.0, std::f64::consts::TAU * frequency_hz * self.period_s);
        let integral = self.gains.velocity_ki_nm_per_rad * self.period_s * z / (z - 1.0);
        self.gains.velocity_kp_nm_s_per_rad + integral
    }

    fn sampled(&self, frequency_hz: f64, response: fn(&Plant, Complex64) -> Complex64) -> Complex64 {
        let base = std::f64::consts::TAU * frequency_hz;
        let image = |k: i32| {
            let s = Complex64::new(0.0, base + std::f64::consts::TAU * f64::from(k) / self.period_s);
            self.tick(s) * hold(s * self.period_s) * response(&self.plant, s)
        };
        (-self.images_count..=self.images_count).map(image).sum()
    }

    fn tick(&self, s: Complex64) -> Complex64 {
        (-s * self.period_s).exp()
    }
}

/// Zero-order hold: `(1 − e^−x)/x` with x the complex frequency times the period.
fn hold(x: Complex64) -> Complex64 {
    if x.norm() < 1e-9 { Complex64::new(1.0, 0.0) } else { (1.0 - (-x).exp()) / x }
}
