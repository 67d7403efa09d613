//! How much of a cycle the frames of the process data take.

use super::super::can::most_frame_bits;
use super::node::Lengths;
use crate::cia402::frames::{PDOS, split};
use crate::cia402::profile::{DriveProfile, ProcessData};

/// Largest part of a cycle that process data may take: SDO transfers, heartbeats and emergencies need the rest.
const MOST_LOAD: f64 = 0.9;

/// Shortest cycle in which the frames of PDOs of these lengths and of SYNC fit, s.
pub(super) fn shortest_s<'a>(lengths: impl Iterator<Item = &'a Lengths>, bit_rate_hz: f64) -> f64 {
    let pdos = lengths.flatten().filter(|bytes| **bytes > 0);
    let bits: u32 = pdos.map(|bytes| most_frame_bits(*bytes)).sum();
    f64::from(bits + most_frame_bits(0)) / bit_rate_hz / MOST_LOAD
}

/// Shortest cycle of a bus with these drives at a bit rate, s. Frames are counted with all stuff bits that ISO 11898-1 can insert, and
/// may fill 90 % of the cycle.
///
/// # Errors
/// In words: process data that no drive on CAN can have.
pub fn shortest_cycle_s(drives: &[&DriveProfile], bit_rate_hz: f64) -> Result<f64, String> {
    let mut lengths = Vec::new();
    for profile in drives {
        for process_data in [&profile.outputs, &profile.inputs] {
            lengths.push(lengths_of(process_data).map_err(|why| format!("profile `{}`: {why}", profile.id))?);
        }
    }
    Ok(shortest_s(lengths.iter(), bit_rate_hz))
}

fn lengths_of(process_data: &ProcessData) -> Result<Lengths, String> {
    let ProcessData::Mapped(entries) = process_data else {
        return Err(
            "its PDOs are fixed, and a CAN frame holds 8 bytes; choose a profile with a mapping".to_owned()
        );
    };
    let parts = split(entries);
    if parts.len() > usize::from(PDOS) {
        return Err(format!(
            "its process data need {} frames one way, and there are {PDOS} PDOs",
            parts.len()
        ));
    }
    let mut lengths = Lengths::default();
    for (length, part) in lengths.iter_mut().zip(parts) {
        *length = part.iter().map(|entry| entry.bytes()).sum();
    }
    Ok(lengths)
}
