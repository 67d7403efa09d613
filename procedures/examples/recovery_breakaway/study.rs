//! One axis, one procedure, many seeds: what comes out against what is true.

use super::bench::{self, Clean};
use super::plant::Plant;
use super::procedures::axis::Axes;
use super::procedures::case::Case;
use super::procedures::kinds::Experiment;
use super::procedures::measurement::{Conclusion, Measurement, PointResult};
use analysis::effort::Effort;
use analysis::presliding::RampFit;

/// Noise on every torque sample, in units of the Coulomb torque.
const NOISE_RATIO: f64 = 0.01;
/// Rate of the ramps that the dwell law rests on.
const DWELL_LAW_A_PER_S: f64 = 1.0;

/// A planned and simulated procedure, ready to be measured with any seed.
pub(crate) struct Study {
    experiment: Box<dyn Experiment>,
    axes: Axes,
    cases: Vec<Case>,
    clean: Vec<Clean>,
    plant: Plant,
}

/// One number that comes out, and what it should be.
#[derive(Clone, Debug)]
pub(crate) struct Recovered {
    pub(crate) name: String,
    pub(crate) truth: f64,
    pub(crate) value: f64,
    pub(crate) u: f64,
    pub(crate) dof: f64,
}

impl Study {
    /// Plans on the axis `el` with the limits of the plant and runs every distinct point once: repeats differ by
    /// their noise only.
    pub(crate) fn new(experiment: Box<dyn Experiment>, plant: Plant, torque_constant: f64) -> Self {
        let axes = Axes::stacked([("el".to_owned(), bench::limits(&plant, torque_constant))]);
        let cases = experiment.plan("el", &axes).expect("the axis allows what the study asks");
        let mut clean: Vec<Clean> = Vec::new();
        for (k, case) in cases.iter().enumerate() {
            let twin =
                cases[..k].iter().position(|c| c.segments == case.segments && c.requested == case.requested);
            let mut run = twin.map_or_else(|| bench::run(&plant, case, k), |t| clean[t].clone());
            run.window.point = k;
            clean.push(run);
        }
        Self { experiment, axes, cases, clean, plant }
    }

    /// The conclusion of one seed.
    pub(crate) fn conclude(&self, seed: u64) -> Conclusion {
        let noise_nm = NOISE_RATIO * self.plant.coulomb;
        self.judge(|clean| bench::measured(&clean.window, noise_nm, seed))
    }

    fn judge(&self, measure: impl Fn(&Clean) -> super::procedures::log::Window) -> Conclusion {
        let points: Vec<PointResult> = self
            .cases
            .iter()
            .zip(&self.clean)
            .map(|(case, clean)| self.experiment.analyse(case, &measure(clean), &self.axes))
            .collect();
        self.experiment.conclude(&self.cases, &points, &self.axes)
    }

    /// Name and truth of every number: parameters of the plant, and the functionals of the noise-free friction.
    pub(crate) fn truths(&self) -> Vec<(String, f64)> {
        let plant = &self.plant;
        let mut truths = vec![
            ("stiffness, ramps".to_owned(), plant.sigma0),
            ("stiffness, multisine".to_owned(), plant.sigma0),
            ("damping, multisine".to_owned(), plant.sigma1 + plant.viscous),
        ];
        let z_ss = self.true_z_ss();
        let exact = self.judge(|clean| clean.window.clone());
        let mut law: Vec<(f64, f64)> = Vec::new();
        for m in breakaways(&exact) {
            let [rate, dwell] = ["rate", "dwell"].map(|n| condition(m, n));
            let each: Vec<f64> = self
                .ramps()
                .filter(|(case, _)| {
                    case.requested("rate") == Some(rate.0) && case.requested("dwell") == Some(dwell.0)
                })
                .map(|(case, clean)| true_breakaway(case, clean, z_ss))
                .collect();
            let truth = each.iter().sum::<f64>() / each.len() as f64;
            if rate.0 == DWELL_LAW_A_PER_S {
                law.push((dwell.1.ln_1p(), truth));
            }
            truths.push((breakaway_name(m), truth));
        }
        if law.len() > 2 {
            truths.push(("dwell slope".to_owned(), slope(&law)));
        }
        truths
    }

