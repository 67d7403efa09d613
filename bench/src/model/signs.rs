//! Kinds of procedures that others rely on: what closes a loop comes after those that prove signs, and torques follow the
//! measured torque constants.

/// Proves signs and scales of torque, encoders and gyros with open loops; the name of the gate that it opens, too.
pub(crate) const POLARITY: &str = "polarity";

/// Shows on which side a tracker sees a motion. Where it saw nothing, no loop is closed on it; what only a mirror of a
/// milliradian follows needs no more than that no fault was found.
pub(crate) const TRACKER_SIGN: &str = "tracker-latency";

/// Kinds that show signs of trackers and mirror: a selection that closes loops behind them takes them along.
pub(crate) const SHOW_SIGNS: [&str; 2] = [TRACKER_SIGN, "optical-gain"];

/// Measures the torque constant of an axis, by which every torque of a run is told that rests on its current.
pub(crate) const TORQUE_CONSTANT: &str = "torque-constant";
