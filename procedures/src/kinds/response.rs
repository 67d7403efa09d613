//! Responses of an axis to an excitation: frequency, modes, latency, imported records.

pub(in crate::kinds) mod excited;
pub(in crate::kinds) mod frequency_response;
pub(in crate::kinds) mod imported_response;
pub(in crate::kinds) mod latency;
pub(in crate::kinds) mod modes;
