//! Transport delay.
