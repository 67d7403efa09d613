//! A simulated unit from what a run found: findings in, settings of a unit with their uncertainties out.
//!
//! What a unit with given settings would show is a function for each measurand ([`relations`]). The settings are those that explain
//! all findings best, the base unit being weak prior knowledge ([`procedures::identification`]): several findings of one setting are
//! weighted by their inverse variances, a finding of several settings moves all of them, and a setting of which nothing was found
//! keeps the value of the base. Modes over elevation scale the curves of the base ([`modes`]). What only shows in curves is found by
//! runs of the procedure on candidate twins ([`rehearsal`]).

use procedures::measurement::Measurement;
use procedures::verdict::coverage_factor;
use reports::record::{Findings, ProcedureFindings};
use sim_devices::unit::UnitSettings;

use crate::model::rig::Rig;

mod modes;
mod rehearsal;
mod relations;
mod settings;
mod shown;
#[cfg(test)]
mod tests;
mod text;

pub use rehearsal::Rehearsal;
pub use text::unit_file;

/// What the bench itself has to do with its findings.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Names of azimuth and elevation.
    axes: [String; 2],
    /// What an ampere of each is worth in the rig file.
    rig_nm_per_a: [f64; 2],
    /// Period of the loop: an exchange of the bus takes one.
    tick_s: f64,
}

impl Setup {
    /// Of a rig; `None` for one without a director's two axes.
    pub fn of(rig: &Rig) -> Option<Self> {
        rig.gimbal()?;
        let [Some(az), Some(el)] = rig.pair() else { return None };
        let constant = |limits: &procedures::axis::AxisLimits| limits.torque_constant_nm_per_a;
        Some(Self {
            axes: [az.name.clone(), el.name.clone()],
            rig_nm_per_a: [constant(&az.limits)?, constant(&el.limits)?],
            tick_s: 1.0 / rig.loop_rate_hz,
        })
    }
}

/// A value that was found, with the procedure that found it.
#[derive(Clone, Copy, Debug)]
struct Finding<'a> {
    procedure: &'a ProcedureFindings,
    measurement: &'a Measurement,
    /// 0 azimuth, 1 elevation; `None` for what belongs to neither.
    axis: Option<usize>,
    value: f64,
}

impl Finding<'_> {
    /// A condition as it was reached.
    fn condition(&self, name: &str) -> Option<f64> {
        let condition = self.measurement.conditions.iter().find(|condition| condition.name == name)?;
        Some(condition.achieved.unwrap_or(condition.requested))
    }

    /// What a flag says after these words, e.g. `90 deg` of `largest at 90 deg`.
    fn flag(&self, words: &str) -> Option<&str> {
        self.measurement.flags.iter().find_map(|flag| flag.strip_prefix(words))
    }

    fn dof(&self) -> f64 {
        self.measurement.dof.unwrap_or(f64::INFINITY)
    }

    /// Whether a magnitude is told apart from nothing: noise makes it larger, never smaller.
    fn is_above_noise(&self) -> bool {
        self.value.abs() > coverage_factor(self.measurement.dof) * self.measurement.u
    }

    /// Where it stands, e.g. `friction-torque of AZ-FRICTION (AZ-FRICTION.mcap)`.
    fn evidence(&self) -> String {
        let log = self.procedure.log.as_ref().map_or_else(String::new, |log| format!(" ({log})"));
        format!("{} of {}{log}", self.measurement.measurand, self.procedure.id)
    }
}

/// All values of a run that count, in the order of its procedures. In an earlier build state the unit has other loads.
fn findings<'a>(run: &'a Findings, setup: &Setup) -> Vec<Finding<'a>> {
    let final_state = run.procedures.iter().filter(|procedure| procedure.state.is_none());
    let counting = final_state.flat_map(|procedure| {
        let sound = |m: &&Measurement| m.inconclusive.is_none() && m.doubt.is_none();
        procedure.measurements.iter().filter(sound).map(move |m| (procedure, m))
    });
    let finding = |(procedure, measurement): (&'a ProcedureFindings, &'a Measurement)| {
        let axis = setup.axes.iter().position(|name| *name == measurement.axis);
        Some(Finding { procedure, measurement, axis, value: measurement.value.filter(|v| v.is_finite())? })
    };
    counting.filter_map(finding).collect()
}

/// A value with its uncertainty, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// The value.
    pub value_si: f64,
    /// Standard uncertainty.
    pub u_si: f64,
    /// Degrees of freedom; `None`: infinite.
    pub dof: Option<f64>,
}

impl Value {
    /// Expanded uncertainty U = k·u, k = t(0.97725, ν).
    pub fn expanded_u_si(&self) -> f64 {
        coverage_factor(self.dof) * self.u_si
    }
}

/// How much the findings say of a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// They determine it.
    Measured,
    /// They determine its magnitude; its sign is that of the base.
    Magnitude,
    /// They only say something of it together with other settings: the base has a say in it.
    InPart,
}

/// A setting that the findings say something of.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedSetting {
    /// Key, e.g. `az.coulomb-torque`.
    pub key: &'static str,
    /// What the twin gets.
    pub value: Value,
    /// How much of that the findings say.
    pub standing: Standing,
    /// What it was found from, by its share.
    pub evidence: Vec<String>,
}

/// A curve over elevation that the findings say something of.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedCurve {
    /// Table, e.g. `az-structure`.
    pub table: &'static str,
    /// Key in that table, e.g. `mode-1-frequency`.
    pub key: &'static str,
    /// What was found: elevation in rad, and the value there.
    pub points: Vec<(f64, Value)>,
    /// What it was found from.
    pub evidence: Vec<String>,
}

/// What a run says of a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// The twin: the base with what was found.
    pub unit: UnitSettings,
    /// Settings that were found, in the order of [`sim_devices::unit::PARAMETERS`].
    pub settings: Vec<IdentifiedSetting>,
    /// Curves that were found, in the order of [`sim_devices::unit::CURVES`].
    pub curves: Vec<IdentifiedCurve>,
    /// Findings that contradict each other or that the twin does not show, in words.
    pub contradictions: Vec<String>,
    /// What was changed so that the twin can be simulated, in words.
    pub remarks: Vec<String>,
}

/// A finding farther than this from what the twin shows, in its standard uncertainty, contradicts the others.
const CONTRADICTS_U: f64 = 3.0;

/// The twin of a unit by what a run found of it; what was not measured is that of `base`.
pub fn identify(run: &Findings, setup: &Setup, base: &UnitSettings) -> Identified {
    let findings = findings(run, setup);
    let mut found = settings::identify(&findings, setup, base);
    modes::identify(&findings, base, &mut found);
    found
}
