//! From PRE-OP to SAFE-OP: process data, watchdogs, distributed clocks.

use std::future::Future;
use std::time::Duration;

use ethercrab::DcSync;
use ethercrab::error::Error;
use ethercrab::subdevice_group::{DcConfiguration, NoDc, PreOpPdi};

use super::al::AlState;
use super::group::{Group, Stage, capacity};
use super::open::SYNC_MANAGERS;
use super::pump::Pump;
use super::settings::WATCHDOG_STEP_S;
use super::{EtherCatBus, Failure, Mapped, ProcessImage, Slot};
use crate::device::DeviceError;

/// Longest configuration of one step: each station has 5 s to change its state.
const STEP_LIMIT: Duration = Duration::from_secs(20);
/// Registers of the process-data watchdog.
const WATCHDOG_DIVIDER: u16 = 0x0400;
const WATCHDOG_TIME: u16 = 0x0420;
/// Divider for steps of 100 µs.
const DIVIDER_100_US: u16 = 2498;
/// Sync managers that may carry outputs.
const SYNC_MANAGERS_COUNT: u16 = 4;
/// Sync manager control: mode and direction of outputs in three buffers, and the bit by which they feed the watchdog.
const OUTPUTS: u8 = 0x04;
const FEEDS_WATCHDOG: u8 = 0x40;

type Mapping = Box<Stage<PreOpPdi, NoDc>>;

impl EtherCatBus {
    pub(super) fn configure(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        let sync0_positions = self.sync0_positions()?;
        let mut group = match std::mem::replace(&mut self.group, Group::Gone) {
            Group::PreOp(group) => group,
            mapped => {
                self.group = mapped;
                return Err(self.failure("the bus is mapped already, or has failed: open it anew".to_owned()));
            }
        };
        for (k, mut station) in group.iter_mut(&self.main).enumerate() {
            let has_sync0 = sync0_positions.contains(&k);
            station.set_dc_sync(if has_sync0 { DcSync::Sync0 } else { DcSync::Disabled });
        }
        // ethercrab reads the mappings through the same mailboxes.
        self.pump.mail_counters = self.mailboxes.lend();
        let done = run(&mut self.pump, STEP_LIMIT, group.into_pre_op_pdi(&self.main));
        self.mailboxes.take_back(&std::mem::take(&mut self.pump.mail_counters));
        let group = Box::new(done.map_err(|why| self.failed("process data cannot be mapped", why))?);
        let mapped = self.lay_out(&group)?;
        self.set_watchdogs(&mapped)?;
        self.group = self.enter_safe_op(group)?;
        self.supervisor.set_all(AlState::SafeOp);
        let image =
            ProcessImage { outputs: vec![0; mapped.output_bytes], inputs: vec![0; mapped.input_bytes] };
        let slots = self.stations.iter().map(|s| s.station).zip(mapped.slots.iter().cloned()).collect();
        self.mapped = Some(mapped);
        Ok((image, slots))
    }

    /// The positions of the stations that get SYNC0, counted from 0; none without distributed clocks.
    fn sync0_positions(&self) -> Result<Vec<usize>, DeviceError> {
        let Some(clocks) = &self.settings.distributed_clocks else { return Ok(Vec::new()) };
        let failure = |expected: String, found: String, help| DeviceError::Field {
            device: self.name.clone(),
            field: "distributed clocks",
            expected,
            found,
            help,
        };
        let position = |number: &u16| {
            let found =
                self.stations.iter().position(|station| station.station == *number && station.has_sync0);
            let help = "correct the stations with SYNC0 in the rig file";
            found.ok_or_else(|| {
                failure(format!("a station {number} that can make SYNC0"), "none".to_owned(), help)
            })
        };
        let named: Vec<_> = clocks.sync0_stations.iter().map(position).collect::<Result<_, _>>()?;
        let able = self.stations.iter().enumerate().filter(|(_, station)| station.has_sync0).map(|(k, _)| k);
        let chosen = if named.is_empty() { able.collect() } else { named };
        if chosen.is_empty() {
            let help = "set distributed clocks off for this bus";
            return Err(failure("at least one station with SYNC0".to_owned(), "none".to_owned(), help));
        }
        Ok(chosen)
    }

