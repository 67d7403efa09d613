//! From names on the command line to everything that a run needs, checked: nothing moves before this succeeds.

use procedures::campaign::{self, Campaign, Claim};
use procedures::case::Case;
use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::procedure::{Procedure, Subset};
use procedures::requirement::Requirements;

use crate::files::shipped::{self, Folder, sort};
use crate::model::rig::Rig;
use crate::model::signs;

pub(crate) mod calibration;
mod conditions;
mod fitting;
pub(crate) mod phases;
pub(crate) mod preflight;
pub(crate) mod rehearsal;
mod select;
mod stages;

use fitting::fit;
use select::select;
#[cfg(test)]
pub(crate) use stages::tests::staged;
pub use stages::{Asked, PlannedStage};

/// One procedure, planned.
#[derive(Debug)]
pub struct PlannedProcedure {
    /// The procedure.
    pub procedure: Procedure,
    /// Points of the procedure.
    pub cases: Vec<Case>,
    /// What the campaign keeps of its sweep.
    pub subsets: Vec<Subset>,
    /// Index of its stage in the plan.
    pub stage: Option<usize>,
    /// The rig in the build state of its stage, where something of it differs.
    pub rig: Option<Box<Rig>>,
}

impl PlannedProcedure {
    /// Whether any of its points closes a loop: signs and scales must then be proven before.
    pub fn closes_loops(&self) -> bool {
        self.cases.iter().any(|case| !case.open_loop)
    }

    /// Whether signs and scales must be proven before it begins.
    pub fn needs_polarity(&self) -> bool {
        self.procedure.kind != signs::POLARITY && self.closes_loops()
    }

    /// The rig as it is in its build state.
    pub fn on<'a>(&'a self, rig: &'a Rig) -> &'a Rig {
        self.rig.as_deref().unwrap_or(rig)
    }

    /// What its file asks for and the axis has no room for, a sentence each.
    pub fn cuts(&self, rig: &Rig) -> Vec<String> {
        self.procedure.experiment.cuts(&self.procedure.axis, &self.on(rig).limits())
    }

    /// Longest duration of all its points, s.
    pub fn planned_s(&self) -> f64 {
        self.cases.iter().map(Case::planned_s).sum()
    }
}

/// A campaign with all its files read and its points planned.
#[derive(Debug)]
pub struct CampaignPlan {
    /// Campaign id.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Only a part of it.
    pub partial: bool,
    /// Ids that must get a verdict.
    pub must_measure: Vec<String>,
    /// What the campaign claims; a part of one claims to verify what it measures.
    pub claim: Claim,
    /// Requirements.
    pub requirements: Requirements,
    /// File of the requirements.
    pub requirements_source: SourceFile,
    /// The campaign's file; `None` where single procedures were named.
    pub source: Option<SourceFile>,
    /// Stages in order; empty where there are none.
    pub stages: Vec<PlannedStage>,
    /// Procedures in order, stage by stage.
    pub procedures: Vec<PlannedProcedure>,
    /// What the rig lacks a device for, and what that costs, a sentence each; empty unless it was asked to be left out.
    pub left_out: Vec<String>,
}

/// What the person asked for.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Campaigns or procedures; `quick` if empty.
    pub names: Vec<String>,
    /// Another requirements file.
    pub requirements: Option<String>,
    /// Requirement ids, procedure ids, stages, axes or kinds to keep.
    pub select: Vec<String>,
    /// Polarity was proven by an earlier run: it need not be checked first.
    pub polarity_proven: bool,
    /// Procedures that need a device that the rig lacks are left out; otherwise they are refused.
    pub skip_missing: bool,
}

/// Mistakes in files, or nothing that fits the selection.
#[derive(Debug)]
pub enum PlanError {
    /// Mistakes in files: exit 2.
    Mistakes(Vec<Diagnostic>),
    /// The files are right, but the rig does not allow what they ask: exit 2 in `check` and `plan`, 6 in `run`.
    Refused(Vec<Diagnostic>),
    /// Exit 5.
    NothingSelected(String),
}

impl PlanError {
    /// What is wrong, for those to whom the kind of mistake makes no difference.
    pub(crate) fn diagnostics(self) -> Vec<Diagnostic> {
        match self {
            Self::Mistakes(found) | Self::Refused(found) => found,
            Self::NothingSelected(message) => vec![Diagnostic::new(message)],
        }
    }
}

impl From<Vec<Diagnostic>> for PlanError {
    fn from(mistakes: Vec<Diagnostic>) -> Self {
        Self::Mistakes(mistakes)
    }
}

