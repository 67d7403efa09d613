//! DC link of the drives: a rectified supply behind its resistance, a capacitor, a switched shunt.
//!
//! `C·dv/dt = i_s − P/v − v/R_shunt`, with `i_s = (E − v)/R_s`, never negative (the rectifier lets nothing back) and
//! never above the supply's limit. Implicit midpoint rule: in the mean voltage of a step it is a quadratic equation,
//! solved in closed form, and its energy balance is exact: what the supply puts in is what the drives draw, plus what
//! the shunt burns, plus what the capacitor gains.

use crate::unit::SupplySettings;

/// State of the DC link.
#[derive(Clone, Debug)]
pub struct Supply {
    open_v: f64,
    source_siemens: f64,
    shunt_siemens: f64,
    shunt_on_v: f64,
    shunt_off_v: f64,
    /// 2C/h.
    double_capacitance_per_step: f64,
    continuous_a: f64,
    peak_a: f64,
    /// Approach of the mean square of the supply current per step.
    warming_ratio: f64,
    bus_v: f64,
    shunt_closed: bool,
    /// The peak is used up; the supply has fallen back to its continuous current.
    fallen_back: bool,
    mean_square_a2: f64,
    supply_a: f64,
    shunt_w: f64,
    drawn_w: f64,
}

/// The peak is there again once the mean square current is below this part of the continuous one's square.
const RECOVERY_RATIO: f64 = 0.9;

impl Supply {
    /// A charged DC link without load, to be advanced every `step_s`.
    pub fn new(s: &SupplySettings, step_s: f64) -> Self {
        Self {
            open_v: s.open_voltage_v,
            source_siemens: 1.0 / s.source_resistance_ohm,
            shunt_siemens: 1.0 / s.shunt_resistance_ohm,
            shunt_on_v: s.shunt_on_v,
            shunt_off_v: s.shunt_off_v.min(s.shunt_on_v),
            double_capacitance_per_step: 2.0 * s.capacitance_f / step_s,
            continuous_a: s.continuous_current_a.min(s.peak_current_a),
            peak_a: s.peak_current_a,
            warming_ratio: -(-step_s / warming_time_s(s)).exp_m1(),
            bus_v: s.open_voltage_v,
            shunt_closed: false,
            fallen_back: false,
            mean_square_a2: 0.0,
            supply_a: 0.0,
            shunt_w: 0.0,
            drawn_w: 0.0,
        }
    }

    /// One step with this power drawn by all drives together (negative: fed back); returns the bus voltage.
    #[inline]
    pub fn step(&mut self, power_w: f64) -> f64 {
        let shunt_siemens = if self.shunt_closed { self.shunt_siemens } else { 0.0 };
        let idle = Balance {
            slope: self.double_capacitance_per_step + shunt_siemens,
            push: self.double_capacitance_per_step * self.bus_v,
        };
        let (mean_v, supply_a) = self.mean(idle, power_w);
        self.drawn_w = power_w.min(Balance { push: idle.push + supply_a, ..idle }.most_w());
        self.bus_v = (2.0 * mean_v - self.bus_v).max(0.0);
        self.supply_a = supply_a;
        self.shunt_w = shunt_siemens * mean_v * mean_v;
        self.shunt_closed =
            self.bus_v >= self.shunt_on_v || self.shunt_closed && self.bus_v > self.shunt_off_v;
        self.mean_square_a2 += (supply_a * supply_a - self.mean_square_a2) * self.warming_ratio;
        let allowed_a2 = self.continuous_a * self.continuous_a;
        let back_at_a2 = if self.fallen_back { RECOVERY_RATIO * allowed_a2 } else { allowed_a2 };
        self.fallen_back = self.mean_square_a2 >= back_at_a2;
        self.bus_v
    }

    /// Mean voltage over the step and the supply's current: blocked, conducting, or at its limit.
    #[inline]
    fn mean(&self, idle: Balance, power_w: f64) -> (f64, f64) {
        let conducting = Balance {
            slope: idle.slope + self.source_siemens,
            push: idle.push + self.source_siemens * self.open_v,
        };
        let mean_v = conducting.mean_v(power_w);
        let supply_a = (self.open_v - mean_v) * self.source_siemens;
        if supply_a <= 0.0 {
            return (idle.mean_v(power_w), 0.0);
        }
        let limit_a = if self.fallen_back { self.continuous_a } else { self.peak_a };
        if supply_a > limit_a {
            return (Balance { push: idle.push + limit_a, ..idle }.mean_v(power_w), limit_a);
        }
        (mean_v, supply_a)
    }

    /// The mains are gone: what is in the capacitor is all there is.
    pub fn lose_mains(&mut self) {
        self.open_v = 0.0;
    }

    /// Voltage of the DC link, V.
    pub fn bus_v(&self) -> f64 {
        self.bus_v
    }

    /// Current of the supply over the last step, A.
    pub fn supply_a(&self) -> f64 {
        self.supply_a
    }

    /// Power in the shunt over the last step, W.
    pub fn shunt_w(&self) -> f64 {
        self.shunt_w
    }

    /// Power that the drives got over the last step, W: less than asked for where the link breaks down.
    pub fn drawn_w(&self) -> f64 {
        self.drawn_w
    }
}

/// Power that a drive draws from the link: shaft power plus the losses of winding and drive, W; negative while it feeds
/// more back than it burns. `loss_ohm` is those losses over the square of the current.
#[inline]
pub fn drive_w(loss_ohm: f64, torque_nm: f64, velocity_rad_per_s: f64, current_a: f64) -> f64 {
    torque_nm * velocity_rad_per_s + loss_ohm * current_a * current_a
}

/// Time constant of the supply's mean square current, so that a rested supply gives its peak for the peak time:
/// `I_p²·(1 − e^(−t/τ)) = I_c²`.
fn warming_time_s(s: &SupplySettings) -> f64 {
    let share = (s.continuous_current_a / s.peak_current_a).powi(2);
    if share > 0.0 && share < 1.0 { -s.peak_time_s / (-share).ln_1p() } else { s.peak_time_s }
}

/// Currents into the link over a step, `push − slope·v̄ − P/v̄ = 0`.
#[derive(Clone, Copy)]
struct Balance {
    slope: f64,
    push: f64,
}

impl Balance {
    /// The upper root; where more is asked for than the link can give, the voltage at which it gives most.
    #[inline]
    fn mean_v(self, power_w: f64) -> f64 {
        let root = (self.push * self.push - 4.0 * self.slope * power_w).max(0.0).sqrt();
        (self.push + root) / (2.0 * self.slope)
    }

    fn most_w(self) -> f64 {
        self.push * self.push / (4.0 * self.slope)
    }
}

#[cfg(test)]
mod tests;
