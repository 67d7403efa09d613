//! Questions of a procedure to the operator.

/// What a question is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PromptClass {
    /// Somebody's health depends on the answer.
    Safety,
    /// Configuration, handling, remarks.
    Info,
}
