//! Heat sink of a drive: first order, heated by losses that grow with the square of the current.

use crate::unit::AxisSettings;

/// Temperature of a heat sink, updated at a fixed period.
#[derive(Clone, Debug)]
pub struct HeatSink {
    temperature_degc: f64,
    ambient_degc: f64,
    rise_degc_per_a2: f64,
    approach_ratio: f64,
}

impl HeatSink {
    /// A heat sink at a temperature, to be advanced every `period_s`.
    pub fn new(axis: &AxisSettings, temperature_degc: f64, period_s: f64) -> Self {
        let rise_degc_per_w = axis.heat_sink_rise_degc / axis.heat_sink_power_w;
        let loss_w_per_a2 = axis.loss_power_w / (axis.loss_current_a * axis.loss_current_a);
        Self {
            temperature_degc,
            ambient_degc: axis.ambient_degc,
            rise_degc_per_a2: rise_degc_per_w * loss_w_per_a2,
            approach_ratio: -(-period_s / axis.heat_sink_time_s).exp_m1(),
        }
    }

    /// One period with this mean square of the current.
    pub fn advance(&mut self, mean_square_a2: f64) {
        let end_degc = self.ambient_degc + self.rise_degc_per_a2 * mean_square_a2;
        self.temperature_degc += (end_degc - self.temperature_degc) * self.approach_ratio;
    }

    /// From now on it starts from this temperature.
    pub fn set_temperature_degc(&mut self, degc: f64) {
        self.temperature_degc = degc;
    }

    /// Temperature now.
    pub fn temperature_degc(&self) -> f64 {
        self.temperature_degc
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::UnitSettings;

    #[test]
    fn continuous_current_warms_azimuth_by_2_68_degrees() {
        let axis = UnitSettings::default().az;
        let mut sink = HeatSink::new(&axis, 40.0, 0.01);
        let steps = (axis.heat_sink_time_s / 0.01).round() as u32;
        (0..steps).for_each(|_| sink.advance(14.2 * 14.2));
        let after_one_time_constant = 40.0 + 40.0 * 0.067 * (1.0 - (-1.0_f64).exp());
        assert!((sink.temperature_degc() - after_one_time_constant).abs() < 1e-6);
    }
}
