//! The sensors of a simulated inertial measurement unit: what any such unit on the elevation frame measures, whatever it speaks.

use crate::motion::Motion;
use crate::physics::inertial::{Mount, Sensor, SensorErrors};
use crate::physics::noise::SeedAddress;
use crate::unit::{ImuSettings, warmed_degc};

const GYROS: [&str; 3] = ["imu.gyro-x", "imu.gyro-y", "imu.gyro-z"];
const ACCELEROMETERS: [&str; 3] = ["imu.accelerometer-x", "imu.accelerometer-y", "imu.accelerometer-z"];

/// What can go wrong with a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageFault {
    /// A bit of the checksum is wrong.
    Checksum,
    /// The message is not sent; its number is used up.
    Dropped,
    /// The unit says that gyro X is not valid.
    InvalidStatus,
}

/// Rates and specific forces about X, Y, Z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Readings {
    pub(crate) rate_rad_per_s: [f64; 3],
    pub(crate) force_m_per_s2: [f64; 3],
}

/// Gyros and accelerometers on their mount, and the faults that are planted in them.
#[derive(Clone, Debug)]
pub(crate) struct InertialSensors {
    mount: Mount,
    gyros: [Sensor; 3],
    gyro_signs: [f64; 3],
    accelerometers: [Sensor; 3],
    temperature_degc: f64,
    warming: Warming,
    fault: Option<(MessageFault, u32)>,
    frozen: bool,
    offset_rad_per_s: f64,
    /// Readings of the last message.
    reported: Readings,
}

impl InertialSensors {
    pub(crate) fn new(imu: &ImuSettings, address: &SeedAddress, tick_s: f64) -> Self {
        let sensors = |names: [&str; 3], errors: [SensorErrors; 3]| {
            [0, 1, 2].map(|k| Sensor::new(&errors[k], address, names[k], tick_s))
        };
        Self {
            mount: Mount::new(imu),
            gyros: sensors(GYROS, gyro_errors(imu)),
            gyro_signs: imu.gyro_sign_factor.map(f64::signum),
            accelerometers: sensors(ACCELEROMETERS, accelerometer_errors(imu)),
            temperature_degc: imu.temperature_degc,
            warming: Warming::new(imu),
            fault: None,
            frozen: false,
            offset_rad_per_s: 0.0,
            reported: Readings::default(),
        }
    }

    /// The point begins so long after the beginning of the campaign, by the plan.
    pub(crate) fn begin_after(&mut self, planned_s: f64) {
        self.warming.planned_s = planned_s;
    }

    /// What the sensors measure of a motion, as the mean over the last `averaging_s`.
    pub(crate) fn measure(&mut self, tick: u64, now_s: f64, averaging_s: f64, mean: &Motion) -> Readings {
        let felt = self.mount.feel(mean);
        let warmer_degc = self.warming.degc(now_s);
        let mut readings = Readings::default();
        for k in 0..3 {
            let felt_rate = self.warming.of_rate(felt.rate_rad_per_s[k], warmer_degc);
            let rate = self.gyros[k].read(tick, averaging_s, felt_rate);
            readings.rate_rad_per_s[k] = self.gyro_signs[k] * rate;
            readings.force_m_per_s2[k] =
                self.accelerometers[k].read(tick, averaging_s, felt.specific_force_m_per_s2[k]);
        }
        readings
    }

    /// Readings that the unit reports for those that it has measured: with an offset of the gyros, or unchanged for a frozen unit.
    pub(crate) fn report(&mut self, measured: Readings) -> Readings {
        if !self.frozen {
            let rate_rad_per_s = measured.rate_rad_per_s.map(|rate| rate + self.offset_rad_per_s);
            self.reported = Readings { rate_rad_per_s, ..measured };
        }
        self.reported
    }

    /// Temperature of the unit at a time of the point, °C.
    pub(crate) fn temperature_degc(&self, now_s: f64) -> f64 {
        self.temperature_degc + self.warming.degc(now_s)
    }

