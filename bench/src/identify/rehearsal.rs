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

use self::fit::{Curves, Point, Unknown, fit};
use super::settings::{IN_STEPS, MEASURED_RATIO, spread_si, with_rounding};
use super::{Identified, IdentifiedSetting, Standing, Value};
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
    /// A setting that shows in the curves as those do, and that stays as it is: its uncertainty is theirs, too.
    with: Option<&'static str>,
    /// What of the curves tells them, in words.
    evidence: &'static str,
    /// Whether they show in a curve of a picture.
    shows: fn(&Plot, &Series) -> bool,
    /// Whether the instrument of a curve has another scale than the simulated one: all points of such curves may be shifted by one value.
    is_scaled: fn(&Plot, &Series) -> bool,
    /// Standard uncertainty of that shift, in the unit of the pictures.
    scale_u: f64,
}

/// A setting with the step that tells the slopes of the curves; `*` stands for the axis of the procedure.
struct Stepped {
    key: &'static str,
    step_si: f64,
    /// Values to begin with, as distances from the base; empty where the curves are almost straight lines of the setting.
    scan_si: &'static [f64],
}

/// What is sought where: curves of the mirror, and phases of the structure.
const SOUGHT: &[Sought] = &[
    // The strain gauge is inside the mirror's loop; the autocollimator has a scale of its own, of some tenths of a per cent.
    Sought {
        kind: "fsm-response",
        settings: &[
            Stepped { key: "mirror.hysteresis", step_si: 0.02, scan_si: &[] },
            // A narrow line: curves of 140 Hz know nothing of one at 136 Hz.
            Stepped {
                key: "mirror.support-frequency",
                step_si: 0.5,
                scan_si: &[-8.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0, 8.0],
            },
        ],
        with: None,
        evidence: "gain and phase",
        shows: |plot, series| {
            ["gain-", "phase-"].iter().any(|id| plot.id.starts_with(id))
                && [", strain gauge", ", autocollimator"].iter().any(|end| series.label.ends_with(end))
        },
        is_scaled: |plot, series| plot.id.starts_with("gain-") && series.label.ends_with(", autocollimator"),
        scale_u: 0.1,
    },
    // From command to encoder, whichever part of the way takes the time.
    Sought {
        kind: "modes",
        settings: &[Stepped { key: "*.command-delay", step_si: 250e-6, scan_si: &[] }],
        with: Some("*.sensor-delay"),
        evidence: "phases",
        shows: |plot, series| {
            plot.id.starts_with("encoder-")
                && plot.id.ends_with("-phase")
                && series.label.starts_with("measured")
        },
        is_scaled: |_, _| false,
        scale_u: 1.0,
    },
];

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
                let keys = sought.keys(&procedure.axis);
                let is_found = |key: &String| found.settings.iter().any(|own| own.key == key);
                if keys.iter().all(is_found) || curves(sought, &procedure.plots).is_empty() {
                    continue;
                }
                if let Err(why) = self.add(sought, &keys, procedure, found) {
                    found.remarks.push(format!("{}: as in the base: {why}", keys.join(" and ")));
                }
            }
        }
    }

    fn add(
        &self,
        sought: &Sought,
        keys: &[String],
        procedure: &ProcedureFindings,
        found: &mut Identified,
    ) -> Result<(), String> {
        let names = keys.join(" and ");
        (self.tell)(&format!("{}: rehearsals for {names}", procedure.id));
        let stage = Stage::new(self, procedure)?;
        let measured = curves(sought, &procedure.plots);
        let settings: Vec<_> = keys.iter().map(|key| setting(key)).collect();
        let shown = |values_si: &[f64]| {
            let mut unit = found.unit.clone();
            settings.iter().zip(values_si).for_each(|(setting, value_si)| setting.set(&mut unit, *value_si));
            Ok::<_, String>(curves(sought, &stage.plots(self, &unit)?))
        };
        let unknown = |(setting, stepped): (&&'static _, &Stepped)| unknown(setting, stepped, &found.unit);
        let unknowns: Vec<Unknown> = settings.iter().zip(sought.settings).map(unknown).collect();
        let fit = fit(&measured, &unknowns, sought.scale_u, &shown)?;
        if fit.misfit_ratio > MISFIT_MOST {
            found.contradictions.push(format!(
                "{}: curves deviate from those of the twin by {:.1} times their noise, whatever {names} is",
                procedure.id, fit.misfit_ratio
            ));
        }
        let log = procedure.log.as_ref().map_or_else(String::new, |log| format!(" ({log})"));
        let with_u_si = sought.with.map_or(0.0, |key| known_u_si(&of_axis(key, &procedure.axis), found));
        for ((setting, value), unknown) in settings.iter().zip(&fit.values).zip(&unknowns) {
            if value.u_si > MEASURED_RATIO * unknown.prior.u
                || found.settings.iter().any(|own| own.key == setting.key)
            {
                continue;
            }
            let u_si = with_rounding(setting.key, value.u_si.hypot(with_u_si), found.unit.step_rate_hz);
            let is_measured = u_si <= MEASURED_RATIO * unknown.prior.u;
            let value = Value { value_si: unknown.rounded(value.value_si), u_si, ..*value };
            setting.set(&mut found.unit, value.value_si);
            found.settings.push(IdentifiedSetting {
                key: setting.key,
                value,
                standing: if is_measured { Standing::Measured } else { Standing::InPart },
                evidence: vec![format!("{} of {}{log}", sought.evidence, procedure.id)],
            });
        }
        let place = |key: &str| PARAMETERS.iter().position(|p| p.key == key);
        found.settings.sort_by_key(|own| place(own.key));
        Ok(())
    }
}

