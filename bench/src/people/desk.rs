//! The desk: asks the operator before a point and keeps what was said.

use std::io::BufRead;
use std::sync::atomic::AtomicU16;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use procedures::procedure::{Prompt, PromptClass};

use super::Answers;
use crate::clock::Age;
use crate::cycle::prompt::LIMIT_S;
use crate::people::event::Shown;
use crate::people::signals;
use crate::plan::Asked;
use crate::record::journal::Entry;

/// A safety answer is worth nothing after this (safety.md: people).
const VALID_S: f64 = 30.0 * 60.0;
/// How often a signal is looked for while somebody thinks.
const LOOK: Duration = Duration::from_millis(100);
/// Wrong phrases before the answer counts as no.
const TRIES: usize = 3;

/// How an answer came to be where the bench itself brings what is asked for, because every device is simulated: a build
/// state, or something that the simulation has by itself.
const STATE_APPLIED: &str = "simulated: state applied";
const IN_SIMULATION: &str = "simulated: part of the simulation";

/// Why a procedure does not begin, or not go on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Denied {
    /// The operator said no, or nothing.
    Refused(String),
    /// A signal came while the question stood; its exit code.
    Stopped(u8),
}

/// Asks and remembers. One at a time: who answers reads one question after the other.
pub struct Desk {
    answers: Answers,
    /// A device is real: safety prompts want their phrase typed.
    real: bool,
    by: String,
    lines: Option<Receiver<String>>,
    /// Info prompts that were answered, by who asks and id.
    told: Vec<(String, String)>,
    /// The safety prompts that were asked together last, and when each was answered. Any other one means that somebody
    /// may have entered the area.
    secured: Vec<(String, Age)>,
    limit_s: f64,
}

impl Desk {
    /// A desk at which `operator` sits.
    pub fn new(answers: Answers, real: bool, operator: Option<&str>) -> Self {
        let by = operator.unwrap_or("operator not named").to_owned();
        Self { answers, real, by, lines: None, told: Vec::new(), secured: Vec::new(), limit_s: LIMIT_S }
    }