    #[cfg(test)]
    pub(crate) fn reported(&self) -> &Readings {
        &self.reported
    }

    /// What is wrong with the next message.
    pub(crate) fn take_fault(&mut self) -> Option<MessageFault> {
        let (fault, count) = self.fault.take()?;
        self.fault = (count > 1).then(|| (fault, count - 1));
        Some(fault)
    }

    /// Spoils the next `count` messages.
    pub(crate) fn inject(&mut self, fault: MessageFault, count: u32) {
        self.fault = (count > 0).then_some((fault, count));
    }

    /// The unit goes on reporting the readings of its last message.
    pub(crate) fn freeze(&mut self) {
        self.frozen = true;
    }

    /// The gyros read this much more from now on.
    pub(crate) fn shift_gyros(&mut self, by_rad_per_s: f64) {
        self.offset_rad_per_s += by_rad_per_s;
    }
}

/// How the unit warms up over a campaign, and what that makes of its gyros.
#[derive(Clone, Copy, Debug)]
struct Warming {
    planned_s: f64,
    rise_degc: f64,
    time_constant_s: f64,
    scale_per_k_ratio: f64,
    bias_per_k_rad_per_s: f64,
}

impl Warming {
    fn new(imu: &ImuSettings) -> Self {
        Self {
            planned_s: 0.0,
            rise_degc: imu.warm_up_degc,
            time_constant_s: imu.warm_up_time_s,
            scale_per_k_ratio: imu.gyro_scale_per_k_ratio,
            bias_per_k_rad_per_s: imu.gyro_bias_per_k_rad_per_s,
        }
    }

    /// What the unit is warmer at a time of the point than when the campaign began.
    fn degc(&self, now_s: f64) -> f64 {
        if self.rise_degc == 0.0 {
            return 0.0;
        }
        warmed_degc(self.rise_degc, self.time_constant_s, self.planned_s + now_s)
    }

    /// What a gyro that is so much warmer makes of a rate.
    fn of_rate(&self, rate_rad_per_s: f64, warmer_degc: f64) -> f64 {
        if warmer_degc == 0.0 {
            return rate_rad_per_s;
        }
        (1.0 + self.scale_per_k_ratio * warmer_degc) * rate_rad_per_s
            + self.bias_per_k_rad_per_s * warmer_degc
    }
}

fn gyro_errors(imu: &ImuSettings) -> [SensorErrors; 3] {
    [0, 1, 2].map(|k| SensorErrors {
        random_walk_per_sqrt_hz: imu.gyro_random_walk_rad_per_sqrt_s * imu.gyro_noise_factor,
        bias_instability: imu.gyro_bias_instability_rad_per_s,
        // K·√t is what a random walk gathers in t.
        rate_walk_per_sqrt_s: imu.gyro_hourly_walk_rad_per_s / 3600.0_f64.sqrt(),
        bias: imu.gyro_bias_rad_per_s[k],
        scale_error_ratio: imu.gyro_scale_error_ratio[k],
        quantum: imu.gyro_quantum_rad_per_s,
        spike: imu.gyro_spike_rad_per_s,
        spike_rate_hz: imu.gyro_spike_rate_hz,
    })
}

fn accelerometer_errors(imu: &ImuSettings) -> [SensorErrors; 3] {
    [0, 1, 2].map(|k| SensorErrors {
        random_walk_per_sqrt_hz: imu.accelerometer_random_walk_m_per_s_per_sqrt_s,
        bias_instability: imu.accelerometer_bias_instability_m_per_s2,
        rate_walk_per_sqrt_s: 0.0,
        bias: imu.accelerometer_bias_m_per_s2[k],
        scale_error_ratio: imu.accelerometer_scale_error_ratio[k],
        quantum: 0.0,
        spike: 0.0,
        spike_rate_hz: 0.0,
    })
}
