//! Force gauge on a lever arm.
