//! What one log of a run tells the judge of the others: torque constants that a force gauge measured, and inertias that
//! frequency responses of the sliding axis show.
//!
//! Torque is K_t·(i − (J/K_t)·α): a response from torque to angle gives J/K_t whatever K_t is, and K_t is a factor of the
//! whole.

use std::collections::BTreeMap;

use procedures::axis::{Axes, MeasuredConstant};
use procedures::case::Case;
use procedures::drift;
use procedures::log::Window;
use procedures::measurement::Measurement;
use procedures::quantity::QuantityKind;
use procedures::requirement::Requirements;
use procedures::stimulus::Stimulus;
use rayon::prelude::*;
use reports::record::ProcedureFindings;

use super::inertia::Inertias;
use super::{JudgedLog, compared};
use crate::model::signs;

/// Measurand of the kind that measures torque constants.
pub(super) const CONSTANT: &str = "torque-constant";
/// Friction by the gauge, at which the constant was measured.
const PULLED: &str = "pulled-friction-torque";
/// The inertia counts in a torque that changes by more than this part of its standard uncertainty where the inertia is one
/// standard uncertainty larger.
const INERTIA_COUNTS: f64 = 0.1;
/// How far the temperatures of a motor may lie apart, K, where a log does not say: from a room at 20 °C to a drive at the 60 °C of the
/// shipped gates.
const UNKNOWN_KELVIN: f64 = 40.0;

/// Least and greatest temperature of the heat sink of each axis in a log, °C.
pub type HeatSinks = BTreeMap<String, [f64; 2]>;

/// Torque constants and inertias by axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    constants: BTreeMap<String, AtTemperature>,
    inertias: Inertias,
    /// Inertias count as one standard uncertainty larger: what that changes is their share in the uncertainty of a number.
    more_inertia: bool,
}

#[derive(Clone, Debug, PartialEq)]
struct AtTemperature {
    constant: MeasuredConstant,
    /// Id of the procedure that measured it.
    procedure: String,
    /// Heat sink while it was measured; `None` where the log does not hold it.
    heat_sink_degc: Option<[f64; 2]>,
}

impl Known {
    /// What these logs found; of several constants of one axis the one with the smallest uncertainty.
    fn found(judged: &[Option<JudgedLog>]) -> Self {
        let mut constants: BTreeMap<String, AtTemperature> = BTreeMap::new();
        for log in judged.iter().flatten().filter(|log| log.findings.kind == signs::TORQUE_CONSTANT) {
            let Some(constant) = constant(&log.findings.measurements) else { continue };
            let axis = &log.findings.axis;
            let before = constants.get(axis);
            if before.is_none_or(|before| constant.u_ratio() < before.constant.u_ratio()) {
                let heat_sink_degc = log.heat_sinks_degc.get(axis).copied();
                let procedure = log.findings.id.clone();
                constants.insert(axis.clone(), AtTemperature { constant, procedure, heat_sink_degc });
            }
        }
        Self { constants, inertias: Inertias::found(judged), more_inertia: false }
    }

    /// The constants as well as they are known at the temperatures of another log.
    fn at(&self, heat_sinks_degc: &HeatSinks) -> Self {
        let mut known = self.clone();
        for (axis, found) in &mut known.constants {
            let kelvin = match (found.heat_sink_degc, heat_sinks_degc.get(axis)) {
                (Some([low, high]), Some([least, greatest])) => (greatest - low).max(high - least).max(0.0),
                _ => UNKNOWN_KELVIN,
            };
            found.constant = found.constant.at_other_temperature(kelvin);
        }
        known
    }

    /// The axes with the torque constants, which all points share. Inertia they do not: each takes off its own.
    pub(super) fn with_constants(&self, axes: &Axes) -> Axes {
        let mut axes = axes.clone();
        for axis in axes.all_mut() {
            axis.limits.measured_constant =
                self.constants.get(&axis.name).map(|found| found.constant.clone());
        }
        axes
    }

