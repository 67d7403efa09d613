//! A station on the bus: a drive, what its encoder sees of the angle, and the motor behind it.

use crate::cia402::Drive;
use crate::faults::EncoderView;
use crate::physics::encoder::Coupling;
use crate::physics::supply::drive_w;
use crate::unit::AxisSettings;
use drivers::wire::{BusState, ProcessImage, Slot};

/// A drive with its encoder, its motor and its place in the process image.
#[derive(Debug)]
pub(crate) struct Station {
    pub(crate) drive: Drive,
    pub(crate) encoder_view: EncoderView,
    coupling: Coupling,
    /// Of no meaning before the bus is mapped.
    pub(super) slot: Slot,
    /// With the sign of the motor's phases.
    torque_constant_nm_per_a: f64,
    /// Change of the torque constant per kelvin of the heat sink above ambient.
    per_k_ratio: f64,
    ambient_degc: f64,
    /// Losses of motor and drive over the square of the current.
    loss_ohm: f64,
}

/// What a motor does over a step of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Torque at the shaft.
    pub(crate) torque_nm: f64,
    /// Power drawn from the DC link.
    pub(crate) drawn_w: f64,
}

impl Station {
    /// A station with this drive and the motor of an axis; `vendor` is whom it claims to be made by.
    pub(crate) fn new(mut drive: Drive, axis: &AxisSettings, vendor: Option<u32>) -> Self {
        if !axis.soft_limits_enforced() {
            drive.ignore_soft_limits();
        }
        if let Some(vendor) = vendor {
            drive.claim_vendor(vendor);
        }
        Self {
            drive,
            encoder_view: EncoderView::default(),
            coupling: Coupling::new(axis),
            slot: Slot::default(),
            torque_constant_nm_per_a: axis.motor_sign_factor.signum() * axis.torque_constant_nm_per_a,
            per_k_ratio: axis.torque_constant_per_k_ratio,
            ambient_degc: axis.ambient_degc,
            loss_ohm: axis.loss_resistance_ohm(),
        }
    }

    /// What the motor does over a step that begins at this angle and rate of its shaft.
    #[inline]
    pub(crate) fn work(&mut self, step: u64, angle_rad: f64, velocity_rad_per_s: f64) -> Effort {
        let seen_rad = self.seen_rad(angle_rad);
        let current_a = self.drive.current_a(step, seen_rad);
        let torque_nm = self.torque_nm(current_a);
        Effort { torque_nm, drawn_w: drive_w(self.loss_ohm, torque_nm, velocity_rad_per_s, current_a) }
    }

    /// Torque of the motor at a current, as warm as it is.
    #[inline]
    pub(super) fn torque_nm(&self, current_a: f64) -> f64 {
        let torque_nm = self.torque_constant_nm_per_a * current_a;
        if self.per_k_ratio == 0.0 {
            return torque_nm;
        }
        torque_nm * (1.0 + self.per_k_ratio * (self.drive.heat_sink_degc() - self.ambient_degc))
    }

    /// Angle that the encoder measures when its axis has come to this one.
    #[inline]
    pub(super) fn seen_rad(&mut self, shaft_rad: f64) -> f64 {
        self.encoder_view.seen_rad(self.coupling.follow(shaft_rad))
    }

    /// The encoder goes on showing what it measures at this angle of its axis.
    pub(super) fn freeze_encoder(&mut self, shaft_rad: f64) {
        self.encoder_view.freeze(self.coupling.follow(shaft_rad));
    }

    /// Takes a place at the end of the process image; the abort code of the mapping fault where there is one.
    pub(super) fn map(&mut self, image: &mut ProcessImage) -> Result<(), u32> {
        let (outputs, inputs) = self.drive.map()?;
        let first_output = image.outputs.len();
        let first_input = image.inputs.len();
        self.slot =
            Slot { outputs: first_output..first_output + outputs, inputs: first_input..first_input + inputs };
        image.outputs.resize(first_output + outputs, 0);
        image.inputs.resize(first_input + inputs, 0);
        Ok(())
    }

    /// Puts its inputs into the frame and takes its outputs out of it.
    pub(super) fn exchange(&mut self, step: u64, shaft_rad: f64, to_op: bool, image: &mut ProcessImage) {
        let seen_rad = self.seen_rad(shaft_rad);
        self.drive.send(step, seen_rad, &mut image.inputs[self.slot.inputs.clone()]);
        if to_op {
            self.drive.set_bus_state(BusState::Op);
        }
        self.drive.receive(step, &image.outputs[self.slot.outputs.clone()]);
    }
}
