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

pub(in crate::kinds) use channels::{Channel, Record};
pub(in crate::kinds) use course::Course;
pub(in crate::kinds) use keys::{BACKGROUND, EXCITATION, Excited};
pub(in crate::kinds) use notes::notes;
pub(in crate::kinds) use plan::{ELEVATION, GAINS, LEVEL, plan};
pub(in crate::kinds) use reading::{conditions, read};
pub(in crate::kinds) use windows::{Measured, measure};
