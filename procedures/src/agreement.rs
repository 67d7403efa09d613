//! Independent estimates of one quantity: what two procedures of a run found under the same conditions must agree.
//!
//! Pure: from measurements to measurements, so that a run and its re-judgement agree (ISO/IEC 17025:2017, 7.7.1:
//! results are monitored by comparing different characteristics of the item and by replicate tests).

use crate::measurement::{Condition, Measurement};

#[cfg(test)]
mod tests;

/// Estimates of one quantity that are farther apart than so many of their combined standard uncertainties disagree.
pub const MOST_U: f64 = 3.0;

/// Measurands that are properties of the unit under their conditions: who measures them twice finds the same. What depends
/// on a target, a load or the course of a procedure (currents of a duty, tracking errors) is not among them.
pub const PROPERTIES: &[&str] = &[
    "apparent-inertia",
    "breakaway-torque",
    "bristle-stiffness",
    "cogging-amplitude",
    "cogging-order",
    "cogging-peak",
    "coulomb-torque",
    "friction-torque",
    "hold-margin",
    "presliding-damping",
    "spring-stiffness",
    "spring-torque",
    "static-torque",
    "stribeck-velocity",
    "torque-constant",
    "unbalance-torque",
    "velocity-bandwidth",
    "velocity-delay-margin",
    "velocity-gain-margin",
    "velocity-modulus-margin",
    "velocity-phase-margin",
    "viscous-coefficient",
];

/// A measurement of a procedure.
#[derive(Clone, Copy, Debug)]
struct Place {
    procedure: usize,
    measurement: usize,
}

/// Two estimates of one quantity that disagree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Disagreement {
    /// Indices of the procedures that made them.
    pub procedures: [usize; 2],
    /// What disagrees, and by how much.
    pub sentence: String,
}

/// Compares what each procedure found (name and measurements) with what the others found, and gives what disagrees to both
/// measurements as a doubt.
pub fn compare(found: &mut [(String, Vec<Measurement>)]) -> Vec<Disagreement> {
    let mut disagreements = Vec::new();
    let places = places(found);
    for (k, &later) in places.iter().enumerate() {
        for &earlier in places[..k].iter().filter(|earlier| earlier.procedure != later.procedure) {
            let [a, b] = [earlier, later].map(|p| &found[p.procedure].1[p.measurement]);
            let Some(apart_u) = apart_u(a, b) else { continue };
            let names = [earlier, later].map(|p| found[p.procedure].0.clone());
            let text = |m: &Measurement| {
                m.value.map_or_else(String::new, |value| {
                    format!("{} ± {}", m.kind.format(value), m.kind.format(m.u))
                })
            };
            let sentence = format!(
                "{} of {}{}: {} found {}, {} found {}: {apart_u:.1} of their combined standard uncertainties apart, \
                 {MOST_U} allowed",
                a.measurand,
                a.axis,
                under(a),
                names[0],
                text(a),
                names[1],
                text(b)
            );
            for place in [earlier, later] {
                let own = &mut found[place.procedure].1[place.measurement].doubt;
                own.get_or_insert_with(|| sentence.clone());
            }
            disagreements.push(Disagreement { procedures: [earlier.procedure, later.procedure], sentence });
        }
    }
    disagreements
}

fn places(found: &[(String, Vec<Measurement>)]) -> Vec<Place> {
    let mut all = Vec::new();
    for (procedure, (_, measurements)) in found.iter().enumerate() {
        let property = |m: &Measurement| {
            // A bound lies away from the truth, and so from every estimate of it.
            let is_estimate = m.value.is_some() && m.inconclusive.is_none() && m.bound.is_none();
            PROPERTIES.contains(&m.measurand.as_str()) && is_estimate
        };
        let own = measurements.iter().enumerate().filter(|(_, m)| property(m));
        all.extend(own.map(|(measurement, _)| Place { procedure, measurement }));
    }
    all
}

/// Distance of two estimates of one quantity over their combined standard uncertainty, where it is too large; `None` where they
/// agree or are no estimates of the same quantity under the same conditions.
fn apart_u(a: &Measurement, b: &Measurement) -> Option<f64> {
    if !is_same(a, b) {
        return None;
    }
    let apart = (a.value? - b.value?).abs();
    let apart_u = apart / a.u.hypot(b.u);
    (apart > 0.0 && (apart_u > MOST_U || apart_u.is_nan())).then_some(apart_u)
}

/// Whether both are estimates of one quantity under the same conditions.
pub(crate) fn is_same(a: &Measurement, b: &Measurement) -> bool {
    let alike = |(x, y): (&Condition, &Condition)| x.name == y.name && x.requested == y.requested;
    a.measurand == b.measurand
        && a.axis == b.axis
        && a.conditions.len() == b.conditions.len()
        && a.conditions.iter().zip(&b.conditions).all(alike)
}

/// Flags every estimate of a quantity that another procedure knows better: that one is the parameter of the unit, the others
/// are cross-checks of it. Of equals the earlier one is the parameter.
pub fn name_cross_checks(found: &mut [(String, Vec<Measurement>)]) {
    let places = places(found);
    for &own in &places {
        let at = |place: Place| &found[place.procedure].1[place.measurement];
        let rivals =
            places.iter().filter(|other| other.procedure != own.procedure && is_same(at(**other), at(own)));
        let by_u = |a: &&Place, b: &&Place| at(**a).u.total_cmp(&at(**b).u);
        let Some(&best) = rivals.min_by(by_u) else { continue };
        let is_better = at(best).u < at(own).u || (at(best).u == at(own).u && best.procedure < own.procedure);
        if is_better {
            let flag = format!("a cross-check: {} is the better measurement", found[best.procedure].0);
            found[own.procedure].1[own.measurement].flags.push(flag);
        }
    }
}

fn under(measurement: &Measurement) -> String {
    let each = |c: &Condition| format!("{} {}", c.name, c.kind.format(c.requested));
    let all: Vec<String> = measurement.conditions.iter().map(each).collect();
    if all.is_empty() { String::new() } else { format!(" at {}", all.join(", ")) }
}