    /// What one seed gives, in the order of `truths`; a number that is missing stays out.
    pub(crate) fn recover(&self, truths: &[(String, f64)], seed: u64) -> Vec<Recovered> {
        let conclusion = self.conclude(seed);
        truths
            .iter()
            .filter_map(|(name, truth)| {
                let m = conclusion.measurements.iter().find(|m| is(m, name))?;
                let dof = m.dof.unwrap_or(f64::INFINITY);
                Some(Recovered { name: name.clone(), truth: *truth, value: m.value?, u: m.u, dof })
            })
            .collect()
    }

    fn ramps(&self) -> impl Iterator<Item = (&Case, &Clean)> {
        self.cases.iter().zip(&self.clean).filter(|(case, _)| case.requested("direction").is_some())
    }

    /// z_ss as the procedure defines it (mean over the ramps of T_∞/σ0), from noise-free data and the true load.
    fn true_z_ss(&self) -> f64 {
        let each: Vec<f64> = self
            .ramps()
            .filter_map(|(case, clean)| {
                let direction = case.requested("direction")?;
                let rows = &clean.window.topics[0];
                let span = span_of(case, clean);
                let range = rows.range(span.0 - 0.5, span.1);
                let [position, torque] = [0, 1].map(|c| &rows.columns[c][range.clone()]);
                let effort =
                    Effort::new(&rows.time_s[range.clone()], position, torque, self.plant.inertia).ok()?;
                let x: Vec<f64> = effort.position_rad.iter().map(|p| direction * (p - span.2)).collect();
                let friction: Vec<f64> = effort
                    .position_rad
                    .iter()
                    .zip(&effort.effort_nm)
                    .map(|(p, f)| direction * (f + self.plant.load(*p)))
                    .collect();
                RampFit::new(&effort.time_s, &x, &friction).map(|fit| fit.z_ss_rad())
            })
            .collect();
        each.iter().sum::<f64>() / each.len() as f64
    }
}

/// Start, end and starting angle of the ramp of a case.
fn span_of(case: &Case, clean: &Clean) -> (f64, f64, f64) {
    let index =
        case.segments.iter().position(|s| s.label.starts_with("ramp")).expect("a ramp point has a ramp");
    let span = &clean.window.segments[index];
    (span.start_s, span.end_s, span.start_position_rad)
}

/// The largest true friction torque over 0.5…8 z_ss of the ramp.
fn true_breakaway(case: &Case, clean: &Clean, z_ss: f64) -> f64 {
    let direction = case.requested("direction").expect("a ramp has a direction");
    let (start_s, end_s, start_rad) = span_of(case, clean);
    let rows = &clean.window.topics[0];
    rows.range(start_s, end_s)
        .filter(|&i| (0.5..=8.0).contains(&(direction * (rows.columns[0][i] - start_rad) / z_ss)))
        .map(|i| direction * clean.friction_nm[i])
        .fold(f64::NEG_INFINITY, f64::max)
}

fn breakaways(conclusion: &Conclusion) -> impl Iterator<Item = &Measurement> {
    conclusion.measurements.iter().filter(|m| m.measurand == "breakaway-torque" && m.point.is_none())
}

/// Requested and achieved value of a condition.
fn condition(m: &Measurement, name: &str) -> (f64, f64) {
    let found = m.conditions.iter().find(|c| c.name == name).expect("every breakaway has rate and dwell");
    (found.requested, found.achieved.unwrap_or(f64::NAN))
}

fn breakaway_name(m: &Measurement) -> String {
    format!("breakaway {} A/s, dwell {} s", condition(m, "rate").0, condition(m, "dwell").0)
}

fn is(m: &Measurement, name: &str) -> bool {
    match m.measurand.as_str() {
        "bristle-stiffness" if m.estimator.starts_with("presliding-multisine") => {
            name == "stiffness, multisine"
        }
        "bristle-stiffness" => name == "stiffness, ramps",
        "presliding-damping" => name == "damping, multisine",
        "dwell-slope" => name == "dwell slope",
        "breakaway-torque" if m.point.is_none() => name == breakaway_name(m),
        _ => false,
    }
}

/// Slope of a line through points.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (over, under) =
        points.iter().fold((0.0, 0.0), |(o, u), (px, py)| (o + (px - x) * (py - y), u + (px - x).powi(2)));
    over / under
}
