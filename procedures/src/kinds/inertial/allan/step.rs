//! The step in which a gyro puts out its rates, from the samples at rest.

use analysis::allan::{OutputStep, output_step};
use analysis::estimate::Estimate;

use super::STEP;
use crate::kinds::inertial::{COUNTER_MODULUS, GYROS, Samples};
use crate::measurement::{Bound, Measurement};
use crate::quantity::QuantityKind as Q;
use crate::reason::{InertialReason, Reason};

const ESTIMATOR: &str = "output-step/1";
/// More messages than ticks by this ratio are several in a tick.
const SEVERAL_RATIO: f64 = 1.5;

pub(super) fn measured(samples: &Samples, index: usize, tick_s: f64) -> Measurement {
    let gyro = GYROS[index];
    let messages = samples.messages_in_most();
    if samples.period_s >= COUNTER_MODULUS * tick_s && tick_s > 0.0 {
        return without(gyro, InertialReason::UncountedMessages { period_s: samples.period_s }.into());
    }
    let Some(found) = output_step(&samples.rates_of_messages(index, messages)) else {
        return without(gyro, InertialReason::FewValues { gyro }.into());
    };
    let (of_sample, bound) = match found {
        OutputStep::Seen(estimate) => {
            let several = SEVERAL_RATIO * samples.period_s < messages * tick_s;
            let reason = "several messages came in a tick, and the samples may hold one of them only";
            (estimate, several.then(|| Bound::AtMost(reason.to_owned())))
        }
        OutputStep::AtMost(gap) => {
            let reason = "no step is seen, and samples with a larger one would be further apart";
            let most = Estimate { value: gap, u: 0.0, dof: f64::INFINITY, n: samples.len() };
            (most, Some(Bound::AtMost(reason.to_owned())))
        }
    };
    // A mean of n messages moves by an nth of a step when one of them moves by a step.
    let estimate = Estimate { value: messages * of_sample.value, u: messages * of_sample.u, ..of_sample };
    let mut m = Measurement::new(STEP, gyro, Q::AngularVelocity, Some(estimate), ESTIMATOR);
    if messages > 1.0 {
        let step_urad_per_s = 1e6 * of_sample.value;
        m.flags.push(format!("{step_urad_per_s:.4} urad/s in means of {messages:.0} messages"));
    }
    if let Some(bound) = bound {
        m.set_bound(bound);
    }
    m
}

pub(super) fn without(gyro: &str, reason: Reason) -> Measurement {
    Measurement::inconclusive(STEP, gyro, Q::AngularVelocity, ESTIMATOR, reason)
}
