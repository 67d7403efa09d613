//! Interlocks on what the bench sees and on the bench itself: frames, samples, channels, the loop, the log.

use super::{Interlock, View, above};

/// A part of the bench that says nothing for longer than this hangs (safety.md: liveness).
const SILENCE_S: f64 = 0.1;
/// Share of the ring to the log's writer at which the run is stopped (safety.md: deadlines).
const RING_RATIO: f64 = 0.9;
/// Unit of the angles that frozen channels are judged by.
const MICRORADIANS: f64 = 1e6;

pub(crate) const BUS: Interlock = Interlock {
    name: "bus",
    doc: "Three exchanges in a row, or five in a hundred, without a frame or with a wrong working counter.",
    unit: "exchanges",
    shared: true,
    steerable: false,
    check: |v| match (v.bad_exchanges_in_row, v.bad_exchanges_in_100) {
        (row, _) if row >= 3 => Some((f64::from(row), 3.0)),
        (_, hundred) if hundred >= 5 => Some((f64::from(hundred), 5.0)),
        _ => None,
    },
};

pub(crate) const STALE_DATA: Interlock = Interlock {
    name: "stale data",
    doc: "The newest sample of the axis is older than the rig allows.",
    unit: "s",
    shared: false,
    steerable: false,
    check: |v| above(v.age_s, v.guard.safety.watchdog_s),
};

pub(crate) const MISSED_CYCLES: Interlock = Interlock {
    name: "missed cycles",
    doc: "The loop missed more periods in a row than the rig allows.",
    unit: "periods",
    shared: true,
    steerable: true,
    check: |v| above(f64::from(v.missed_periods), f64::from(v.max_missed_periods)),
};

pub(crate) const FROZEN_ENCODER: Interlock = Interlock {
    name: "frozen encoder",
    doc: "The count has not changed for 50 ms although, by gyro, torque or its own speed, the axis must \
          have moved by more than 20 counts.",
    unit: "urad",
    shared: false,
    steerable: true,
    check: |v| {
        let (missed_rad, limit_rad) = v.memory.frozen_encoder()?;
        above(MICRORADIANS * missed_rad, MICRORADIANS * limit_rad)
    },
};

pub(crate) const RATE_FEEDBACK: Interlock = Interlock {
    name: "rate feedback",
    doc: "The velocity loop of the axis has had no valid sample for too long.",
    unit: "s",
    shared: true,
    steerable: true,
    check: |v| above(v.feedback_age_s, v.guard.safety.watchdog_s).filter(|_| by_gyro(v)),
};

pub(crate) const FROZEN_GYRO: Interlock = Interlock {
    name: "frozen gyro",
    doc: "The gyro has sent the same rates, or the same message number, for 50 ms while the encoder moved.",
    unit: "urad",
    shared: true,
    steerable: true,
    check: |v| {
        let (missed_rad, limit_rad) = v.memory.frozen_gyro()?;
        above(MICRORADIANS * missed_rad, MICRORADIANS * limit_rad).filter(|_| by_gyro(v))
    },
};

pub(crate) const RATE_DISAGREEMENT: Interlock = Interlock {
    name: "rate disagreement",
    doc: "Gyro and encoder do not agree on the rate of the axis: one of them is wrong, or wired wrongly.",
    unit: "rad/s",
    shared: false,
    steerable: false,
    check: |v| {
        let seen = v.feedback_disagreement_rad_per_s.abs();
        above(seen, v.guard.safety.max_rate_disagreement_rad_per_s).filter(|_| by_gyro(v))
    },
};

pub(crate) const TRACKER_LOST: Interlock = Interlock {
    name: "tracker lost",
    doc: "An axis follows a target that the coarse tracker has lost for three frames: they did not arrive \
          or did not show it.",
    unit: "s",
    shared: true,
    steerable: true,
    check: |v| {
        let (missing_s, limit_s) = v.target_missing_s?;
        above(missing_s, limit_s).filter(|_| v.expects_operation)
    },
};

pub(crate) const LIVENESS: Interlock = Interlock {
    name: "liveness",
    doc: "The log writer has not responded for 100 ms; a control loop that hangs is stopped by the \
          watchdogs of its drives.",
    unit: "s",
    shared: true,
    steerable: true,
    check: |v| above(v.silent_s, SILENCE_S),
};

pub(crate) const LOG_RING: Interlock = Interlock {
    name: "log ring",
    doc: "The ring to the log's writer is 90 % full: the log would lose rows.",
    unit: "ratio",
    shared: true,
    steerable: true,
    // At the limit is too much already.
    check: |v| (v.ring_ratio >= RING_RATIO || v.ring_ratio.is_nan()).then_some((v.ring_ratio, RING_RATIO)),
};

fn by_gyro(view: &View<'_>) -> bool {
    view.uses_gyro && view.expects_operation
}
