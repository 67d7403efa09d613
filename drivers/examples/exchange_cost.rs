//! What an exchange of this crate's EtherCAT bus costs beside one of ethercrab alone, on the same interface.
//!
//! `cargo run --release -p drivers --example exchange_cost -- INTERFACE [RATE_HZ [BLOCKS [SECONDS]]]`, 1000 Hz and 10 blocks
//! of 5 s unless said. It needs SubDevices behind the interface that may be driven with outputs of 0, e.g. those of
//! `bench sim` in another process, and the right to open packet sockets. Start both with `chrt -f 40`: at the usual
//! priority, percentiles tell more about the computer than about the code.
//!
//! Bare is ethercrab's own exchange (`tx_rx_dc`) and a loop of two calls of the system, send and receive, which waits. It has
//! no protection against late, repeated or foreign frames. Ours is `EtherCatBus::exchange`, with the outputs and inputs of
//! the process image, the supervision of the stations and, in every tenth millisecond, a look into a mailbox.
//!
//! Both are opened once, bare first: the stations then have the addresses, mappings and clocks that ours has given them,
//! which are the same that bare has given them, so that either can exchange. A block is SECONDS of one, then of the other;
//! which one begins changes from block to block. Only one has a socket at a time, and its first 100 ms do not count. The time
//! of an exchange is from just before it is begun until its inputs are there. Exchanges of more than 1 ms are counted apart:
//! they are stalls of the computer. Own part is the time of an exchange without what it waited for the interface; code is the
//! own part without the calls of the system that send and receive (receiving is a wait on the bare side). Between two virtual
//! interfaces, the call that sends also does what the far end's interrupt would do.
//!
//! Exit code: 0 within the limits, 1 outside or not done, 2 usage.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::process::ExitCode;

#[cfg(target_os = "linux")]
#[path = "exchange_cost/bare.rs"]
mod bare;
#[cfg(target_os = "linux")]
#[path = "exchange_cost/clock.rs"]
mod clock;
#[cfg(target_os = "linux")]
#[path = "exchange_cost/compare.rs"]
mod compare;
#[path = "exchange_cost/figures.rs"]
mod figures;
#[cfg(target_os = "linux")]
#[path = "exchange_cost/meter.rs"]
mod meter;
#[cfg(target_os = "linux")]
#[path = "exchange_cost/ours.rs"]
mod ours;

use figures::{BlockFigures, Limits};

/// Limits of the project.
const LIMITS: Limits = Limits { p50_ratio: 1.15, p99_ratio: 1.3 };

/// What is compared, and for how long.
struct Plan {
    interface: String,
    rate_hz: u32,
    blocks: u32,
    seconds: u32,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(plan) = read(&arguments) else {
        eprintln!(
            "usage: exchange_cost INTERFACE [RATE_HZ [BLOCKS [SECONDS]]]; rate 1 to 10000, blocks and seconds 1 to 1000"
        );
        return ExitCode::from(2);
    };
    match compared(&plan) {
        Ok(blocks) => match figures::verdict(&blocks, &LIMITS) {
            Some(true) => ExitCode::SUCCESS,
            Some(false) | None => ExitCode::from(1),
        },
        Err(reason) => {
            eprintln!("exchange_cost: {reason}");
            ExitCode::from(1)
        }
    }
}

fn read(arguments: &[String]) -> Option<Plan> {
    let number = |at: usize, usual: u32, most: u32| match arguments.get(at) {
        None => Some(usual),
        Some(text) => text.parse().ok().filter(|value| (1..=most).contains(value)),
    };
    let interface = arguments.first().filter(|name| !name.starts_with('-'))?.clone();
    let plan = Plan {
        interface,
        rate_hz: number(1, 1000, 10_000)?,
        blocks: number(2, 10, 1000)?,
        seconds: number(3, 5, 1000)?,
    };
    (arguments.len() <= 4).then_some(plan)
}

#[cfg(target_os = "linux")]
fn compared(plan: &Plan) -> Result<Vec<BlockFigures>, String> {
    compare::blocks(plan)
}

#[cfg(not(target_os = "linux"))]
fn compared(plan: &Plan) -> Result<Vec<BlockFigures>, String> {
    let Plan { interface, rate_hz, blocks, seconds } = plan;
    Err(format!("packet sockets need Linux ({interface}, {rate_hz} Hz, {blocks} blocks of {seconds} s)"))
}
