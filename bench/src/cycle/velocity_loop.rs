//! The velocity loop of one axis: an external law where there is one, and the built-in law that takes over when that fails.

use std::fmt::{self, Display};

use controllers::velocity::VelocityController;
use external_law::rows::{LawInput, LawOutput};

use crate::cycle::interlock::Trip;
use crate::cycle::laws::Stepped;

/// A demand may exceed the torque limit by this share: rounding in the law.
const ROUNDING: f64 = 1e-9;

/// What made an external law unusable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LawFault {
    /// A torque that is not a number, or beyond the limit.
    Torque {
        /// The demand.
        torque_nm: f64,
        /// Largest torque of the axis.
        limit_nm: f64,
    },
    /// The law itself reported a fault.
    Reported {
        /// Code of the law's own.
        code: f64,
    },
    /// The process of the law did not answer in time.
    Late {
        /// Time since the request.
        after_us: f64,
        /// Longest time allowed.
        limit_us: f64,
    },
    /// The process of the law ended.
    Ended {
        /// Exit code, or minus the number of the signal.
        code: i32,
    },
}

impl LawFault {
    /// As the trip of an interlock of this axis; the stop is steerable, because sensors and drive are sound.
    pub fn trip(self, axis: usize) -> Trip {
        let (interlock, seen, limit, unit) = match self {
            Self::Torque { torque_nm, limit_nm } => ("torque of external law", torque_nm, limit_nm, "N*m"),
            Self::Reported { code } => ("fault of external law", code, 0.0, "(code)"),
            Self::Late { after_us, limit_us } => ("answer of external law", after_us, limit_us, "us"),
            Self::Ended { code } => ("process of external law", f64::from(code), 0.0, "(exit code)"),
        };
        Trip { interlock, axis: Some(axis), seen, limit, unit, shared: false, steerable: true }
    }
}

impl Display for LawFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Torque { torque_nm, .. } if !torque_nm.is_finite() => {
                write!(f, "the law gave a torque that is not a finite number")
            }
            Self::Torque { .. } => write!(f, "the law gave a torque beyond the limit of the axis"),
            Self::Reported { code } => write!(f, "the law reported fault {code}"),
            Self::Late { .. } => write!(f, "the process of the law did not answer in time"),
            Self::Ended { code } if *code < 0 => write!(f, "signal {} ended the process of the law", -code),
            Self::Ended { code } => write!(f, "the process of the law ended with exit code {code}"),
        }
    }
}

/// The velocity loop of one axis.
#[derive(Debug)]
pub(super) struct VelocityLoop {
    built_in: VelocityController,
    external: Option<External>,
    fault: Option<LawFault>,
}

/// An external law of one axis.
#[derive(Debug)]
pub(super) struct External {
    pub(super) law: Stepped,
    pub(super) limit_nm: f64,
    /// Whether the built-in law has not taken over yet. A law that is left is kept: to free it would take time in the tick.
    pub(super) in_use: bool,
}

impl External {
    /// The steps of one tick; the torque of the last.
    fn steps(&mut self, input: &LawInput, steps: u32) -> Result<f64, LawFault> {
        (0..steps).try_fold(0.0, |_, _| self.step(input))
    }

    fn step(&mut self, input: &LawInput) -> Result<f64, LawFault> {
        let LawOutput { torque_nm, fault: code, .. } = self.law.step(input)?;
        if code != 0.0 {
            return Err(LawFault::Reported { code });
        }
        let limit_nm = self.limit_nm;
        // NaN is not within the limit.
        let is_within = torque_nm.abs() <= limit_nm * (1.0 + ROUNDING);
        if input.take_over == 0.0 && !is_within {
            return Err(LawFault::Torque { torque_nm, limit_nm });
        }
        Ok(torque_nm)
    }
}

impl VelocityLoop {
    /// The built-in law alone.
    pub(super) fn new(built_in: VelocityController) -> Self {
        Self { built_in, external: None, fault: None }
    }

    /// From now on an external law makes the torque.
    pub(super) fn step_by(&mut self, external: External) {
        self.external = Some(external);
    }

    /// From now on the built-in law makes the torque; it must be made to take over first.
    pub(super) fn leave_external(&mut self) {
        if let Some(external) = &mut self.external {
            external.in_use = false;
        }
    }

    /// All steps of a law from one call of this to the next have one deadline together.
    pub(super) fn end_tick(&mut self) {
        if let Some(external) = &mut self.external {
            external.law.end_tick();
        }
    }

    /// What made the external law unusable, once.
    pub(super) fn take_fault(&mut self) -> Option<LawFault> {
        self.fault.take()
    }

    /// Bumpless start: at zero velocity error and without feed-forward the next torque is `torque_nm`.
    pub(super) fn reset(&mut self, torque_nm: f64) {
        self.take_over(torque_nm, 0.0, 0.0, 0.0);
    }

    /// Bumpless start from what was sent: the next torque at this reference, rate and feed-forward is `torque_nm`, but for
    /// one step of an integral.
    pub(super) fn take_over(
        &mut self,
        torque_nm: f64,
        reference_rad_per_s: f64,
        rate_rad_per_s: f64,
        feed_forward_nm: f64,
    ) {
        self.built_in.take_over(torque_nm, reference_rad_per_s, rate_rad_per_s, feed_forward_nm);
        let input = LawInput {
            take_over: 1.0,
            reference_rad_per_s,
            rate_rad_per_s,
            feed_forward_nm,
            acceleration_rad_per_s2: 0.0,
            sent_nm: torque_nm,
        };
        if let Some(external) = self.external.as_mut().filter(|external| external.in_use)
            && let Err(fault) = external.step(&input)
        {
            external.in_use = false;
            self.fault = Some(fault);
        }
    }

    /// The steps of one tick; returns the torque of the last one. If the external law fails in one of them, the built-in law makes
    /// this torque and all later ones. It goes on from `own_nm`, the torque of the last tick without what a test added to it:
    /// nothing of an excitation may stay in a stop.
    pub(super) fn update(&mut self, input: &LawInput, own_nm: f64, steps: u32) -> f64 {
        let LawInput { reference_rad_per_s, rate_rad_per_s, feed_forward_nm, .. } = *input;
        if let Some(external) = self.external.as_mut().filter(|external| external.in_use) {
            match external.steps(input, steps) {
                Ok(torque_nm) => return torque_nm,
                Err(fault) => {
                    external.in_use = false;
                    self.fault = Some(fault);
                    self.built_in.take_over(own_nm, reference_rad_per_s, rate_rad_per_s, feed_forward_nm);
                    return self.built_in.update(reference_rad_per_s, rate_rad_per_s, feed_forward_nm);
                }
            }
        }
        let step = |_| self.built_in.update(reference_rad_per_s, rate_rad_per_s, feed_forward_nm);
        (0..steps).map(step).last().unwrap_or(0.0)
    }
}
