//! Piezo actuator: hysteresis and creep.
