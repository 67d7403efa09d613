//! What AL status codes mean.

/// What an AL status code (register 0134h, ETG.1000.6 and ETG.1020) means, e.g. 001Bh process-data watchdog.
pub fn al_status_meaning(code: u16) -> &'static str {
    let known = CODES.iter().find(|row| row.0 == code).map(|row| row.1);
    known.unwrap_or(if code >= 0x8000 { "maker specific: see the station's manual" } else { "unknown code" })
}

const CODES: &[(u16, &str)] = &[
    (0x0000, "no error"),
    (0x0001, "unspecified error"),
    (0x0002, "no memory"),
    (0x0003, "invalid device setup"),
    (0x0004, "invalid revision"),
    (0x0006, "SII content does not match the firmware"),
    (0x0007, "firmware update failed"),
    (0x000E, "licence error"),
    (0x0011, "requested state change is not allowed"),
    (0x0012, "unknown requested state"),
    (0x0013, "boot state not supported"),
    (0x0014, "no valid firmware"),
    (0x0015, "invalid mailbox configuration for boot"),
    (0x0016, "invalid mailbox configuration"),
    (0x0017, "invalid sync manager configuration"),
    (0x0018, "no valid inputs"),
    (0x0019, "no valid outputs"),
    (0x001A, "synchronisation error"),
    (0x001B, "process-data watchdog expired: outputs came too late or not at all"),
    (0x001C, "invalid sync manager types"),
    (0x001D, "invalid output configuration"),
    (0x001E, "invalid input configuration"),
    (0x001F, "invalid watchdog configuration"),
    (0x0020, "needs a cold start"),
    (0x0021, "needs INIT"),
    (0x0022, "needs PRE-OP"),
    (0x0023, "needs SAFE-OP"),
    (0x0024, "invalid input mapping"),
    (0x0025, "invalid output mapping"),
    (0x0026, "inconsistent settings"),
    (0x0027, "free run not supported"),
    (0x0028, "synchronisation mode not supported"),
    (0x0029, "free run needs three buffers"),
    (0x002A, "background watchdog"),
    (0x002B, "no valid inputs and outputs"),
    (0x002C, "fatal synchronisation error: SYNC0 is missing"),
    (0x002D, "no synchronisation: SYNC0 was never seen"),
    (0x002E, "cycle time is too small"),
    (0x0030, "invalid configuration of the distributed clock"),
    (0x0031, "invalid latch configuration of the distributed clock"),
    (0x0032, "PLL of the distributed clock is not locked"),
    (0x0033, "input or output error of the distributed clock"),
    (0x0034, "time-out of the distributed clock: frames do not fit SYNC0"),
    (0x0035, "invalid cycle time of the distributed clock"),
    (0x0036, "SYNC0 cycle time is not supported"),
    (0x0037, "SYNC1 cycle time is not supported"),
    (0x0041, "mailbox AoE"),
    (0x0042, "mailbox EoE"),
    (0x0043, "mailbox CoE"),
    (0x0044, "mailbox FoE"),
    (0x0045, "mailbox SoE"),
    (0x004F, "mailbox VoE"),
    (0x0050, "no access to the EEPROM"),
    (0x0051, "EEPROM error"),
    (0x0052, "external hardware is not ready"),
    (0x0060, "restarted by itself"),
    (0x0061, "device identification was changed"),
    (0x0070, "detected modules do not fit the configuration"),
    (0x00F0, "application controller is available"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_ascend_and_unknown_ones_say_so() {
        assert!(CODES.is_sorted_by(|a, b| a.0 < b.0));
        assert_eq!(al_status_meaning(0x1D), "invalid output configuration");
        assert_eq!(al_status_meaning(0x0099), "unknown code");
        assert_eq!(al_status_meaning(0x8001), "maker specific: see the station's manual");
    }
}
