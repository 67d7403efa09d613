//! Numbers of errors (PIPython 2.13, `gcserror.py`, and the E-727 user manual), in words of ours.

/// What the number that `ERR?` gives means.
pub(super) fn error_meaning(code: i32) -> &'static str {
    match code {
        0 => "no error",
        1 => "syntax of a parameter",
        2 => "unknown command",
        3 => "command too long",
        5 => "move refused: no reference, or servo off",
        7 => "position out of the travel limits",
        8 => "velocity out of its limits",
        10 => "stopped by a command",
        15 => "no such axis",
        17 => "parameter out of its range",
        24 => "wrong number of parameters",
        25 => "not a valid number",
        26 => "parameter missing",
        54 => "no such parameter",
        57 => "no such table of the recorder",
        58 => "no such option of the recorder",
        59 => "no such source of the recorder",
        60 => "parameter protected: raise the command level (CCL)",
        64 => "parameter can only be read",
        66 => "voltage limit exceeded",
        67 => "wave too large",
        72 => "the analog input is the target",
        73 => "the wave generator is running",
        76 => "input buffer full: commands come too fast",
        77 => "fewer points recorded than asked for",
        79 => "open-loop value refused: servo on",
        93 => "not allowed while moving",
        302 => "voltage out of its limits",
        303 => "open-loop value refused: servo on",
        555 => "unknown error of the controller",
        _ => "not in the list of this driver: see the manual of the controller",
    }
}
