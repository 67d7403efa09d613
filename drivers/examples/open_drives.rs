//! Brings an EtherCAT line of drives of any maker up, exchanges process data and takes it down again.
//!
//! `cargo run -p drivers --example open_drives -- INTERFACE [--cycles N] [--cycle-us US] [--sync0] [--enable]
//! [--read INDEX:SUB]... [--probe]`, 1000 cycles of 1000 us unless said. It needs the right to open packet sockets; start it
//! with `chrt -f 40`, else the lateness tells about the computer.
//!
//! It lists the stations (name, vendor, product, revision, serial number), the process data that each is mapped to, and what
//! the driver `Cia402` misses in the dictionary of each CiA 402 drive. The stations go to SAFE-OP and OP and back to INIT.
//! Nothing is written into a dictionary, unless `--enable` is given for a drive that has all that `Cia402` needs.
//!
//! `--sync0` switches on distributed clocks and SYNC0 once a cycle, frames half-way between. `--enable` enables the first
//! CiA 402 drive, in cyclic velocity or, if it cannot do that, in cyclic torque, with a setpoint of 0: a drive in torque mode
//! does not hold its axis. With `Cia402` where the dictionary of the drive has all that it needs, else with its power state
//! machine alone on the mapping that the drive has. `--read` reads an object of every station, indices and sub-indices
//! in hexadecimal digits. `--probe` asks each station for an object that there is not (7FFFh) and writes its device type
//! (1000h), which a drive must refuse, and says how it does.
//!
//! Exit code: 0 done without a wrong working counter, an AL error or an emergency; 1 not so; 2 usage.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::process::ExitCode;

#[path = "open_drives/arguments.rs"]
mod arguments;
#[cfg(target_os = "linux")]
#[path = "open_drives/axis.rs"]
mod axis;
#[cfg(target_os = "linux")]
#[path = "exchange_cost/clock.rs"]
mod clock;
#[cfg(target_os = "linux")]
#[path = "open_drives/cycles.rs"]
mod cycles;
#[cfg(target_os = "linux")]
#[path = "open_drives/mapping.rs"]
mod mapping;
#[cfg(target_os = "linux")]
#[path = "open_drives/objects.rs"]
mod objects;
#[cfg(target_os = "linux")]
#[path = "open_drives/session.rs"]
mod session;

use arguments::Plan;

fn main() -> ExitCode {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let plan = match arguments::read(&given) {
        Ok(plan) => plan,
        Err(reason) => {
            eprintln!("open_drives: {reason}\n{}", arguments::USAGE);
            return ExitCode::from(2);
        }
    };
    match pass(&plan) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(reason) => {
            eprintln!("open_drives: {reason}");
            ExitCode::from(1)
        }
    }
}

#[cfg(target_os = "linux")]
fn pass(plan: &Plan) -> Result<bool, String> {
    session::pass(plan)
}

#[cfg(not(target_os = "linux"))]
fn pass(plan: &Plan) -> Result<bool, String> {
    Err(format!("packet sockets need Linux: {plan:?}"))
}
