//! Windows that the target's acceleration opens.

/// Stretches [from, to] in s: from `before_s` before to `after_s` after every sample whose magnitude exceeds `threshold`;
/// those that touch are one. Samples that are no number open nothing; times ascend.
pub fn opened(
    time_s: &[f64],
    acceleration: &[f64],
    threshold: f64,
    before_s: f64,
    after_s: f64,
) -> Vec<[f64; 2]> {
    let mut windows: Vec<[f64; 2]> = Vec::new();
    for (t_s, _) in time_s.iter().zip(acceleration).filter(|(_, a)| a.abs() > threshold) {
        let [from_s, to_s] = [t_s - before_s, t_s + after_s];
        match windows.last_mut() {
            Some(last) if from_s <= last[1] => last[1] = to_s,
            _ => windows.push([from_s, to_s]),
        }
    }
    windows
}
