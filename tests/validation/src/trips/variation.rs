//! What differs in a trial from the shipped rig and units: what nobody tuned anything for.

use std::time::Duration;

use bench::clock::{Clock, Lateness};
use bench::model::axis::AxisGuard;
use bench::model::rig::Rig;
use sim_devices::unit::UnitSettings;

use super::draw::Random;

/// Voltage that a shunt never switches on at.
const NEVER_V: f64 = 1e6;
/// One tick in so many comes late, where any does.
const LATE_ONE_IN: u32 = 400;

/// Each item is drawn for half of the seeds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variation {
    /// Current limit of both drives, of the shipped one.
    pub torque_share: Option<f64>,
    /// Following error that trips.
    pub max_following_error_rad: Option<f64>,
    /// Angle that each encoder calls zero.
    pub zero_rad: [f64; 2],
    /// The shunt is open, and this is the capacitance of the DC link.
    pub open_shunt_f: Option<f64>,
    /// Most periods by which a tick comes late.
    pub late_periods: Option<u32>,
}

impl Variation {
    pub(super) fn draw(random: &mut Random, rig: &Rig) -> Self {
        let mut half = |low: f64, high: f64| {
            let value = random.between(low, high);
            (random.one_of(2) == 0).then_some(value)
        };
        Self {
            torque_share: half(0.5, 1.0),
            max_following_error_rad: half(3.0, 10.0).map(f64::to_radians),
            zero_rad: [0, 1].map(|axis| {
                let zero_rad = rig.axes[axis].limits.zero_tolerance_rad;
                half(-zero_rad, zero_rad).unwrap_or(0.0)
            }),
            open_shunt_f: half(0.5e-3, 4.7e-3),
            late_periods: half(1.0, f64::from(rig.max_missed_periods) + 1.0).map(|most| most as u32),
        }
    }

    /// The rig with its limits.
    pub(super) fn rig(&self, shipped: &Rig) -> Rig {
        let mut rig = shipped.clone();
        for axis in &mut rig.axes {
            let guard = &mut axis.guard;
            guard.safety.max_following_error_rad =
                self.max_following_error_rad.unwrap_or(guard.safety.max_following_error_rad);
        }
        rig
    }

    /// The unit as it is built.
    pub(super) fn unit(&self, shipped: &UnitSettings) -> UnitSettings {
        let mut unit = shipped.clone();
        let share = self.torque_share.unwrap_or(1.0);
        unit.az.current_limit_a *= share;
        unit.el.current_limit_a *= share;
        [unit.az.encoder_zero_rad, unit.el.encoder_zero_rad] = self.zero_rad;
        if let Some(capacitance_f) = self.open_shunt_f {
            unit.supply.capacitance_f = capacitance_f;
            unit.supply.shunt_on_v = NEVER_V;
        }
        unit
    }

    /// What a stop of an axis can rely on.
    pub(super) fn guard(&self, shipped: &AxisGuard) -> AxisGuard {
        let mut guard = shipped.clone();
        guard.rely_on(self.torque_share.unwrap_or(1.0) * shipped.max_torque_nm);
        guard
    }

    /// The clock of a trial.
    pub(super) fn clock(&self, seed: u64, loop_rate_hz: f64) -> Clock {
        self.late_periods.map_or(Clock::Virtual, |most| {
            Clock::Late(Lateness {
                seed,
                period: Duration::from_secs_f64(1.0 / loop_rate_hz),
                from: Duration::ZERO,
                until: Duration::MAX,
                one_in: LATE_ONE_IN,
                periods: [1, most],
            })
        })
    }
}
