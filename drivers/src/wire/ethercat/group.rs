//! ethercrab's group of SubDevices in the forms that a bus can be in, and one cycle of it.

use std::ops::Range;
use std::time::Duration;

use ethercrab::error::Error;
use ethercrab::subdevice_group::{HasDc, NoDc, PreOp, SafeOp};
use ethercrab::{DefaultLock, MainDevice, SubDeviceGroup};

use super::super::{ProcessImage, Slot};

/// Most stations on a bus; a power of two.
pub(super) const MOST_STATIONS: usize = 16;
/// Room for the process data of all stations; a frame holds no more.
pub(super) const MOST_BYTES: usize = 1486;
/// What a frame has room for behind its two headers.
const FRAME_BYTES: usize = 1498;
/// Header and working counter of a datagram.
const OVERHEAD_BYTES: usize = 12;

pub(super) type Stage<State, Dc> = SubDeviceGroup<MOST_STATIONS, MOST_BYTES, DefaultLock, State, Dc>;

/// The group in one of its forms.
pub(super) enum Group {
    /// A step of the configuration has failed.
    Gone,
    /// Mailboxes only.
    PreOp(Box<Stage<PreOp, NoDc>>),
    /// Process data without distributed clocks.
    Free(Box<Stage<SafeOp, NoDc>>),
    /// Process data with distributed clocks.
    Synchronised(Box<Stage<SafeOp, HasDc>>),
}

/// What a cyclic frame brought back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle {
    pub(super) working_counter: u16,
    /// AL status of each station, without the error bit.
    pub(super) states: [u8; MOST_STATIONS],
    pub(super) clock: Option<ClockReading>,
}

/// The reference clock when the frame passed it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClockReading {
    pub(super) system_time_ns: u64,
    pub(super) after_sync0: Duration,
    pub(super) next_cycle_in: Duration,
}

/// Bytes of process data that fit into one frame with distributed clock and the states of `stations_count` stations.
pub(super) const fn capacity(stations_count: usize) -> usize {
    let others = OVERHEAD_BYTES + 8 + OVERHEAD_BYTES + stations_count * (OVERHEAD_BYTES + 2);
    FRAME_BYTES.saturating_sub(others)
}

impl Group {
    /// Passes one frame.
    pub(super) async fn pass(&self, main: &MainDevice<'_>) -> Result<Cycle, Error> {
        match self {
            Self::Gone | Self::PreOp(_) => Err(Error::Internal),
            Self::Free(group) => {
                let response = group.tx_rx(main).await?;
                let states = states(response.subdevice_states.iter().map(|&state| u8::from(state)));
                Ok(Cycle { working_counter: response.working_counter, states, clock: None })
            }
            Self::Synchronised(group) => {
                let response = group.tx_rx_dc(main).await?;
                let states = states(response.subdevice_states.iter().map(|&state| u8::from(state)));
                let clock = Some(ClockReading {
                    system_time_ns: response.extra.dc_system_time,
                    after_sync0: response.extra.cycle_start_offset,
                    next_cycle_in: response.extra.next_cycle_wait,
                });
                Ok(Cycle { working_counter: response.working_counter, states, clock })
            }
        }
    }

    /// Takes the outputs of all stations out of an image.
    pub(super) fn put_outputs(&self, main: &MainDevice<'_>, slots: &[Slot], image: &ProcessImage) {
        match self {
            Self::Gone | Self::PreOp(_) => {}
            Self::Free(group) => put(group, main, slots, image),
            Self::Synchronised(group) => put(group, main, slots, image),
        }
    }

    /// Puts the inputs of all stations into an image.
    pub(super) fn take_inputs(&self, main: &MainDevice<'_>, slots: &[Slot], image: &mut ProcessImage) {
        match self {
            Self::Gone | Self::PreOp(_) => {}
            Self::Free(group) => take(group, main, slots, image),
            Self::Synchronised(group) => take(group, main, slots, image),
        }
    }
}

fn states(found: impl Iterator<Item = u8>) -> [u8; MOST_STATIONS] {
    let mut states = [0; MOST_STATIONS];
    for (state, found) in states.iter_mut().zip(found) {
        *state = found;
    }
    states
}

fn put<Dc>(group: &Stage<SafeOp, Dc>, main: &MainDevice<'_>, slots: &[Slot], image: &ProcessImage) {
    for (station, slot) in group.iter(main).zip(slots) {
        copy(image.outputs.get(slot.outputs.clone()), &mut station.outputs_raw_mut());
    }
}

fn take<Dc>(group: &Stage<SafeOp, Dc>, main: &MainDevice<'_>, slots: &[Slot], image: &mut ProcessImage) {
    for (station, slot) in group.iter(main).zip(slots) {
        let range: Range<usize> = slot.inputs.clone();
        if let Some(inputs) = image.inputs.get_mut(range) {
            copy(Some(&station.inputs_raw()), inputs);
        }
    }
}

/// Copies where both sides have the same length.
fn copy(from: Option<&[u8]>, into: &mut [u8]) {
    if let Some(from) = from.filter(|from| from.len() == into.len()) {
        into.copy_from_slice(from);
    }
}
