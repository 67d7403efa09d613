//! Tests of the whole program, from the command line to the files it leaves.

mod bench;
mod documents;
mod expected;
mod files;
mod imports;
mod interrupts;
mod latency;
mod mirror;
mod modes;
mod people;
mod polarity;
mod positions;
mod rejudge;
mod safety;
mod units;
mod verdicts;
