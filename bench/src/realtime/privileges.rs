//! Privileges of this program, and that it gives them up as soon as sockets and rights of the loop were taken.
//!
//! Linux counts capabilities for each thread, and a thread inherits those of the thread that started it. Therefore the first
//! thread keeps only what the opening of a session needs, without effect; the thread of the session puts it into effect, opens
//! the rig and gives everything up. What is left to root is its way to files of other users: `--out` may lead there.

use reports::record::Grant;
use rustix::thread::{CapabilitySet, CapabilitySets, capabilities, set_capabilities};

/// What an opening needs: packet sockets, real-time priority, locked memory, higher limits.
const OPENING: CapabilitySet = CapabilitySet::NET_RAW
    .union(CapabilitySet::SYS_NICE)
    .union(CapabilitySet::IPC_LOCK)
    .union(CapabilitySet::SYS_RESOURCE);
/// Root's way to files of other users.
const FILES: CapabilitySet = CapabilitySet::DAC_OVERRIDE
    .union(CapabilitySet::DAC_READ_SEARCH)
    .union(CapabilitySet::FOWNER)
    .union(CapabilitySet::CHOWN);

/// The thread that calls, and all that it starts, can from now on do no more than open a session, and only after
/// [`raise`]. To be called before the program starts a thread.
pub fn keep_for_opening() {
    limit(OPENING.union(FILES), FILES);
}

/// Puts the privileges of the opening into effect for the thread that calls.
pub fn raise() {
    limit(OPENING.union(FILES), OPENING.union(FILES));
}

/// Gives up all privileges of the thread that calls, root's way to files excepted.
pub fn give_up() -> Grant {
    limit(FILES, FILES);
    let what = "privileges given up".to_owned();
    match capabilities(None).map(|sets| sets.permitted) {
        Ok(left) if left.is_empty() => Grant {
            what,
            granted: true,
            found: "none is left to the thread of the loop".to_owned(),
            remedy: None,
        },
        Ok(left) if FILES.contains(left) => {
            let found = "root's access to files is left, nothing else".to_owned();
            Grant { what, granted: true, found, remedy: None }
        }
        Ok(left) => {
            let found = format!("the kernel leaves capabilities {:#x}", left.bits());
            Grant { what, granted: false, found, remedy: Some("run the program without root".to_owned()) }
        }
        Err(error) => {
            let remedy = Some("nothing: this kernel has no capabilities".to_owned());
            Grant { what, granted: false, found: error.to_string(), remedy }
        }
    }
}

/// Takes away what is beyond these sets. A kernel that refuses leaves things as they are; [`give_up`] then says so.
fn limit(permitted: CapabilitySet, effective: CapabilitySet) {
    let Ok(now) = capabilities(None) else { return };
    let permitted = now.permitted.intersection(permitted);
    let sets = CapabilitySets {
        permitted,
        effective: permitted.intersection(effective),
        inheritable: CapabilitySet::empty(),
    };
    let _ = set_capabilities(None, sets);
}

#[cfg(test)]
mod tests {
    use rustix::net::{AddressFamily, SocketType};

    use super::*;

    fn sets() -> CapabilitySets {
        capabilities(None).expect("Linux has capabilities")
    }

    #[test]
    fn an_opening_can_be_raised_once_and_nothing_comes_back_after_it() {
        // In threads of their own: what is given up is gone for good.
        let seen = std::thread::spawn(|| {
            let could = sets().permitted;
            keep_for_opening();
            let kept = sets();
            let child = std::thread::spawn(move || {
                raise();
                let raised = sets();
                let grant = give_up();
                raise();
                (raised, sets(), grant)
            });
            (could, kept, child.join().expect("no panic"))
        });
        let (could, kept, (raised, after, grant)) = seen.join().expect("no panic");
        assert!(FILES.contains(kept.effective), "{:?}", kept.effective);
        assert_eq!(kept.permitted, could.intersection(OPENING.union(FILES)));
        assert_eq!(raised.effective, kept.permitted, "a thread inherits what it may raise");
        assert!(FILES.contains(after.permitted) && FILES.contains(after.effective), "{:?}", after.permitted);
        assert!(grant.granted, "{grant:?}");
    }

    #[test]
    fn after_it_no_packet_socket_is_to_be_had() {
        let opened = std::thread::spawn(|| {
            give_up();
            rustix::net::socket(AddressFamily::PACKET, SocketType::RAW, None).map(|_| ())
        });
        assert_eq!(opened.join().expect("no panic"), Err(rustix::io::Errno::PERM));
    }
}
