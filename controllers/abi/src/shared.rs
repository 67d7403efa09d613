//! The memory through which a law in another process is stepped: one request and one answer at a time.
#![allow(unsafe_code, reason = "memory that two processes share is mapped by address")]

use std::os::fd::{AsFd, OwnedFd};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, ftruncate, memfd_create};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use rustix::thread::futex;
use rustix::time::Timespec;

use crate::rows::{LawInput, LawOutput, LawSetup, MOST_PARAMETERS};

/// What both processes see. Zeros are a valid value: no request yet.
#[repr(C)]
struct Rows {
    /// Number of the newest request, counted by the bench; a law is stepped once for each.
    request: AtomicU32,
    /// Number of the newest request that was answered.
    answer: AtomicU32,
    parameter_count: AtomicU32,
    setup: [AtomicU64; 5],
    input: [AtomicU64; 6],
    output: [AtomicU64; 3],
    parameters: [AtomicU64; MOST_PARAMETERS],
}

/// The shared memory, mapped into this process.
#[derive(Debug)]
pub struct Mapping(NonNull<Rows>);

// SAFETY: everything in the memory is atomic.
unsafe impl Send for Mapping {}

impl Mapping {
    /// New memory with what a law is made from, and the file to hand to the other process.
    ///
    /// # Errors
    /// When the operating system gives no memory.
    pub fn create(setup: &LawSetup, values_si: &[f64]) -> std::io::Result<(Self, OwnedFd)> {
        let memory = memfd_create("law-rows", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)?;
        ftruncate(&memory, size_of::<Rows>() as u64)?;
        // Memory that the other process could shorten would end this one at its next access.
        fcntl_add_seals(&memory, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
        let mapping = Self::of(&memory)?;
        let rows = mapping.rows();
        let LawSetup {
            period_s,
            torque_limit_nm,
            velocity_limit_rad_per_s,
            acceleration_limit_rad_per_s2,
            inertia_kg_m2,
        } = *setup;
        let setup = [
            period_s,
            torque_limit_nm,
            velocity_limit_rad_per_s,
            acceleration_limit_rad_per_s2,
            inertia_kg_m2,
        ];
        store(&rows.setup, &setup);
        store(&rows.parameters, values_si);
        rows.parameter_count.store(values_si.len().min(MOST_PARAMETERS) as u32, Ordering::Release);
        Ok((mapping, memory))
    }

    /// The memory behind a file that another process made.
    ///
    /// # Errors
    /// When the file is too short, or cannot be mapped.
    pub fn of(file: &impl AsFd) -> std::io::Result<Self> {
        let length = size_of::<Rows>();
        if rustix::fs::fstat(file)?.st_size < length as i64 {
            return Err(std::io::Error::other(format!("expected at least {length} bytes of shared memory")));
        }
        let access = ProtFlags::READ | ProtFlags::WRITE;
        // SAFETY: the kernel chooses the address, so no other memory is replaced.
        let at = unsafe { mmap(std::ptr::null_mut(), length, access, MapFlags::SHARED, file, 0) }?;
        Ok(Self(NonNull::new(at.cast()).ok_or_else(|| std::io::Error::other("mapped to address 0"))?))
    }

    fn rows(&self) -> &Rows {
        // SAFETY: the mapping has the size of `Rows`, is aligned to a page, and lives as long as `self`; all of it is
        // atomic, so that others may write to it.
        unsafe { self.0.as_ref() }
    }

    /// What the law is made from: its setup and the values of its parameters.
    pub fn setup(&self) -> (LawSetup, Vec<f64>) {
        let rows = self.rows();
        let count = (rows.parameter_count.load(Ordering::Acquire) as usize).min(MOST_PARAMETERS);
        let [
            period_s,
            torque_limit_nm,
            velocity_limit_rad_per_s,
            acceleration_limit_rad_per_s2,
            inertia_kg_m2,
        ] = load(&rows.setup);
        let setup = LawSetup {
            period_s,
            torque_limit_nm,
            velocity_limit_rad_per_s,
            acceleration_limit_rad_per_s2,
            inertia_kg_m2,
        };
        (setup, load(&rows.parameters)[..count].to_vec())
    }

    /// Asks for a step and wakes the other process.
    pub fn ask(&self, input: &LawInput) {
        let rows = self.rows();
        let LawInput {
            take_over,
            reference_rad_per_s,
            rate_rad_per_s,
            feed_forward_nm,
            acceleration_rad_per_s2,
            sent_nm,
        } = *input;
        let input = [
            take_over,
            reference_rad_per_s,
            rate_rad_per_s,
            feed_forward_nm,
            acceleration_rad_per_s2,
            sent_nm,
        ];
        store(&rows.input, &input);
        rows.request.fetch_add(1, Ordering::AcqRel);
        wake(&rows.request);
    }

    /// The answer to the newest request, once it is there.
    pub fn answer(&self) -> Option<LawOutput> {
        let rows = self.rows();
        if rows.answer.load(Ordering::Acquire) != rows.request.load(Ordering::Relaxed) {
            return None;
        }
        let [torque_nm, saturated, fault] = load(&rows.output);
        Some(LawOutput { torque_nm, saturated, fault })
    }

    /// Sleeps until the newest request is answered, or for so long at the most.
    pub fn sleep_until_answered(&self, at_most: Duration) {
        let rows = self.rows();
        let seen = rows.answer.load(Ordering::Acquire);
        if seen != rows.request.load(Ordering::Relaxed) {
            sleep(&rows.answer, seen, at_most);
        }
    }

    /// Sleeps until there is another request than the one that was `answered` last, or for so long at the most; whether there is
    /// one.
    pub fn sleep_until_asked(&self, answered: u32, at_most: Duration) -> bool {
        let request = &self.rows().request;
        if request.load(Ordering::Acquire) == answered {
            sleep(request, answered, at_most);
        }
        request.load(Ordering::Acquire) != answered
    }

    /// Number and input of the newest request if it is not the one that was `answered` last.
    pub fn request(&self, answered: u32) -> Option<(u32, LawInput)> {
        let rows = self.rows();
        let number = rows.request.load(Ordering::Acquire);
        if number == answered {
            return None;
        }
        let [
            take_over,
            reference_rad_per_s,
            rate_rad_per_s,
            feed_forward_nm,
            acceleration_rad_per_s2,
            sent_nm,
        ] = load(&rows.input);
        let input = LawInput {
            take_over,
            reference_rad_per_s,
            rate_rad_per_s,
            feed_forward_nm,
            acceleration_rad_per_s2,
            sent_nm,
        };
        Some((number, input))
    }

    /// Answers the request of this number and wakes the bench.
    pub fn reply(&self, number: u32, output: &LawOutput) {
        let rows = self.rows();
        store(&rows.output, &[output.torque_nm, output.saturated, output.fault]);
        rows.answer.store(number, Ordering::Release);
        wake(&rows.answer);
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: this is the mapping that `of` made, and nothing refers to it any more.
        let _ = unsafe { munmap(self.0.as_ptr().cast(), size_of::<Rows>()) };
    }
}

fn store(cells: &[AtomicU64], values: &[f64]) {
    for (cell, value) in cells.iter().zip(values) {
        cell.store(value.to_bits(), Ordering::Relaxed);
    }
}

fn load<const N: usize>(cells: &[AtomicU64; N]) -> [f64; N] {
    std::array::from_fn(|k| f64::from_bits(cells[k].load(Ordering::Relaxed)))
}

fn wake(number: &AtomicU32) {
    let _ = futex::wake(number, futex::Flags::empty(), 1);
}

/// Sleeps while the number is what was seen. Signals and spurious wakes are the caller's to see: it looks again.
fn sleep(number: &AtomicU32, seen: u32, at_most: Duration) {
    let at_most = Timespec {
        tv_sec: i64::try_from(at_most.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: at_most.subsec_nanos().into(),
    };
    let _ = futex::wait(number, futex::Flags::empty(), seen, Some(&at_most));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_one_process_writes_another_mapping_of_the_memory_reads() {
        let setup = LawSetup { period_s: 2.5e-4, inertia_kg_m2: 975.0, ..LawSetup::default() };
        let (bench, memory) = Mapping::create(&setup, &[3.0, -4.5]).expect("memory");
        let law = Mapping::of(&memory).expect("the same memory");
        assert_eq!(law.setup(), (setup, vec![3.0, -4.5]));
        assert_eq!(law.request(0), None);
        let input = LawInput { rate_rad_per_s: 0.25, sent_nm: -7.0, ..LawInput::default() };
        bench.ask(&input);
        assert_eq!(bench.answer(), None, "nobody has answered yet");
        assert_eq!(law.request(0), Some((1, input)));
        let output = LawOutput { torque_nm: 12.5, saturated: 1.0, fault: 0.0 };
        law.reply(1, &output);
        assert_eq!(bench.answer(), Some(output));
        assert_eq!(law.request(1), None);
    }

    #[test]
    fn the_other_process_cannot_shorten_the_memory() {
        let (_bench, memory) = Mapping::create(&LawSetup::default(), &[]).expect("memory");
        assert!(ftruncate(&memory, 0).is_err());
    }

    #[test]
    fn memory_that_is_too_short_is_refused() {
        let memory = memfd_create("short", MemfdFlags::CLOEXEC).expect("memory");
        assert!(Mapping::of(&memory).is_err());
    }
}
