//! What measurands are like, where a criterion does not say it: always above zero or not, and which way they become worse.

use super::{Scale, Worse};
use crate::quantity::{Comparator, Limit};
use crate::requirement::Judged;

/// Measurands that are above zero on every unit and matter by their ratio: root mean squares, noise, peaks and percentiles of
/// errors, times. A measurand that may be zero, a ratio in decibels and a margin of a loop are compared by their difference.
const BY_RATIO: &[&str] = &[
    "accelerometer-noise",
    "angle-random-walk",
    "bias-instability",
    "coarse-track-peak",
    "coarse-track-percentile",
    "coarse-track-rms",
    "coarse-track-rms-inside",
    "coarse-track-rms-whole",
    "cue-settling-time",
    "encoder-noise",
    "fine-dwell",
    "fine-track-peak",
    "fine-track-percentile",
    "fine-track-rms",
    "fine-track-rms-inside",
    "fine-track-rms-whole",
    "gyro-noise",
    "longest-frame-gap",
    "model-error-rms",
    "path-error",
    "path-error-aligned",
    "path-error-peak",
    "path-error-rms",
    "peak-current-az",
    "peak-current-el",
    "position-noise",
    "positioning-accuracy",
    "positioning-repeatability",
    "ramp-error",
    "ramp-error-aligned",
    "ramp-error-peak",
    "ramp-error-rms",
    "rms-current-az",
    "rms-current-el",
    "servo-error",
    "shunt-power",
    "slew-settling-time",
    "step-rise-time",
    "step-settling-time",
    "stop-angle",
    "stop-time",
    "supply-current-peak",
    "supply-current-rms",
    "torque-noise",
    "tracker-jitter",
    "tracker-latency",
    "transport-back",
    "transport-by-onset",
    "transport-jitter",
    "transport-out",
    "transport-round-trip",
    "velocity-delay-margin",
];

/// How values of a measurand are compared, unless the criterion says it.
pub(super) fn scale_of(measurand: &str) -> Scale {
    if BY_RATIO.contains(&measurand) { Scale::LogRatio } else { Scale::Difference }
}

/// Every limit that a requirement has for a measurand, those under conditions included; its goal where it has no limit.
pub(super) fn limits_of(judged: &Judged) -> impl Iterator<Item = &Limit> {
    let bands = judged.bands.iter().map(|band| &band.limit);
    let corners = judged.mask.iter().flat_map(|mask| mask.corners.iter().map(|(_, limit)| limit));
    let goal = judged.goal.iter().filter(|_| !judged.is_limited());
    judged.limit.iter().chain(bands).chain(corners).chain(goal)
}

/// Which way a measurand becomes worse by its limits; `None` without any, for a range, and where limits differ in this.
pub(super) fn worse_of(judged: &Judged) -> Option<Worse> {
    let mut ways = limits_of(judged).map(|limit| match limit.comparator {
        Comparator::Less | Comparator::AtMost => Some(Worse::Higher),
        Comparator::Greater | Comparator::AtLeast => Some(Worse::Lower),
        Comparator::Within => None,
    });
    let first = ways.next()??;
    ways.all(|way| way == Some(first)).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds;
    use crate::quantity::QuantityKind;

    #[test]
    fn every_measurand_of_the_list_exists_stands_once_and_is_no_ratio_in_decibels() {
        assert!(BY_RATIO.is_sorted() && BY_RATIO.windows(2).all(|pair| pair[0] != pair[1]));
        for name in BY_RATIO {
            let (_, measurand) = kinds::measurand(name).unwrap_or_else(|| panic!("no measurand `{name}`"));
            let may_be_zero = [QuantityKind::Decibel, QuantityKind::Count, QuantityKind::Temperature];
            assert!(!may_be_zero.contains(&measurand.kind), "{name}");
        }
    }

    #[test]
    fn root_mean_squares_peaks_and_settling_times_are_compared_by_their_ratio_and_overshoot_is_not() {
        for kind in kinds::KINDS {
            for measurand in kind.measurands {
                let name = measurand.name;
                let is_magnitude =
                    ["-rms", "-settling-time", "-percentile"].iter().any(|end| name.ends_with(end));
                assert!(!is_magnitude || scale_of(name) == Scale::LogRatio, "{name}");
                assert!(!name.contains("overshoot") || scale_of(name) == Scale::Difference, "{name}");
            }
        }
    }
}