    /// The axes as well as they are known over the motion of a point. Inertias are those of the final build state: an earlier one has
    /// its own.
    pub(super) fn axes_of(&self, axes: &Axes, case: &Case, is_final_state: bool) -> Axes {
        let mut axes = self.with_constants(axes);
        let gimbal = axes.gimbal().ok();
        let elevation_rad = gimbal.and_then(|g| motion_rad(case, &g.inner.name));
        let outer = gimbal.map(|g| g.outer.name.clone());
        for axis in axes.all_mut() {
            let limits = &mut axis.limits;
            let is_outer = outer.as_ref() == Some(&axis.name);
            let found = self.inertias.best_over(&axis.name, is_outer, elevation_rad);
            if let Some(best) = found.filter(|_| is_final_state) {
                limits.inertia_kg_m2 = limits.torque_ratio() * best.kg_m2;
                limits.inertia_u_ratio = best.u_kg_m2 / best.kg_m2;
            }
            if self.more_inertia {
                limits.inertia_kg_m2 *= 1.0 + limits.inertia_u_ratio;
            }
        }
        axes
    }

    /// What the report says of torques that follow a measured constant, one sentence an axis.
    fn remarks(&self, measurements: &[Measurement]) -> Vec<String> {
        let rests = |axis: &str| measurements.iter().any(|m| drift::rests_on_torque_constant(m, axis));
        let told = self.constants.iter().filter(|(axis, _)| rests(axis));
        told.map(|(axis, found)| {
            format!(
                "Torques of {axis} follow the torque constant that {} measured, {}, at a pull of {}: at \
                 that torque they and the friction by the force gauge are one measurement, not two that \
                 confirm each other.",
                found.procedure,
                QuantityKind::TorqueConstant.format(found.constant.nm_per_a),
                QuantityKind::Torque.format(found.constant.torque_nm)
            )
        })
        .collect()
    }

    /// Keeps everything from passing that rests on a constant which is not that of the rig file.
    pub(super) fn put_in_doubt(&self, measurements: &mut [Measurement]) {
        for (axis, found) in &self.constants {
            let Some(doubt) = &found.constant.doubt else { continue };
            for measurement in measurements.iter_mut().filter(|m| drift::rests_on_torque_constant(m, axis)) {
                measurement.doubt.get_or_insert_with(|| doubt.clone());
            }
        }
    }
}

/// Where a point has an axis while it measures: over its strokes, else where its last move ends, else where it starts.
fn motion_rad(case: &Case, axis: &str) -> Option<[f64; 2]> {
    let start_rad = *case.start_pose_rad.get(axis)?;
    let mut range = [start_rad; 2];
    if case.axis != axis {
        return Some(range);
    }
    let mut has_strokes = false;
    for segment in &case.segments {
        match segment.stimulus {
            Stimulus::Reversals { from_rad, to_rad, .. } => {
                let own = [from_rad.min(to_rad), from_rad.max(to_rad)];
                range = if has_strokes { [range[0].min(own[0]), range[1].max(own[1])] } else { own };
                has_strokes = true;
            }
            Stimulus::Move { target_rad, .. } | Stimulus::Step { target_rad } if !has_strokes => {
                range = [target_rad; 2];
            }
            _ => {}
        }
    }
    Some(range)
}

fn constant(measurements: &[Measurement]) -> Option<MeasuredConstant> {
    let usable = |name: &str| {
        measurements.iter().find(|m| m.measurand == name && m.inconclusive.is_none() && m.value.is_some())
    };
    let found = usable(CONSTANT)?;
    let constant = MeasuredConstant::new(found.value?, found.u, found.dof, usable(PULLED)?.value?)?;
    Some(constant.doubted(found.doubt.clone()))
}

