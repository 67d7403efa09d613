//! The line and its SubDevices as a MainDevice sees them: frames in, frames out.

mod anything;
mod bench;
mod clocks;
mod commands;
mod described;
mod emergencies;
mod faults;
mod fmmus;
mod foreign;
mod frames;
mod mailboxes;
mod registers;
mod states;
mod sync_managers;
pub(crate) mod toy;
mod trigger;
mod watchdogs;
