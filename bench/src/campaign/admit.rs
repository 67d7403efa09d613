//! Before anything moves: who is there, whether people and calibrations allow the run, what it must hold alone.

use std::ops::Range;

use procedures::campaign::Claim;
use reports::record::{DeviceRecord, TitlePage};

use super::{RunError, Setup, point};
use crate::clock;
use crate::model::rig::Tier;
use crate::people::lock::{self, Held, Holder, LockError};
use crate::people::{self, Situation};
use crate::plan::CampaignPlan;
use crate::plan::calibration;
use crate::record::log::{SUFFIX, origin};
use crate::record::page::{Basis, KeptFile, Page, PageStage, PlannedLog};
use crate::record::polarity;

/// Why a law is not stepped in process outside virtual time.
const IN_PROCESS: &str = "an external law is stepped in process, where it may crash the bench or make its ticks late; \
                          allowed on a rig of tier virtual only";

/// What a run must hold before its rig is opened: another process may be speaking over the same wires.
///
/// # Errors
/// When somebody else holds one of them, or when the last run on the interface was lost and nobody has looked yet.
pub(super) fn hold_wires(setup: &Setup<'_>) -> Result<Held, LockError> {
    let folder = &setup.lock_folder;
    let lines = lock::claim(folder, &lock::lines(setup.rig), &Holder::run(&setup.folder))?;
    Ok(lock::take(folder, &lock::interfaces(setup.rig), &setup.folder)?.with_lines(lines))
}

/// Who is there, whether people allow the run, and what it must hold alone beside its wires.
///
/// `found` is the bus and its devices where a session has them open; otherwise the rig is opened once to learn it.
pub(super) fn admit(
    setup: &Setup<'_>,
    found: Option<(String, Vec<DeviceRecord>)>,
    wires: Held,
) -> Result<(Page, Held), RunError> {
    let (bus, devices) = found.map_or_else(|| point::identify(setup), Ok)?;
    let real = crate::rig::identities::real(&devices);
    let Setup { plan, unit, jobs, answers, .. } = setup;
    let wire_faults = wire_faults(setup);
    let situation = Situation { real: &real, unit, plan, jobs: *jobs, answers, wire_faults: &wire_faults };
    let mut refusals = people::refusals(&situation);
    if setup.rig.tier != Tier::Virtual && setup.laws.any_in_process() {
        refusals.push(IN_PROCESS.to_owned());
    }
    refusals.extend(calibration::refusals(setup.rig, &real, &clock::today()));
    if !refusals.is_empty() {
        return Err(RunError::Refused(refusals.join("\n  and: ")));
    }
    let held = wires.take_more(&setup.lock_folder, &lock::rig_itself(setup.rig, &bus, &devices))?;
    Ok((title_page(setup, devices)?, held))
}

fn title_page(setup: &Setup<'_>, devices: Vec<DeviceRecord>) -> Result<Page, RunError> {
    let plan = setup.plan;
    let rig = KeptFile::of(&setup.rig.source);
    let unit_files: Vec<KeptFile> = setup.unit.sources.iter().map(KeptFile::of).collect();
    let real = devices.iter().any(|device| device.may_be_real);
    let unit: Vec<String> = unit_files.iter().map(|file| file.text.clone()).collect();
    let laws = setup.laws.records();
    let polarity = Basis::new(&devices, &unit, &rig.text, setup.gains, &laws);
    if let Some(earlier) = &setup.polarity {
        polarity::accept(earlier, &polarity).map_err(RunError::Refused)?;
    }
    let started_utc = clock::utc_now();
    let instruments = calibration::records(setup.rig, &clock::today());
    Ok(Page {
        schema: 1,
        campaign: plan.id.clone(),
        title: plan.title.clone(),
        partial: plan.partial,
        left_out: plan.left_out.clone(),
        campaign_file: plan.source.as_ref().map(KeptFile::of),
        requirements: KeptFile::of(&plan.requirements_source),
        must_measure: plan.must_measure.clone(),
        // Who selects asks for a verdict on what he selects.
        claim: if plan.partial { Claim::Acceptance } else { plan.claim },
        rig,
        rig_id: setup.rig.id.clone(),
        unit: setup.unit.id.clone(),
        unit_files,
        seed: setup.seed,
        origin: origin(&devices),
        devices,
        polarity,
        stages: stages(plan),
        procedures: logs(plan),
        instruments,
        grants: Vec::new(),
        title_page: TitlePage::default(),
        operator: setup.operator.clone(),
        serial_number: setup.serial_number.clone(),
        command_line: setup.command_line.clone(),
        jobs: if real || setup.site.keeps_session() { 1 } else { setup.jobs.unwrap_or_else(processors) },
        wire_faults: wire_faults(setup),
        laws,
        started_utc,
    })
}

/// Faults that are planted on the wire, as they were asked for.
fn wire_faults(setup: &Setup<'_>) -> Vec<String> {
    setup.site.wire_faults().map(|faults| faults.asked().to_vec()).unwrap_or_default()
}

/// Processors of this machine that the program may use.
pub(crate) fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The procedures of a plan with the names of their logs.
fn logs(plan: &CampaignPlan) -> Vec<PlannedLog> {
    let logs = plan.procedures.iter().map(|p| PlannedLog {
        id: p.procedure.id.clone(),
        title: p.procedure.title.clone(),
        kind: p.procedure.kind.to_owned(),
        axis: p.procedure.axis.clone(),
        log: format!("{}{SUFFIX}", p.procedure.id),
        yields: p.procedure.yields.iter().map(|&name| name.to_owned()).collect(),
        closes_loops: p.closes_loops(),
        stage: plan.stage_of(p).map(|s| s.stage.id.clone()),
        state: plan.state_of(p).map(|s| s.id.clone()),
        planned_s: Some(p.planned_s()),
    });
    logs.collect()
}

/// The stages of a plan.
fn stages(plan: &CampaignPlan) -> Vec<PageStage> {
    let ids = |named: &[(String, Range<usize>)]| named.iter().map(|(id, _)| id.clone()).collect();
    let stages = plan.stages.iter().map(|s| PageStage {
        id: s.stage.id.clone(),
        title: s.stage.title.clone(),
        state: s.state.as_ref().map(|state| KeptFile::of(&state.source)),
        needs: ids(&s.stage.needs),
        needs_pass: ids(&s.stage.needs_pass),
    });
    stages.collect()
}
