//! The test bench: rig, clock, loop, recorder, journal, judge, command line.
//!
//! Two halves that never share memory: one runs (devices, loop, log), the other judges (pure functions of a recorded
//! file). The log is the only door between them.

pub mod axis_loop;
pub mod calibration;
pub mod campaign;
pub mod channels;
pub mod cli;
pub mod clock;
pub mod console;
pub mod devices;
pub mod dither;
pub mod durable;
pub mod event;
pub mod evidence;
pub mod exit;
pub mod feedback;
pub mod files;
pub mod gate;
pub mod import;
pub mod inspect;
pub mod interlock;
pub mod journal;
pub mod judge;
pub mod lock;
pub mod model;
pub mod page;
pub mod people;
pub mod plan;
pub mod polarity;
pub mod preflight;
pub mod prompt;
pub mod recorder;
pub mod rehearsal;
pub mod rig;
pub mod run;
pub mod safe;
pub mod sequence;
pub mod session;
pub mod signals;
pub mod site;
pub mod stage;
pub mod stops;
pub mod tracking;
