//! Faults on the far side of the wires, each at its instant.

use std::time::Duration;

use super::{Plant, VirtualBus};
use crate::cia402::wiring::{EMERGENCY_STOP, ENABLING_SWITCH};
use crate::faults::Fault;
use crate::payload::Imu;

impl<P: Plant> VirtualBus<P> {
    /// Puts a fault down for an instant of world time; one in the past acts at the next look at the rig.
    pub(crate) fn schedule(&mut self, at: Duration, fault: Fault) {
        self.schedule.add(at, fault);
    }

    /// Lets everything happen that is due by `now`, the world brought to the instant of each.
    pub(super) fn keep_schedule(&mut self, now: Duration) {
        while let Some((at, fault)) = self.schedule.pop(now) {
            let at = at.max(self.now);
            self.integrate_to(at);
            self.befall(at, fault);
        }
    }

    fn befall(&mut self, at: Duration, fault: Fault) {
        let stations = self.stations.as_mut();
        match fault {
            Fault::Encoder { drive, fault } => stations[drive].drive.inject_encoder_fault(fault),
            Fault::EncoderFrozen { drive } => stations[drive].freeze_encoder(self.plant.shaft_rad(drive)),
            Fault::EncoderJump { drive, by_rad } => stations[drive].encoder_view.slip(by_rad),
            Fault::Drive { drive, code } => stations[drive].drive.find_fault(code),
            Fault::CurrentStuck { drive, current_a } => stations[drive].drive.stick(current_a),
            Fault::SafeTorqueOff { drive, active } => stations[drive].drive.block_gates(active),
            Fault::EmergencyStop { pressed } => {
                self.emergency_stop = pressed;
                for station in stations {
                    station.drive.set_input(EMERGENCY_STOP, pressed);
                    station.drive.block_gates(pressed);
                }
            }
            Fault::EnablingSwitch { held } => {
                stations.iter_mut().for_each(|station| station.drive.set_input(ENABLING_SWITCH, held));
            }
            Fault::BusSilent { lasting } => {
                self.lost_frames.silent_until =
                    lasting.map_or(Duration::MAX, |lasting| at.saturating_add(lasting));
            }
            Fault::FramesLost { count } => self.lost_frames.next_count = count,
            Fault::HeatSink { drive, degc } => stations[drive].drive.heat_to(degc),
            Fault::SupplyLost => self.plant.lose_mains(),
            Fault::ImuSilent => self.with_imu(Imu::fall_silent),
            Fault::ImuFrozen => self.with_imu(Imu::freeze),
            Fault::GyroOffset { by_rad_per_s } => self.with_imu(|imu| imu.shift_gyros(by_rad_per_s)),
        }
    }

    /// A rig without inertial unit refuses such a fault when it is put down.
    fn with_imu(&mut self, befall: impl FnOnce(&mut Imu)) {
        if let Some(imu) = self.plant.imu() {
            befall(imu);
        }
    }
}
