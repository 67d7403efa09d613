//! Errors of gyros and accelerometers.
