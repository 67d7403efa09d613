//! The test bench: rig, clock, loop, recorder, journal, judge, command line.
//!
//! Two halves that never share memory: one runs (devices, loop, log), the other judges (pure functions of a recorded
//! file). The log is the only door between them.
//!
//! Each folder is a room. A room uses only rooms that stand above it in this list:
//!
//! | room | what is in it |
//! | --- | --- |
//! | [`clock`], [`exit`] | the only file that reads a clock; what the program's exit codes mean |
//! | [`realtime`] | what a ticking thread asks of Linux, how late its ticks come, what a machine can do |
//! | [`model`] | what a rig is: plain structs |
//! | [`record`] | what a run leaves in its folder beside its logs: title page, journal, evidence |
//! | [`rig`] | an open rig: its drives and devices, what they tell and what they are told |
//! | [`site`] | where rigs are opened: simulated worlds in virtual time, at the speed of the day, or over real wires |
//! | [`cycle`] | what happens in every tick: sequence, loops, interlocks, stops, recorder; the session between points |
//! | `import` | logs of tables that other tools recorded |
//! | [`files`] | readers of the files that people write |
//! | [`plan`] | from names on the command line to checked points: stages, stops computed before motion, rehearsal |
//! | [`judge`] | logs in, findings out |
//! | [`people`] | what a run tells and asks people, and what it is refused for because of them |
//! | [`sim`] | a simulated rig in a process of its own, at the far end of real wires |
//! | [`campaign`] | a run: procedures to jobs, points to the loop, logs to the judge |
//! | [`identify`] | findings in, a simulated unit out; runs of procedures on candidates |
//! | [`regression`] | two controllers on the same units: many runs at a time, and what they leave |
//! | [`cli`] | the command line, one verb a file |

pub mod campaign;
pub mod cli;
pub mod clock;
pub mod cycle;
pub mod exit;
pub mod files;
pub mod identify;
mod import;
pub mod judge;
pub mod model;
pub mod people;
pub mod plan;
pub mod realtime;
pub mod record;
pub mod regression;
pub mod rig;
pub mod sim;
pub mod site;
