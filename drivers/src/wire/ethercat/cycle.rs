//! One exchange, the acyclic datagram beside it, and reads and writes outside of the cycle.

use std::future::{Future, poll_fn};
use std::io;
use std::pin::pin;
use std::task::Poll;
use std::time::Duration;

use super::al::{self, AlPdu};
use super::datagram::{Content, Datagram, Outcome};
use super::group::Cycle;
use super::mailbox::{MailAction, MailArea, MailPdu, Mailboxes, Reply};
use super::pump::Stopped;
use super::{
    DcStatus, EtherCatBus, Exchange, Failure, MOST_AL_ERRORS, ProcessImage, REPLY_LIMIT, StationInfo,
};
use crate::device::DeviceError;

/// Registers of the sync manager of the mailbox that the host reads: status, activation, PDI control.
const MAILBOX_STATUS: u16 = 0x080D;
const MAILBOX_ACTIVATION: u16 = 0x080E;

/// Who wants the acyclic datagram.
#[derive(Clone, Copy, Debug)]
enum Job {
    Al(AlPdu),
    Mail(MailPdu),
}

impl EtherCatBus {
    pub(super) fn cycle(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        self.pump.reach(now).map_err(|error| self.link_failed(error))?;
        let at = self.pump.link.now();
        let expected = self.check_image(image)?;
        self.last_exchange = Some(at);
        self.took_part.fill(false);
        let cycle = self.pass_both(at, image)?;
        let Some(cycle) = cycle else { return Ok(Exchange { working_counter: 0, expected }) };
        if let Some(mapped) = &self.mapped {
            self.group.take_inputs(&self.main, &mapped.slots, image);
            self.took_part = mapped.who_took_part(&cycle);
        }
        for (k, &state) in cycle.states.iter().take(self.stations.len()).enumerate() {
            self.supervisor.seen(k, state);
        }
        if let Some(reading) = cycle.clock {
            self.clock = Some(DcStatus {
                system_time_ns: reading.system_time_ns,
                after_sync0: reading.after_sync0,
                next_cycle_in: reading.next_cycle_in,
                at,
            });
        }
        Ok(Exchange { working_counter: cycle.working_counter, expected })
    }

    /// The working counter that is expected; an error if the bus is not mapped or the image is another bus's.
    fn check_image(&self, image: &ProcessImage) -> Result<u16, DeviceError> {
        let Some(mapped) = &self.mapped else {
            return Err(self.failure("exchange before the bus was mapped".to_owned()));
        };
        let [outputs, inputs] = [image.outputs.len(), image.inputs.len()];
        if [outputs, inputs] == [mapped.output_bytes, mapped.input_bytes] {
            return Ok(mapped.working_counter);
        }
        let (expected_outputs, expected_inputs) = (mapped.output_bytes, mapped.input_bytes);
        Err(self.failure(format!(
            "process image of {outputs} bytes of outputs and {inputs} of inputs, expected {expected_outputs} and \
             {expected_inputs}: take the image that mapping the bus gave"
        )))
    }

    /// Passes the cyclic frame and at most one acyclic datagram; `None` if the cyclic frame has no reply.
    fn pass_both(&mut self, at: Duration, image: &ProcessImage) -> Result<Option<Cycle>, DeviceError> {
        let deadline = at + self.settings.reply_timeout();
        let job = next_job(&self.supervisor, &mut self.mailboxes, at);
        if let Some(mapped) = &self.mapped {
            self.group.put_outputs(&self.main, &mapped.slots, image);
        }
        let control = control_bytes(job);
        let datagram = job.and_then(|job| datagram(job, &self.stations, &self.mailboxes, &control));
        let answer = &mut self.answer[..];
        let (mut cycle, mut outcome) = (None, datagram.is_none().then_some(Outcome::Lost));
        let stopped = {
            let mut cyclic = pin!(self.group.pass(&self.main));
            let mut acyclic = pin!(async {
                match &datagram {
                    Some(datagram) => datagram.pass(&self.main, answer).await,
                    None => Outcome::Lost,
                }
            });
            let both = pin!(poll_fn(|context| {
                if cycle.is_none()
                    && let Poll::Ready(done) = cyclic.as_mut().poll(context)
                {
                    cycle = Some(done);
                }
                if outcome.is_none()
                    && let Poll::Ready(done) = acyclic.as_mut().poll(context)
                {
                    outcome = Some(done);
                }
                if cycle.is_some() && outcome.is_some() { Poll::Ready(()) } else { Poll::Pending }
            }));
            self.pump.run(deadline, both)
        };
        if let Some(job) = job {
            self.finish(job, outcome.unwrap_or(Outcome::Lost));
        }
        match stopped {
            Err(Stopped::Link(error)) => Err(self.link_failed(error)),
            // What ethercrab cannot read is as good as lost.
            Ok(()) | Err(Stopped::Deadline) => Ok(cycle.and_then(Result::ok)),
        }
    }

    /// Passes one acyclic datagram outside of the cycle; whether there was one to pass.
    pub(super) fn pass_acyclic(&mut self) -> io::Result<bool> {
        let now = self.pump.link.now();
        let Some(job) = next_job(&self.supervisor, &mut self.mailboxes, now) else { return Ok(false) };
        let control = control_bytes(Some(job));
        let Some(datagram) = datagram(job, &self.stations, &self.mailboxes, &control) else {
            return Ok(false);
        };
        let passed = {
            let pass = pin!(datagram.pass(&self.main, &mut self.answer[..]));
            self.pump.run(now + REPLY_LIMIT, pass)
        };
        let outcome = match passed {
            Ok(outcome) => outcome,
            Err(Stopped::Deadline) => Outcome::Lost,
            Err(Stopped::Link(error)) => {
                self.finish(job, Outcome::Lost);
                return Err(error);
            }
        };
        self.finish(job, outcome);
        Ok(true)
    }

