//! Rows at even distances in time, where a stalled computer or a lost message has left gaps.

/// Deviation of the distance between two rows from the median distance, relative, up to which a record is even.
const EVEN_RATIO: f64 = 0.1;
/// Rows that follow another one by less than this share of the median distance are left out: two of them would make
/// a cubic through both as steep as their noise.
const CROWDED_RATIO: f64 = 0.5;

/// Time from one row to the next, over the median distance, above which rows are missing.
const GAP_RATIO: f64 = 1.5;
/// Longest time without a row that is bridged, in periods of the fastest motion that matters: within a tenth of a period
/// a cubic through the rows around it follows it.
pub const BRIDGED_PERIODS: f64 = 0.1;

/// A stretch of time without rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Time of the last row before it, s.
    pub at_s: f64,
    /// Time from there to the next row, s.
    pub lasted_s: f64,
}

/// An even raster over a record, and the rows from which a column's values on it are interpolated.
#[derive(Clone, Debug)]
pub struct EvenRows {
    /// Times of the raster, s.
    time_s: Vec<f64>,
    /// Distance of two of them, s.
    sample_s: f64,
    /// Times and indices of the rows used; `None` where the record is even and its rows are the raster.
    kept: Option<Vec<Row>>,
    longest: Gap,
}

/// A row of the record.
#[derive(Clone, Copy, Debug)]
struct Row {
    index: usize,
    time_s: f64,
}

impl EvenRows {
    /// The raster of a record with these times: its own rows where all lie within 10 % of their median distance,
    /// else points at the median distance from the first row on. `None` below five rows or if time does not advance.
    pub fn over(time_s: &[f64]) -> Option<Self> {
        let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.len() < 4 || !steps.iter().all(|step| *step > 0.0 && step.is_finite()) {
            return None;
        }
        let longest = (0..steps.len()).max_by(|&a, &b| steps[a].total_cmp(&steps[b]))?;
        let longest = Gap { at_s: time_s[longest], lasted_s: steps[longest] };
        steps.sort_by(f64::total_cmp);
        let sample_s = steps[steps.len() / 2];
        let duration_s = time_s[time_s.len() - 1] - time_s[0];
        if steps.iter().all(|step| (step / sample_s - 1.0).abs() <= EVEN_RATIO) {
            let sample_s = duration_s / steps.len() as f64;
            return Some(Self { time_s: time_s.to_vec(), sample_s, kept: None, longest });
        }
        let mut kept: Vec<Row> = Vec::with_capacity(time_s.len());
        for (index, &time_s) in time_s.iter().enumerate() {
            if kept.last().is_none_or(|last| time_s - last.time_s >= CROWDED_RATIO * sample_s) {
                kept.push(Row { index, time_s });
            }
        }
        let end_s = kept.last()?.time_s;
        let count = ((end_s - time_s[0]) / sample_s).floor() as usize + 1;
        let raster = (0..count).map(|k| time_s[0] + k as f64 * sample_s).collect();
        (kept.len() > 3).then_some(Self { time_s: raster, sample_s, kept: Some(kept), longest })
    }

    /// Times of the raster, s.
    pub fn time_s(&self) -> &[f64] {
        &self.time_s
    }

    /// Distance of two points of the raster, s.
    pub fn sample_s(&self) -> f64 {
        self.sample_s
    }

    /// The longest time without a row, where rows are missing: above 1.5 times the distance of two rows.
    pub fn missing(&self) -> Option<Gap> {
        (self.longest.lasted_s > GAP_RATIO * self.sample_s).then_some(self.longest)
    }

    /// The longest time without a row, where rows are missing for too long for motions up to `flat_hz` ([`BRIDGED_PERIODS`]).
    pub fn unbridged(&self, flat_hz: f64) -> Option<Gap> {
        self.missing().filter(|gap| gap.lasted_s > BRIDGED_PERIODS / flat_hz)
    }

    /// A column of the record on the raster: as it is, or by cubics through two rows on either side (Lagrange).
    ///
    /// `values` are as many as the record's times.
    pub fn column(&self, values: &[f64]) -> Vec<f64> {
        let Some(kept) = &self.kept else { return values.to_vec() };
        let mut next = 0;
        self.time_s
            .iter()
            .map(|&at_s| {
                while next < kept.len() && kept[next].time_s < at_s {
                    next += 1;
                }
                let first = next.saturating_sub(2).min(kept.len() - 4);
                cubic(&kept[first..first + 4], values, at_s)
            })
            .collect()
    }
}

/// Value at an instant of the polynomial through some rows.
fn cubic(rows: &[Row], values: &[f64], at_s: f64) -> f64 {
    let weight = |row: &Row| -> f64 {
        let others = rows.iter().filter(|other| other.index != row.index);
        others.map(|other| (at_s - other.time_s) / (row.time_s - other.time_s)).product()
    };
    rows.iter().map(|row| weight(row) * values[row.index]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(time_s: &[f64]) -> Vec<f64> {
        time_s.iter().map(|t| 2.0 - 3.0 * t + 5.0 * t * t - 40.0 * t * t * t).collect()
    }

    #[test]
    fn an_even_record_stays_as_it_is_bit_for_bit() {
        let time_s: Vec<f64> = (0..100).map(|k| 7.0 + f64::from(k) * 4e-3).collect();
        let rows = EvenRows::over(&time_s).expect("advances");
        assert_eq!((rows.time_s(), rows.column(&curve(&time_s))), (&time_s[..], curve(&time_s)));
        // Rows of a slow log are far apart, and none is missing.
        assert_eq!((rows.missing(), rows.unbridged(20.0), rows.unbridged(50.0)), (None, None, None));
    }

    #[test]
    fn a_cubic_is_the_same_after_a_gap_a_shift_and_rows_in_a_hurry() {
        let mut time_s: Vec<f64> = (0..40).map(|k| f64::from(k) * 4e-3).collect();
        time_s.extend((0..40).map(|k| 0.167 + f64::from(k) * 4e-3));
        time_s.insert(41, 0.16705);
        let rows = EvenRows::over(&time_s).expect("advances");
        let gap = Gap { at_s: time_s[39], lasted_s: 0.167 - time_s[39] };
        assert_eq!((rows.missing(), rows.unbridged(5.0), rows.unbridged(10.0)), (Some(gap), None, Some(gap)));
        assert!((rows.sample_s() - 4e-3).abs() < 1e-12);
        let even = rows.time_s().windows(2).all(|pair| (pair[1] - pair[0] - 4e-3).abs() < 1e-9);
        assert!(even && rows.time_s().len() == 81, "{}", rows.time_s().len());
        for (value, truth) in rows.column(&curve(&time_s)).iter().zip(curve(rows.time_s())) {
            assert!((value - truth).abs() < 1e-12, "{value} against {truth}");
        }
    }

    #[test]
    fn a_record_whose_time_stands_still_or_goes_back_is_none() {
        for time_s in [vec![0.0; 20], vec![0.0, 1.0, 2.0, 1.5, 3.0, 4.0], vec![0.0, 1.0], vec![f64::NAN; 9]] {
            assert!(EvenRows::over(&time_s).is_none());
        }
    }
}
