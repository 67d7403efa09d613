//! How long a target was dwelt on.

/// A stretch of a fine track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dwell {
    /// Time of its first frame.
    pub from_s: f64,
    /// Time of its last frame.
    pub to_s: f64,
}

impl Dwell {
    /// Duration.
    pub fn lasts_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// The longest stretch in which frames follow each other within `gap_s` and the root mean square of both axes over every
/// window of `window_s` in it is at most `limit`; `None` where no window is, or for records of unequal lengths. Errors that
/// are no numbers exceed every limit; times ascend.
pub fn longest_dwell(
    time_s: &[f64],
    errors: [&[f64]; 2],
    limit: f64,
    window_s: f64,
    gap_s: f64,
) -> Option<Dwell> {
    if errors.iter().any(|axis| axis.len() != time_s.len()) {
        return None;
    }
    let mut longest: Option<Dwell> = None;
    let mut from = 0;
    let breaks = |k: &usize| time_s[*k] - time_s[*k - 1] > gap_s;
    for to in (1..time_s.len()).filter(breaks).chain([time_s.len()]) {
        let stretch = [0, 1].map(|axis| &errors[axis][from..to]);
        let within = within(&time_s[from..to], stretch, limit, window_s);
        let found = within.map(|[a, b]| Dwell { from_s: time_s[from + a], to_s: time_s[from + b] });
        if found.is_some_and(|f| longest.is_none_or(|l| f.lasts_s() > l.lasts_s())) {
            longest = found;
        }
        from = to;
    }
    longest
}

/// First and last frame of the longest run of windows that keep the limit.
fn within(time_s: &[f64], errors: [&[f64]; 2], limit: f64, window_s: f64) -> Option<[usize; 2]> {
    let mut sums = vec![[0.0; 2]];
    for k in 0..time_s.len() {
        sums.push([0, 1].map(|axis: usize| sums[k][axis] + errors[axis][k] * errors[axis][k]));
    }
    let (mut longest, mut run): (Option<[usize; 2]>, Option<[usize; 2]>) = (None, None);
    let length = |[a, b]: [usize; 2]| time_s[b] - time_s[a];
    let mut first = 0;
    for last in 0..time_s.len() {
        // The shortest window that is no shorter than asked for.
        while first < last && time_s[last] - time_s[first + 1] >= window_s {
            first += 1;
        }
        if time_s[last] - time_s[first] < window_s {
            continue;
        }
        let count = (last + 1 - first) as f64;
        let keeps = (0..2).all(|axis| sums[last + 1][axis] - sums[first][axis] <= limit * limit * count);
        run = keeps.then(|| [run.map_or(first, |r| r[0]), last]);
        if run.is_some_and(|r| longest.is_none_or(|l| length(r) > length(l))) {
            longest = run;
        }
    }
    longest
}