    /// Gives a datagram's outcome to whom it belongs.
    fn finish(&mut self, job: Job, outcome: Outcome) {
        let now = self.pump.link.now();
        let reply = match outcome {
            Outcome::Lost => Reply::Lost,
            Outcome::Refused => Reply::Refused,
            Outcome::Done(count) => Reply::Done(&self.answer[..count]),
        };
        match job {
            Job::Mail(pdu) => self.mailboxes.done(now, pdu, reply),
            Job::Al(AlPdu::Write { station, control }) => {
                self.supervisor.written(now, station, control, matches!(reply, Reply::Done(_)));
            }
            Job::Al(AlPdu::Read { station }) => {
                let status = match reply {
                    Reply::Done(bytes) => <[u8; 6]>::try_from(bytes).ok(),
                    Reply::Lost | Reply::Refused => None,
                };
                let Some(status) = status else { return self.supervisor.unread(now, station) };
                if let Some(error) = self.supervisor.read(now, station, status) {
                    if self.al_errors.len() == MOST_AL_ERRORS {
                        self.al_errors.remove(0);
                    }
                    self.al_errors.push(error);
                }
            }
        }
    }

    /// Reads a register outside of the cycle.
    pub(super) fn read_register<const N: usize>(
        &mut self,
        address: u16,
        register: u16,
    ) -> Result<[u8; N], DeviceError> {
        let bytes = N as u16;
        self.pass_one(&Datagram { address, register, content: Content::Read { bytes } })?;
        self.answer
            .first_chunk()
            .copied()
            .ok_or_else(|| self.failure("internal error: short answer".to_owned()))
    }

    /// Writes a register outside of the cycle.
    pub(super) fn write_register(
        &mut self,
        address: u16,
        register: u16,
        bytes: &[u8],
    ) -> Result<(), DeviceError> {
        self.pass_one(&Datagram { address, register, content: Content::Write(bytes) })
    }

    /// Passes a datagram that must be taken, twice if it is lost.
    fn pass_one(&mut self, datagram: &Datagram<'_>) -> Result<(), DeviceError> {
        let Datagram { address, register, .. } = *datagram;
        let what = format!("register {register:04X}h of the station with address {address:04X}h");
        for _ in 0..2 {
            let deadline = self.pump.link.now() + REPLY_LIMIT;
            let passed = {
                let pass = pin!(datagram.pass(&self.main, &mut self.answer[..]));
                self.pump.run(deadline, pass)
            };
            match passed {
                Ok(Outcome::Done(_)) => return Ok(()),
                Ok(Outcome::Refused) => {
                    return Err(self.failure(format!("{what}: the station does not answer")));
                }
                Ok(Outcome::Lost) | Err(Stopped::Deadline) => {}
                Err(stopped) => return Err(self.failed(&what, Failure::Stopped(stopped))),
            }
        }
        Err(self.failure(format!("{what}: two frames were lost; check cables and supplies")))
    }

    fn link_failed(&self, error: io::Error) -> DeviceError {
        self.failed("no exchange", Failure::Stopped(Stopped::Link(error)))
    }
}

/// What is to be passed beside the next cyclic frame: states first.
fn next_job(supervisor: &al::Supervisor, mailboxes: &mut Mailboxes, now: Duration) -> Option<Job> {
    match supervisor.next(now) {
        Some(pdu) => Some(Job::Al(pdu)),
        None => mailboxes.next(now).map(Job::Mail),
    }
}

/// The bytes of a short write.
fn control_bytes(job: Option<Job>) -> [u8; 2] {
    match job {
        Some(Job::Al(AlPdu::Write { control, .. })) => [control, 0],
        Some(Job::Mail(MailPdu { action: MailAction::Repeat { activation }, .. })) => [activation, 0],
        _ => [0, 0],
    }
}

/// The datagram of a job; `None` for a station that there is not.
fn datagram<'a>(
    job: Job,
    stations: &[StationInfo],
    mailboxes: &'a Mailboxes,
    control: &'a [u8; 2],
) -> Option<Datagram<'a>> {
    match job {
        Job::Al(AlPdu::Write { station, .. }) => Some(Datagram {
            address: stations.get(station)?.configured_address,
            register: al::CONTROL,
            content: Content::Write(control),
        }),
        Job::Al(AlPdu::Read { station }) => Some(Datagram {
            address: stations.get(station)?.configured_address,
            register: al::STATUS,
            content: Content::Read { bytes: al::STATUS_BYTES },
        }),
        Job::Mail(MailPdu { station, action }) => {
            let MailArea { address, write_at, read_at, read_bytes, .. } = mailboxes.area(station)?;
            let (register, content) = match action {
                MailAction::Write | MailAction::WriteAbort => {
                    (write_at, Content::Write(mailboxes.outgoing()))
                }
                MailAction::Status => (MAILBOX_STATUS, Content::Read { bytes: 1 }),
                MailAction::RepeatStatus => (MAILBOX_STATUS, Content::Read { bytes: 3 }),
                MailAction::Repeat { .. } => (MAILBOX_ACTIVATION, Content::Write(&control[..1])),
                MailAction::Read => (read_at, Content::Read { bytes: read_bytes }),
            };
            Some(Datagram { address, register, content })
        }
    }
}
