//! Exit codes: part of the command-line contract.

/// Why the program ends, as the number that scripts see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExitCode {
    /// The number.
    pub code: u8,
    /// One line: what it means.
    pub meaning: &'static str,
}

/// Pass or conditional pass; a screening without a shortfall.
pub const PASS: u8 = 0;
/// Fail or conditional fail; a difference between runs that are compared.
pub const FAIL: u8 = 1;
/// Usage, unreadable input, bad file.
pub const USAGE: u8 = 2;
/// Inconclusive, incomplete, trip or abort in motion; findings that differ when they are judged again.
pub const INCONCLUSIVE: u8 = 3;
/// Bench, device or output I/O.
pub const BENCH: u8 = 4;
/// Nothing selected.
pub const NOTHING_SELECTED: u8 = 5;
/// Refused before motion.
pub const REFUSED: u8 = 6;
/// Damaged log, or a run folder that was altered; results still written from what is whole.
pub const DAMAGED: u8 = 65;
/// Internal error.
pub const INTERNAL: u8 = 70;
/// Stopped by a signal, the rig is safe: 128 and the number of the signal, as shells count.
pub const SIGHUP: u8 = 129;
/// See [`SIGHUP`].
pub const SIGINT: u8 = 130;
/// See [`SIGHUP`].
pub const SIGQUIT: u8 = 131;
/// See [`SIGHUP`].
pub const SIGTERM: u8 = 143;
/// See [`SIGHUP`].
pub const SIGXCPU: u8 = 152;

/// All codes, the one that wins first.
pub const EXIT_CODES: &[ExitCode] = &[
    ExitCode { code: SIGINT, meaning: "stopped by SIGINT (Ctrl-C); the rig was brought to its safe state" },
    ExitCode { code: SIGTERM, meaning: "stopped by SIGTERM; the rig was brought to its safe state" },
    ExitCode { code: SIGHUP, meaning: "stopped by SIGHUP; the rig was brought to its safe state" },
    ExitCode {
        code: SIGQUIT,
        meaning: "stopped by SIGQUIT (Ctrl-\\); the rig was brought to its safe state",
    },
    ExitCode {
        code: SIGXCPU,
        meaning: "stopped by SIGXCPU (limit of processor time); the rig was brought to its safe state",
    },
    ExitCode { code: INTERNAL, meaning: "internal error: a defect in the bench, please report it" },
    ExitCode {
        code: FAIL,
        meaning: "a requirement is not met (fail or conditional fail); `compare` finds a difference; `regress` finds the candidate worse",
    },
    ExitCode { code: BENCH, meaning: "the bench, a device or the output failed (I/O)" },
    ExitCode {
        code: DAMAGED,
        meaning: "a log is damaged or a run folder was altered; results were written from the intact part",
    },
    ExitCode {
        code: REFUSED,
        meaning: "refused before motion: limits, gates or devices do not allow the run",
    },
    ExitCode {
        code: INCONCLUSIVE,
        meaning: "inconclusive or incomplete, a trip or abort in motion, or `rejudge` finds other results \
                  with the same limits",
    },
    ExitCode { code: PASS, meaning: "pass or conditional pass; a screening without a shortfall" },
    ExitCode { code: USAGE, meaning: "usage: bad command line, unreadable input or a mistake in a file" },
    ExitCode { code: NOTHING_SELECTED, meaning: "nothing selected" },
];

/// The one of two codes that wins.
pub fn worse(a: u8, b: u8) -> u8 {
    let rank = |code: u8| EXIT_CODES.iter().position(|e| e.code == code).unwrap_or(0);
    if rank(a) <= rank(b) { a } else { b }
}

/// The code of a run that came to `code`, where somebody must look at the rig: an axis met its end stop or was not left at
/// standstill. That is 4 whatever else was found: neither a verdict nor a signal may hide it.
pub fn of_run(code: u8, somebody_must_look: bool) -> u8 {
    if somebody_must_look { BENCH } else { code }
}
