//! Settings that no formula relates to a finding: the procedure is run on candidate twins, and their curves are compared with the
//! measured ones.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU16;

use controllers::DirectorGains;
use procedures::diagnostic::Diagnostic;
use procedures::log::LogReader;
use procedures::trace::Plot;
use reports::record::{Findings, ProcedureFindings};
use sim_devices::unit::{FieldOfPart, PARAMETERS, Setting, UnitSettings};

use super::settings::{MEASURED_RATIO, spread_si};
use super::{Identified, IdentifiedSetting, Standing, Value};
use crate::campaign::simulated::{NoResult, Simulated};
use crate::cycle::laws::Laws;
use crate::files::{parameters, profile};
use crate::model::rig::{Rig, Tier};
use crate::plan::{CampaignPlan, PlanError, Wanted, plan};
use crate::record::log::PROCEDURE;
use crate::site::unit::{Unit, World};

/// A setting that shows in curves.
struct Sought {
    /// Key of the setting.
    key: &'static str,
    /// Kind of the procedure.
    kind: &'static str,
    /// Beginnings of the ids of pictures.
    pictures: &'static [&'static str],
    /// How the labels of curves end.
    curve: &'static str,
    /// Step from the base that tells the slope, SI.
    step: f64,
}

/// Gain and phase by the strain gauge, which is inside the loop of the mirror: its scale is not that of a reference.
const SOUGHT: &[Sought] = &[Sought {
    key: "mirror.hysteresis",
    kind: "fsm-response",
    pictures: &["gain-", "phase-"],
    curve: ", strain gauge",
    step: 0.02,
}];

/// Steps towards the solution; the curves are almost straight lines of the setting.
const STEPS: usize = 2;
/// Root of χ²/ν above which the curves are not those of a mirror with any value of the setting.
const MISFIT_MOST: f64 = 5.0;

/// A measured run whose procedures can be run again on other units.
pub struct Rehearsal<'a> {
    /// What it found.
    pub findings: &'a Findings,
    /// Its folder.
    pub run: &'a Path,
    /// Its rig.
    pub rig: &'a Rig,
    /// The unit that the twin is made from; its settings are those of the twin.
    pub base: &'a Unit,
    /// Told which procedure is rehearsed: that can take minutes.
    pub tell: &'a dyn Fn(&str),
}

impl Rehearsal<'_> {
    /// Adds what curves tell, by rehearsals of the procedures that show it. What cannot be rehearsed is a remark.
    pub fn identify(&self, found: &mut Identified) {
        for sought in SOUGHT {
            let shows = |p: &&ProcedureFindings| p.state.is_none() && p.kind == sought.kind;
            for procedure in self.findings.procedures.iter().filter(shows) {
                if curves(sought, &procedure.plots).is_empty() {
                    continue;
                }
                if let Err(why) = self.add(sought, procedure, found) {
                    found.remarks.push(format!("{}: stays that of the base: {why}", sought.key));
                }
            }
        }
    }

    fn add(
        &self,
        sought: &Sought,
        procedure: &ProcedureFindings,
        found: &mut Identified,
    ) -> Result<(), String> {
        let setting = PARAMETERS.iter().find(|p| p.key == sought.key).expect("a setting that exists");
        (self.tell)(&format!("{}: rehearsals for {}", procedure.id, sought.key));
        let stage = Stage::new(self, procedure)?;
        let measured = curves(sought, &procedure.plots);
        let shown = |value_si: f64| {
            let mut unit = found.unit.clone();
            setting.set(&mut unit, value_si);
            Ok::<_, String>(curves(sought, &stage.plots(self, &unit)?))
        };
        let fit = fit(setting, sought.step, &measured, setting.get(&found.unit), shown)?;
        if fit.misfit_ratio > MISFIT_MOST {
            found.contradictions.push(format!(
                "{}: curves deviate from those of the twin by {:.1} times their noise, whatever {} is",
                procedure.id, fit.misfit_ratio, sought.key
            ));
        }
        let prior_si = spread_si(setting, setting.get(&found.unit));
        if fit.value.u_si > MEASURED_RATIO * prior_si {
            return Err("the curves hardly depend on it".to_owned());
        }
        setting.set(&mut found.unit, fit.value.value_si);
        let log = procedure.log.as_ref().map_or_else(String::new, |log| format!(" ({log})"));
        found.settings.push(IdentifiedSetting {
            key: setting.key,
            value: fit.value,
            standing: Standing::Measured,
            evidence: vec![format!("gain and phase of {}{log}", procedure.id)],
        });
        let place = |key: &str| PARAMETERS.iter().position(|p| p.key == key);
        found.settings.sort_by_key(|own| place(own.key));
        Ok(())
    }
}

