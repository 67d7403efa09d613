//! Network interfaces of Linux: whether one may carry EtherCAT, and whether there is hardware behind it (safety.md §5).
//!
//! What the kernel says stands in files: `/sys/class/net` and `/proc/net`. The checks are given the folder in which these lie, so
//! that tests can bring their own.

use std::fs;
use std::path::{Path, PathBuf};

use drivers::device::DeviceError;

/// What a check found out about an interface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interface {
    /// E.g. `enp3s0`.
    pub name: String,
    /// Whether there is hardware behind it: a card in a slot or on a bus.
    pub is_physical: bool,
    /// The other end of a pair of virtual interfaces, where it is in the same name space.
    pub peer: Option<String>,
    /// Whether it is one end of a pair of virtual interfaces.
    pub is_pair: bool,
}

/// Where the kernel's files lie.
#[derive(Clone, Debug)]
pub struct Kernel {
    root: PathBuf,
}

impl Default for Kernel {
    fn default() -> Self {
        Self { root: PathBuf::from("/") }
    }
}

impl Kernel {
    /// Another root folder, for tests.
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    fn net(&self, name: &str) -> PathBuf {
        self.root.join("sys/class/net").join(name)
    }

    fn text(&self, path: &str) -> String {
        fs::read_to_string(self.root.join(path)).unwrap_or_default()
    }

    fn number(&self, name: &str, file: &str) -> Option<u64> {
        fs::read_to_string(self.net(name).join(file)).ok()?.trim().parse().ok()
    }

    /// Names of all interfaces, in order.
    pub(super) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.root.join("sys/class/net")).into_iter().flatten().flatten();
        let mut names: Vec<String> =
            entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort();
        names
    }

    /// Whether a character device of these numbers, such as a serial port, has a physical device behind it.
    pub(super) fn has_device(&self, major: u32, minor: u32) -> bool {
        self.root.join(format!("sys/dev/char/{major}:{minor}/device")).exists()
    }

    /// What an interface is.
    ///
    /// # Errors
    /// When there is none of this name.
    pub fn interface(&self, name: &str) -> Result<Interface, DeviceError> {
        let names = self.names();
        if name.is_empty() || !names.iter().any(|own| own == name) {
            let reason = format!(
                "no such network interface; found {}; correct its name in the rig file or create it",
                names.join(", ")
            );
            return Err(failure(name, reason));
        }
        let index = self.number(name, "ifindex");
        let link = self.number(name, "iflink");
        let is_physical = self.net(name).join("device").exists();
        // A virtual LAN or a bridge port links to another interface, too, but says what it is.
        let kind = fs::read_to_string(self.net(name).join("uevent")).unwrap_or_default();
        let has_kind = kind.lines().any(|line| line.starts_with("DEVTYPE="));
        let is_pair = !is_physical && !has_kind && link.is_some() && link != index;
        let links_back = |other: &&String| {
            is_pair && self.number(other, "ifindex") == link && self.number(other, "iflink") == index
        };
        let peer = names.iter().find(links_back).cloned();
        Ok(Interface { name: name.to_owned(), is_physical, peer, is_pair })
    }

    /// Refuses an interface that anything else uses: one with an address or a route cannot carry EtherCAT alone.
    ///
    /// # Errors
    /// What uses it, and what to do.
    pub fn check_unused(&self, name: &str, addresses: &[String]) -> Result<(), DeviceError> {
        if !addresses.is_empty() {
            let found = addresses.join(", ");
            let reason = format!(
                "the interface has the address {found}, so programs send other frames through it; expected none: run \
                 `ip addr flush dev {name}` and switch off whatever gives it addresses"
            );
            return Err(failure(name, reason));
        }
        let routes = self.text("proc/net/route");
        let has_route = routes.lines().skip(1).any(|line| line.split_whitespace().next() == Some(name));
        let routes6 = self.text("proc/net/ipv6_route");
        /// Of IPv6 only the default route counts: every interface has one to itself and one for multicast.
        const ANYWHERE: &str = "00000000000000000000000000000000";
        let has_default6 = routes6.lines().any(|line| {
            let mut fields = line.split_whitespace();
            let is_default = fields.next() == Some(ANYWHERE) && fields.next() == Some("00");
            is_default && line.split_whitespace().last() == Some(name)
        });
        if has_route || has_default6 {
            let reason = format!(
                "a route leads through the interface; EtherCAT needs one of its own: run `ip route flush dev {name}`"
            );
            return Err(failure(name, reason));
        }
        Ok(())
    }

    /// Frames that the interface has received since it exists.
    pub fn received(&self, name: &str) -> u64 {
        self.number(name, "statistics/rx_packets").unwrap_or(0)
    }
}

