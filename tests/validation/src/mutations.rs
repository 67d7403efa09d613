//! Mutated files of every sort that people write or a disk gives back, each read by the program itself.

mod bed;
mod child;
mod log;
mod sorts;
mod text;
mod trial;

pub use bed::Bed;
pub use trial::{Trial, all, table};