    /// Brings the stations into SAFE-OP, with SYNC0 if distributed clocks are on.
    fn enter_safe_op(&mut self, group: Mapping) -> Result<Group, DeviceError> {
        let Some(clocks) = &self.settings.distributed_clocks else {
            let done = run(&mut self.pump, STEP_LIMIT, group.into_safe_op(&self.main));
            return done.map(|group| Group::Free(Box::new(group))).map_err(|why| self.not_safe_op(why));
        };
        let timing = DcConfiguration {
            start_delay: Duration::from_secs_f64(clocks.start_delay_s),
            sync0_period: Duration::from_secs_f64(clocks.sync0_period_s),
            sync0_shift: Duration::from_secs_f64(clocks.sync0_shift_s),
        };
        let clocked = run(&mut self.pump, STEP_LIMIT, group.configure_dc_sync(&self.main, timing));
        let clocked = clocked.map_err(|why| self.failed("distributed clocks cannot be set", why))?;
        self.supervisor.hold_op_until(self.pump.link.now() + timing.start_delay + timing.sync0_period);
        let done = run(&mut self.pump, STEP_LIMIT, clocked.into_safe_op(&self.main));
        done.map(|group| Group::Synchronised(Box::new(group))).map_err(|why| self.not_safe_op(why))
    }

    fn not_safe_op(&mut self, why: Failure) -> DeviceError {
        let explained = self.explain_states(self.stations.len() as u16);
        self.failed(&format!("the stations do not reach SAFE-OP{explained}"), why)
    }

    /// Lays the process data out in our image: outputs and inputs in station order.
    fn lay_out(&self, group: &Stage<PreOpPdi, NoDc>) -> Result<Mapped, DeviceError> {
        let (mut outputs_end, mut inputs_end) = (0, 0);
        let mut slots = Vec::new();
        for station in group.iter(&self.main) {
            let (outputs, inputs) = (station.outputs_raw().len(), station.inputs_raw().len());
            slots.push(Slot {
                outputs: outputs_end..outputs_end + outputs,
                inputs: inputs_end..inputs_end + inputs,
            });
            outputs_end += outputs;
            inputs_end += inputs;
        }
        let most = capacity(slots.len());
        let found = outputs_end + inputs_end;
        if found == 0 || found > most {
            return Err(DeviceError::Field {
                device: self.name.clone(),
                field: "process data",
                expected: format!("1 to {most} bytes in one frame"),
                found: format!("{found} bytes"),
                help: "check the mappings of the stations (1C12h, 1C13h)",
            });
        }
        let working_counter = slots.iter().map(super::counted).sum();
        Ok(Mapped { slots, output_bytes: outputs_end, input_bytes: inputs_end, working_counter })
    }

    /// Sets the process-data watchdog of every station with outputs, reads it back and checks that outputs feed it.
    fn set_watchdogs(&mut self, mapped: &Mapped) -> Result<(), DeviceError> {
        let steps = self.settings.watchdog_steps();
        for (k, slot) in mapped.slots.iter().enumerate() {
            if slot.outputs.is_empty() {
                continue;
            }
            let address = self.stations[k].configured_address;
            for (register, value) in [(WATCHDOG_DIVIDER, DIVIDER_100_US), (WATCHDOG_TIME, steps)] {
                self.write_register(address, register, &value.to_le_bytes())?;
                let found = u16::from_le_bytes(self.read_register(address, register)?);
                if found != value {
                    let number = self.stations[k].station;
                    return Err(DeviceError::Field {
                        device: self.name.clone(),
                        field: "process-data watchdog",
                        expected: format!(
                            "{value} in register {register:04X}h of station {number} ({} s)",
                            f64::from(steps) * WATCHDOG_STEP_S
                        ),
                        found: found.to_string(),
                        help: "the station cannot stop by itself when frames stay out: use another type",
                    });
                }
            }
            self.check_feeding(k, address)?;
        }
        Ok(())
    }

    /// Refuses a station whose outputs do not feed its watchdog.
    fn check_feeding(&mut self, k: usize, address: u16) -> Result<(), DeviceError> {
        for manager in 0..SYNC_MANAGERS_COUNT {
            let bytes = self.read_register::<8>(address, SYNC_MANAGERS + 8 * manager)?;
            let is_outputs = bytes[4] & 0x0F == OUTPUTS && bytes[6] & 1 != 0 && bytes[2..4] != [0, 0];
            if is_outputs && bytes[4] & FEEDS_WATCHDOG == 0 {
                return Err(DeviceError::Field {
                    device: self.name.clone(),
                    field: "process-data watchdog",
                    expected: format!(
                        "bit 6 of the control of sync manager {manager} of station {}",
                        self.stations[k].station
                    ),
                    found: format!("control {:02X}h", bytes[4]),
                    help: "the station does not supervise its outputs: correct its SII (category 41)",
                });
            }
        }
        Ok(())
    }
}

/// Drives one of ethercrab's steps to its end.
pub(super) fn run<T>(
    pump: &mut Pump,
    limit: Duration,
    step: impl Future<Output = Result<T, Error>>,
) -> Result<T, Failure> {
    let deadline = pump.link.now() + limit;
    let mut step = Box::pin(step);
    match pump.run(deadline, step.as_mut()) {
        Ok(done) => done.map_err(Failure::EtherCat),
        Err(stopped) => Err(Failure::Stopped(stopped)),
    }
}