/// Widens the temperatures of each axis by what a window of the log shows.
pub(super) fn take_heat(heat_sinks_degc: &mut HeatSinks, axes: &Axes, window: &Window) {
    for axis in axes.names() {
        let column = window.rows(&format!("/{axis}")).and_then(|rows| rows.column("heat_sink_degc"));
        for degc in column.unwrap_or_default().iter().copied().filter(|degc| degc.is_finite()) {
            let range = heat_sinks_degc.entry(axis.to_owned()).or_insert([degc; 2]);
            *range = [range[0].min(degc), range[1].max(degc)];
        }
    }
}

/// Whether any number of a log rests on torques that were told from a current.
fn tells_torques(log: &JudgedLog) -> bool {
    let rests = |m: &Measurement| drift::rests_on_torque_constant(m, &m.axis);
    follows_constants(&log.findings) && log.findings.measurements.iter().any(rests)
}

/// Whether the torques of a procedure follow what others found of the torque constants.
pub(super) fn follows_constants(found: &ProcedureFindings) -> bool {
    ![signs::TORQUE_CONSTANT, signs::POLARITY].contains(&found.kind.as_str())
}

/// The logs of a run, each judged by all that the others found, and what they found.
pub(super) struct Settled {
    pub(super) logs: Vec<Option<JudgedLog>>,
    /// Axes whose torques follow a measured constant, with the id of the procedure that measured it.
    pub(super) sources_of_constants: BTreeMap<String, String>,
    /// Inertias of which pulses and responses disagree, a sentence an axis.
    pub(super) disagreements: Vec<String>,
}

/// The judged logs, each by all that the others found: those whose torques were told from a current are judged again by the
/// torque constants and inertias that other logs measured, in whichever order they were recorded. `again` judges the log of an
/// index; where it gives `None`, the log stays as it was judged.
pub(super) fn settled(
    judged: &[Option<JudgedLog>],
    again: &(dyn Fn(usize, &Known) -> Option<JudgedLog> + Sync),
    requirements: &Requirements,
) -> Settled {
    let known = Known::found(judged);
    let settle = |(index, log): (usize, &Option<JudgedLog>)| {
        let log = log.as_ref()?;
        if !tells_torques(log) {
            return Some(log.clone());
        }
        let known = known.at(&log.heat_sinks_degc);
        let Some(mut found) = again(index, &known) else { return Some(log.clone()) };
        let inertias = known.inertias.clone();
        found.findings.remarks.extend(known.remarks(&found.findings.measurements));
        if let Some(other) = again(index, &Known { more_inertia: true, ..known }) {
            add_inertia(&mut found, &other, &inertias, requirements);
        }
        Some(found)
    };
    let logs = judged.par_iter().enumerate().map(settle).collect();
    let sources = known.constants.iter().map(|(axis, found)| (axis.clone(), found.procedure.clone()));
    let disagreements = known.inertias.doubts().map(|doubt| format!("{doubt}.")).collect();
    Settled { logs, sources_of_constants: sources.collect(), disagreements }
}

/// Adds to the uncertainty of each torque what it changes by where inertias are one standard uncertainty larger. Where the inertia
/// of its axis is in doubt, a torque that changes by more than a part of its uncertainty passes nothing.
fn add_inertia(log: &mut JudgedLog, other: &JudgedLog, inertias: &Inertias, requirements: &Requirements) {
    let is_final_state = log.findings.state.is_none();
    let pairs = log.findings.measurements.iter_mut().zip(&other.findings.measurements);
    for (own, other) in
        pairs.filter(|(own, other)| own.measurand == other.measurand && own.point == other.point)
    {
        let (Some(value), Some(changed)) = (own.value, other.value) else { continue };
        if !drift::rests_on_torque_constant(own, &own.axis) {
            continue;
        }
        let share = (changed - value).abs();
        let doubt = inertias.doubt_of(&own.axis).filter(|_| is_final_state && share > INERTIA_COUNTS * own.u);
        if let Some(doubt) = doubt {
            own.doubt.get_or_insert_with(|| doubt.to_owned());
        }
        own.add_known(share);
    }
    if is_final_state {
        compared::judge_again(&mut log.findings, requirements);
    }
}

