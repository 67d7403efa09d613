//! Faults of a datagram port, on purpose: those of frames, a counter that jumps, and silence.
//!
//! Datagrams are treated as frames are (see [`FaultPlan`]): they are counted from 1, each way for itself, from
//! [`FaultControl::begin`] on. Datagrams longer than an Ethernet frame (1514 bytes) are cut off.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use super::super::{DatagramPort, EthernetLink, MAX_FRAME_BYTES};
use super::{FaultControl, FaultPlan, FaultyLink};
use crate::device::DeviceError;

/// A counter in received datagrams that jumps, as that of a device which lost messages or was started again.
#[derive(Clone, Copy, Debug)]
pub struct CounterJump {
    /// Number of the first datagram that has it; all later ones have it too.
    pub first: u64,
    /// How much more the counter says, modulo 2³².
    pub by: u32,
    /// Adds to the counter of a datagram and makes its checksum right again.
    pub add: fn(&mut [u8], u32),
}

/// A time in which no datagram is received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PortSilence {
    /// Number of the first datagram that is lost.
    pub first: u64,
    /// For how long.
    pub lasts: Duration,
}

/// All faults of a datagram port.
#[derive(Clone, Debug, Default)]
pub struct PortFaultPlan {
    /// What befalls single datagrams, as it befalls frames: lost, late, doubled, damaged, cut off, out of order.
    pub datagrams: FaultPlan,
    /// Counters that jump.
    pub jumps: Vec<CounterJump>,
    /// Silences.
    pub silences: Vec<PortSilence>,
}

/// A datagram port with faults.
pub struct FaultyDatagramPort<P> {
    link: FaultyLink<PortLink<P>>,
}

/// A port as a link of frames, for the faults that both have.
struct PortLink<P> {
    port: P,
    control: Arc<FaultControl>,
    jumps: Vec<CounterJump>,
    silences: Vec<PortSilence>,
    now: Duration,
    received_count: u64,
    silent_until: Duration,
}

impl<P: DatagramPort> FaultyDatagramPort<P> {
    /// A port that has these faults from the moment when `control` begins them.
    pub fn new(port: P, plan: PortFaultPlan, control: Arc<FaultControl>) -> Self {
        let PortFaultPlan { datagrams, jumps, silences } = plan;
        let link = PortLink {
            port,
            control: Arc::clone(&control),
            jumps,
            silences,
            now: Duration::ZERO,
            received_count: 0,
            silent_until: Duration::ZERO,
        };
        Self { link: FaultyLink::new(link, datagrams, control) }
    }
}

impl<P: DatagramPort> PortLink<P> {
    /// Does to a received datagram what is due to it; `false` if it is lost.
    fn befall(&mut self, datagram: &mut [u8]) -> bool {
        self.received_count += 1;
        let number = self.received_count;
        for silence in self.silences.iter().filter(|silence| silence.first == number) {
            self.silent_until = self.silent_until.max(self.now + silence.lasts);
        }
        for jump in self.jumps.iter().filter(|jump| number >= jump.first) {
            (jump.add)(datagram, jump.by);
        }
        self.now >= self.silent_until
    }
}

impl<P: DatagramPort> DatagramPort for FaultyDatagramPort<P> {
    fn name(&self) -> &str {
        self.link.link.port.name()
    }

    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        self.link.link.now = now;
        // Whole datagrams pass the faults, whatever room the caller has.
        let mut datagram = [0; MAX_FRAME_BYTES];
        let received = self.link.receive(&mut datagram).map_err(|error| unwrapped(self.name(), error))?;
        Ok(received.map(|length| {
            let count = length.min(into.len());
            into[..count].copy_from_slice(&datagram[..count]);
            count
        }))
    }

    fn send(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.link.link.now = now;
        self.link.send(bytes).map_err(|error| unwrapped(self.name(), error))
    }
}

impl<P: DatagramPort> EthernetLink for PortLink<P> {
    fn name(&self) -> &str {
        self.port.name()
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        self.port.send(self.now, frame).map_err(io::Error::other)
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        while let Some(length) = self.port.receive(self.now, into).map_err(io::Error::other)? {
            let length = length.min(into.len());
            if !self.control.is_active() || self.befall(&mut into[..length]) {
                return Ok(Some(length));
            }
        }
        Ok(None)
    }

    fn now(&self) -> Duration {
        self.now
    }

    /// Time is an argument here: nothing is waited for.
    fn wait(&mut self, _until: Duration) -> io::Result<()> {
        Ok(())
    }
}

/// The port's own error, which passed the link as one of the operating system.
fn unwrapped(name: &str, error: io::Error) -> DeviceError {
    let told = error.to_string();
    let own = error.into_inner().and_then(|inner| inner.downcast::<DeviceError>().ok());
    own.map_or_else(|| DeviceError::Bus { device: name.to_owned(), reason: told }, |own| *own)
}

#[cfg(test)]
mod tests;
