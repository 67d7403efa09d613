//! Analog card of the bench beyond the mirror's own channels.
//!
//! | output | goes to | input | comes from |
//! | --- | --- | --- | --- |
//! | 0, 1 | mirror commands azimuth, elevation | 0, 1 | strain gauges azimuth, elevation |
//! | 2 | oscilloscope, synchronisation | 2, 3 | autocollimator azimuth, elevation |
//! | 3 | input 4 | 4 | output 3 |
//! | | | 5, 6 | autocollimators at the polygons of azimuth, elevation; +10 V: no face in sight |
//! | | | 9 | force gauge on the lever arm: the size of the pull |
//! | | | 7, 8 | current clamps on the supply and on the shunt of the DC link |
//!
//! The autocollimator looks at the mirror and stands on the structure that carries it: it sees the true tilt, sway of
//! the support included, clipped at its range.

use std::collections::VecDeque;
use std::time::Duration;

use crate::force_gauge::ForceGauge;
use crate::physics::noise::{Noise, SeedAddress};
use crate::reference::AngleReference;
use crate::unit::InstrumentsSettings;

/// Channels of the autocollimator: azimuth, elevation.
pub(crate) const REFERENCE_INPUTS: [usize; 2] = [2, 3];
/// Channels of the autocollimators that look at the polygons: azimuth, elevation.
pub(crate) const POLYGON_INPUTS: [usize; 2] = [5, 6];
/// Angle per volt of these: the range of ±400 µrad is ±8 V.
const POLYGON_SCALE_RAD_PER_V: f64 = 50e-6;
/// Synchronisation output.
pub(crate) const SYNC_OUTPUT: usize = 2;
/// Looped back.
pub(crate) const ECHO_OUTPUT: usize = 3;
pub(crate) const ECHO_INPUT: usize = 4;
/// Current clamps on the DC link: supply, shunt.
pub(crate) const CLAMP_INPUTS: [usize; 2] = [7, 8];

/// Force gauge.
pub(crate) const FORCE_INPUT: usize = 9;
/// Scale of its analog output: its range of 2000 N is 10 V.
const FORCE_N_PER_V: f64 = 200.0;

/// Scale of the clamps: 10 V are 100 A, above the supply's 60 A peak.
const CLAMP_A_PER_V: f64 = 10.0;
/// Noise of a clamp of that range (ours: 1e-4 of it).
const CLAMP_NOISE_A: f64 = 0.01;

/// Range of the card.
const LIMIT_V: f64 = 10.0;
/// Changes of the looped output that are remembered.
const REMEMBERED: usize = 64;

/// Loop-back and autocollimator.
#[derive(Clone, Debug)]
pub(crate) struct AnalogChannels {
    scale_rad_per_v: f64,
    gain: f64,
    range_rad: f64,
    noises: [Noise; 2],
    polygons: [AngleReference; 2],
    clamp_noises: [Noise; 2],
    force_gauge: ForceGauge,
    tick_rate_hz: f64,
    echo_delay: Duration,
    /// Voltages of the looped output with the times from which on they reach the input.
    echoes: VecDeque<(Duration, f64)>,
    echo_v: f64,
}

impl AnalogChannels {
    /// A card read at ticks of this rate.
    pub(crate) fn new(settings: &InstrumentsSettings, address: &SeedAddress, tick_rate_hz: f64) -> Self {
        let deviation_rad = settings.mirror_reference_noise_rad;
        Self {
            scale_rad_per_v: settings.mirror_reference_scale_rad_per_v,
            gain: 1.0 + settings.mirror_reference_scale_error_ratio,
            range_rad: settings.mirror_reference_range_rad,
            noises: ["az", "el"].map(|axis| Noise::new(address, &format!("reference.{axis}"), deviation_rad)),
            polygons: ["az", "el"].map(|axis| AngleReference::new(settings, address, axis)),
            clamp_noises: ["supply", "shunt"]
                .map(|lead| Noise::new(address, &format!("clamp.{lead}"), CLAMP_NOISE_A)),
            force_gauge: ForceGauge::new(settings, address),
            tick_rate_hz,
            echo_delay: Duration::from_secs_f64(settings.echo_delay_s),
            echoes: VecDeque::with_capacity(REMEMBERED),
            echo_v: 0.0,
        }
    }

    /// Voltage of an axis of the autocollimator for a true tilt.
    pub(crate) fn reference_v(&mut self, axis: usize, now: Duration, tilt_rad: f64) -> f64 {
        let tick = self.tick(now);
        let seen_rad = (tilt_rad * self.gain).clamp(-self.range_rad, self.range_rad);
        let volts = (seen_rad + self.noises[axis].at(tick)) / self.scale_rad_per_v;
        volts.clamp(-LIMIT_V, LIMIT_V)
    }

    /// Voltage of the autocollimator at the polygon of an axis for its true angle: how far the nearest face is off, or the
    /// upper end of the card's range where none is in sight.
    pub(crate) fn polygon_v(&mut self, axis: usize, now: Duration, angle_rad: f64) -> f64 {
        let deviation_rad = self.polygon_rad(axis, now, angle_rad);
        deviation_rad.map_or(LIMIT_V, |deviation_rad| {
            (deviation_rad / POLYGON_SCALE_RAD_PER_V).clamp(-LIMIT_V, LIMIT_V)
        })
    }

    /// What that autocollimator shows: how far the nearest face is off; `None` where none is in sight.
    pub(crate) fn polygon_rad(&mut self, axis: usize, now: Duration, angle_rad: f64) -> Option<f64> {
        let tick = self.tick(now);
        self.polygons[axis].read(tick, angle_rad).map(|reading| reading.deviation_rad)
    }

    fn tick(&self, now: Duration) -> u64 {
        (now.as_secs_f64() * self.tick_rate_hz).round() as u64
    }

    /// Voltage of a clamp (0 supply, 1 shunt) around a lead with this current.
    pub(crate) fn clamp_v(&mut self, clamp: usize, now: Duration, current_a: f64) -> f64 {
        let tick = self.tick(now);
        let volts = (current_a + self.clamp_noises[clamp].at(tick)) / CLAMP_A_PER_V;
        volts.clamp(-LIMIT_V, LIMIT_V)
    }

    /// Voltage of the force gauge while somebody pulls with this torque, either way.
    pub(crate) fn force_v(&mut self, now: Duration, torque_nm: f64) -> f64 {
        (self.force_n(now, torque_nm) / FORCE_N_PER_V).clamp(-LIMIT_V, LIMIT_V)
    }

    /// Force that the gauge shows while somebody pulls with this torque, either way.
    pub(crate) fn force_n(&mut self, now: Duration, torque_nm: f64) -> f64 {
        let tick = self.tick(now);
        self.force_gauge.read_n(tick, torque_nm.abs())
    }

    /// The looped output has this voltage from now on.
    pub(crate) fn write_echo(&mut self, now: Duration, volts: f64) {
        if self.echoes.len() == REMEMBERED {
            self.settle(now);
            self.echoes.truncate(REMEMBERED - 1);
        }
        self.echoes.push_back((now + self.echo_delay, volts.clamp(-LIMIT_V, LIMIT_V)));
    }

    /// Voltage of the looped input.
    pub(crate) fn echo_v(&mut self, now: Duration) -> f64 {
        self.settle(now);
        self.echo_v
    }

    fn settle(&mut self, now: Duration) {
        while let Some(&(from, volts)) = self.echoes.front()
            && from <= now
        {
            self.echo_v = volts;
            self.echoes.pop_front();
        }
    }
}
