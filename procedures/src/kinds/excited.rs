//! An axis that is excited while it slides: plan and record, shared by the kinds that read responses from it.
//!
//! Friction decides what a response shows: from rest the contact is a spring, while sliding it is a small damper
//! (director.md, section 8). So the axis goes back and forth, and the excitation never reverses it.

#![allow(clippy::result_large_err, reason = "a plan is refused once, before anything runs")]

mod channels;
mod course;
mod detected;
mod keys;
mod notes;
mod plan;
mod reached;
mod reading;
mod repeated;
mod signal;
mod tracked;
mod usable;
mod windows;

pub(super) use channels::{Channel, Record};
pub(super) use course::Course;
pub(super) use keys::{BACKGROUND, EXCITATION, Excited};
pub(super) use notes::notes;
pub(super) use plan::{ELEVATION, GAINS, LEVEL, plan};
pub(super) use reading::{conditions, read};
pub(super) use windows::{Measured, measure};
