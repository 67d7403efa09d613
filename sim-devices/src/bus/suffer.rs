//! Faults on the far side of the wires, each at its instant.

use std::time::Duration;

use super::VirtualBus;
use crate::cia402::wiring::{EMERGENCY_STOP, ENABLING_SWITCH};
use crate::faults::Fault;

impl VirtualBus {
    /// Puts a fault down for an instant of world time; one in the past acts at the next look at the rig.
    pub(crate) fn schedule(&mut self, at: Duration, fault: Fault) {
        self.agenda.add(at, fault);
    }

    /// Lets everything happen that is due by `now`, the world brought to the instant of each.
    pub(super) fn keep_agenda(&mut self, now: Duration) {
        while let Some((at, fault)) = self.agenda.pop(now) {
            let at = at.max(self.now);
            self.integrate_to(at);
            self.befall(at, fault);
        }
    }

    fn befall(&mut self, at: Duration, fault: Fault) {
        match fault {
            Fault::Encoder { drive, fault } => self.drives[drive].suffer(fault),
            Fault::EncoderFrozen { drive } => {
                let angle_rad = self.world.axes[self.axis_of_drive[drive]].angle_rad();
                self.sights[drive].freeze(angle_rad);
            }
            Fault::EncoderJump { drive, by_rad } => self.sights[drive].slip(by_rad),
            Fault::Drive { drive, code } => self.drives[drive].find_fault(code),
            Fault::CurrentStuck { drive, current_a } => self.drives[drive].stick(current_a),
            Fault::SafeTorqueOff { drive, active } => self.drives[drive].block_gates(active),
            Fault::EmergencyStop { pressed } => {
                for drive in &mut self.drives {
                    drive.set_input(EMERGENCY_STOP, pressed);
                    drive.block_gates(pressed);
                }
            }
            Fault::EnablingSwitch { held } => {
                self.drives.iter_mut().for_each(|drive| drive.set_input(ENABLING_SWITCH, held));
            }
            Fault::BusSilent { lasting } => {
                self.silent_until = lasting.map_or(Duration::MAX, |lasting| at.saturating_add(lasting));
            }
            Fault::FramesLost { count } => self.frames_to_lose = count,
            Fault::SupplyLost => self.supply.lose_mains(),
            Fault::HeatSink { drive, degc } => self.drives[drive].heat_to(degc),
            Fault::ImuSilent => self.payload.imu.fall_silent(),
            Fault::ImuFrozen => self.payload.imu.freeze(),
            Fault::GyroOffset { by_rad_per_s } => self.payload.imu.shift_gyros(by_rad_per_s),
        }
    }
}