#[cfg(test)]
mod tests {
    use procedures::case::{Mode, Segment};
    use procedures::measurement::{Estimate, Evidence};
    use procedures::stimulus::ProfileLimits;

    use super::*;
    use crate::files::rig::read_rig;
    use crate::files::shipped::{self, Folder};
    use crate::judge::missing;
    use crate::judge::stage::tests::{planned, requirements};
    use crate::record::page::PlannedLog;

    const LIMITS: ProfileLimits =
        ProfileLimits { velocity_rad_per_s: 0.1, acceleration_rad_per_s2: 1.0, jerk_rad_per_s3: 10.0 };

    fn case(axis: &str, elevation_rad: f64, stimuli: &[Stimulus]) -> Case {
        let segment = |stimulus: &Stimulus| Segment {
            stimulus: stimulus.clone(),
            ..Segment::hold("any", Mode::Position, 60.0)
        };
        Case {
            axis: axis.to_owned(),
            start_pose_rad: BTreeMap::from([("az".to_owned(), 2.0), ("el".to_owned(), elevation_rad)]),
            segments: stimuli.iter().map(segment).collect(),
            ..Case::default()
        }
    }

    #[test]
    fn a_point_has_its_axis_where_its_strokes_are_or_its_last_move_ends_and_the_other_axis_where_it_starts() {
        let approach = Stimulus::Move { target_rad: 0.9, limits: LIMITS };
        let strokes = Stimulus::Reversals { from_rad: 1.5, to_rad: 1.1, limits: LIMITS, cycles: 1 };
        let back = Stimulus::Move { target_rad: 0.0, limits: LIMITS };
        let of_elevation = |stimuli: &[Stimulus]| motion_rad(&case("el", 0.2, stimuli), "el");
        assert_eq!(of_elevation(&[approach.clone(), strokes.clone(), back]), Some([1.1, 1.5]));
        assert_eq!(of_elevation(&[approach]), Some([0.9; 2]));
        assert_eq!(of_elevation(&[]), Some([0.2; 2]));
        assert_eq!(motion_rad(&case("az", 0.2, &[strokes]), "el"), Some([0.2; 2]));
        assert_eq!(motion_rad(&case("az", 0.2, &[]), "roll"), None);
    }

    /// Inertia of elevation is known at 0 deg, to 1 %.
    #[test]
    fn each_point_is_judged_by_the_inertia_where_it_is() {
        let rig = shipped::find(Folder::Rigs, "sim", None).and_then(read_rig).expect("the shipped rig");
        let axes = rig.limits();
        let known = Known { inertias: Inertias::one("el", 0.0, 1000.0, 10.0), ..Known::default() };
        let judged_by = |deg: f64, is_final_state: bool| {
            let there = known.axes_of(&axes, &case("el", deg.to_radians(), &[]), is_final_state);
            let limits = there.get("el").expect("elevation");
            [limits.inertia_kg_m2, limits.inertia_u_ratio]
        };
        let [near, far] = [judged_by(0.0, true), judged_by(80.0, true)];
        assert_eq!([near[0], far[0]], [1000.0; 2]);
        // 0.045 per radian over 80 deg, rectangular: 3.6 %.
        assert!((near[1] - 0.01).abs() < 1e-12 && (far[1] - 0.0376).abs() < 1e-4, "{near:?} {far:?}");
        // In an earlier build state the rig file alone tells.
        let shipped = axes.get("el").expect("elevation");
        assert_eq!(judged_by(0.0, false), [shipped.inertia_kg_m2, shipped.inertia_u_ratio]);
    }

