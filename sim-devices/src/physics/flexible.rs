//! Flexible modes of the structure, discretised exactly.
