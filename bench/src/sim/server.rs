//! The loop of a served simulator: what comes over bus and lines is answered, orders are taken in between.

use std::io;
use std::sync::atomic::AtomicU16;
use std::time::Duration;

use drivers::device::DeviceError;
use sim_devices::rig::Fault;

use super::Report;
use super::bus::{BusFault, ServedBus};
use super::control::{Asked, Control};
use super::lines::ServedLines;
use super::truth::{self, TruthLog};
use crate::people::signals;
use crate::site::FarWorld;
use crate::site::order::{Answer, Order};

/// Longest wait for a frame: watchdogs must act, orders be taken and bytes be moved without any. A serial command and its reply are
/// moved four times: at this wait they take less than a tick of 1 ms, as they do on a cable.
const LONGEST_WAIT: Duration = Duration::from_micros(100);

/// Why a server ended by itself.
#[derive(Debug)]
pub(super) enum Broken {
    /// Its interface is gone.
    Interface(io::Error),
    /// A simulated device on a line is gone.
    Line(DeviceError),
}

impl From<io::Error> for Broken {
    fn from(error: io::Error) -> Self {
        Self::Interface(error)
    }
}

impl From<DeviceError> for Broken {
    fn from(error: DeviceError) -> Self {
        Self::Line(error)
    }
}

/// A simulator whose bus, serial lines and sockets are served.
pub(super) struct Server {
    bus: Box<dyn ServedBus>,
    lines: ServedLines,
    world: Box<dyn FarWorld>,
    truth: Option<TruthLog>,
    next_row: Duration,
    report: Report,
}

impl Server {
    /// A server of this bus and these lines, with the world behind them.
    pub(super) fn new(
        bus: Box<dyn ServedBus>,
        lines: ServedLines,
        world: Box<dyn FarWorld>,
        truth: Option<TruthLog>,
    ) -> Self {
        let next_row = bus.now();
        Self { bus, lines, world, truth, next_row, report: Report::default() }
    }

    /// Serves until an order or a signal ends it.
    ///
    /// # Errors
    /// When the interface or a simulated device is gone.
    pub(super) fn serve(
        mut self,
        control: &Control,
        stop: &AtomicU16,
    ) -> Result<(Report, Option<TruthLog>), Broken> {
        loop {
            let latest = self.bus.now() + LONGEST_WAIT;
            self.bus.wait(self.bus.next_due().map_or(latest, |due| due.min(latest)))?;
            self.bus.exchange(&mut self.report)?;
            let now = self.bus.now();
            self.lines.pump(now)?;
            self.keep_truth(now);
            while let Some(asked) = control.next() {
                if self.obey(asked, now) {
                    return Ok(self.end());
                }
            }
            if signals::exit_code(stop) != 0 {
                return Ok(self.end());
            }
        }
    }

    fn end(mut self) -> (Report, Option<TruthLog>) {
        self.report.contacts = self.world.surroundings().contacts();
        (self.report, self.truth)
    }

    fn keep_truth(&mut self, now: Duration) {
        if let Some(truth) = &mut self.truth
            && now >= self.next_row
        {
            truth.row(now, &self.world.truth());
            self.next_row = now + Duration::from_secs(1) / truth::RATE_HZ;
        }
    }

    /// Does what was asked for; true if that is the end.
    fn obey(&mut self, asked: Asked, now: Duration) -> bool {
        let done = || Ok("done".to_owned());
        let result = match &asked.order {
            Order::Wire(fault) => self.bus.inject(now, BusFault::Wire(*fault)).and_then(|()| done()),
            Order::Node(fault) => self.bus.inject(now, BusFault::Node(*fault)).and_then(|()| done()),
            Order::World(fault) => {
                let scheduled = self.world.schedule(now, Fault::from(*fault));
                scheduled.map_err(|error| error.to_string()).and_then(|()| done())
            }
            Order::Bring(case) => {
                self.world.surroundings().bring(case);
                done()
            }
            Order::Status => Ok(self.status(now)),
            Order::Stop => Ok("the simulator ends".to_owned()),
        };
        let answer = result.map_or_else(Answer::Refused, Answer::Done);
        asked.answer(answer);
        let ends = asked.order == Order::Stop;
        if ends {
            asked.wait_until_told();
        }
        ends
    }

    fn status(&mut self, now: Duration) -> String {
        let axes = self.world.truth();
        let place = |axis: &sim_devices::rig::AxisTruth| {
            format!("{} {:.6} rad {:.6} rad/s", axis.name, axis.angle_rad, axis.rate_rad_per_s)
        };
        let places: Vec<String> = axes.iter().map(place).collect();
        let contacts = self.world.surroundings().contacts().len();
        format!(
            "{:.3} s; {} frames answered, {} not; {}; {contacts} contacts with end stops",
            now.as_secs_f64(),
            self.report.frames,
            self.report.unanswered,
            places.join(", ")
        )
    }
}
