//! Motor torque less inertia: block averages of a record and F̂ = T_m − J·α.

use super::derivative::Differentiator;

/// Blocks a second for each hertz of flat bandwidth: leaves the differentiator's window finely divided.
const BLOCKS_PER_FLAT_CYCLE: f64 = 40.0;
/// Cycles of the flat bandwidth that a record lasts: long records move slowly and need less of it.
const FLAT_CYCLES: f64 = 20.0;
/// Least and largest flat bandwidth of the acceleration, Hz. The presliding mode of a direct-drive axis,
/// √(σ0/J)/2π, lies at 1 to 2 Hz; above 5 Hz the encoder's quantum, differentiated twice, outweighs the rest.
const FLAT_HZ: [f64; 2] = [1.0, 5.0];

/// A record in equal blocks: means of time, position and motor torque, and what follows from them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effort {
    /// Mean time of each block, s.
    pub time_s: Vec<f64>,
    /// Mean position of each block, rad.
    pub position_rad: Vec<f64>,
    /// Velocity, rad/s.
    pub velocity_rad_per_s: Vec<f64>,
    /// Torque that accelerates the axis, J·α, N·m.
    pub inertial_nm: Vec<f64>,
    /// F̂ = T_m − J·α, N·m.
    pub effort_nm: Vec<f64>,
}

/// Means of consecutive blocks of `block` samples; a remainder at the end is left out.
pub fn block_means(values: &[f64], block: usize) -> Vec<f64> {
    values.chunks_exact(block.max(1)).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect()
}

impl Effort {
    /// The effort of a uniformly sampled record: `time_s`, `position_rad`, motor torque `torque_nm`, equally long.
    ///
    /// Blocks are averaged first, then differentiated without phase by [`Differentiator`], flat to 20 cycles of the
    /// record's length but between 1 and 5 Hz. `None` if the record is ragged, not advancing in time, or shorter
    /// than the differentiator's window.
    pub fn new(time_s: &[f64], position_rad: &[f64], torque_nm: &[f64], inertia_kg_m2: f64) -> Option<Self> {
        let count = time_s.len();
        if count < 2 || position_rad.len() != count || torque_nm.len() != count {
            return None;
        }
        let duration_s = time_s[count - 1] - time_s[0];
        let sample_s = duration_s / (count - 1) as f64;
        if !(sample_s > 0.0 && sample_s.is_finite()) {
            return None;
        }
        let flat_hz = (FLAT_CYCLES / duration_s).clamp(FLAT_HZ[0], FLAT_HZ[1]);
        let block = ((1.0 / (BLOCKS_PER_FLAT_CYCLE * flat_hz * sample_s)).round() as usize).max(1);
        let differentiator = Differentiator::new(1.0 / (sample_s * block as f64), flat_hz)?;
        let position = block_means(position_rad, block);
        let velocity = differentiator.velocity(&position)?;
        let acceleration = differentiator.acceleration(&position)?;
        let inertial: Vec<f64> = acceleration.iter().map(|a| inertia_kg_m2 * a).collect();
        let torque = block_means(torque_nm, block);
        Some(Self {
            time_s: block_means(time_s, block),
            position_rad: position,
            velocity_rad_per_s: velocity,
            effort_nm: torque.iter().zip(&inertial).map(|(t, i)| t - i).collect(),
            inertial_nm: inertial,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_has_its_exact_velocity_and_effort_up_to_the_ends() {
        let t: Vec<f64> = (0..3000).map(|k| f64::from(k) * 0.25e-3).collect();
        let x: Vec<f64> = t.iter().map(|t| 0.3 * t + 0.5 * 0.08 * t * t).collect();
        let effort = Effort::new(&t, &x, &vec![100.0; t.len()], 1000.0).expect("long enough");
        for k in 0..effort.time_s.len() {
            assert!((effort.effort_nm[k] - 20.0).abs() < 1e-4, "{}", effort.effort_nm[k]);
            let v = 0.3 + 0.08 * effort.time_s[k];
            assert!((effort.velocity_rad_per_s[k] - v).abs() < 1e-9);
        }
    }

    #[test]
    fn a_record_that_is_too_short_or_ragged_gives_nothing() {
        let t: Vec<f64> = (0..20).map(|k| f64::from(k) * 1e-3).collect();
        assert_eq!(Effort::new(&t, &t, &t, 1.0), None);
        assert_eq!(Effort::new(&t, &t[1..], &t, 1.0), None);
        assert_eq!(Effort::new(&[0.0; 500], &[0.0; 500], &[0.0; 500], 1.0), None);
    }
}
