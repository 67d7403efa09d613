//! What a delay that jitters leaves in frequency responses of the current.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use procedures::measurement::Measurement;
use procedures::requirement::Requirements;
use reports::record::ProcedureFindings;

use super::compared::judge_again;

/// Measurand of steps of the command: standard deviation of their delay.
const JITTER: &str = "transport-jitter";
/// Measurand of responses from command to current: where a lag of first order has lost 3 dB.
const BANDWIDTH: &str = "current-bandwidth";
/// A smaller share of the bandwidth is not worth a flag.
const LEAST_SHARE: f64 = 0.01;

/// Adds to bandwidths of the current what jitter takes from them, as far as the latency procedure of the run cannot exclude it. An axis
/// without one has the largest jitter of the others: its drive is on the same bus.
///
/// A delay with the standard deviation σ multiplies the response by exp(-ω²σ²/2). To first order that lowers the frequency f at which a
/// lag of first order has lost 3 dB by (2πfσ)² of it, which is the half-width of a rectangular distribution.
pub(super) fn count_jitter(procedures: &mut [ProcedureFindings], requirements: &Requirements) {
    let mut most_s: BTreeMap<String, f64> = BTreeMap::new();
    for m in procedures.iter().filter(|p| p.state.is_none()).flat_map(|p| &p.measurements) {
        if let Some(value) = m.value.filter(|_| m.measurand == JITTER && m.inconclusive.is_none()) {
            let own_s = most_s.entry(m.axis.clone()).or_insert(0.0);
            *own_s = own_s.max(value + m.u);
        }
    }
    let of_others_s = most_s.values().copied().fold(0.0, f64::max);
    for procedure in procedures.iter_mut().filter(|p| p.state.is_none()) {
        let mut is_changed = false;
        for m in procedure.measurements.iter_mut().filter(|m| m.measurand == BANDWIDTH) {
            is_changed |= widen(m, most_s.get(&m.axis).copied().unwrap_or(of_others_s));
        }
        if is_changed {
            judge_again(procedure, requirements);
        }
    }
}

/// Whether there was something to add.
fn widen(m: &mut Measurement, jitter_s: f64) -> bool {
    let Some(value_hz) = m.value.filter(|_| jitter_s > 0.0) else { return false };
    let share = (TAU * value_hz * jitter_s).powi(2);
    m.add_known(share * value_hz / 3_f64.sqrt());
    if share > LEAST_SHARE {
        let [most_us, most] = [1e6 * jitter_s, 100.0 * share];
        m.flags.push(format!("a delay that jitters by up to {most_us:.0} us (rms) takes up to {most:.1} %"));
    }
    true
}

#[cfg(test)]
mod tests {
    use procedures::quantity::QuantityKind;

    use super::*;

    fn bandwidth() -> Measurement {
        let mut m = Measurement::new(BANDWIDTH, "az", QuantityKind::Frequency, None, "any/1");
        (m.value, m.u) = (Some(918.4), 2.8);
        m
    }

    /// Drawn unit 2010 in service: 1019 Hz behind a jitter of 45 us (rms) read 918 Hz, 18 expanded uncertainties too low.
    #[test]
    fn a_bandwidth_behind_a_delay_that_jitters_holds_the_truth() {
        let mut m = bandwidth();
        assert!(widen(&mut m, 61e-6));
        assert!((m.value.expect("of the response") - 1019.5).abs() < 2.0 * m.u, "{m:?}");
        assert!(m.flags[0].starts_with("a delay that jitters by up to 61 us (rms)"), "{:?}", m.flags);
    }

    #[test]
    fn without_jitter_a_bandwidth_stays_as_it_is() {
        let mut m = bandwidth();
        assert!(!widen(&mut m, 0.0) && m == bandwidth());
        assert!(widen(&mut m, 10e-6) && m.u < 4.0 && m.flags.is_empty(), "{m:?}");
    }
}
