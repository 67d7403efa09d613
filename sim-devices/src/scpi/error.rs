//! Errors of SCPI (SCPI-1999, 21.8): code and text.

/// An entry of the error queue.
pub(crate) type Error = (i32, &'static str);

/// Errors that our instruments report.
pub(crate) mod code {
    use super::Error;

    pub(crate) const SYNTAX: Error = (-102, "Syntax error");
    pub(crate) const PARAMETER_NOT_ALLOWED: Error = (-108, "Parameter not allowed");
    pub(crate) const MISSING_PARAMETER: Error = (-109, "Missing parameter");
    pub(crate) const UNDEFINED_HEADER: Error = (-113, "Undefined header");
    pub(crate) const TRIGGER_IGNORED: Error = (-211, "Trigger ignored");
    pub(crate) const INIT_IGNORED: Error = (-213, "Init ignored");
    pub(crate) const SETTINGS_CONFLICT: Error = (-221, "Settings conflict");
    pub(crate) const OUT_OF_RANGE: Error = (-222, "Data out of range");
    pub(crate) const ILLEGAL_PARAMETER: Error = (-224, "Illegal parameter value");
    pub(crate) const STALE: Error = (-230, "Data corrupt or stale");
    pub(crate) const QUEUE_OVERFLOW: Error = (-350, "Queue overflow");
    pub(crate) const INPUT_OVERRUN: Error = (-363, "Input buffer overrun");
    pub(crate) const INTERRUPTED: Error = (-410, "Query INTERRUPTED");
}
