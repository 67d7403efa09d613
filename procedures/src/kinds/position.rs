//! Position: steps, slews, profiles, accuracy, rest.

pub(in crate::kinds) mod accuracy;
pub(in crate::kinds) mod positioned;
pub(in crate::kinds) mod profile;
pub(in crate::kinds) mod slew;
pub(in crate::kinds) mod static_hold;
pub(in crate::kinds) mod step;
