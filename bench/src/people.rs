//! What a run is refused for because people may stand beside real devices, and who answers its questions (safety.md §5).
//!
//! Beside that, what people are told ([`event`], [`console`]), what they order ([`signals`]), what a run holds against others
//! ([`lock`]), and the look at a rig after a run was lost ([`inspect`]).
//!
//! What else must not meet a real device gets its row in [`RULES`] when it comes.

use std::collections::BTreeMap;

use procedures::procedure::{Prompt, PromptClass};

use crate::plan::{Asked, CampaignPlan};
use crate::site::unit::Unit;

pub(crate) mod columns;
pub(crate) mod console;
mod desk;
pub mod event;
pub(crate) mod inspect;
pub(crate) mod lock;
pub mod signals;
#[cfg(test)]
mod tests;
pub mod underway;

pub use desk::{Denied, Desk};

/// How questions are answered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answers {
    /// `--yes`: everything is answered with yes.
    pub yes: bool,
    /// `--non-interactive`: nobody is asked.
    pub non_interactive: bool,
    /// `--answers`: by id of the prompt.
    pub file: BTreeMap<String, String>,
    /// Somebody sits there: stdin and stderr are terminals.
    pub terminal: bool,
}

impl Answers {
    /// An answer that is there before anybody is asked, and how it came to be.
    pub fn given(&self, prompt: &Prompt) -> Option<(String, &'static str)> {
        match self.file.get(&prompt.id) {
            Some(text) => Some((text.clone(), "answers file")),
            None => self.yes.then(|| ("yes".to_owned(), "--yes")),
        }
    }
}

/// What the rules look at.
#[derive(Clone, Copy)]
pub struct Situation<'a> {
    /// Names of the devices that count as real.
    pub real: &'a [&'a str],
    /// Unit file.
    pub unit: &'a Unit,
    /// What is going to be run.
    pub plan: &'a CampaignPlan,
    /// Procedures at a time, where somebody asked for a number.
    pub jobs: Option<usize>,
    /// How questions are answered.
    pub answers: &'a Answers,
    /// Faults that are planted on the wire, as they were asked for.
    pub wire_faults: &'a [String],
}

impl<'a> Situation<'a> {
    fn prompts(&self) -> impl Iterator<Item = &'a Prompt> {
        self.plan.questions().into_iter().map(|asked| asked.prompt)
    }

    fn safety_prompts(&self) -> impl Iterator<Item = &'a str> {
        self.prompts().filter(|p| p.class == PromptClass::Safety).map(|p| p.id.as_str())
    }
}

/// A reason to refuse a run before anything moves.
pub struct Rule {
    /// Only where a device is real.
    pub with_real_devices: bool,
    /// What is wrong and what to do, if it is.
    pub broken: fn(&Situation<'_>) -> Option<String>,
}

/// All rules, in the order in which they are told.
pub const RULES: &[Rule] = &[
    Rule { with_real_devices: true, broken: planted_defect },
    Rule { with_real_devices: true, broken: disturbed_wire },
    Rule { with_real_devices: true, broken: parallel },
    Rule { with_real_devices: true, broken: safety_answered_by_nobody },
    Rule { with_real_devices: true, broken: safety_answered_by_file },
    Rule { with_real_devices: true, broken: safety_without_terminal },
    Rule { with_real_devices: false, broken: unanswered },
];

/// Everything that a run is refused for; empty if nothing.
pub fn refusals(situation: &Situation<'_>) -> Vec<String> {
    let real = !situation.real.is_empty();
    RULES.iter().filter(|r| real || !r.with_real_devices).filter_map(|r| (r.broken)(situation)).collect()
}

fn planted_defect(s: &Situation<'_>) -> Option<String> {
    let planted = s.unit.is_defect();
    planted.then(|| {
        format!(
            "unit `{}` is a planted defect, but {} is real: defects run on simulated devices only; choose \
             another --unit",
            s.unit.id, s.real[0]
        )
    })
}

fn disturbed_wire(s: &Situation<'_>) -> Option<String> {
    let fault = s.wire_faults.first()?;
    Some(format!(
        "--wire-fault {fault}: {} is real, and faults are planted on wires to simulated devices only; leave out \
         --wire-fault",
        s.real[0]
    ))
}

fn parallel(s: &Situation<'_>) -> Option<String> {
    s.jobs.filter(|&jobs| jobs > 1).map(|jobs| {
        format!(
            "--jobs {jobs}: {} is real, and real axes run one procedure at a time; leave out --jobs",
            s.real[0]
        )
    })
}

fn safety_answered_by_nobody(s: &Situation<'_>) -> Option<String> {
    let prompt = s.safety_prompts().next()?;
    let flag = match s.answers {
        Answers { yes: true, .. } => "--yes",
        Answers { non_interactive: true, .. } => "--non-interactive",
        _ => return None,
    };
    Some(format!(
        "{flag}: safety prompt `{prompt}` must be answered by a person at the rig, because {} is real; \
         leave out {flag}",
        s.real[0]
    ))
}

fn safety_answered_by_file(s: &Situation<'_>) -> Option<String> {
    let prompt = s.safety_prompts().find(|prompt| s.answers.file.contains_key(*prompt))?;
    Some(format!(
        "--answers: safety prompt `{prompt}` must be answered by a person at the rig, because {} is real; \
         remove it from the file",
        s.real[0]
    ))
}

fn safety_without_terminal(s: &Situation<'_>) -> Option<String> {
    let prompt = s.safety_prompts().next().filter(|_| !s.answers.terminal)?;
    Some(format!(
        "safety prompt `{prompt}` must be answered at a terminal, because {} is real: start the run in a \
         terminal, with stdin and stderr attached",
        s.real[0]
    ))
}

fn unanswered(s: &Situation<'_>) -> Option<String> {
    if s.answers.terminal && !s.answers.non_interactive {
        return None;
    }
    // On simulated devices the bench itself brings a build state or a target.
    let brought = |asked: &Asked<'_>| asked.brought && s.real.is_empty();
    let mut asked = s.plan.questions().into_iter().filter(|asked| !brought(asked));
    let prompt = asked.find(|asked| s.answers.given(asked.prompt).is_none())?.prompt;
    Some(format!(
        "prompt `{}` has no answer and cannot be asked: give --answers FILE with `{0} = \"yes\"` in it, or \
         run in a terminal without --non-interactive",
        prompt.id
    ))
}
