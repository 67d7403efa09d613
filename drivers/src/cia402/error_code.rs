//! What error codes mean.

/// What a CiA 402 error code (603Fh, and the code of an emergency message) means, e.g. 4310h drive over-temperature.
/// A code that is not in the table is named by its class (IEC 61800-7-201).
pub fn error_code_meaning(code: u16) -> &'static str {
    CODES.iter().find(|(known, _)| *known == code).map_or_else(|| class_meaning(code), |(_, meaning)| meaning)
}

fn class_meaning(code: u16) -> &'static str {
    match code >> 8 {
        0x00 => "no error",
        0x10 => "generic error",
        0x20..=0x2F => "current (class 2xxxh)",
        0x30..=0x3F => "voltage (class 3xxxh)",
        0x40..=0x4F => "temperature (class 4xxxh)",
        0x50..=0x5F => "device hardware (class 5xxxh)",
        0x60..=0x6F => "device software (class 6xxxh)",
        0x70..=0x7F => "additional modules, e.g. sensors (class 7xxxh)",
        0x80..=0x8F => "monitoring, e.g. communication (class 8xxxh)",
        0x90..=0x9F => "external error (class 9xxxh)",
        0xFF => "manufacturer specific: see the drive's manual",
        0xF0..=0xFE => "additional functions (class Fxxxh)",
        _ => "unknown error code",
    }
}

const CODES: &[(u16, &str)] = &[
    (0x0000, "no error"),
    (0x1000, "generic error"),
    (0x2310, "continuous over-current at the output"),
    (0x2320, "short circuit or earth leakage at the output"),
    (0x2330, "earth leakage at the output"),
    (0x2340, "short circuit at the output"),
    (0x2350, "thermal overload of the motor (I²t)"),
    (0x3110, "mains over-voltage"),
    (0x3120, "mains under-voltage"),
    (0x3130, "mains phase failure"),
    (0x3210, "DC link over-voltage"),
    (0x3220, "DC link under-voltage"),
    (0x3230, "DC link load error"),
    (0x4110, "excess ambient temperature"),
    (0x4210, "device over-temperature"),
    (0x4310, "drive over-temperature"),
    (0x4410, "supply over-temperature"),
    (0x5112, "24 V supply low"),
    (0x5113, "5 V supply low"),
    (0x5400, "power stage"),
    (0x5441, "contact of the enable or safe torque off input opened"),
    (0x5530, "non-volatile memory"),
    (0x6010, "software watchdog"),
    (0x6320, "parameter error"),
    (0x7110, "brake chopper"),
    (0x7113, "brake chopper over-current"),
    (0x7121, "motor blocked"),
    (0x7122, "motor error or commutation malfunction"),
    (0x7300, "sensor"),
    (0x7305, "incremental sensor 1"),
    (0x7306, "incremental sensor 2"),
    (0x7310, "speed"),
    (0x7320, "position"),
    (0x7500, "communication"),
    (0x8110, "process data lost (overrun)"),
    (0x8130, "heartbeat or life guarding"),
    (0x8140, "recovered from bus off"),
    (0x8311, "excess torque"),
    (0x8400, "velocity controller"),
    (0x8500, "position controller"),
    (0x8600, "positioning controller"),
    (0x8611, "following error"),
    (0x8612, "reference limit"),
    (0x8700, "synchronisation controller"),
    (0xF001, "deceleration"),
    (0xF002, "sub-synchronous run"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_ascend_and_unknown_ones_fall_back_to_their_class() {
        assert!(CODES.is_sorted_by(|a, b| a.0 < b.0));
        assert_eq!(error_code_meaning(0x4310), "drive over-temperature");
        assert_eq!(error_code_meaning(0x8611), "following error");
        assert_eq!(error_code_meaning(0x2345), "current (class 2xxxh)");
        assert_eq!(error_code_meaning(0xFF07), "manufacturer specific: see the drive's manual");
        assert_eq!(error_code_meaning(0xABCD), "unknown error code");
    }
}
