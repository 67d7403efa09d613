//! From names on the command line to everything that a run needs, checked: nothing moves before this succeeds.

use procedures::campaign::{self, Campaign, Subset};
use procedures::case::Case;
use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::procedure::Procedure;
use procedures::requirement::Requirements;

use crate::files::rig::Rig;
use crate::files::shipped::{self, Folder};
use crate::polarity;
use crate::preflight;

/// One procedure, planned.
#[derive(Debug)]
pub struct PlannedProcedure {
    /// The procedure.
    pub procedure: Procedure,
    /// Its points.
    pub cases: Vec<Case>,
    /// What the campaign keeps of its sweep.
    pub subsets: Vec<Subset>,
}

impl PlannedProcedure {
    /// Whether any of its points closes a loop: signs and scales must then be proven before.
    pub fn closes_loops(&self) -> bool {
        self.cases.iter().any(|case| !case.open_loop)
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
    /// Requirements.
    pub requirements: Requirements,
    /// Their file.
    pub requirements_source: SourceFile,
    /// The campaign's file; `None` where single procedures were named.
    pub source: Option<SourceFile>,
    /// Procedures in order.
    pub procedures: Vec<PlannedProcedure>,
}

/// What the person asked for.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Campaigns or procedures; `quick` if empty.
    pub names: Vec<String>,
    /// Another requirements file.
    pub requirements: Option<String>,
    /// Requirement ids, procedure ids, axes or kinds to keep.
    pub select: Vec<String>,
    /// Polarity was proven by an earlier run: it need not be checked first.
    pub polarity_proven: bool,
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
    let source = find_requirements(wanted, &read)?;
    let requirements = keep(Requirements::parse(&source), &mut mistakes);
    let Some(requirements) = requirements else { return Err(mistakes.into()) };
    if let Some(campaign) = &read.campaign {
        mistakes.extend(campaign::check(campaign, &read.procedures, &requirements));
    }
    if !mistakes.is_empty() {
        return Err(mistakes.into());
    }
    if let Some(twice) = same_id(&read.procedures) {
        return Err(vec![twice].into());
    }
    let procedures = plan_all(read.procedures, read.subsets, rig)?;
    let unsafe_ones = preflight::refusals(&procedures, rig);
    if !unsafe_ones.is_empty() {
        return Err(PlanError::Refused(unsafe_ones));
    }
    let single = procedures.first().map_or("run", |p| p.procedure.id.as_str()).to_owned();
    let (id, title) =
        read.campaign.as_ref().map_or((single.clone(), single), |c| (c.id.clone(), c.title.clone()));
    let whole = CampaignPlan {
        id,
        title,
        partial: read.campaign.is_none(),
        must_measure: read.campaign.as_ref().map(|c| c.must_measure.clone()).unwrap_or_default(),
        requirements,
        requirements_source: source,
        source: read.campaign.map(|c| c.source),
        procedures,
    };
    let mut plan = select(whole, &wanted.select)?;
    if !wanted.polarity_proven {
        polarity_first(&mut plan, rig)?;
    }
    Ok(plan)
}

/// Puts the shipped check of polarity in front of a plan that closes loops and does not check it itself.
fn polarity_first(plan: &mut CampaignPlan, rig: &Rig) -> Result<(), PlanError> {
    let checked = plan.procedures.iter().any(|p| p.procedure.kind == polarity::KIND);
    if checked || !plan.procedures.iter().any(PlannedProcedure::closes_loops) {
        return Ok(());
    }
    let check = Procedure::parse(shipped::find(Folder::Procedures, polarity::KIND, None)?)?;
    let planned = plan_all(vec![check], vec![Vec::new()], rig)?;
    plan.procedures.splice(0..0, planned);
    Ok(())
}

fn same_id(procedures: &[Procedure]) -> Option<Diagnostic> {
    let twice = (1..procedures.len()).find(|&i| procedures[..i].iter().any(|p| p.id == procedures[i].id))?;
    let message = format!("two procedures have the id `{}`", procedures[twice].id);
    Some(
        Diagnostic::new(message)
            .help("logs are named after the id: run them one after the other, or rename one"),
    )
}

