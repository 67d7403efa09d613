//! Prompts: answered before each point, and before points only.

use std::sync::mpsc::Sender;
use std::sync::{Arc, PoisonError};

use procedures::procedure::{Prompt, PromptClass};

use super::Shared;
use crate::cycle::prompt::{Answer, Question};
use crate::people::Denied;
use crate::people::event::{RunEvent, Shown};
use crate::plan::Asked;
use crate::record::journal::Entry;

/// Has the prompts of a procedure and of its stage answered; called before each point, because an answer may have
/// become too old.
pub(super) fn ask(shared: &Shared<'_>, index: usize, events: &Sender<RunEvent>) -> Result<(), Denied> {
    let plan = shared.setup.plan;
    let asked = plan.asked(&plan.procedures[index]);
    if asked.is_empty() {
        return Ok(());
    }
    put(shared, &asked, events)
}

/// Name of the question after a trip.
const LOOKED_AT: &str = "looked-at";

/// After a trip or a failure in a session: has somebody confirm that they have looked at the rig.
pub(super) fn ask_for_a_look(
    shared: &Shared<'_>,
    procedure: &str,
    events: &Sender<RunEvent>,
) -> Result<(), Denied> {
    let why = shared.why_halted.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let prompt = Prompt {
        id: LOOKED_AT.to_owned(),
        class: PromptClass::Safety,
        text: format!("{why}. Inspect the rig: may {procedure} begin?"),
        simulated: false,
    };
    shared.desk.lock().unwrap_or_else(PoisonError::into_inner).forget(LOOKED_AT);
    put(shared, &[Asked { owner: procedure, prompt: &prompt, brought: false, wait_s: 0.0 }], events)
}

fn put(shared: &Shared<'_>, asked: &[Asked<'_>], events: &Sender<RunEvent>) -> Result<(), Denied> {
    let mut desk = shared.desk.lock().unwrap_or_else(PoisonError::into_inner);
    let mut kept = true;
    let said = desk.clear(
        asked,
        &shared.setup.stop,
        &mut |owner, text| {
            let shown = Shown::default();
            let _ =
                events.send(RunEvent::Question { text: format!("{owner}: {text}"), shown: shown.clone() });
            shown
        },
        &mut |entry| {
            if let Entry::Answered { procedure, prompt, answer, by, how, .. } = &entry {
                let _ = events.send(RunEvent::Answered {
                    asked_by: procedure.clone(),
                    prompt: prompt.clone(),
                    answer: answer.clone(),
                    by: format!("{by} ({how})"),
                });
            }
            kept &= matches!(shared.journal.lock().map(|mut j| j.write(entry)), Ok(Ok(())));
        },
    );
    // Nobody may rely on an answer that is not on record.
    if kept { said } else { Err(Denied::Refused("an answer cannot be written into the journal".to_owned())) }
}

/// In virtual time nobody can be waited for: every prompt was answered before the point began, or it does not begin.
pub(super) fn answered(asked: &[Asked<'_>]) -> Arc<[Question]> {
    let answered = |asked: &Asked<'_>| {
        let question = Question::new(asked.prompt.class);
        question.give(Answer::Confirmed);
        question
    };
    asked.iter().map(answered).collect()
}
