//! Stages, build states, questions and instruments, as `bench plan` prints them.

use crate::cli::output;
use crate::model::instrument::Calibration;
use crate::model::rig::Rig;
use crate::plan::{CampaignPlan, PlannedProcedure};

/// The stages of a plan in order, and what is asked of people; nothing where there are none.
pub(super) fn text(plan: &CampaignPlan) -> Vec<String> {
    let mut lines = Vec::new();
    if !plan.stages.is_empty() {
        lines.push("stages (if a stage is not successful, the stages that need it are skipped)".to_owned());
        lines.push(output::table(&rows(plan)));
        for stage in &plan.stages {
            let waived = stage.waived.iter().map(|gate| {
                format!("- `{}` does not wait for {gate}, which is not in this selection", stage.stage.id)
            });
            lines.extend(waived);
        }
        lines.push(String::new());
    }
    let questions = plan.questions();
    if !questions.is_empty() {
        lines.push("questions to the operator".to_owned());
        let row = |asked: &crate::plan::Asked<'_>| {
            let class = asked.prompt.class.word();
            let note = if asked.brought { " (with simulated devices the bench answers)" } else { "" };
            vec![
                asked.owner.to_owned(),
                asked.prompt.id.clone(),
                class.to_owned(),
                format!("{}{note}", asked.prompt.text),
            ]
        };
        lines.push(output::table(&questions.iter().map(row).collect::<Vec<_>>()));
        lines.push(String::new());
    }
    lines
}

fn rows(plan: &CampaignPlan) -> Vec<Vec<String>> {
    let head = ["stage", "build state", "needs", "must pass", "procedures", "duration"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    let or_dash = |texts: Vec<&str>| if texts.is_empty() { "-".to_owned() } else { texts.join(" ") };
    for (index, planned) in plan.stages.iter().enumerate() {
        let stage = &planned.stage;
        let own: Vec<&PlannedProcedure> = plan.procedures.iter().filter(|p| p.stage == Some(index)).collect();
        let state =
            planned.state.as_ref().map_or("final".to_owned(), |state| format!("{}: not judged", state.id));
        rows.push(vec![
            stage.id.clone(),
            state,
            or_dash(stage.needs.iter().map(|(id, _)| id.as_str()).collect()),
            or_dash(stage.needs_pass.iter().map(|(id, _)| id.as_str()).collect()),
            own.iter().map(|p| p.procedure.id.as_str()).collect::<Vec<_>>().join(" "),
            format!("{:.0} s", own.iter().map(|p| p.planned_s()).sum::<f64>()),
        ]);
    }
    rows
}

/// Instruments of the rig and until when they may be believed.
pub(super) fn instruments(rig: &Rig) -> Vec<String> {
    if rig.instruments.is_empty() {
        return Vec::new();
    }
    let row = |i: &crate::model::instrument::Instrument| {
        let until = match &i.calibration {
            Calibration::Simulated => "simulated".to_owned(),
            Calibration::Certified { certificate, due, .. } => {
                format!("until {due}, certificate {certificate}")
            }
        };
        vec![i.name.clone(), i.role.clone(), until]
    };
    let rows: Vec<Vec<String>> = rig.instruments.iter().map(row).collect();
    vec!["\ninstruments".to_owned(), output::table(&rows)]
}