/// Plans every procedure on the rig.
fn plan_all(
    procedures: Vec<Procedure>,
    subsets: Vec<Vec<Subset>>,
    rig: &Rig,
) -> Result<Vec<PlannedProcedure>, PlanError> {
    let (mut planned, mut refusals) = (Vec::new(), Vec::new());
    for (procedure, subsets) in procedures.into_iter().zip(subsets) {
        if let Some(cases) = keep(procedure.plan(&rig.limits(), &subsets), &mut refusals) {
            planned.push(PlannedProcedure { procedure, cases, subsets });
        }
    }
    if refusals.is_empty() { Ok(planned) } else { Err(PlanError::Refused(refusals)) }
}

/// Files as read; a procedure and its subset have the same index.
#[derive(Default)]
struct Read {
    campaign: Option<Campaign>,
    procedures: Vec<Procedure>,
    subsets: Vec<Vec<Subset>>,
}

impl Read {
    fn add(&mut self, procedure: Option<Procedure>, subsets: &[Subset]) {
        if let Some(procedure) = procedure {
            self.procedures.push(procedure);
            self.subsets.push(subsets.to_vec());
        }
    }
}

fn read_campaign(wanted: &Wanted, mistakes: &mut Vec<Diagnostic>) -> Result<Read, Vec<Diagnostic>> {
    let names = if wanted.names.is_empty() { vec!["quick".to_owned()] } else { wanted.names.clone() };
    let mut all = Read::default();
    for name in &names {
        let source = shipped::find(Folder::Procedures, name, None)?;
        if !is_campaign(&source) {
            all.add(keep(Procedure::parse(source), mistakes), &[]);
            continue;
        }
        if names.len() > 1 {
            let message = format!("`{name}` is a campaign: run one campaign, or any number of procedures");
            return Err(vec![Diagnostic::new(message).help("start one run for each campaign")]);
        }
        let Some(read) = keep(Campaign::parse(source), mistakes) else { continue };
        for entry in &read.procedures {
            let found = shipped::find(Folder::Procedures, &entry.file, Some(&read.source.name))
                .map_err(|found| pointed(found, &read.source, &entry.span));
            let Some(file) = keep(found, mistakes) else { continue };
            all.add(keep(Procedure::parse(file), mistakes), &entry.points);
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
    match (&wanted.requirements, &read.campaign) {
        (Some(name), _) => shipped::find(Folder::Procedures, name, None),
        (None, Some(campaign)) => {
            shipped::find(Folder::Procedures, &campaign.requirements, Some(&campaign.source.name))
        }
        (None, None) => shipped::find(Folder::Procedures, "requirements", None),
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

/// Keeps the procedures that a selection means: by requirement id, procedure id, axis or kind.
fn select(mut plan: CampaignPlan, select: &[String]) -> Result<CampaignPlan, PlanError> {
    if select.is_empty() {
        return Ok(plan);
    }
    let means = |p: &PlannedProcedure, word: &str| {
        let procedure = &p.procedure;
        let by_requirement = plan.requirements.get(word).is_some_and(|r| serves(procedure, r));
        procedure.id == word || procedure.axis == word || procedure.kind == word || by_requirement
    };
    for word in select {
        if !plan.procedures.iter().any(|p| means(p, word)) {
            let message =
                format!("--select {word}: no procedure, axis, kind or requirement of `{}`", plan.id);
            return Err(PlanError::NothingSelected(message));
        }
    }
    let kept: Vec<bool> = plan.procedures.iter().map(|p| select.iter().any(|w| means(p, w))).collect();
    let mut flags = kept.iter();
    plan.procedures.retain(|_| *flags.next().unwrap_or(&false));
    let (requirements, procedures) = (&plan.requirements, &plan.procedures);
    // A requirement counts when it was named, or when procedures that were named otherwise serve it.
    let whole = |p: &&PlannedProcedure| {
        let p = &p.procedure;
        select.iter().any(|w| p.id == *w || p.axis == *w || p.kind == w)
    };
    plan.must_measure.retain(|id| {
        let served = |r| procedures.iter().filter(whole).any(|p| serves(&p.procedure, r));
        select.contains(id) || requirements.get(id).is_some_and(served)
    });
    plan.partial = true;
    Ok(plan)
}

fn serves(procedure: &Procedure, requirement: &procedures::requirement::Requirement) -> bool {
    let yields = procedure.experiment.yields();
    requirement.axis.as_ref().is_none_or(|axis| *axis == procedure.axis)
        && requirement.measurands().any(|m| yields.contains(&m))
}
