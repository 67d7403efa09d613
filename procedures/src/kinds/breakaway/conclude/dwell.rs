//! Dwell law at the rates that have enough dwells.

use analysis::dwell::{DwellLaw, Repeats};
use analysis::uncertainty::{Component, combine};

use super::ramps::{Broken, cells};
use super::{Conclusion, DWELL_LAW_RATE, FEWEST_DWELLS, Findings, Q, asks_for_dwell_law, condition, plots};

const ESTIMATOR: &str = "dwell-law/1";

/// One slope for each rate of 1 A/s or more that has three dwells and repeats.
pub(super) fn conclude(findings: &Findings<'_>, broken: &[Broken<'_>], conclusion: &mut Conclusion) {
    if !asks_for_dwell_law(findings.keys) {
        if !findings.keys.ramps.is_empty() {
            let why = "dwell law not determined: it takes three dwells with repeats at 1 A/s or more";
            conclusion.remarks.push(why.to_owned());
        }
        return;
    }
    let mut found = false;
    for rate in rates(broken) {
        let groups = groups(broken, rate);
        let Some(law) = DwellLaw::new(&groups, findings.keys.dwell_constant_s) else { continue };
        found = true;
        report(findings, broken, rate, &groups, &law, conclusion);
    }
    if !found {
        let reason = format!("fewer than {FEWEST_DWELLS} dwells with repeats broke away at 1 A/s or more");
        conclusion.measurements.push(findings.none("dwell-slope", Q::Torque, ESTIMATOR, reason));
    }
}

fn report(
    findings: &Findings<'_>,
    broken: &[Broken<'_>],
    rate: f64,
    groups: &[Repeats],
    law: &DwellLaw,
    conclusion: &mut Conclusion,
) {
    let repeats = Component { u: law.slope_u_nm, dof: law.dof };
    let spread = combine(&[repeats, findings.torque_constant(law.slope_nm)]);
    let n = groups.iter().map(|g| g.torque_nm.len()).sum();
    let mut m = findings.measurement("dwell-slope", Q::Torque, law.slope_nm, spread, n, ESTIMATOR);
    let at_rate: Vec<&Broken<'_>> = broken.iter().filter(|b| b.rate == rate).collect();
    if let Some(one) = at_rate.first() {
        m.conditions =
            ["rate", "pose"].iter().filter_map(|n| condition(one.case, n, one.case.requested(n))).collect();
    }
    m.flags.push(format!("per unit of ln(1 + t/{:.0} s), t counted to 3 z_ss", law.tau_s));
    if law.misfit_nm > 3.0 * law.repeatability_nm {
        m.flags.push(format!("not a logarithm: the means miss the line by up to {:.2} N·m", law.misfit_nm));
    }
    m.evidence = at_rate.iter().map(|b| findings.evidence(b.span_s)).collect();
    conclusion.measurements.push(m);
    conclusion.plots.push(plots::dwell(rate, groups, law));
}

/// Rates fast enough, each once, in plan order.
fn rates(broken: &[Broken<'_>]) -> Vec<f64> {
    let mut rates: Vec<f64> = Vec::new();
    for one in broken.iter().filter(|b| b.rate >= DWELL_LAW_RATE) {
        if !rates.contains(&one.rate) {
            rates.push(one.rate);
        }
    }
    rates
}

fn groups(broken: &[Broken<'_>], rate: f64) -> Vec<Repeats> {
    let mut groups = Vec::new();
    for cell in cells(broken).iter().filter(|c| c[0].rate == rate) {
        for direction in [1.0, -1.0] {
            let own: Vec<&&Broken<'_>> = cell.iter().filter(|b| b.direction == direction).collect();
            if !own.is_empty() {
                groups.push(Repeats {
                    direction_ratio: direction,
                    rest_s: own.iter().map(|b| b.rest_s).collect(),
                    torque_nm: own.iter().map(|b| b.peak.torque_nm).collect(),
                });
            }
        }
    }
    groups
}