/// A procedure of the run, to be run in virtual time.
struct Stage {
    rig: Rig,
    gains: DirectorGains,
    plan: CampaignPlan,
    folder: tempfile::TempDir,
    seed: u64,
}

impl Stage {
    fn new(run: &Rehearsal<'_>, procedure: &ProcedureFindings) -> Result<Self, String> {
        let first = |found: Vec<Diagnostic>| found.first().map_or_else(String::new, ToString::to_string);
        let io = |error: std::io::Error| format!("rehearsal: {error}");
        let log = run.run.join(procedure.log.as_deref().ok_or("its procedure has no log")?);
        let reader = LogReader::open(&log).map_err(|error| error.to_string())?;
        let attached = reader.attachments().iter().find(|a| a.name == PROCEDURE);
        let text = &attached.ok_or_else(|| format!("{}: no attachment {PROCEDURE}", log.display()))?.text;
        let folder = tempfile::tempdir().map_err(io)?;
        let file = folder.path().join(PROCEDURE);
        std::fs::write(&file, text).map_err(io)?;
        let rig = run.rig.clone().rehearsed_on(Tier::Virtual, &profile::simulated());
        let gains = parameters::load(&rig).map_err(first)?;
        let wanted = Wanted {
            names: vec![file.to_string_lossy().into_owned()],
            polarity_proven: true,
            ..Wanted::default()
        };
        let plan = plan(&wanted, &rig).map_err(|error| match error {
            PlanError::Mistakes(found) | PlanError::Refused(found) => first(found),
            PlanError::NothingSelected(why) => why,
        })?;
        // Other noise than in the run, where that was simulated, too.
        Ok(Self { rig, gains, plan, folder, seed: run.findings.seed.wrapping_add(1) })
    }

    /// The pictures of the procedure on this unit.
    fn plots(&self, run: &Rehearsal<'_>, unit: &UnitSettings) -> Result<Vec<Plot>, String> {
        let folder: PathBuf = self.folder.path().join("run");
        let unit = Unit { world: World::Director(Box::new(unit.clone())), ..run.base.clone() };
        let simulated = Simulated {
            plan: &self.plan,
            rig: &self.rig,
            gains: &self.gains,
            laws: &Laws::default(),
            unit: &unit,
            seed: self.seed,
            folder: &folder,
            stop: &Arc::new(AtomicU16::new(0)),
        };
        let result = simulated.run().map_err(|NoResult { why, .. }| format!("rehearsal: {why}"))?;
        let plots = result.judged.iter().flatten().flat_map(|judged| judged.findings.plots.clone()).collect();
        drop(result);
        std::fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        Ok(plots)
    }
}

/// A point of a measured curve.
#[derive(Clone, Debug, PartialEq)]
struct Point {
    /// Picture, curve and abscissa.
    name: String,
    y: f64,
    /// Standard uncertainty.
    u: f64,
}

/// The points of the sought curves. Pictures draw U with k = 2.
fn curves(sought: &Sought, plots: &[Plot]) -> Vec<Point> {
    let pictures = plots.iter().filter(|plot| sought.pictures.iter().any(|id| plot.id.starts_with(id)));
    let series = pictures.flat_map(|plot| plot.series.iter().map(move |series| (plot, series)));
    let own = series.filter(|(_, series)| series.label.ends_with(sought.curve));
    own.flat_map(|(plot, series)| {
        let points = series.x.iter().zip(&series.y).zip(&series.u);
        points.map(move |((x, y), u)| Point {
            name: format!("{} {} {x}", plot.id, series.label),
            y: *y,
            u: 0.5 * u,
        })
    })
    .filter(|point| point.y.is_finite() && point.u > 0.0)
    .collect()
}

/// A setting from curves.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fit {
    value: Value,
    /// Root of χ²/ν.
    misfit_ratio: f64,
}

