//! Serial ports: opened for this program alone, 8 data bits, no parity, 1 stop bit, no flow control, any bit rate.

use std::fs;
use std::os::fd::OwnedFd;

use rustix::fs::{FlockOperation, Mode, OFlags};
use rustix::io::Errno;
use rustix::termios::{
    ControlModes, InputModes, OptionalActions, QueueSelector, SpecialCodeIndex, Termios, tcflush, tcgetattr,
    tcsetattr,
};

use super::shared::failure;
use crate::device::DeviceError;

/// Largest difference between the bit rate that was asked for and the one that the port keeps. A receiver samples the last
/// bit of a character, the tenth, within half a bit of its middle: both ends together may be off by 5 %.
const MOST_BAUD_ERROR_RATIO: f64 = 0.02;
/// Names of ports that stay the same when adapters change places.
const BY_ID: &str = "/dev/serial/by-id";

/// Opens a port. What had arrived before is thrown away.
///
/// # Errors
/// When there is no such port, it is not to be had, or it cannot do the bit rate.
pub(super) fn open(address: &str, path: &str, baud: u32) -> Result<OwnedFd, DeviceError> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let port = rustix::fs::open(path, flags, Mode::empty()).map_err(|errno| refused(address, errno))?;
    let settings = tcgetattr(&port).map_err(|errno| refused(address, errno))?;
    // The kernel's own exclusive mode does not bind root, the lock does not bind programs that do not ask for it.
    rustix::fs::flock(&port, FlockOperation::NonBlockingLockExclusive)
        .and_then(|()| rustix::termios::ioctl_tiocexcl(&port))
        .map_err(|errno| refused(address, errno))?;
    configure(address, &port, settings, baud)?;
    tcflush(&port, QueueSelector::IOFlush).map_err(|errno| refused(address, errno))?;
    Ok(port)
}

/// Gives a port back. The kernel waits up to 30 s for bytes that a port does not send, so they are thrown away unless all are
/// sent.
pub(super) fn release(port: &OwnedFd, is_sent: bool) {
    // On a port that is gone there is nothing to give back.
    if !is_sent {
        let _ = tcflush(port, QueueSelector::OFlush);
    }
    let _ = rustix::termios::ioctl_tiocnxcl(port);
}

/// Writes the settings and reads them back: the kernel reports success as soon as any of them was taken.
fn configure(address: &str, port: &OwnedFd, mut settings: Termios, baud: u32) -> Result<(), DeviceError> {
    settings.make_raw();
    settings.input_modes.remove(InputModes::IXOFF | InputModes::IXANY);
    settings.control_modes.remove(ControlModes::CSTOPB | ControlModes::CRTSCTS | ControlModes::PARENB);
    settings.control_modes.insert(ControlModes::CLOCAL | ControlModes::CREAD | ControlModes::CS8);
    // With a least count of 0, a port without bytes could not be told from one that is gone.
    settings.special_codes[SpecialCodeIndex::VMIN] = 1;
    settings.special_codes[SpecialCodeIndex::VTIME] = 0;
    settings.set_speed(baud).map_err(|errno| refused(address, errno))?;
    let help = "choose a bit rate that the adapter can do; its data sheet lists them";
    let bit_rate = |found: String| failure(address, "bit rate", format!("{baud} bit/s"), found, help);
    tcsetattr(port, OptionalActions::Now, &settings)
        .map_err(|errno| bit_rate(format!("the port refuses it ({})", std::io::Error::from(errno))))?;
    let kept = tcgetattr(port).map_err(|errno| refused(address, errno))?;
    for found in [kept.input_speed(), kept.output_speed()] {
        if (f64::from(found) / f64::from(baud) - 1.0).abs() > MOST_BAUD_ERROR_RATIO {
            return Err(bit_rate(format!("{found} bit/s")));
        }
    }
    let framing = ControlModes::CSIZE | ControlModes::CSTOPB | ControlModes::PARENB | ControlModes::CRTSCTS;
    if kept.control_modes & framing != ControlModes::CS8 {
        let found = format!("control modes {:o} (octal)", kept.control_modes.bits());
        let expected = "8 data bits, no parity, 1 stop bit, no flow control";
        return Err(failure(address, "framing", expected, found, "use another adapter"));
    }
    Ok(())
}

/// The error of a port that cannot be opened.
fn refused(address: &str, errno: Errno) -> DeviceError {
    let found = std::io::Error::from(errno).to_string();
    let (found, help) = match errno {
        Errno::NOENT | Errno::NODEV | Errno::NXIO => (
            format!("{found}; there are: {}", ports(BY_ID)),
            "plug the adapter in, or correct the address in the rig file",
        ),
        Errno::ACCESS | Errno::PERM => (
            found,
            "give the user the group that owns the port, often `dialout` (`ls -l` shows it), then log in anew",
        ),
        Errno::BUSY | Errno::WOULDBLOCK => (
            format!("one that another program has open ({found})"),
            "end the other program; `fuser -v` with the path shows which it is",
        ),
        Errno::NOTTY | Errno::INVAL | Errno::ISDIR => {
            (format!("something that is no serial port ({found})"), "correct the address in the rig file")
        }
        _ => (found, "check adapter and cable"),
    };
    failure(address, "port", "a serial port that this program has alone", found, help)
}

/// Names of the ports in a folder, in order.
fn ports(folder: &str) -> String {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.path().display().to_string()).collect();
    names.sort();
    if names.is_empty() { format!("none in {folder}") } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_permission_says_how_to_grant_it() {
        let text = refused("serial:/dev/ttyS0?baud=9600", Errno::ACCESS).to_string();
        assert!(text.starts_with("serial:/dev/ttyS0?baud=9600: port: expected a serial port"), "{text}");
        assert!(text.contains("Permission denied") && text.contains("`dialout`"), "{text}");
    }

    #[test]
    fn ports_are_listed_by_names_that_last() {
        let folder = std::env::temp_dir().join(format!("ports-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("made");
        let of_folder = folder.display().to_string();
        assert_eq!(ports(&of_folder), format!("none in {of_folder}"));
        for name in ["usb-b", "usb-a"] {
            fs::write(folder.join(name), "").expect("made");
        }
        assert_eq!(ports(&of_folder), format!("{of_folder}/usb-a, {of_folder}/usb-b"));
        fs::remove_dir_all(&folder).expect("removed");
    }
}
