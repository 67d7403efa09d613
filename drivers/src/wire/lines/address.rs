//! Addresses of lines and ports of the operating system.

use std::fmt;
use std::net::SocketAddr;

/// Slowest bit rate that an address may name, bit/s: the slowest that the kernel has a name for.
const MIN_BAUD: u32 = 50;
/// Fastest bit rate that an address may name, bit/s: above what any adapter for RS-422 does.
const MAX_BAUD: u32 = 50_000_000;

/// Where a device is connected that speaks bytes or datagrams.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LineAddress {
    /// A serial port, `serial:/dev/ttyUSB0?baud=921600`: 8 data bits, no parity, 1 stop bit, no flow control.
    Serial {
        /// Path of the port. Names in `/dev/serial/by-id` stay the same when adapters change places.
        path: String,
        /// Bit rate, bit/s. Any number that the adapter can do; it need not be one that the kernel has a name for.
        baud: u32,
    },
    /// A TCP connection, `tcp:192.168.1.20:5025`.
    Tcp {
        /// Name or IP address of the device.
        host: String,
        /// Port of the device.
        port: u16,
    },
    /// Datagrams to and from one peer, `udp:192.168.1.21:6000?bind=192.168.1.2:6001`. Datagrams of others are not taken.
    Udp {
        /// Name or IP address of the device.
        host: String,
        /// Port that the device sends from and listens at.
        port: u16,
        /// Address and port of this computer that the device sends to.
        bind: SocketAddr,
    },
}

/// Sorts of lines, as addresses begin with them.
pub const LINE_SORTS: [&str; 3] = ["serial", "tcp", "udp"];

impl LineAddress {
    /// Reads an address.
    ///
    /// # Errors
    /// How an address of this sort is written.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (sort, rest) = text.split_once(':').unwrap_or((text, ""));
        match sort {
            "serial" => serial(rest).ok_or_else(|| {
                format!(
                    "write path and bit rate of the port, e.g. `serial:/dev/ttyUSB0?baud=921600`; bit rates are \
                     {MIN_BAUD} to {MAX_BAUD}"
                )
            }),
            "tcp" => {
                let found = host_and_port(rest).map(|(host, port)| Self::Tcp { host, port });
                found.ok_or_else(|| "write host and port of the device, e.g. `tcp:192.168.1.20:5025`".to_owned())
            }
            "udp" => udp(rest).ok_or_else(|| {
                "write host and port of the device, and the own address that it sends to, e.g. \
                 `udp:192.168.1.21:6000?bind=192.168.1.2:6001`"
                    .to_owned()
            }),
            _ => Err(format!("write type and place of the line; types are {}", LINE_SORTS.join(", "))),
        }
    }
}

fn serial(rest: &str) -> Option<LineAddress> {
    let (path, baud) = rest.split_once("?baud=")?;
    let is_path = path.starts_with('/') && !path.contains('\0');
    let baud = baud.parse().ok().filter(|baud| (MIN_BAUD..=MAX_BAUD).contains(baud))?;
    is_path.then(|| LineAddress::Serial { path: path.to_owned(), baud })
}

fn udp(rest: &str) -> Option<LineAddress> {
    let (peer, bind) = rest.split_once("?bind=")?;
    let (host, port) = host_and_port(peer)?;
    Some(LineAddress::Udp { host, port, bind: bind.parse().ok()? })
}

/// A host, of which an IPv6 address stands in brackets, and a port.
fn host_and_port(text: &str) -> Option<(String, u16)> {
    let (host, port) = text.rsplit_once(':')?;
    let port = port.parse().ok().filter(|&port: &u16| port > 0)?;
    let host = match host.strip_prefix('[') {
        Some(v6) => v6.strip_suffix(']').filter(|v6| v6.contains(':'))?,
        None => Some(host).filter(|host| !host.contains(':'))?,
    };
    let is_name = !host.is_empty() && host.chars().all(|c| c.is_ascii_alphanumeric() || "-._:%".contains(c));
    is_name.then(|| (host.to_owned(), port))
}

impl fmt::Display for LineAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial { path, baud } => write!(f, "serial:{path}?baud={baud}"),
            Self::Tcp { host, port } => write!(f, "tcp:{}:{port}", bracketed(host)),
            Self::Udp { host, port, bind } => write!(f, "udp:{}:{port}?bind={bind}", bracketed(host)),
        }
    }
}

fn bracketed(host: &str) -> String {
    if host.contains(':') { format!("[{host}]") } else { host.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_comes_back_as_it_was_written() {
        let all = [
            "serial:/dev/ttyUSB0?baud=921600",
            "serial:/dev/serial/by-id/usb-FTDI_FT232H-if00-port0?baud=4147200",
            "tcp:192.168.1.20:5025",
            "tcp:scope.lab:5025",
            "tcp:[fe80::1%eth0]:5025",
            "udp:192.168.1.21:6000?bind=192.168.1.2:6001",
            "udp:[::1]:6000?bind=[::1]:6001",
        ];
        for text in all {
            assert_eq!(LineAddress::parse(text).map(|address| address.to_string()), Ok(text.to_owned()));
        }
    }

    #[test]
    fn what_is_no_address_is_told_how_one_is_written() {
        let wrong = [
            ("", "write type and place of the line; types are serial, tcp, udp"),
            ("ttyUSB0", "write type and place of the line; types are serial, tcp, udp"),
            ("serial:", "write path and bit rate"),
            ("serial:/dev/ttyUSB0", "write path and bit rate"),
            ("serial:ttyUSB0?baud=9600", "write path and bit rate"),
            ("serial:/dev/ttyUSB0?baud=0", "write path and bit rate"),
            ("serial:/dev/ttyUSB0?baud=1e6", "write path and bit rate"),
            ("serial:/dev/ttyUSB0?baud=9600?baud=9600", "write path and bit rate"),
            ("tcp:host", "write host and port"),
            ("tcp::5025", "write host and port"),
            ("tcp:host:0", "write host and port"),
            ("tcp:host:70000", "write host and port"),
            ("tcp:::1:5025", "write host and port"),
            ("tcp:[host]:5025", "write host and port"),
            ("tcp:a b:5025", "write host and port"),
            ("udp:127.0.0.1:6000", "write host and port of the device, and the own address"),
            ("udp:127.0.0.1:6000?bind=6001", "write host and port of the device, and the own address"),
        ];
        for (text, expected) in wrong {
            let error = LineAddress::parse(text).expect_err(text);
            assert!(error.starts_with(expected), "{text}: {error}");
        }
    }
}
