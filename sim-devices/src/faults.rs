//! What can go wrong with a simulated rig, and when.
//!
//! A fault acts at an instant of simulated time inside the simulated devices. The host learns of it only by what the
//! devices then send, or do not send.

use std::time::Duration;

use crate::physics::encoder::EncoderFault;

/// Something that goes wrong, or is put right again. `drive` is 0 for station 1, 1 for station 2 and so on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The encoder of a drive reports an error or a warning, or its checksum is wrong.
    Encoder {
        /// Drive of the encoder.
        drive: usize,
        /// The fault; `None` puts the encoder right again.
        fault: Option<EncoderFault>,
    },
    /// The encoder of a drive goes on sending the angle of this instant, with a right checksum.
    EncoderFrozen {
        /// Drive of the encoder.
        drive: usize,
    },
    /// The scale of an encoder slips: from now on its readings are offset. Offsets add up.
    EncoderJump {
        /// Drive of the encoder.
        drive: usize,
        /// Offset, rad; positive makes the encoder read more.
        by_rad: f64,
    },
    /// The drive detects a fault of its own. It reacts as the fault reaction option code (605Eh) says, where it still can.
    Drive {
        /// Drive that detects the fault.
        drive: usize,
        /// Error code (603Fh).
        code: u16,
    },
    /// The power stage of a drive is stuck: while it is on, it gives this current, whatever is commanded.
    CurrentStuck {
        /// Drive whose current is stuck.
        drive: usize,
        /// The current, A.
        current_a: f64,
    },
    /// Safe torque off of a drive (IEC 61800-5-2): the gates of its power stage are blocked, or released again.
    SafeTorqueOff {
        /// Drive whose gates are blocked.
        drive: usize,
        /// `true` blocks the gates.
        active: bool,
    },
    /// The emergency stop: safe torque off of all drives, and bit 3 of their digital inputs (60FDh: interlock).
    EmergencyStop {
        /// Whether it is pressed.
        pressed: bool,
    },
    /// The enabling switch. Bit 16 of the digital inputs (60FDh) is set while it is held; it is held from the start.
    /// Releasing it takes no torque away by itself.
    EnablingSwitch {
        /// Whether it is held.
        held: bool,
    },
    /// No exchange is answered for a time, or ever again. The drives react as their watchdog (2F00h) and their abort
    /// connection option code (6007h) say.
    BusSilent {
        /// How long; `None` for good.
        lasting: Option<Duration>,
    },
    /// The next frames are lost.
    FramesLost {
        /// How many.
        count: u32,
    },
    /// The mains supply fails: only its capacitor and the energy that the axes regenerate feed the DC link.
    SupplyLost,
    /// The heat sink of a drive takes a temperature at once.
    HeatSink {
        /// Drive of the heat sink.
        drive: usize,
        /// Temperature of the heat sink, °C.
        degc: f64,
    },
    /// The inertial unit sends nothing any more.
    ImuSilent,
    /// The inertial unit goes on sending the rates and accelerations of its last message, with right sequence number and
    /// checksum.
    ImuFrozen,
    /// The gyros of the inertial unit have an additional offset from now on. Offsets add up.
    GyroOffset {
        /// Offset of each of the three gyros, rad/s.
        by_rad_per_s: f64,
    },
}

impl Fault {
    /// The drive that the fault concerns; `None` for a fault that concerns no single drive.
    pub fn drive(&self) -> Option<usize> {
        match *self {
            Self::Encoder { drive, .. }
            | Self::EncoderFrozen { drive }
            | Self::EncoderJump { drive, .. }
            | Self::Drive { drive, .. }
            | Self::CurrentStuck { drive, .. }
            | Self::SafeTorqueOff { drive, .. }
            | Self::HeatSink { drive, .. } => Some(drive),
            Self::EmergencyStop { .. }
            | Self::EnablingSwitch { .. }
            | Self::BusSilent { .. }
            | Self::FramesLost { .. }
            | Self::SupplyLost
            | Self::ImuSilent
            | Self::ImuFrozen
            | Self::GyroOffset { .. } => None,
        }
    }

    /// Whether the fault concerns the inertial unit.
    pub(crate) fn is_of_imu(&self) -> bool {
        matches!(self, Self::ImuSilent | Self::ImuFrozen | Self::GyroOffset { .. })
    }
}

/// Faults to come, by time.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaultSchedule {
    /// Latest first, so that the next one is at the end and can be popped.
    waiting: Vec<(Duration, Fault)>,
}

impl FaultSchedule {
    /// Schedules a fault. Faults of the same instant act in the order in which they were added.
    pub(crate) fn add(&mut self, at: Duration, fault: Fault) {
        let index = self.waiting.partition_point(|(waiting_at, _)| *waiting_at > at);
        self.waiting.insert(index, (at, fault));
    }

    /// Removes the next fault that is due by `now`; the instant at which it acts comes first.
    pub(crate) fn pop(&mut self, now: Duration) -> Option<(Duration, Fault)> {
        self.waiting.pop_if(|(at, _)| *at <= now)
    }
}

/// Turns the true angle into the one that a faulty encoder measures, before it is quantised.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EncoderView {
    /// Angle at which the encoder is frozen.
    held_rad: Option<f64>,
    /// Sum of all slips; positive makes the encoder read more.
    jump_rad: f64,
}

impl EncoderView {
    /// The measured angle at a true angle.
    #[inline]
    pub(crate) fn seen_rad(&self, angle_rad: f64) -> f64 {
        self.held_rad.unwrap_or(angle_rad + self.jump_rad)
    }

    /// Freezes the measured angle at its value for this true angle.
    pub(crate) fn freeze(&mut self, angle_rad: f64) {
        self.held_rad = Some(self.seen_rad(angle_rad));
    }

    /// Adds an offset to the measured angle. It has no effect on a frozen encoder.
    pub(crate) fn slip(&mut self, by_rad: f64) {
        self.jump_rad += by_rad;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_kept_in_order_of_time_and_then_of_entry() {
        let at = Duration::from_millis;
        let mut schedule = FaultSchedule::default();
        schedule.add(at(20), Fault::SupplyLost);
        schedule.add(at(10), Fault::EmergencyStop { pressed: true });
        schedule.add(at(10), Fault::EmergencyStop { pressed: false });
        assert_eq!(schedule.pop(at(9)), None);
        assert_eq!(schedule.pop(at(30)), Some((at(10), Fault::EmergencyStop { pressed: true })));
        assert_eq!(schedule.pop(at(30)), Some((at(10), Fault::EmergencyStop { pressed: false })));
        assert_eq!(schedule.pop(at(19)), None);
        assert_eq!(schedule.pop(at(20)), Some((at(20), Fault::SupplyLost)));
        assert_eq!(schedule.pop(Duration::MAX), None);
    }

    #[test]
    fn a_frozen_encoder_stays_where_it_slipped_to() {
        let mut view = EncoderView::default();
        assert_eq!(view.seen_rad(0.5), 0.5);
        view.slip(0.25);
        assert_eq!(view.seen_rad(0.5), 0.75);
        view.freeze(0.5);
        assert_eq!(view.seen_rad(1.5), 0.75);
    }
}
