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
/// Jitter of a delay that nothing of the run has looked at: uniform over 0.2 ms (ours; LAT-JIT allows more, behind which a bandwidth
/// means little).
const UNKNOWN_S: f64 = 58e-6;
const NOT_LOOKED_AT: &str = "the jitter of the delay was not measured on this axis";

/// Adds to bandwidths of the current what jitter takes from them, as far as the latency procedure of the axis cannot exclude it. On an
/// axis without one it may be the largest that is expected, or that of another axis where this is larger: that another drive on the same
/// bus does not jitter says nothing (drawn unit 2072 in service: 0 and 53 us).
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
    let unknown_s = most_s.values().copied().fold(UNKNOWN_S, f64::max);
    for procedure in procedures.iter_mut().filter(|p| p.state.is_none()) {
        let mut is_changed = false;
        for m in procedure.measurements.iter_mut().filter(|m| m.measurand == BANDWIDTH) {
            is_changed |= match most_s.get(&m.axis) {
                Some(jitter_s) => widen(m, *jitter_s),
                None => {
                    let is_wider = widen(m, unknown_s);
                    m.flags.extend(is_wider.then(|| NOT_LOOKED_AT.to_owned()));
                    is_wider
                }
            };
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
    use procedures::diagnostic::SourceFile;
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

    /// Drawn unit 2072 in service: azimuth does not jitter, elevation by 53 us (rms), and its 976 Hz read 906 Hz.
    #[test]
    fn an_axis_without_a_latency_procedure_is_not_taken_to_jitter_as_little_as_another_one() {
        let found = |measurements: Vec<Measurement>| {
            let mut all = [ProcedureFindings { measurements, ..ProcedureFindings::default() }];
            let text = "schema = 1\n[[requirement]]\nid = 'CUR-BW'\ntext = 't'\nsource = 'ours'\nmethod = 'test'\n\
                        axes = ['az']\nmeasurand = ['current-bandwidth']\nlimit = '>= 800 Hz'\n";
            let source = SourceFile::new("requirements.toml", text.to_owned());
            count_jitter(&mut all, &Requirements::parse(&source).expect("one requirement"));
            let [found] = all;
            found.measurements.into_iter().find(|m| m.measurand == BANDWIDTH).expect("it is there")
        };
        let jitter = |axis: &str| {
            let mut m = Measurement::new(JITTER, axis, QuantityKind::Time, None, "any/1");
            (m.value, m.u) = (Some(0.0), 12e-6);
            m
        };
        let read = || Measurement { value: Some(906.1), ..bandwidth() };
        let elsewhere = found(vec![jitter("el"), read()]);
        assert!(elsewhere.flags.iter().any(|flag| flag == NOT_LOOKED_AT), "{elsewhere:?}");
        assert!(2.0 * elsewhere.u > 976.0 - 906.1, "{elsewhere:?}");
        let here = found(vec![jitter("az"), read()]);
        assert!(here.u < 10.0 && here.flags.is_empty(), "{here:?}");
        assert_eq!(found(vec![read()]), elsewhere, "no axis was looked at");
    }

    #[test]
    fn without_jitter_a_bandwidth_stays_as_it_is() {
        let mut m = bandwidth();
        assert!(!widen(&mut m, 0.0) && m == bandwidth());
        assert!(widen(&mut m, 10e-6) && m.u < 4.0 && m.flags.is_empty(), "{m:?}");
    }
}
