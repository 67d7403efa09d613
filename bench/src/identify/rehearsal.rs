//! Settings that no formula relates to a finding: the procedure is run on candidate twins, and their curves are compared with the
//! measured ones.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU16;

use controllers::DirectorGains;
use procedures::diagnostic::Diagnostic;
use procedures::identification::Prior;
use procedures::log::LogReader;
use procedures::trace::{Plot, Series};
use reports::record::{Findings, ProcedureFindings};
use sim_devices::unit::{FieldOfPart, PARAMETERS, Setting, UnitSettings};

use self::fit::{Curves, Point, fit};
use super::settings::{MEASURED_RATIO, spread_si};
use super::{Identified, IdentifiedSetting, Standing};
use crate::campaign::simulated::{NoResult, Simulated};
use crate::cycle::laws::Laws;
use crate::files::{parameters, profile};
use crate::model::rig::{Rig, Tier};
use crate::plan::{CampaignPlan, Wanted, plan};
use crate::record::log::PROCEDURE;
use crate::site::unit::{Unit, World};

mod fit;

/// Settings that show in curves of a kind.
struct Sought {
    /// The kind of the procedure.
    kind: &'static str,
    settings: &'static [Stepped],
    /// Beginnings of the ids of pictures.
    pictures: &'static [&'static str],
    /// How the labels of curves end.
    curves: &'static [&'static str],
    scaled: Scaled,
}

/// A setting with the step from the base that tells the slopes of the curves.
struct Stepped {
    key: &'static str,
    step_si: f64,
}

/// Curves by an instrument whose scale is not that of the simulated one: all points of them may be shifted by one value.
struct Scaled {
    /// Beginning of the ids of pictures.
    picture: &'static str,
    /// How the labels of curves end.
    curve: &'static str,
    /// Standard uncertainty of the shift, in the unit of the pictures.
    u: f64,
}

/// Gain and phase of the mirror. The strain gauge is inside its loop; the autocollimator has a scale of its own, of some tenths of a
/// per cent.
const SOUGHT: &[Sought] = &[Sought {
    kind: "fsm-response",
    settings: &[
        Stepped { key: "mirror.hysteresis", step_si: 0.02 },
        Stepped { key: "mirror.support-frequency", step_si: 2.0 },
    ],
    pictures: &["gain-", "phase-"],
    curves: &[", strain gauge", ", autocollimator"],
    scaled: Scaled { picture: "gain-", curve: ", autocollimator", u: 0.1 },
}];

/// Root of χ²/ν above which the curves are not those of the twin with any values of the settings.
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
                    found.remarks.push(format!("{}: as in the base: {why}", sought.names()));
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
        (self.tell)(&format!("{}: rehearsals for {}", procedure.id, sought.names()));
        let stage = Stage::new(self, procedure)?;
        let measured = curves(sought, &procedure.plots);
        let settings: Vec<_> = sought.settings.iter().map(|stepped| setting(stepped.key)).collect();
        let shown = |values_si: &[f64]| {
            let mut unit = found.unit.clone();
            settings.iter().zip(values_si).for_each(|(setting, value_si)| setting.set(&mut unit, *value_si));
            Ok::<_, String>(curves(sought, &stage.plots(self, &unit)?))
        };
        let priors: Vec<Prior> = settings.iter().map(|setting| prior(setting, &found.unit)).collect();
        let steps: Vec<f64> = sought.settings.iter().map(|stepped| stepped.step_si).collect();
        let fit = fit(&measured, &priors, &steps, sought.scaled.u, &shown)?;
        if fit.misfit_ratio > MISFIT_MOST {
            found.contradictions.push(format!(
                "{}: curves deviate from those of the twin by {:.1} times their noise, whatever {} is",
                procedure.id,
                fit.misfit_ratio,
                sought.names()
            ));
        }
        let log = procedure.log.as_ref().map_or_else(String::new, |log| format!(" ({log})"));
        for ((setting, value), prior) in settings.iter().zip(&fit.values).zip(&priors) {
            if value.u_si > MEASURED_RATIO * prior.u
                || found.settings.iter().any(|own| own.key == setting.key)
            {
                continue;
            }
            setting.set(&mut found.unit, value.value_si);
            found.settings.push(IdentifiedSetting {
                key: setting.key,
                value: *value,
                standing: Standing::Measured,
                evidence: vec![format!("gain and phase of {}{log}", procedure.id)],
            });
        }
        let place = |key: &str| PARAMETERS.iter().position(|p| p.key == key);
        found.settings.sort_by_key(|own| place(own.key));
        Ok(())
    }
}

impl Sought {
    /// E.g. `mirror.hysteresis and mirror.support-frequency`.
    fn names(&self) -> String {
        let keys: Vec<&str> = self.settings.iter().map(|stepped| stepped.key).collect();
        keys.join(" and ")
    }
}

/// A setting of units by its key.
fn setting(key: &str) -> &'static Setting<FieldOfPart<UnitSettings>> {
    PARAMETERS.iter().find(|p| p.key == key).expect("a setting that exists")
}

/// What is known of a setting before its curves are looked at.
fn prior(setting: &Setting<FieldOfPart<UnitSettings>>, unit: &UnitSettings) -> Prior {
    let value = setting.get(unit);
    Prior { value, u: spread_si(setting, value), range: setting.range_si, is_fixed: false }
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
        let plan = plan(&wanted, &rig).map_err(|error| first(error.diagnostics()))?;
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

/// The points of the sought curves. Pictures draw U with k = 2.
fn curves(sought: &Sought, plots: &[Plot]) -> Curves {
    let mut all = Curves::new();
    for plot in plots.iter().filter(|plot| sought.pictures.iter().any(|id| plot.id.starts_with(id))) {
        let own = |series: &&Series| sought.curves.iter().any(|curve| series.label.ends_with(curve));
        for series in plot.series.iter().filter(own) {
            let Scaled { picture, curve, .. } = sought.scaled;
            let is_scaled = plot.id.starts_with(picture) && series.label.ends_with(curve);
            for ((x, &y), u) in series.x.iter().zip(&series.y).zip(&series.u) {
                if y.is_finite() && *u > 0.0 {
                    let name = format!("{} {} {x}", plot.id, series.label);
                    all.insert(name, Point { y, u: 0.5 * u, is_scaled });
                }
            }
        }
    }
    all
}
