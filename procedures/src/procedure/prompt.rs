//! Questions to the operator, asked before the first point of a procedure, or before the first procedure of a stage.

use crate::table::{Field, Shape, TableReader};

/// What a question is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PromptClass {
    /// Somebody's health depends on the answer.
    Safety,
    /// Configuration, handling, remarks.
    Info,
}

impl PromptClass {
    /// The word in procedure files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Safety => "safety",
            Self::Info => "info",
        }
    }
}

/// A question to the operator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prompt {
    /// Unique in its procedure or campaign, e.g. `area-clear`; on a real rig it is the phrase that a safety prompt wants typed.
    pub id: String,
    /// What it is about.
    pub class: PromptClass,
    /// What the operator reads.
    pub text: String,
    /// What is asked for is there by itself where every device is simulated, e.g. a target.
    pub simulated: bool,
}

/// Keys of a `[[prompt]]`.
pub(crate) const FIELDS: &[Field] = &[
    Field::required(
        "id",
        Shape::Text,
        "Name of the prompt, e.g. `area-clear`; on a real rig the operator types it to confirm a safety prompt.",
    ),
    Field::required(
        "class",
        Shape::Choice(&["safety", "info"]),
        "`safety`: the safety of people depends on the answer; `info`: configuration, handling, remarks.",
    ),
    Field::required("text", Shape::Text, "Question shown to the operator."),
    Field::default(
        "simulated",
        Shape::Boolean,
        "false",
        "With simulated devices only, the bench answers: the simulation provides what the prompt asks for, \
         such as a target.",
    ),
];

/// All prompts of a procedure, or of a stage of a campaign.
pub(crate) fn read(table: &mut TableReader<'_>) -> Vec<Prompt> {
    if !table.has("prompt") {
        return Vec::new();
    }
    let all = table.tables("prompt", |entry| {
        let id = entry.text("id");
        let class = entry.text("class");
        let text = entry.text("text");
        let simulated = entry.boolean("simulated").unwrap_or(false);
        let class = match class?.as_str() {
            "safety" => PromptClass::Safety,
            _ => PromptClass::Info,
        };
        let named = id.as_deref().is_none_or(super::read::is_harmless);
        if !named {
            entry.mistake("id", "`id` of a prompt: letters, digits, `-` and `_`, such as `area-clear`", None);
        }
        Some(Prompt { id: id.filter(|_| named)?, class, text: text?, simulated })
    });
    let all = all.unwrap_or_default();
    if let Some(twice) = (1..all.len()).find(|&k| all[..k].iter().any(|p| p.id == all[k].id)) {
        let message = format!("two prompts have the id `{}`", all[twice].id);
        table.mistake("prompt", message, Some("answers are assigned by id: rename one".to_owned()));
    }
    all
}
