mod foreign;
mod record;
mod stepped;

use std::io;

use super::*;
use crate::wire::EthernetLink;

/// An interface at which nobody answers.
struct Silent {
    now: Duration,
    /// Time passes while somebody waits.
    has_time: bool,
    fails: bool,
    /// Gives back what is sent, as a loopback plug does.
    is_loop: bool,
    looped: Option<Vec<u8>>,
}

const SILENT: Silent =
    Silent { now: Duration::ZERO, has_time: true, fails: false, is_loop: false, looped: None };

impl EthernetLink for Silent {
    fn name(&self) -> &str {
        "enp3s0"
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        if self.fails {
            return Err(io::ErrorKind::NetworkDown.into());
        }
        self.looped = self.is_loop.then(|| frame.to_vec());
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        let Some(frame) = self.looped.take() else { return Ok(None) };
        into[..frame.len()].copy_from_slice(&frame);
        Ok(Some(frame.len()))
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        if self.has_time {
            self.now = self.now.max(until);
        }
        Ok(())
    }
}

fn open(link: Silent) -> String {
    let opened = EtherCatBus::open(Box::new(link), EtherCatSettings::usual("bus 0", 1e-3));
    opened.err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn nobody_answering_is_an_error_that_names_interface_expected_and_found() {
    let text = "bus 0 (enp3s0): SubDevices: expected 1 to 16 SubDevices, found no reply; \
                check that the cable is in the first SubDevice's IN port, that it has supply, and that the rig file names \
                the right interface";
    assert_eq!(open(SILENT), text);
    assert_eq!(open(Silent { is_loop: true, ..SILENT }), text, "own frames are no answers");
}

#[test]
fn an_interface_whose_time_stands_still_does_not_hold_anybody_up() {
    assert!(open(Silent { has_time: false, ..SILENT }).contains("no reply"));
}

#[test]
fn an_interface_that_is_down_is_said_to_have_failed() {
    let text = open(Silent { fails: true, ..SILENT });
    assert!(
        text.starts_with("bus 0 (enp3s0): SubDevices cannot be counted: the interface failed: "),
        "{text}"
    );
}