/// Reads and plans everything.
///
/// # Errors
/// All mistakes of all files at once; or that nothing fits the selection.
pub fn plan(wanted: &Wanted, rig: &Rig) -> Result<CampaignPlan, PlanError> {
    let mut mistakes = Vec::new();
    let read = read_campaign(wanted, &mut mistakes)?;
    let requirements = find_requirements(wanted, &read)
        .and_then(|source| Requirements::parse(&source).map(|requirements| (requirements, source)));
    let requirements = keep(requirements, &mut mistakes);
    let stages = read.campaign.as_ref().map_or_else(|| Ok(Vec::new()), stages::read);
    let stages = keep(stages, &mut mistakes).unwrap_or_default();
    let Read { campaign, procedures, entries } = read;
    let planned = plan_all(procedures, &entries, &stages, rig);
    if let (Some(campaign), Some((requirements, _))) = (&campaign, &requirements) {
        // What a procedure's own file has wrong comes first: that nothing yields a measurand may be its consequence.
        let sound = planned.as_ref().ok().filter(|_| mistakes.is_empty());
        let own = sound.map(|all| all.iter().map(|planned| &planned.procedure).collect());
        let of_campaign = campaign::check(campaign, own, requirements);
        mistakes.extend(of_campaign);
    }
    let (Some((requirements, source)), true) = (requirements, mistakes.is_empty()) else {
        mistakes.extend(match planned {
            Err(PlanError::Mistakes(found) | PlanError::Refused(found)) => found,
            _ => Vec::new(),
        });
        return Err(mistakes.into());
    };
    let procedures = planned?;
    let asked = campaign.as_ref().map(|c| c.must_measure(&requirements)).unwrap_or_default();
    let nothing = conditions::met_nowhere(&requirements, &source, &asked, &procedures);
    if !nothing.is_empty() {
        return Err(nothing.into());
    }
    if let Some(twice) = same_id(&procedures) {
        return Err(vec![twice].into());
    }
    let single = procedures.first().map_or("run", |p| p.procedure.id.as_str()).to_owned();
    let (id, title) = campaign.as_ref().map_or((single.clone(), single), |c| (c.id.clone(), c.title.clone()));
    let whole = CampaignPlan {
        id,
        title,
        partial: campaign.is_none(),
        must_measure: asked,
        claim: campaign.as_ref().map(|c| c.claim).unwrap_or_default(),
        requirements,
        requirements_source: source,
        source: campaign.map(|c| c.source),
        stages,
        procedures,
        left_out: Vec::new(),
    };
    let mut plan = fit(select(whole, &wanted.select)?, rig, wanted.skip_missing)?;
    polarity_first(&mut plan, rig, wanted.polarity_proven)?;
    if let Some(circle) = plan.circle() {
        return Err(vec![circle].into());
    }
    // What is not selected does not move.
    let unsafe_ones = preflight::refusals(&plan.procedures, rig);
    if unsafe_ones.is_empty() { Ok(plan) } else { Err(PlanError::Refused(unsafe_ones)) }
}

/// Puts the shipped check of polarity in front of a plan that closes loops and does not check it itself. In a build
/// state before the final one a campaign has a check of its own: what is rebuilt may be wired another way, and an earlier
/// run's proof is of the final state.
fn polarity_first(plan: &mut CampaignPlan, rig: &Rig, proven: bool) -> Result<(), PlanError> {
    let state = |p: &PlannedProcedure| plan.state_of(p).map(|state| state.id.clone());
    let checks = |p: &&PlannedProcedure| p.procedure.kind == signs::POLARITY;
    let checked: Vec<_> = plan.procedures.iter().filter(checks).map(state).collect();
    let relies = |p: &&PlannedProcedure| p.needs_polarity() && !checked.contains(&state(p));
    let early = plan.procedures.iter().filter(relies).find(|p| state(p).is_some());
    if let Some(early) = early {
        let state = state(early).unwrap_or_default();
        let message = format!(
            "{} closes loops in build state `{state}`, but no procedure checks polarity in that state",
            early.procedure.id
        );
        let help = "add a procedure of the kind `polarity` to that stage".to_owned();
        return Err(vec![Diagnostic::new(message).help(help)].into());
    }
    if !proven && plan.procedures.iter().any(|p| relies(&p)) {
        let planned = plan_all(vec![shipped_check(rig)?], &[Kept::default()], &[], rig)?;
        plan.procedures.splice(0..0, planned);
    }
    Ok(())
}

/// The shipped check of polarity; on a rig without the axis that it names it begins with the rig's first axis.
fn shipped_check(rig: &Rig) -> Result<Procedure, Vec<Diagnostic>> {
    let source = shipped::find(Folder::Procedures, signs::POLARITY, None)?;
    let check = Procedure::parse(source.clone())?;
    let first = rig.axes.first().filter(|_| rig.axis_index(&check.axis).is_none());
    let Some(first) = first else { return Ok(check) };
    let line = |axis: &str| format!("axis = \"{axis}\"");
    let text = source.text.replacen(&line(&check.axis), &line(&first.name), 1);
    Procedure::parse(SourceFile { text, ..source })
}

