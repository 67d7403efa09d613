//! A question to the operator while the loop runs: the loop asks and looks for the answer, another thread talks.

use std::sync::atomic::{AtomicU8, Ordering};

use procedures::procedure::PromptClass;

/// Longest wait for an answer (safety.md: deadlines).
pub const LIMIT_S: f64 = 600.0;

const UNASKED: u8 = 0;
const ASKED: u8 = 1;
const CONFIRMED: u8 = 2;
const REFUSED: u8 = 3;

/// What the operator said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// What the prompt asks about is so; go on.
    Confirmed,
    /// What the prompt asks about is not so; stop.
    Refused,
}

/// One question of a point.
#[derive(Debug)]
pub struct Question {
    /// Safety questions are asked while the drives have no torque, others while the axes are held.
    pub class: PromptClass,
    state: AtomicU8,
}

impl Question {
    /// Not asked yet.
    pub fn new(class: PromptClass) -> Self {
        Self { class, state: AtomicU8::new(UNASKED) }
    }

    /// The loop has come to it; an answer that is there already stays.
    pub fn ask(&self) {
        let _ = self.state.compare_exchange(UNASKED, ASKED, Ordering::AcqRel, Ordering::Acquire);
    }

    /// Whether the loop waits for it.
    pub fn is_asked(&self) -> bool {
        self.state.load(Ordering::Acquire) == ASKED
    }

    /// Answers it, before or after it was asked.
    pub fn give(&self, answer: Answer) {
        let state = match answer {
            Answer::Confirmed => CONFIRMED,
            Answer::Refused => REFUSED,
        };
        self.state.store(state, Ordering::Release);
    }

    /// The answer, once there is one.
    pub fn answer(&self) -> Option<Answer> {
        match self.state.load(Ordering::Acquire) {
            CONFIRMED => Some(Answer::Confirmed),
            REFUSED => Some(Answer::Refused),
            _ => None,
        }
    }
}
