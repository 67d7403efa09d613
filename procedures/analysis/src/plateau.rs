//! Which stretch of a stroke runs steadily at its plateau velocity.

use std::ops::Range;

/// The longest stretch in which the mean velocity over `window_count` samples stays within `tolerance_ratio` of
/// `target_rad_per_s` (signed); the earliest of equals; empty if there is none.
///
/// `angle_rad` is sampled at `sample_rate_hz`. The mean is centred; at the ends of the record the nearest whole window counts.
pub fn longest_steady(
    angle_rad: &[f64],
    sample_rate_hz: f64,
    target_rad_per_s: f64,
    window_count: usize,
    tolerance_ratio: f64,
) -> Range<usize> {
    let n = angle_rad.len();
    let window = window_count.max(1);
    if n <= window {
        return 0..0;
    }
    let allowed = (tolerance_ratio * target_rad_per_s).abs();
    let steady = |i: usize| {
        let from = i.saturating_sub(window / 2).min(n - 1 - window);
        let velocity = (angle_rad[from + window] - angle_rad[from]) * sample_rate_hz / window as f64;
        (velocity - target_rad_per_s).abs() <= allowed
    };
    let mut best = 0..0;
    let mut start = 0;
    for i in 0..=n {
        if i == n || !steady(i) {
            if i - start > best.len() {
                best = start..i;
            }
            start = i + 1;
        }
    }
    best
}

/// Mean velocity along a stretch: the way over the time; 0 if it has fewer than two samples.
pub fn mean_velocity_rad_per_s(angle_rad: &[f64], sample_rate_hz: f64) -> f64 {
    match angle_rad {
        [first, .., last] => (last - first) * sample_rate_hz / (angle_rad.len() - 1) as f64,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_and_a_stall_are_left_out() {
        // 1 s ramp to 2 rad/s, 1 s cruise, a stall of 0.1 s, 3 s cruise, 1 s ramp down; 1 kHz.
        let velocity = |t: f64| match t {
            t if t < 1.0 => 2.0 * t,
            t if (2.0..2.1).contains(&t) => 0.0,
            t if t < 5.1 => 2.0,
            t => 2.0 - 2.0 * (t - 5.1),
        };
        let mut angle = vec![0.0];
        for i in 0..6100 {
            angle.push(angle[i] + velocity(i as f64 / 1000.0) / 1000.0);
        }
        let steady = longest_steady(&angle, 1000.0, 2.0, 50, 0.05);
        assert!((2100..2130).contains(&steady.start), "{steady:?}");
        assert!((5080..5160).contains(&steady.end), "{steady:?}");
        assert!((mean_velocity_rad_per_s(&angle[steady], 1000.0) - 2.0).abs() < 0.01);
        assert!(longest_steady(&angle, 1000.0, -2.0, 50, 0.05).is_empty());
        assert!(longest_steady(&angle[..30], 1000.0, 2.0, 50, 0.05).is_empty());
    }
}