fn same_id(procedures: &[PlannedProcedure]) -> Option<Diagnostic> {
    let ids: Vec<&str> = procedures.iter().map(|p| p.procedure.id.as_str()).collect();
    let twice = (1..ids.len()).find(|&i| ids[..i].contains(&ids[i]))?;
    let message = format!("two procedures have the id `{}`", ids[twice]);
    Some(
        Diagnostic::new(message)
            .help("logs are named after the id: run the procedures one after the other, or rename one"),
    )
}

/// Plans every procedure on the rig as its build state has it.
fn plan_all(
    procedures: Vec<Procedure>,
    kept: &[Kept],
    stages: &[PlannedStage],
    rig: &Rig,
) -> Result<Vec<PlannedProcedure>, PlanError> {
    let mut planned = Vec::new();
    let mut refusals = Vec::new();
    for (procedure, kept) in procedures.into_iter().zip(kept) {
        let stage = kept.stage.and_then(|index| stages.get(index));
        let built = stage.map_or(Ok(None), |stage| stage.rig(rig))?;
        let limits = built.as_deref().unwrap_or(rig).limits();
        if let Some(cases) = keep(procedure.plan(&limits, &kept.subsets), &mut refusals) {
            let Kept { subsets, stage } = kept.clone();
            planned.push(PlannedProcedure { procedure, cases, subsets, stage, rig: built });
        }
    }
    if refusals.is_empty() { Ok(planned) } else { Err(PlanError::Refused(refusals)) }
}

/// What a campaign says of one of its procedures.
#[derive(Clone, Debug, Default)]
struct Kept {
    subsets: Vec<Subset>,
    stage: Option<usize>,
}

/// Files as read; a procedure and what is kept of it have the same index.
#[derive(Default)]
struct Read {
    campaign: Option<Campaign>,
    procedures: Vec<Procedure>,
    entries: Vec<Kept>,
}

impl Read {
    fn add(&mut self, procedure: Option<Procedure>, kept: Kept) {
        if let Some(procedure) = procedure {
            self.procedures.push(procedure);
            self.entries.push(kept);
        }
    }
}

fn read_campaign(wanted: &Wanted, mistakes: &mut Vec<Diagnostic>) -> Result<Read, Vec<Diagnostic>> {
    let names = if wanted.names.is_empty() { vec!["quick".to_owned()] } else { wanted.names.clone() };
    let mut all = Read::default();
    for name in &names {
        let source = shipped::find(Folder::Procedures, name, None)
            .and_then(|source| sort::expect(source, Folder::Procedures))?;
        if !is_campaign(&source) {
            all.add(keep(Procedure::parse(source), mistakes), Kept::default());
            continue;
        }
        if names.len() > 1 {
            let message = format!("`{name}` is a campaign: run one campaign, or any number of procedures");
            return Err(vec![Diagnostic::new(message).help("start one run per campaign")]);
        }
        let Some(read) = keep(Campaign::parse(source), mistakes) else { continue };
        for entry in &read.procedures {
            let found = shipped::find(Folder::Procedures, &entry.file, Some(&read.source.name))
                .and_then(|source| sort::expect(source, Folder::Procedures))
                .map_err(|found| pointed(found, &read.source, &entry.span));
            let Some(file) = keep(found, mistakes) else { continue };
            let kept = Kept { subsets: entry.points.clone(), stage: entry.stage };
            all.add(keep(Procedure::parse(file), mistakes), kept);
        }
        all.campaign = Some(read);
    }
    Ok(all)
}

fn pointed(found: Vec<Diagnostic>, source: &SourceFile, span: &std::ops::Range<usize>) -> Vec<Diagnostic> {
    found.into_iter().map(|d| if d.file.is_none() { d.at(source, span.clone()) } else { d }).collect()
}

/// A campaign is a file with `[[procedure]]` entries; a procedure has a `kind`.
pub fn is_campaign(source: &SourceFile) -> bool {
    let starts = |key: &str| source.text.lines().any(|l| l.trim_start().starts_with(key));
    starts("[[procedure]]") || starts("must-measure") || (starts("requirements") && !starts("kind"))
}

fn find_requirements(wanted: &Wanted, read: &Read) -> Result<SourceFile, Vec<Diagnostic>> {
    let find = |name: &str, beside: Option<&str>| {
        shipped::find(Folder::Requirements, name, beside)
            .and_then(|source| sort::expect(source, Folder::Requirements))
    };
    match (&wanted.requirements, &read.campaign) {
        (Some(name), _) => find(name, None),
        (None, Some(Campaign { requirements, requirements_span, source, .. })) => {
            find(requirements, Some(&source.name)).map_err(|found| pointed(found, source, requirements_span))
        }
        (None, None) => find("requirements", None),
    }
}

fn keep<T>(result: Result<T, Vec<Diagnostic>>, mistakes: &mut Vec<Diagnostic>) -> Option<T> {
    match result {
        Ok(value) => Some(value),
        Err(found) => {
            mistakes.extend(found);
            None
        }
    }
}