/// Refuses an interface on which somebody sent in a time in which this program did not. `before` and `after` are
/// [`Kernel::received`] at its ends.
///
/// # Errors
/// How many frames came, and what to do.
pub fn check_silent(name: &str, before: u64, after: u64) -> Result<(), DeviceError> {
    let count = after.saturating_sub(before);
    if count == 0 {
        return Ok(());
    }
    let reason = format!(
        "{count} foreign frames arrived before the first of this program was sent; expected none: another MainDevice \
         or an office network is on this cable, or IPv6 or ARP is on at the other end"
    );
    Err(failure(name, reason))
}

pub(crate) fn failure(name: &str, reason: String) -> DeviceError {
    DeviceError::Bus { device: format!("interface {name}"), reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A made-up machine: a card, a pair of virtual interfaces, a virtual LAN.
    fn machine() -> (tempfile::TempDir, Kernel) {
        let root = tempfile::tempdir().expect("a folder");
        let net = root.path().join("sys/class/net");
        for (name, index, link) in [("enp3s0", 2, 2), ("ecm", 7, 8), ("ecs", 8, 7), ("vlan5", 9, 2)] {
            let folder = net.join(name);
            fs::create_dir_all(folder.join("statistics")).expect("created");
            fs::write(folder.join("ifindex"), format!("{index}\n")).expect("written");
            fs::write(folder.join("iflink"), format!("{link}\n")).expect("written");
            fs::write(folder.join("statistics/rx_packets"), "12\n").expect("written");
        }
        fs::create_dir_all(net.join("enp3s0/device")).expect("created");
        fs::write(net.join("vlan5/uevent"), "DEVTYPE=vlan\nINTERFACE=vlan5\n").expect("written");
        fs::create_dir_all(root.path().join("proc/net")).expect("created");
        let routes = "Iface\tDestination\tGateway\nenp3s0\t0000A8C0\t00000000\n";
        fs::write(root.path().join("proc/net/route"), routes).expect("written");
        let kernel = Kernel::at(root.path());
        (root, kernel)
    }

    #[test]
    fn a_pair_of_virtual_interfaces_is_told_from_a_card_and_from_a_virtual_lan() {
        let (_root, kernel) = machine();
        let pair = kernel.interface("ecm").expect("there");
        assert_eq!((pair.is_pair, pair.is_physical, pair.peer.as_deref()), (true, false, Some("ecs")));
        let card = kernel.interface("enp3s0").expect("there");
        assert_eq!((card.is_pair, card.is_physical, card.peer), (false, true, None));
        assert!(!kernel.interface("vlan5").expect("there").is_pair);
    }

    #[test]
    fn a_missing_interface_is_named_with_those_that_there_are() {
        let (_root, kernel) = machine();
        let error = kernel.interface("eth9").expect_err("missing").to_string();
        assert!(error.contains("eth9") && error.contains("ecm, ecs, enp3s0, vlan5"), "{error}");
        assert!(kernel.interface("").is_err());
    }

    #[test]
    fn an_interface_with_an_address_a_route_or_foreign_frames_is_refused() {
        let (_root, kernel) = machine();
        assert!(kernel.check_unused("ecm", &[]).is_ok());
        let error = kernel.check_unused("ecm", &["10.0.0.1".to_owned()]).expect_err("address").to_string();
        assert!(error.contains("10.0.0.1") && error.contains("ip addr flush dev ecm"), "{error}");
        let error = kernel.check_unused("enp3s0", &[]).expect_err("route").to_string();
        assert!(error.contains("route"), "{error}");
        assert!(check_silent("ecm", 12, kernel.received("ecm")).is_ok());
        let error = check_silent("ecm", 9, kernel.received("ecm")).expect_err("foreign").to_string();
        assert!(error.contains("3 foreign frames"), "{error}");
    }
}
