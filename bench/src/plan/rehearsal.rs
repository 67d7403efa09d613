//! Whether a planned run would begin: gains, build states, calibrations, and every device opened once on simulated wires
//! in each way in which a point wants it. Nothing moves, nothing real is touched.

use std::collections::BTreeSet;

use procedures::case::Case;
use procedures::diagnostic::Diagnostic;

use crate::clock::{self, Clock};
use crate::files::parameters;
use crate::model::rig::Rig;
use crate::plan::calibration;
use crate::plan::{CampaignPlan, PlanError};
use crate::rig::PointSettings;
use crate::site::unit::Unit;
use crate::site::{Purpose, Site, VirtualSite, check_scenery};

/// Everything that a run of this plan on this rig and unit would be refused for before its first motion, as far as files
/// say: who answers prompts, and whether the rig is free, only the run itself can know.
///
/// # Errors
/// See [`PlanError`].
pub(crate) fn rehearse(plan: &CampaignPlan, rig: &Rig, unit: &Unit) -> Result<(), PlanError> {
    let built = plan.units(unit)?;
    let gains = parameters::load(rig)?;
    let site = VirtualSite::new(unit, &built);
    let overdue = calibration::refusals(rig, &[], &clock::today());
    let mut refusals: Vec<Diagnostic> =
        overdue.into_iter().map(|reason| Diagnostic::new(reason).in_file(&rig.source)).collect();
    let mut opened = BTreeSet::new();
    for planned in &plan.procedures {
        let rig_file = planned.on(rig);
        for case in &planned.cases {
            if let Err(error) = check_scenery(unit, case) {
                let message = format!("{}: {error}", planned.procedure.id);
                refusals.push(Diagnostic::new(message).in_file(&rig.source));
                break;
            }
            if !opened.insert((planned.stage, wants(case))) {
                continue;
            }
            let purpose = Purpose { seed: 1, procedure: "check", stage: planned.stage, ..Purpose::default() };
            let opened =
                site.open(rig_file, &gains, &purpose).and_then(|session| session.rig.arm(&session.clock));
            let settings = PointSettings::for_case(rig_file, case);
            let changed = opened.and_then(|mut rig| rig.change_before_ticks(&settings, &Clock::Virtual));
            if let Err(error) = changed {
                let message = format!("{}, point `{}`: {error}", planned.procedure.id, case.point);
                let help =
                    "a run would fail here, after opening its devices: make rig file and unit file agree";
                refusals.push(Diagnostic::new(message).in_file(&rig.source).help(help));
                // Every other point would say the same.
                return Err(PlanError::Refused(refusals));
            }
        }
    }
    if refusals.is_empty() { Ok(()) } else { Err(PlanError::Refused(refusals)) }
}

/// What a point wants of the devices beside what the rig file says.
fn wants(case: &Case) -> String {
    let Case { axis, mirror_channel, fine_frame_rate_hz, torque_limit_nm, fence, .. } = case;
    let limits = fence.as_ref().map(|fence| (&fence.bench_rad, &fence.drive_rad));
    format!("{axis} {mirror_channel:?} {fine_frame_rate_hz:?} {torque_limit_nm:?} {limits:?}")
}
