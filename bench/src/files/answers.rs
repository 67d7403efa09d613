//! Answers to prompts that were written down before a run.

use std::collections::BTreeMap;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, SCHEMA_FIELD, Shape, read_file, suggestion};

/// Keys of an answers file.
pub(crate) const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::required(
        "answers",
        Shape::Map(&Shape::Text),
        "Answers by prompt id: `yes` or `no`; for an info prompt also a remark.",
    ),
];

/// Reads an answers file; `asked` are the ids of the prompts that the run will ask.
///
/// # Errors
/// All mistakes at once, answers to prompts that nobody asks among them.
pub(crate) fn read(source: &SourceFile, asked: &[&str]) -> Result<BTreeMap<String, String>, Vec<Diagnostic>> {
    read_file(source, FIELDS, |table| {
        table.schema()?;
        let mut answers = BTreeMap::new();
        for (id, text, span) in table.map("answers")? {
            if !asked.contains(&id.as_str()) {
                let help = if asked.is_empty() {
                    "this run asks nothing".to_owned()
                } else {
                    suggestion(&id, asked.iter().copied())
                };
                table.mistake_at(span.clone(), format!("no prompt `{id}` in this run"), Some(help));
            }
            answers.insert(id, text);
        }
        Some(answers)
    })
}