    #[test]
    fn a_constant_is_less_certain_by_what_magnets_lose_at_the_temperature_of_another_log() {
        let constant = MeasuredConstant::new(60.0, 0.18, None, 219.0).expect("a constant");
        let procedure = "AZ-TORQUE-CONSTANT".to_owned();
        let found = AtTemperature { constant, procedure, heat_sink_degc: Some([40.0, 41.0]) };
        let known = Known { constants: BTreeMap::from([("az".to_owned(), found)]), ..Known::default() };
        let u_ratio = |range: Option<[f64; 2]>| {
            let heat_sinks = range.map(|range| ("az".to_owned(), range)).into_iter().collect();
            known.at(&heat_sinks).constants["az"].constant.u_ratio()
        };
        // Where the log does not say, 40 K: 4.8 %, rectangular.
        assert!((u_ratio(None) - 0.003_f64.hypot(0.048 / 3_f64.sqrt())).abs() < 1e-12, "{}", u_ratio(None));
        // 10 K are 1.2 %, rectangular.
        let warm = u_ratio(Some([45.0, 50.0]));
        assert!((warm - 0.003_f64.hypot(0.012 / 3_f64.sqrt())).abs() < 1e-6, "{warm}");
    }

    fn log(id: &str, kind: &str, measurements: Vec<Measurement>) -> JudgedLog {
        let planned = PlannedLog { kind: kind.to_owned(), stage: None, ..planned(id, "") };
        let mut log = missing(&planned, 1);
        log.findings.measurements = measurements;
        log
    }

    /// A torque told from a current, N·m, with a standard uncertainty of 2.
    fn torque(measurand: &str, kind: QuantityKind, value: f64) -> Measurement {
        let estimate = Estimate { value, u: 2.0, dof: 50.0, n: 51 };
        let channels = vec!["/az current_a".to_owned()];
        let evidence = vec![Evidence::new(channels, [0.0, 1.0])];
        Measurement { evidence, ..Measurement::new(measurand, "az", kind, Some(estimate), "e/1") }
    }

    #[test]
    fn a_torque_is_as_uncertain_as_the_inertia_makes_it_that_was_taken_off() {
        let friction =
            |nm| log("AZ-FRICTION", "hysteresis", vec![torque("friction-torque", QuantityKind::Torque, nm)]);
        // One standard uncertainty of the inertia takes another 6 N·m off.
        let again = |_: usize, known: &Known| Some(friction(if known.more_inertia { 194.0 } else { 200.0 }));
        let settled = settled(&[Some(friction(200.0))], &again, &requirements());
        let found = &settled.logs[0].as_ref().expect("it was judged").findings.measurements[0];
        assert_eq!(found.value, Some(200.0));
        assert!((found.u - 2_f64.hypot(6.0)).abs() < 1e-12, "{}", found.u);
    }

    #[test]
    fn a_report_says_that_friction_by_gauge_and_by_current_are_one_measurement() {
        let friction =
            log("AZ-FRICTION", "hysteresis", vec![torque("friction-torque", QuantityKind::Torque, 200.0)]);
        let gauge = log(
            "AZ-TORQUE-CONSTANT",
            signs::TORQUE_CONSTANT,
            vec![
                torque(CONSTANT, QuantityKind::TorqueConstant, 60.0),
                torque(PULLED, QuantityKind::Torque, 219.0),
            ],
        );
        let again = |_: usize, _: &Known| Some(friction.clone());
        // The gauge comes after what it corrects.
        let settled = settled(&[Some(friction.clone()), Some(gauge)], &again, &requirements());
        assert_eq!(settled.sources_of_constants["az"], "AZ-TORQUE-CONSTANT");
        let remarks =
            |index: usize| settled.logs[index].as_ref().expect("it was judged").findings.remarks.join("\n");
        assert!(remarks(0).contains("one measurement, not two that confirm each other"), "{}", remarks(0));
        assert!(!remarks(1).contains("one measurement"), "it says so of what rests on it: {}", remarks(1));
    }
}
