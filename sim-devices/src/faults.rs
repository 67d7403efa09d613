//! What can go wrong with a simulated rig, and when.
//!
//! A fault acts at an instant of world time, on the far side of the wires: the host learns of it only by what the
//! devices then say, or do not say.

use std::time::Duration;

use crate::physics::encoder::EncoderFault;

/// Something that goes wrong, or is put right again. `drive` is 0 for station 1, 1 for station 2 and so on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The encoder of a drive says that something is wrong with it, or nothing any more.
    Encoder {
        /// Whose.
        drive: usize,
        /// What; `None` puts it right.
        fault: Option<EncoderFault>,
    },
    /// The encoder of a drive goes on sending the angle of this instant, with a right checksum.
    EncoderFrozen {
        /// Whose.
        drive: usize,
    },
    /// The scale of an encoder slips: from now on it reads this much more.
    EncoderJump {
        /// Whose.
        drive: usize,
        /// By how much, rad.
        by_rad: f64,
    },
    /// The drive finds a fault of its own, with this error code (603Fh); it reacts by 605Eh where it still can.
    Drive {
        /// Which.
        drive: usize,
        /// Error code.
        code: u16,
    },
    /// The power stage of a drive goes on giving this current whatever it is told, as long as it is on.
    CurrentStuck {
        /// Which.
        drive: usize,
        /// The current, A.
        current_a: f64,
    },
    /// Safe torque off of a drive (IEC 61800-5-2): the gates of its power stage are blocked, or released again.
    SafeTorqueOff {
        /// Which.
        drive: usize,
        /// Whether it acts.
        active: bool,
    },
    /// The emergency stop: safe torque off of all drives, and bit 3 of their digital inputs (60FDh: interlock).
    EmergencyStop {
        /// Whether it is pressed.
        pressed: bool,
    },
    /// The enabling switch: bit 16 of the digital inputs (60FDh) while it is held, as it is from the start. It takes no
    /// torque away by itself.
    EnablingSwitch {
        /// Whether it is held.
        held: bool,
    },
    /// No exchange is answered for this long, or for good. What the drives do about it is 2F00h and 6007h.
    BusSilent {
        /// How long; `None` for good.
        lasting: Option<Duration>,
    },
    /// The next frames are lost.
    FramesLost {
        /// How many.
        count: u32,
    },
    /// The mains are gone: the DC link lives on its capacitor and on what the axes feed back.
    SupplyLost,
    /// The heat sink of a drive is this hot now.
    HeatSink {
        /// Whose.
        drive: usize,
        /// Temperature of the drive, °C.
        degc: f64,
    },
    /// The inertial unit sends nothing any more.
    ImuSilent,
    /// The inertial unit goes on sending the rates of its last message, numbered and summed as they should be.
    ImuFrozen,
    /// The gyros of the inertial unit read this much more from now on.
    GyroOffset {
        /// By how much, each axis of the unit, rad/s.
        by_rad_per_s: f64,
    },
}

impl Fault {
    /// The drive that it concerns; `None` for what belongs to no single one.
    pub(crate) fn drive(&self) -> Option<usize> {
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

    /// Whether it befalls the inertial unit.
    pub(crate) fn is_of_imu(&self) -> bool {
        matches!(self, Self::ImuSilent | Self::ImuFrozen | Self::GyroOffset { .. })
    }
}

/// Faults to come, by time.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaultSchedule {
    /// The next one last.
    waiting: Vec<(Duration, Fault)>,
}

impl FaultSchedule {
    /// What is put down for the same instant happens in the order in which it was put down.
    pub(crate) fn add(&mut self, at: Duration, fault: Fault) {
        let place = self.waiting.partition_point(|(later, _)| *later > at);
        self.waiting.insert(place, (at, fault));
    }

    /// The next fault that is due by `now`, and when it is.
    pub(crate) fn pop(&mut self, now: Duration) -> Option<(Duration, Fault)> {
        self.waiting.pop_if(|(at, _)| *at <= now)
    }
}

/// What an encoder makes of the true angle before it counts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EncoderView {
    held_rad: Option<f64>,
    jump_rad: f64,
}

impl EncoderView {
    /// The angle that it sees.
    #[inline]
    pub(crate) fn seen_rad(&self, angle_rad: f64) -> f64 {
        self.held_rad.unwrap_or(angle_rad + self.jump_rad)
    }

    /// Stays at what it sees of this angle.
    pub(crate) fn freeze(&mut self, angle_rad: f64) {
        self.held_rad = Some(self.seen_rad(angle_rad));
    }

    /// Sees this much more.
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
