//! What must hold before or whenever the axes move: signs, limits, stops, heat, the bench itself.

pub(in crate::kinds) mod duty;
pub(in crate::kinds) mod polarity;
pub(in crate::kinds) mod range;
pub(in crate::kinds) mod self_check;
pub(in crate::kinds) mod stop;
