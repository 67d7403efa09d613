//! Motor torque less inertia: block averages of a record and F̂ = T_m − J·α.

use super::derivative::Differentiator;
use super::even_rows::{BRIDGED_PERIODS, EvenRows, Gap};

/// Blocks a second for each hertz of flat bandwidth: leaves the differentiator's window finely divided.
const BLOCKS_PER_FLAT_CYCLE: f64 = 40.0;
/// Cycles of the flat bandwidth that a record lasts: long records move slowly and need less of it.
const FLAT_CYCLES: f64 = 20.0;
/// Least and largest flat bandwidth of the acceleration, Hz. The presliding mode of a direct-drive axis,
/// √(σ0/J)/2π, lies at 1 to 2 Hz; above 5 Hz the encoder's quantum, differentiated twice, outweighs the rest.
const FLAT_HZ: [f64; 2] = [1.0, 5.0];

/// Why a record has no effort.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoEffort {
    /// Ragged, not advancing in time, or shorter than the differentiator's window.
    #[error("too few rows, or time does not advance")]
    TooFewRows,
    /// A gap that is too long to be bridged.
    #[error("rows are missing for {} ms from {at_s:.3} s on, at most {} ms can be bridged", (1e3 * .lasted_s).round(), (1e3 * .most_s).round())]
    Gap {
        /// Time of the last row before the gap.
        at_s: f64,
        /// Time from there to the next row.
        lasted_s: f64,
        /// Longest such time that is bridged.
        most_s: f64,
    },
}

/// A record in equal blocks: means of time, position and motor torque, and what follows from them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effort {
    /// Mean time of each block, s.
    pub time_s: Vec<f64>,
    /// Mean position of each block, rad.
    pub position_rad: Vec<f64>,
    /// Velocity, rad/s.
    pub velocity_rad_per_s: Vec<f64>,
    /// F̂ = T_m − J·α, N·m.
    pub effort_nm: Vec<f64>,
}

/// Means of consecutive blocks of `block` samples; a remainder at the end is left out.
pub fn block_means(values: &[f64], block: usize) -> Vec<f64> {
    values.chunks_exact(block.max(1)).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect()
}

impl Effort {
    /// The effort of a record: `time_s`, `position_rad`, motor torque `torque_nm`, equally long.
    ///
    /// Where rows are missing, the record is interpolated first; see [`EvenRows`]. Blocks are averaged, then
    /// differentiated without phase by [`Differentiator`], flat to 20 cycles of the record's length but between 1
    /// and 5 Hz.
    ///
    /// # Errors
    /// See [`NoEffort`].
    pub fn new(
        time_s: &[f64],
        position_rad: &[f64],
        torque_nm: &[f64],
        inertia_kg_m2: f64,
    ) -> Result<Self, NoEffort> {
        let ragged = position_rad.len() != time_s.len() || torque_nm.len() != time_s.len();
        let rows = EvenRows::over(time_s).filter(|_| !ragged).ok_or(NoEffort::TooFewRows)?;
        let duration_s = time_s[time_s.len() - 1] - time_s[0];
        let flat_hz = (FLAT_CYCLES / duration_s).clamp(FLAT_HZ[0], FLAT_HZ[1]);
        if let Some(Gap { at_s, lasted_s }) = rows.unbridged(flat_hz) {
            return Err(NoEffort::Gap { at_s, lasted_s, most_s: BRIDGED_PERIODS / flat_hz });
        }
        let block = ((1.0 / (BLOCKS_PER_FLAT_CYCLE * flat_hz * rows.sample_s())).round() as usize).max(1);
        let derivatives = |position: &[f64]| {
            let differentiator = Differentiator::new(1.0 / (rows.sample_s() * block as f64), flat_hz)?;
            Some([differentiator.velocity(position)?, differentiator.acceleration(position)?])
        };
        let position = block_means(&rows.column(position_rad), block);
        let [velocity, acceleration] = derivatives(&position).ok_or(NoEffort::TooFewRows)?;
        let torque = block_means(&rows.column(torque_nm), block);
        Ok(Self {
            time_s: block_means(rows.time_s(), block),
            position_rad: position,
            velocity_rad_per_s: velocity,
            effort_nm: torque.iter().zip(&acceleration).map(|(t, a)| t - inertia_kg_m2 * a).collect(),
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
        assert_eq!(Effort::new(&t, &t, &t, 1.0), Err(NoEffort::TooFewRows));
        assert_eq!(Effort::new(&t, &t[1..], &t, 1.0), Err(NoEffort::TooFewRows));
        assert_eq!(Effort::new(&[0.0; 500], &[0.0; 500], &[0.0; 500], 1.0), Err(NoEffort::TooFewRows));
    }

    /// An axis that breaks away in 2 s: 5 mrad/s and 0.03 rad/s² where rows are missing.
    fn breaking_away(t: f64) -> f64 {
        1e-3 * (0.3 + t * t * t)
    }

    #[test]
    fn rows_that_a_short_stall_has_cut_out_move_the_effort_by_less_than_a_tenth_of_a_newton_metre() {
        let whole: Vec<f64> = (0..500).map(|k| f64::from(k) * 4e-3).collect();
        // Two rows are missing, and those behind lie 1 ms beside the raster of those before.
        let cut: Vec<f64> =
            whole.iter().enumerate().filter(|(k, _)| !(320..322).contains(k)).map(|(_, t)| *t).collect();
        let cut: Vec<f64> = cut.iter().map(|t| if *t > 1.28 { t - 1e-3 } else { *t }).collect();
        let effort = |time: &[f64]| {
            let x: Vec<f64> = time.iter().map(|t| breaking_away(*t)).collect();
            Effort::new(time, &x, &vec![100.0; time.len()], 1200.0).expect("a short gap")
        };
        let whole = effort(&whole);
        let cut = effort(&cut);
        for (k, &time_s) in cut.time_s.iter().enumerate() {
            assert!((time_s - whole.time_s[k]).abs() < 1e-9);
            assert!((cut.effort_nm[k] - whole.effort_nm[k]).abs() < 0.1, "{time_s}: {}", cut.effort_nm[k]);
        }
    }

    #[test]
    fn a_gap_that_is_too_long_to_be_bridged_is_named() {
        let t: Vec<f64> = (0..500).filter(|k| !(320..328).contains(k)).map(|k| f64::from(k) * 4e-3).collect();
        let refused = Effort::new(&t, &t, &t, 1.0).expect_err("36 ms without rows");
        let expected = "rows are missing for 36 ms from 1.276 s on, at most 20 ms can be bridged";
        assert_eq!(refused.to_string(), expected);
    }
}
