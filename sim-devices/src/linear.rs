//! The unit linearised: transfer functions of its loops.
