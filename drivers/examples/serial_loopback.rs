//! A serial port whose output is wired to its input: what it loses, and how long bytes take through adapter and kernel.
//!
//! `cargo run --release -p drivers --example serial_loopback -- serial:/dev/ttyUSB0?baud=921600 [SECONDS [MOST_MS]]`, 10 s and
//! 2 ms unless said. On RS-422, join TX+ to RX+ and TX− to RX−.
//!
//! Frames of 36 bytes, as long as those of a KVH 1775, go out one every 1.25 times their time on the wire, and not more often
//! than 1000 a second. Each carries its number and a CRC-32. A frame counts as lost when it
//! has not come half a second after the last byte. The way of a frame is the time from the write to the read that completes it, less its
//! own time on the wire: it is what the delay of the adapter (the FIFO of a UART, the latency timer of a USB adapter) and the
//! kernel add. A driver that waits between reads would add its own time: this one reads every 50 us.
//!
//! Exit code: 0 nothing lost or damaged and 99 % of the ways at most MOST_MS, 1 otherwise, 2 usage, 4 no such port.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::process::ExitCode;

#[cfg(target_os = "linux")]
#[path = "exchange_cost/clock.rs"]
mod clock;
#[cfg(target_os = "linux")]
#[path = "serial_loopback/echo.rs"]
mod echo;

#[cfg(not(target_os = "linux"))]
fn main() -> ExitCode {
    eprintln!("serial_loopback runs on Linux only");
    ExitCode::from(2)
}

#[cfg(target_os = "linux")]
fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(plan) = echo::Plan::read(&arguments) else {
        eprintln!("usage: serial_loopback serial:/dev/ttyUSB0?baud=921600 [SECONDS [MOST_MS]]");
        return ExitCode::from(2);
    };
    match echo::measure(&plan) {
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(4)
        }
        Ok(figures) => {
            println!("{}", figures.text(&plan));
            if figures.is_within(&plan) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
    }
}
