//! What connects an encoder with its axis: rigid, or with play, or slipping.

use crate::unit::AxisSettings;

/// Turns the angle of the axis into that of the encoder's shaft.
///
/// With play b the encoder stands after a reversal until the axis has turned by b (a play operator). A coupling that slips
/// loses a share of the travel towards larger angles, for good.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    half_play_rad: f64,
    slip_ratio: f64,
    /// Where axis and encoder were last, once anybody has looked; at first they agree.
    last: Option<Coupled>,
}

#[derive(Clone, Copy, Debug)]
struct Coupled {
    axis_rad: f64,
    encoder_rad: f64,
    /// What was lost so far.
    lost_rad: f64,
}

impl Coupling {
    /// The coupling of an axis.
    pub(crate) fn new(axis: &AxisSettings) -> Self {
        Self {
            half_play_rad: 0.5 * axis.encoder_backlash_rad,
            slip_ratio: axis.encoder_slip_ratio,
            last: None,
        }
    }

    /// The angle of the encoder's shaft when the axis has come to this one.
    #[inline]
    pub(crate) fn follow(&mut self, axis_rad: f64) -> f64 {
        if self.half_play_rad == 0.0 && self.slip_ratio == 0.0 {
            return axis_rad;
        }
        let last = self.last.unwrap_or(Coupled { axis_rad, encoder_rad: axis_rad, lost_rad: 0.0 });
        let lost_rad = last.lost_rad + self.slip_ratio * (axis_rad - last.axis_rad).max(0.0);
        let driven_rad = axis_rad - lost_rad;
        let encoder_rad =
            last.encoder_rad.clamp(driven_rad - self.half_play_rad, driven_rad + self.half_play_rad);
        self.last = Some(Coupled { axis_rad, encoder_rad, lost_rad });
        encoder_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::UnitSettings;

    fn coupling(play_rad: f64, slip_ratio: f64) -> Coupling {
        Coupling::new(&AxisSettings {
            encoder_backlash_rad: play_rad,
            encoder_slip_ratio: slip_ratio,
            ..UnitSettings::default().az
        })
    }

    #[test]
    fn a_rigid_coupling_changes_no_bit() {
        let mut rigid = coupling(0.0, 0.0);
        assert!([0.1, -0.3, 1e-17].iter().all(|&angle| rigid.follow(angle).to_bits() == angle.to_bits()));
    }

    #[test]
    fn after_a_reversal_the_encoder_stands_until_the_play_is_used_up() {
        let mut loose = coupling(2e-4, 0.0);
        let seen: Vec<f64> = [0.0, 0.01, 0.0099, 0.0097, 0.01].map(|angle| loose.follow(angle)).into();
        for (found, expected) in seen.iter().zip([0.0, 0.0099, 0.0099, 0.0098, 0.0099]) {
            assert!((found - expected).abs() < 1e-12, "{seen:?}");
        }
    }

    #[test]
    fn a_slipping_coupling_loses_its_share_of_every_forward_stroke() {
        let mut slipping = coupling(0.0, 1e-3);
        let seen: Vec<f64> = [0.0, 1.0, 0.0, 1.0].map(|angle| slipping.follow(angle)).into();
        for (found, expected) in seen.iter().zip([0.0, 0.999, -0.001, 0.998]) {
            assert!((found - expected).abs() < 1e-12, "{seen:?}");
        }
    }
}
