//! Where the target goes: what the encoders and the coarse tracker say together.

use analysis::derivative::Differentiator;

use super::frames::Frames;
use crate::log::Window;

/// Direction of the target, rate and acceleration, at equal steps of time; azimuth, elevation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sight {
    pub(super) time_s: Vec<f64>,
    pub(super) angle_rad: [Vec<f64>; 2],
    pub(super) rate_rad_per_s: [Vec<f64>; 2],
    pub(super) acceleration_rad_per_s2: [Vec<f64>; 2],
}

impl Sight {
    /// From the frames that show the target: encoder at the exposure plus error, azimuth's over the cosine of elevation.
    /// Where frames are missing it is on straight lines.
    ///
    /// # Errors
    /// In words: no encoder, too few frames for the bandwidth.
    pub(super) fn new(
        frames: &Frames,
        window: &Window,
        axes: [&str; 2],
        bandwidth_hz: f64,
    ) -> Result<Self, String> {
        let shown: Vec<usize> = (0..frames.time_s.len()).filter(|&k| frames.valid[k]).collect();
        let [Some(&first), Some(&last)] = [shown.first(), shown.last()] else {
            return Err("no coarse frame shows the target".to_owned());
        };
        let mut angles = [Vec::new(), Vec::new()];
        for &k in &shown {
            let at_s = frames.time_s[k];
            let [az, el] = [place(window, axes[0], at_s)?, place(window, axes[1], at_s)?];
            angles[0].push(az + frames.error_rad[0][k] / el.cos());
            angles[1].push(el + frames.error_rad[1][k]);
        }
        let numbers: Vec<f64> = shown.iter().map(|&k| frames.number[k]).collect();
        let steps = (frames.number[last] - frames.number[first]) as usize;
        let time_s = (0..=steps).map(|n| frames.time_s[first] + n as f64 * frames.period_s).collect();
        let angle_rad = angles.map(|angle| filled(&numbers, &angle, steps));
        let rate_hz = 1.0 / frames.period_s;
        let differentiator = Differentiator::new(rate_hz, bandwidth_hz).ok_or_else(|| {
            format!("{rate_hz:.0} coarse frames a second do not show accelerations up to {bandwidth_hz} Hz")
        })?;
        let derived = |order: usize| -> Result<[Vec<f64>; 2], String> {
            let derivative = |angle: &Vec<f64>| match order {
                1 => differentiator.velocity(angle),
                _ => differentiator.acceleration(angle),
            };
            let [az, el] = [derivative(&angle_rad[0]), derivative(&angle_rad[1])];
            let both = az.zip(el).ok_or("too few coarse frames for the target's acceleration")?;
            Ok([both.0, both.1].map(|values| without_ends(values, differentiator.window() / 2)))
        };
        let rate_rad_per_s = derived(1)?;
        let acceleration_rad_per_s2 = derived(2)?;
        Ok(Self { time_s, angle_rad, rate_rad_per_s, acceleration_rad_per_s2 })
    }

    /// Rate about an axis at a time, of the nearest sample.
    pub(super) fn rate_at(&self, axis: usize, at_s: f64) -> f64 {
        let k = self.time_s.partition_point(|&t| t < at_s).min(self.time_s.len() - 1);
        self.rate_rad_per_s[axis][k]
    }
}

/// Half a window from either end the polynomial is read off its centre, where noise governs it: what is last known stands.
fn without_ends(mut values: Vec<f64>, half: usize) -> Vec<f64> {
    let n = values.len();
    let low = half.min(n - 1);
    let high = n - 1 - half.min(n - 1);
    let first = values[low];
    let last = values[high];
    values[..low].fill(first);
    values[high..].fill(last);
    values
}

/// Values at whole numbers from the first on.
fn filled(numbers: &[f64], values: &[f64], steps: usize) -> Vec<f64> {
    let mut before = 0;
    let value = |n: usize| {
        let wanted = numbers[0] + n as f64;
        while before + 1 < numbers.len() && numbers[before + 1] <= wanted {
            before += 1;
        }
        let Some(next) = numbers.get(before + 1) else { return values[before] };
        let share = (wanted - numbers[before]) / (next - numbers[before]);
        values[before] + share * (values[before + 1] - values[before])
    };
    (0..=steps).map(value).collect()
}

/// Where the encoder has an axis at a time.
fn place(window: &Window, axis: &str, at_s: f64) -> Result<f64, String> {
    let topic = format!("/{axis}");
    let rows = window.topic(&topic)?;
    let angle = rows.channel("position_rad")?;
    let after = rows.time_s.partition_point(|&t| t < at_s).clamp(1, rows.time_s.len().max(2) - 1);
    let [Some(t), Some(a)] = [rows.time_s.get(after - 1..=after), angle.get(after - 1..=after)] else {
        return Err(format!("{topic} has no rows"));
    };
    let share = ((at_s - t[0]) / (t[1] - t[0])).clamp(0.0, 1.0);
    let value = a[0] + share * (a[1] - a[0]);
    value.is_finite().then_some(value).ok_or_else(|| format!("{topic} position_rad is no number somewhere"))
}
