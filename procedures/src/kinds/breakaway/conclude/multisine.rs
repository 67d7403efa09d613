//! Stiffness and damping from the multisine.

use analysis::load_map::LoadMap;
use analysis::multisine::{Presliding, Record};
use analysis::uncertainty::{Component, combine};

use super::{Conclusion, Findings, MULTISINE, Numbers, Q, condition, plots};
use crate::case::Case;
use crate::kinds::breakaway::course::{first, span, values};

const ESTIMATOR: &str = "presliding-multisine/1";

/// Both measurands of each multisine point, or why there are none.
pub(super) fn conclude(findings: &Findings<'_>, conclusion: &mut Conclusion) {
    for (case, point) in findings.having(MULTISINE) {
        let found = match (&point.inconclusive, &findings.map) {
            (Some(reason), _) | (None, Err(reason)) => Err(reason.clone()),
            (None, Ok(map)) => presliding(&point.numbers, map, findings.limits.inertia_kg_m2),
        };
        match found {
            Ok((found, span_s, slope_u)) => report(findings, case, &found, span_s, slope_u, conclusion),
            Err(reason) => {
                for (name, kind) in [("bristle-stiffness", Q::Stiffness), ("presliding-damping", Q::Damping)]
                {
                    let mut none = findings.none(name, kind, ESTIMATOR, reason.clone());
                    none.point = Some(case.point.clone());
                    conclusion.measurements.push(none);
                }
            }
        }
    }
}

/// The fit, the span of the record, and the uncertainty of the load's slope at the pose.
fn presliding(numbers: &Numbers, map: &LoadMap, inertia: f64) -> Result<(Presliding, [f64; 2], f64), String> {
    let start_rad = first(numbers, "multisine.start")?;
    let [blocks, period_s] = span(numbers, "multisine.period")?;
    let position = values(numbers, "multisine.position");
    let x_rad: Vec<f64> = position.iter().map(|p| p - start_rad).collect();
    let torque: Vec<f64> =
        position.iter().zip(values(numbers, "multisine.torque")).map(|(p, t)| t - map.at(*p)).collect();
    let orders: Vec<u32> = values(numbers, "multisine.orders").iter().map(|&k| k as u32).collect();
    let record = Record {
        x_rad: &x_rad,
        torque_nm: &torque,
        period_blocks: blocks as usize,
        period_s,
        orders: &orders,
        inertia,
        start_nm: first(numbers, "multisine.rest-torque")? - map.at(start_rad),
    };
    let found = Presliding::new(&record).ok_or("the presliding fit did not converge, or too few periods")?;
    // The load is a spring too: an error of the map changes its slope by about u over a quarter cogging period.
    let reach = (map.span_rad()[1] - map.span_rad()[0]) / 16.0;
    Ok((found, span(numbers, "multisine.span")?, map.u_at(start_rad) / reach))
}

fn report(
    findings: &Findings<'_>,
    case: &Case,
    found: &Presliding,
    span_s: [f64; 2],
    slope_u: f64,
    conclusion: &mut Conclusion,
) {
    let flags = vec![
        format!(
            "multisine: {} lines, {} periods, hysteresis of the loops modelled",
            found.lines.len(),
            found.periods
        ),
        format!("misfit over scatter {:.2}", found.misfit_ratio),
        format!("torque ahead of angle by {:.0} µs", 1e6 * found.delay_s),
    ];
    let stiffness = (found.sigma0, found.sigma0_u, slope_u);
    let damping = (found.damping, found.damping_u, 0.0);
    for (name, kind, (value, u, load_u)) in
        [("bristle-stiffness", Q::Stiffness, stiffness), ("presliding-damping", Q::Damping, damping)]
    {
        let scatter = Component { u, dof: found.dof };
        let spread = combine(&[scatter, Component::known(load_u), findings.torque_constant(value)]);
        let mut m = findings.measurement(name, kind, value, spread, found.periods, ESTIMATOR);
        m.point = Some(case.point.clone());
        m.conditions =
            ["level", "pose"].iter().filter_map(|n| condition(case, n, case.requested(n))).collect();
        m.flags.clone_from(&flags);
        m.evidence = vec![findings.evidence(span_s)];
        conclusion.measurements.push(m);
    }
    conclusion.plots.push(plots::presliding(found));
}
