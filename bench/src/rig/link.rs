//! A DC link that takes no more energy: what brakes then must not feed it, or the drives shut down and nothing brakes.

use super::ArmedRig;

/// Share of the highest voltage below it over which braking torque sets in again: 20 V of 680 V. Both axes at full
/// power raise a link of 0.5 mF by 12 V in the millisecond that the answer takes.
const BAND_RATIO: f64 = 0.03;

impl ArmedRig {
    /// From now on the DC link is known to be full. Gives whether that is new.
    pub fn spare_link(&mut self) -> bool {
        !std::mem::replace(&mut self.link_is_full, true)
    }

    /// Whether the DC link was found full.
    pub fn link_is_full(&self) -> bool {
        self.link_is_full
    }

    /// Whether the DC link of an axis is above its band now.
    pub(crate) fn is_over_voltage(&self, axis: usize) -> bool {
        self.actuals[axis].bus_v > self.axes[axis].guard.safety.bus_voltage_v[1]
    }

    /// Share of its braking torque that an axis may give: all of it unless the DC link was found full, none of it at the
    /// highest voltage, and in between a share that falls with the voltage.
    pub fn braking_share(&self, axis: usize) -> f64 {
        let highest_v = self.axes[axis].guard.safety.bus_voltage_v[1];
        if self.link_is_full { share(self.actuals[axis].bus_v, highest_v) } else { 1.0 }
    }
}

/// A voltage that is no number allows nothing.
fn share(bus_v: f64, highest_v: f64) -> f64 {
    let share = (highest_v - bus_v) / (BAND_RATIO * highest_v);
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::share;

    #[test]
    fn a_full_link_gets_nothing_and_one_that_has_come_down_by_20_v_everything() {
        assert_eq!([share(690.0, 680.0), share(680.0, 680.0), share(f64::NAN, 680.0)], [0.0; 3]);
        assert_eq!(share(659.0, 680.0), 1.0);
        assert!((share(669.8, 680.0) - 0.5).abs() < 1e-9);
    }
}
