//! Torque to the rate of the frame (gyro) and of the shaft (encoder), from one record.

use crate::analysis::frf::{Frf, Line};
use crate::analysis::periodic::times_jw;
use crate::kinds::excited::{Channel, Measured};
use crate::measurement::Exclusion;

/// Below this signal to noise of its mean a line says nothing.
const LEAST_SNR_DB: f64 = 20.0;
/// Fewer lines are no response.
const LEAST_LINES: usize = 20;

/// Names of the sensors, in the order of the responses.
pub(super) const SENSORS: [&str; 2] = ["gyro", "encoder"];

/// Both responses, rad/s over N·m.
#[derive(Clone, Debug)]
pub(super) struct Responses {
    pub(super) frfs: [Frf; 2],
    /// Lines that do not count.
    pub(super) hollow: [Frf; 2],
    pub(super) excluded: Vec<Exclusion>,
}

/// The responses of a record, or why modes cannot be read from it.
pub(super) fn read(measured: &Measured) -> Result<Responses, String> {
    if !measured.slides {
        return Err(format!(
            "presliding: the axis did not slide all the time (mean rate {:.3} rad/s), the contact adds a spring to the structure",
            measured.mean_rate_rad_per_s
        ));
    }
    let gyro = measured.response(Channel::Torque, Channel::Rate)?;
    let angle = measured.response(Channel::Torque, Channel::Angle)?;
    judged([gyro, times_jw(&angle, 1).map_err(|e| e.to_string())?])
}

/// Keeps the lines that say something.
pub(super) fn judged(both: [Frf; 2]) -> Result<Responses, String> {
    let (mut excluded, mut frfs, mut hollow) = (Vec::new(), [const { Vec::new() }; 2], [const { Vec::new() }; 2]);
    for (k, lines) in both.into_iter().enumerate() {
        let (kept, noisy): (Frf, Frf) = lines.into_iter().partition(|l| snr_db(l) >= LEAST_SNR_DB);
        if !noisy.is_empty() {
            let reason = format!("{}: signal to noise below {LEAST_SNR_DB} dB", SENSORS[k]);
            excluded.push(Exclusion { count: noisy.len(), of: "lines".to_owned(), reason });
        }
        if kept.len() < LEAST_LINES {
            return Err(format!(
                "the {} has {} lines with a signal to noise above {LEAST_SNR_DB} dB: expected at least {LEAST_LINES}; raise `level` or `duration`",
                SENSORS[k],
                kept.len()
            ));
        }
        (frfs[k], hollow[k]) = (kept, noisy);
    }
    Ok(Responses { frfs, hollow, excluded })
}

/// Signal to noise of a line's mean.
fn snr_db(line: &Line) -> f64 {
    -20.0 * (2.0_f64.sqrt() * line.relative_sd()).log10()
}