/// Weighted least squares of one setting, by Gauss–Newton with the slope between two rehearsals. The noise of a rehearsal is as large as
/// that of the measurement, so variances are doubled; u is widened by what the curves leave (Birge ratio).
fn fit(
    setting: &Setting<FieldOfPart<UnitSettings>>,
    step: f64,
    measured: &[Point],
    base_si: f64,
    shown: impl Fn(f64) -> Result<Vec<Point>, String>,
) -> Result<Fit, String> {
    let [least, most] = setting.range_si;
    let other_si = if base_si + step <= most { base_si + step } else { base_si - step };
    let slopes = [shown(base_si)?, shown(other_si)?];
    let mut at = slopes[0].clone();
    let mut value_si = base_si;
    for _ in 0..STEPS {
        let sums = Sums::new(&paired(measured, &[&slopes[0], &slopes[1], &at]), other_si - base_si)?;
        value_si = (value_si + sums.slope_residual / sums.slope_slope).clamp(least, most);
        at = shown(value_si)?;
    }
    let sums = Sums::new(&paired(measured, &[&slopes[0], &slopes[1], &at]), other_si - base_si)?;
    let misfit_ratio = (sums.residual_residual / sums.dof).sqrt();
    let u_si = sums.slope_slope.sqrt().recip() * misfit_ratio.max(1.0);
    Ok(Fit { value: Value { value_si, u_si, dof: Some(sums.dof) }, misfit_ratio })
}

/// Weighted sums over the points of curves.
struct Sums {
    slope_slope: f64,
    slope_residual: f64,
    residual_residual: f64,
    dof: f64,
}

impl Sums {
    /// Of points with what the base, the other value and the present value show, `step` between the first two.
    fn new(points: &[Paired], step: f64) -> Result<Self, String> {
        let mut sums = Self {
            slope_slope: 0.0,
            slope_residual: 0.0,
            residual_residual: 0.0,
            dof: points.len() as f64 - 1.0,
        };
        for point in points {
            let weight = 0.5 / point.u.powi(2);
            let slope = (point.shown[1] - point.shown[0]) / step;
            let residual = point.y - point.shown[2];
            sums.slope_slope += weight * slope * slope;
            sums.slope_residual += weight * slope * residual;
            sums.residual_residual += weight * residual * residual;
        }
        if points.len() < 3 || sums.slope_slope <= 0.0 {
            return Err("the curves do not depend on it".to_owned());
        }
        Ok(sums)
    }
}

/// A measured point with what rehearsals show there.
struct Paired {
    y: f64,
    u: f64,
    shown: Vec<f64>,
}

/// The points that all have.
fn paired(measured: &[Point], shown: &[&Vec<Point>]) -> Vec<Paired> {
    let one = |point: &Point| {
        let there = |all: &&Vec<Point>| all.iter().find(|own| own.name == point.name).map(|own| own.y);
        let shown = shown.iter().map(there).collect::<Option<Vec<f64>>>()?;
        Some(Paired { y: point.y, u: point.u, shown })
    };
    measured.iter().filter_map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(value: f64, noise: f64) -> Vec<Point> {
        let y = |k: i32| f64::from(k) * value * (1.0 + 0.1 * value) + noise * f64::from(2 * (k % 2) - 1);
        (1..40).map(|k| Point { name: k.to_string(), y: y(k), u: 0.01 }).collect()
    }

    fn hysteresis() -> &'static Setting<FieldOfPart<UnitSettings>> {
        PARAMETERS.iter().find(|p| p.key == "mirror.hysteresis").expect("a setting")
    }

    #[test]
    fn a_setting_is_found_from_curves_that_bend_with_it() {
        let measured = points(0.21, 0.01);
        let fit = fit(hysteresis(), 0.02, &measured, 0.15, |value| Ok(points(value, -0.01))).expect("a fit");
        let error = (fit.value.value_si - 0.21).abs();
        assert!(error < 2.0 * fit.value.u_si && fit.value.u_si < 2e-4, "{fit:?}");
        assert!((1.0..3.0).contains(&fit.misfit_ratio), "{fit:?}");
    }

    #[test]
    fn curves_of_something_else_widen_the_uncertainty() {
        let measured = points(0.21, 0.5);
        let fit = fit(hysteresis(), 0.02, &measured, 0.15, |value| Ok(points(value, 0.0))).expect("a fit");
        assert!(fit.misfit_ratio > MISFIT_MOST && fit.value.u_si > 2e-3, "{fit:?}");
    }

    #[test]
    fn curves_that_do_not_depend_on_it_tell_nothing() {
        let measured = points(0.21, 0.0);
        let found = fit(hysteresis(), 0.02, &measured, 0.15, |_| Ok(points(0.2, 0.0)));
        assert_eq!(found.expect_err("no slope"), "the curves do not depend on it");
    }
}
