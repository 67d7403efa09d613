//! The built-in velocity law `pi` of the bench as an external law in Rust: the same torques as `velocity_pi.c`.
//!
//! `rustc --edition 2024 --crate-type cdylib -O velocity_pi.rs` builds it without a workspace; it needs `rows.rs` alone.
#![allow(unsafe_code, reason = "the functions of a shared library are called from C")]

use std::ffi::c_void;

#[path = "../src/rows.rs"]
#[allow(dead_code, unreachable_pub, reason = "a law needs no more than its rows")]
mod rows;

use rows::{ABI_VERSION, LawInput, LawOutput, LawSetup, RawDescription, RawParameter};

const KP: usize = 0;
const KI: usize = 1;

/// Constants of C strings are immutable, so that any thread may read them.
struct Shared<T>(T);

// SAFETY: everything in it is immutable and lives as long as the library.
unsafe impl<T> Sync for Shared<T> {}

static PARAMETERS: Shared<[RawParameter; 2]> = Shared([
    RawParameter { name: c"velocity-kp".as_ptr(), unit: c"N*m*s/rad".as_ptr(), default_value: f64::NAN },
    RawParameter { name: c"velocity-ki".as_ptr(), unit: c"N*m/rad".as_ptr(), default_value: f64::NAN },
]);

static DESCRIPTION: Shared<RawDescription> = Shared(RawDescription {
    abi_version: ABI_VERSION,
    parameter_bytes: size_of::<RawParameter>() as u32,
    setup_bytes: size_of::<LawSetup>() as u32,
    input_bytes: size_of::<LawInput>() as u32,
    output_bytes: size_of::<LawOutput>() as u32,
    parameter_count: 2,
    name: c"velocity-pi-rust".as_ptr(),
    version: c"1.0".as_ptr(),
    parameters: PARAMETERS.0.as_ptr(),
});

/// PI with feed-forward and conditional integration.
struct Pi {
    kp_nm_s_per_rad: f64,
    ki_step_nm_s_per_rad: f64,
    torque_limit_nm: f64,
    integral_nm: f64,
}

impl Pi {
    fn limited(&self, torque_nm: f64) -> f64 {
        torque_nm.max(-self.torque_limit_nm).min(self.torque_limit_nm)
    }

    fn step(&mut self, input: &LawInput) -> LawOutput {
        let error = finite_or_zero(input.reference_rad_per_s - input.rate_rad_per_s);
        let direct_nm = self.kp_nm_s_per_rad * error + finite_or_zero(input.feed_forward_nm);
        if input.take_over != 0.0 {
            self.integral_nm = self.limited(finite_or_zero(input.sent_nm)) - direct_nm;
            return LawOutput::default();
        }
        let step_nm = self.ki_step_nm_s_per_rad * error;
        let wanted_nm = direct_nm + self.integral_nm + step_nm;
        let torque_nm = self.limited(wanted_nm);
        let saturated = torque_nm != wanted_nm;
        if !saturated || step_nm * wanted_nm < 0.0 {
            self.integral_nm += step_nm;
        }
        LawOutput { torque_nm, saturated: f64::from(u8::from(saturated)), fault: 0.0 }
    }
}

fn finite_or_zero(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

/// Describes the library.
#[unsafe(no_mangle)]
pub extern "C" fn bench_law_describe() -> *const RawDescription {
    &raw const DESCRIPTION.0
}

/// Makes an instance.
///
/// # Safety
/// `setup` points to a row, `parameters` to a value for each parameter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bench_law_create(setup: *const LawSetup, parameters: *const f64) -> *mut c_void {
    // SAFETY: by the interface both are valid, and there is a value for each of the two parameters.
    let (setup, values) = unsafe { (setup.read(), std::slice::from_raw_parts(parameters, 2)) };
    let law = Pi {
        kp_nm_s_per_rad: values[KP],
        ki_step_nm_s_per_rad: values[KI] * setup.period_s,
        torque_limit_nm: setup.torque_limit_nm,
        integral_nm: 0.0,
    };
    Box::into_raw(Box::new(law)).cast()
}

/// One step.
///
/// # Safety
/// `law` comes from [`bench_law_create`]; `input` and `output` point to rows.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bench_law_step(law: *mut c_void, input: *const LawInput, output: *mut LawOutput) {
    // SAFETY: by the interface all three are valid, and nobody else uses them meanwhile.
    unsafe { output.write((*law.cast::<Pi>()).step(&*input)) };
}

/// Frees an instance.
///
/// # Safety
/// `law` comes from [`bench_law_create`] and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bench_law_destroy(law: *mut c_void) {
    // SAFETY: it is the box that `bench_law_create` gave away.
    drop(unsafe { Box::from_raw(law.cast::<Pi>()) });
}
