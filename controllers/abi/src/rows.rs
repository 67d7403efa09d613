//! The rows and the description of `bench_law.h`, field by field. This file uses nothing but `core`, so that a law in
//! Rust can include it.

use core::ffi::c_char;

/// Version of the interface that these rows belong to.
pub const ABI_VERSION: u32 = 1;

/// Most parameters that a law may have.
pub const MOST_PARAMETERS: usize = 64;

/// A parameter of a law: `bench_law_parameter`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RawParameter {
    /// A key of an axis in the parameter file, or a name of the law's own; UTF-8 that ends with a zero.
    pub name: *const c_char,
    /// SI unit of the value; UTF-8 that ends with a zero.
    pub unit: *const c_char,
    /// Value for a name that the parameter file does not have; NaN where the file must have it.
    pub default_value: f64,
}

/// What a library says of itself: `bench_law_description`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RawDescription {
    /// [`ABI_VERSION`]; the first field in every version.
    pub abi_version: u32,
    /// Size of [`RawParameter`].
    pub parameter_bytes: u32,
    /// Size of [`LawSetup`].
    pub setup_bytes: u32,
    /// Size of [`LawInput`].
    pub input_bytes: u32,
    /// Size of [`LawOutput`].
    pub output_bytes: u32,
    /// Entries of `parameters`.
    pub parameter_count: u32,
    /// Name of the law; UTF-8 that ends with a zero.
    pub name: *const c_char,
    /// Version of the law, as its authors count; UTF-8 that ends with a zero.
    pub version: *const c_char,
    /// The parameters; may be null where there are none.
    pub parameters: *const RawParameter,
}

/// What does not change during the life of an instance: `bench_law_setup`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct LawSetup {
    /// Time from step to step.
    pub period_s: f64,
    /// A torque beyond ± this stops the axis.
    pub torque_limit_nm: f64,
    /// Largest speed of the axis in the rig file.
    pub velocity_limit_rad_per_s: f64,
    /// Largest acceleration of the axis in the rig file.
    pub acceleration_limit_rad_per_s2: f64,
    /// Inertia of the axis in the rig file.
    pub inertia_kg_m2: f64,
}

/// One step: `bench_law_input`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct LawInput {
    /// 0: make a torque; 1: take over the torque `sent_nm` without a jump.
    pub take_over: f64,
    /// Commanded rate, any excitation of the test included.
    pub reference_rad_per_s: f64,
    /// Measured rate: gyro or encoder, as the rig file says.
    pub rate_rad_per_s: f64,
    /// Inertia times commanded acceleration.
    pub feed_forward_nm: f64,
    /// Commanded acceleration.
    pub acceleration_rad_per_s2: f64,
    /// Torque that went to the drive in the last tick.
    pub sent_nm: f64,
}

/// What a step gives: `bench_law_output`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct LawOutput {
    /// Torque demand.
    pub torque_nm: f64,
    /// 1 where the torque was limited, else 0.
    pub saturated: f64,
    /// 0; any other value stops the axis and is recorded: a code of the law's own.
    pub fault: f64,
}
