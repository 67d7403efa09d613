//! Before anything moves: who is there, whether people and calibrations allow the run, what it must hold alone.

use reports::record::{DeviceRecord, TitlePage};

use super::{RunError, Setup, point};
use crate::lock::{self, Held};
use crate::page::Page;
use crate::people::{self, Situation};
use crate::polarity::{self, Basis};
use crate::{calibration, clock};

/// Who is there, whether people allow the run, and what it must hold alone.
///
/// `found` is the bus and its devices where a session has them open; otherwise the rig is opened once to learn it.
pub(super) fn admit(
    setup: &Setup<'_>,
    found: Option<(String, Vec<DeviceRecord>)>,
) -> Result<(Page, Held), RunError> {
    let (bus, devices) = found.map_or_else(|| point::identify(setup), Ok)?;
    let real = crate::devices::real(&devices);
    let Setup { plan, unit, jobs, answers, .. } = setup;
    let mut refusals = people::refusals(&Situation { real: &real, unit, plan, jobs: *jobs, answers });
    refusals.extend(calibration::refusals(setup.rig, &real, &clock::today()));
    if !refusals.is_empty() {
        return Err(RunError::Refused(refusals.join("\n  and: ")));
    }
    let held = lock::take(&setup.lock_folder, &lock::resources(setup.rig, &bus, &devices), &setup.folder)?;
    Ok((title_page(setup, devices)?, held))
}

fn title_page(setup: &Setup<'_>, devices: Vec<DeviceRecord>) -> Result<Page, RunError> {
    let (campaign_file, requirements, rig, unit_files) = Page::kept_files(setup.plan, setup.rig, setup.unit);
    let real = devices.iter().any(|device| device.may_be_real);
    let unit: Vec<String> = unit_files.iter().map(|file| file.text.clone()).collect();
    let polarity = Basis::new(&devices, &unit, &rig.text, setup.gains);
    if let Some(earlier) = &setup.polarity {
        polarity::accept(earlier, &polarity).map_err(RunError::Refused)?;
    }
    let started_utc = clock::utc_now();
    let instruments = calibration::records(setup.rig, &clock::today());
    Ok(Page {
        schema: 1,
        campaign: setup.plan.id.clone(),
        title: setup.plan.title.clone(),
        partial: setup.plan.partial,
        left_out: setup.plan.left_out.clone(),
        campaign_file,
        requirements,
        must_measure: setup.plan.must_measure.clone(),
        rig,
        rig_id: setup.rig.id.clone(),
        unit: setup.unit.id.clone(),
        unit_files,
        seed: setup.seed,
        origin: crate::devices::origin(&devices),
        devices,
        polarity,
        stages: Page::stages(setup.plan),
        procedures: Page::logs(setup.plan),
        instruments,
        title_page: TitlePage::default(),
        operator: setup.operator.clone(),
        serial_number: setup.serial_number.clone(),
        command_line: setup.command_line.clone(),
        jobs: if real || setup.site.keeps_session() { 1 } else { setup.jobs.unwrap_or_else(processors) },
        started_utc,
    })
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