    /// Has every prompt answered with yes, or with a remark; what is still valid is not asked again. `say` shows a
    /// question of somebody (and tells when), `keep` takes an answer to the journal.
    ///
    /// # Errors
    /// The first prompt that is not.
    pub fn clear(
        &mut self,
        asked: &[Asked<'_>],
        stop: &AtomicU16,
        say: &mut dyn FnMut(&str, &str) -> Shown,
        keep: &mut dyn FnMut(Entry),
    ) -> Result<(), Denied> {
        for one in asked {
            if self.still_valid(one) {
                continue;
            }
            if one.prompt.class == PromptClass::Safety {
                self.secured.retain(|(id, _)| asked.iter().any(|other| other.prompt.id == *id));
            }
            let owner = one.owner;
            let prompt = one.prompt;
            let (answer, how) = self.answer(one, stop, &mut |text| say(owner, text))?;
            keep(Entry::Answered {
                procedure: owner.to_owned(),
                prompt: prompt.id.clone(),
                class: prompt.class.word().to_owned(),
                text: prompt.text.clone(),
                answer: answer.clone(),
                by: if self.brings(one) && [STATE_APPLIED, IN_SIMULATION].contains(&how) {
                    "bench".to_owned()
                } else {
                    self.by.clone()
                },
                how: how.to_owned(),
            });
            if !self.accepts(prompt, &answer) {
                return Err(Denied::Refused(format!("prompt `{}` was answered with `{answer}`", prompt.id)));
            }
            self.remember(one);
        }
        Ok(())
    }

    /// Whether the bench itself brings what is asked for.
    fn brings(&self, asked: &Asked<'_>) -> bool {
        asked.brought && !self.real
    }

    /// What was answered to this prompt holds no longer: it is asked again.
    pub fn forget(&mut self, id: &str) {
        self.secured.retain(|(secured, _)| secured != id);
    }

    fn still_valid(&self, asked: &Asked<'_>) -> bool {
        let id = &asked.prompt.id;
        if asked.prompt.class == PromptClass::Info || self.brings(asked) {
            return self.told.iter().any(|(owner, told)| owner == asked.owner && told == id);
        }
        let holds = |since: &Age| since.elapsed_s() + asked.wait_s < VALID_S;
        self.secured.iter().any(|(secured, since)| secured == id && holds(since))
    }

    fn remember(&mut self, asked: &Asked<'_>) {
        let id = asked.prompt.id.clone();
        if asked.prompt.class == PromptClass::Info || self.brings(asked) {
            self.told.push((asked.owner.to_owned(), id));
        } else {
            self.secured.retain(|(secured, _)| *secured != id);
            self.secured.push((id, Age::start()));
        }
    }

    /// Whether a safety prompt is confirmed on real devices only by its phrase.
    fn wants_phrase(&self, prompt: &Prompt) -> bool {
        self.real && prompt.class == PromptClass::Safety
    }

    fn accepts(&self, prompt: &Prompt, answer: &str) -> bool {
        if self.wants_phrase(prompt) {
            return answer == prompt.id;
        }
        match prompt.class {
            PromptClass::Safety => answer == "yes",
            PromptClass::Info => answer != "no",
        }
    }

    fn answer(
        &mut self,
        asked: &Asked<'_>,
        stop: &AtomicU16,
        say: &mut dyn FnMut(&str) -> Shown,
    ) -> Result<(String, &'static str), Denied> {
        let prompt = asked.prompt;
        if self.brings(asked) && !self.answers.file.contains_key(&prompt.id) {
            let how = if prompt.simulated { IN_SIMULATION } else { STATE_APPLIED };
            return Ok(("yes".to_owned(), how));
        }
        if !self.wants_phrase(prompt)
            && let Some(given) = self.answers.given(prompt)
        {
            return Ok(given);
        }
        if self.answers.non_interactive || !self.answers.terminal {
            return Err(Denied::Refused(format!("prompt `{}` has no answer and cannot be asked", prompt.id)));
        }
        let how = match (self.wants_phrase(prompt), prompt.class) {
            (true, _) => format!("type `{}` to confirm, `no` to refuse", prompt.id),
            (false, PromptClass::Safety) => "yes or no".to_owned(),
            (false, PromptClass::Info) => "yes, no or a remark".to_owned(),
        };
        let mut answer = String::new();
        let mut before = String::new();
        for _ in 0..TRIES {
            self.forget_what_was_typed();
            let typed = self.line(prompt, stop, &mut || say(&format!("{before}{} [{how}]", prompt.text)))?;
            answer = spelled_out(&typed);
            if answer == "no" || !answer.is_empty() && self.accepts(prompt, &answer) {
                break;
            }
            before = format!("`{typed}` is not a valid answer. ");
        }
        Ok((answer, "terminal"))
    }

    /// What was typed before the question is no answer to it.
    fn forget_what_was_typed(&mut self) {
        let lines = self.lines.get_or_insert_with(read_lines);
        while lines.recv_timeout(LOOK).is_ok() {}
    }

    /// The next line that is typed once `ask` has shown the question.
    fn line(
        &mut self,
        prompt: &Prompt,
        stop: &AtomicU16,
        ask: &mut dyn FnMut() -> Shown,
    ) -> Result<String, Denied> {
        let lines = self.lines.get_or_insert_with(read_lines);
        let looks = (self.limit_s / LOOK.as_secs_f64()).ceil() as u64;
        let mut shown = ask();
        for _ in 0..looks {
            match signals::exit_code(stop) {
                0 => {}
                code => return Err(Denied::Stopped(code)),
            }
            if shown.is_lost() {
                shown = ask();
            }
            match lines.recv_timeout(LOOK) {
                Ok(line) if shown.is_set() => return Ok(line.trim().to_owned()),
                // Typed before anybody could have read the question: no answer to it.
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Denied::Refused(format!("prompt `{}`: the terminal was closed", prompt.id)));
                }
            }
        }
        let minutes = self.limit_s / 60.0;
        Err(Denied::Refused(format!(
            "prompt `{}` was not answered within {minutes:.0} min; start the run again when somebody can \
             answer",
            prompt.id
        )))
    }

    #[cfg(test)]
    pub(super) fn with_lines(mut self, lines: Receiver<String>, limit_s: f64) -> Self {
        (self.lines, self.limit_s) = (Some(lines), limit_s);
        self
    }
}

/// `y` and `n` are yes and no, in capitals or not; everything else is what it is.
fn spelled_out(typed: &str) -> String {
    match typed.to_lowercase().as_str() {
        "y" | "yes" => "yes".to_owned(),
        "n" | "no" => "no".to_owned(),
        _ => typed.to_owned(),
    }
}

/// Lines from the terminal; the thread ends with the terminal or the process.
fn read_lines() -> Receiver<String> {
    let (typed, lines) = channel();
    let read = move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if typed.send(line).is_err() {
                return;
            }
        }
    };
    // Without a thread nobody can answer: the receiver then says that the terminal is gone.
    let _ = std::thread::Builder::new().name("terminal".to_owned()).spawn(read);
    lines
}
