//! Tests of the whole program, from the command line to the files it leaves.

mod bench;
mod closed_loop;
mod defects;
mod documents;
mod duty;
mod expected;
mod files;
mod imports;
mod inertial;
mod interrupts;
mod latency;
mod mirror;
mod modes;
mod optics;
mod people;
mod polarity;
mod positions;
mod range;
mod rejudge;
mod safety;
mod stages;
mod statics;
mod track;
mod tracks;
mod units;
mod verdicts;
