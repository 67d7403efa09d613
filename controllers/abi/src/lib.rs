//! Velocity laws of others, in shared libraries behind the C interface `bench_law.h`.
//!
//! [`Library::load`] checks digest, version and layout of a library; [`Library::create`] makes an [`Instance`] for one
//! axis. [`shared`] is the memory through which a law in another process is stepped. All `unsafe` code of the interface
//! is in this crate, behind safe functions.

mod library;
pub mod rows;
pub mod shared;

pub use library::{Description, Instance, Library, LibraryError, Parameter};
