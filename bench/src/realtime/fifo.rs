//! The one call of this room that no safe wrapper offers.

/// Gives the calling thread a real-time priority from 1 to 99. Threads that it starts have none.
///
/// # Errors
/// What the kernel says, EPERM where the right is missing.
#[allow(unsafe_code, reason = "neither the standard library nor rustix nor nix offers it")]
pub(super) fn take_priority(priority: u8) -> std::io::Result<()> {
    let wanted = libc::sched_param { sched_priority: libc::c_int::from(priority) };
    const POLICY: libc::c_int = libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK;
    // SAFETY: 0 names the calling thread. The kernel reads the structure, which lives until the call returns, and keeps no
    // pointer to it. A refused call changes nothing.
    match unsafe { libc::sched_setscheduler(0, POLICY, &raw const wanted) } {
        0 => Ok(()),
        _ => Err(std::io::Error::last_os_error()),
    }
}