impl Sought {
    /// Keys of its settings for a procedure on this axis.
    fn keys(&self, axis: &str) -> Vec<String> {
        self.settings.iter().map(|stepped| of_axis(stepped.key, axis)).collect()
    }
}

/// A key with the axis that `*` stands for.
fn of_axis(key: &str, axis: &str) -> String {
    key.replacen('*', axis, 1)
}

/// A setting of units by its key.
fn setting(key: &str) -> &'static Setting<FieldOfPart<UnitSettings>> {
    PARAMETERS.iter().find(|p| p.key == key).expect("a setting that exists")
}

/// What is known of a setting before its curves are looked at.
fn unknown(setting: &Setting<FieldOfPart<UnitSettings>>, stepped: &Stepped, unit: &UnitSettings) -> Unknown {
    let value = setting.get(unit);
    let prior = Prior { value, u: spread_si(setting, value), range: setting.range_si, is_fixed: false };
    let grid = if IN_STEPS.contains(&setting.key) { 1.0 / unit.step_rate_hz } else { 0.0 };
    Unknown { prior, step: stepped.step_si, grid, scan: stepped.scan_si }
}

/// Standard uncertainty of a setting of the twin, SI: of what was found, otherwise of the base's value.
fn known_u_si(key: &str, found: &Identified) -> f64 {
    let own = found.settings.iter().find(|own| own.key == key);
    let setting = setting(key);
    own.map_or_else(|| spread_si(setting, setting.get(&found.unit)), |own| own.value.u_si)
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
    for plot in plots {
        for series in plot.series.iter().filter(|series| (sought.shows)(plot, series)) {
            let is_scaled = (sought.is_scaled)(plot, series);
            let is_angle_deg = plot.y.unit == "deg";
            for ((x, &y), u) in series.x.iter().zip(&series.y).zip(&series.u) {
                if y.is_finite() && *u > 0.0 {
                    let name = format!("{} {} {x}", plot.id, series.label);
                    all.insert(name, Point { y, u: 0.5 * u, is_scaled, is_angle_deg });
                }
            }
        }
    }
    all
}
