//! Where a temperature ends that rises under a load which repeats without end.
//!
//! Under a periodic load a body of first order (one time constant τ) has cycle means that follow
//! `E + D·e^(−t/τ)` exactly, whatever the load does inside its cycle: the mean over a period filters the ripple. E is
//! where they end.

use std::fmt;

/// Places on the logarithmic scale of time constants that are tried.
const TRIALS: u32 = 400;
/// Fewest cycle means: the model has three parameters.
const LEAST_MEANS: usize = 4;
/// Time constants whose squared residuals exceed the least by this many variances are out (two standard deviations
/// of one parameter: χ² with one degree of freedom, 95.4 %).
const CHI_SQUARE: f64 = 4.0;

/// Means of a record over whole cycles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CycleMeans {
    /// Middle of each cycle, s.
    pub time_s: Vec<f64>,
    /// Mean of each cycle, °C.
    pub mean_degc: Vec<f64>,
    /// Largest value in the last cycle less its mean, K.
    pub ripple_k: f64,
}

impl CycleMeans {
    /// Means of `degc`, sampled at `time_s` (ascending), between neighbouring `bounds_s`; cycles without samples are
    /// left out.
    pub fn new(time_s: &[f64], degc: &[f64], bounds_s: &[f64]) -> Self {
        let mut means = Self::default();
        for pair in bounds_s.windows(2) {
            let rows = time_s.partition_point(|&t| t < pair[0])..time_s.partition_point(|&t| t < pair[1]);
            let Some(values) = degc.get(rows).filter(|values| !values.is_empty()) else { continue };
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            means.time_s.push(0.5 * (pair[0] + pair[1]));
            means.mean_degc.push(mean);
            means.ripple_k = values.iter().fold(0.0, |most: f64, v| most.max(v - mean));
        }
        means
    }
}

/// A value and its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// The value.
    pub value: f64,
    /// Standard uncertainty of `value`.
    pub u: f64,
}

/// Where a rising temperature ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Heating {
    /// Cycle mean without end, °C.
    pub end_degc: Value,
    /// Time constant, s; `None` where the record holds none: then the end covers every one up to the longest.
    pub time_constant_s: Option<Value>,
    /// Difference to the end at the first mean.
    difference_k: f64,
    /// Time of the first mean.
    from_s: f64,
    /// Time constant of the best fit, be it told or not.
    fitted_s: f64,
}

impl Heating {
    /// The best fit at a time of the record, °C.
    pub fn at(&self, time_s: f64) -> f64 {
        self.end_degc.value + self.difference_k * (-(time_s - self.from_s) / self.fitted_s).exp()
    }
}

/// Why there is no end to be told.
#[derive(Clone, Debug, PartialEq)]
pub enum HeatingError {
    /// Too few whole cycles.
    FewCycles {
        /// Cycle means needed.
        needed: usize,
        /// Cycle means there are.
        found: usize,
    },
    /// Something is no number, time does not ascend, or a setting is not above 0.
    NotANumber,
}

impl fmt::Display for HeatingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewCycles { needed, found } => {
                write!(
                    f,
                    "{found} whole cycles, but {needed} are needed to determine the final temperature: run \
                     more cycles"
                )
            }
            Self::NotANumber => {
                write!(f, "temperatures are not numbers, or times do not ascend: check the log")
            }
        }
    }
}

impl std::error::Error for HeatingError {}

/// Fits `E + D·e^(−t/τ)` to cycle means, τ between a fifth of a cycle and `longest_s`.
///
/// For each τ the fit is linear; the sum of squared residuals over τ (profile likelihood, Bates & Watts, *Nonlinear
/// Regression Analysis*, 1988, ch. 6) says which time constants the record allows, and the ends that go with them are
/// the uncertainty. `u_mean_degc` is what a cycle mean is uncertain by at least (resolution of the sensor). Where no
/// time constant up to `longest_s` can be excluded, none is told, and the end covers all of them.
///
/// # Errors
/// [`HeatingError`]: fewer than four cycles, or what is no number.
pub fn extrapolate(means: &CycleMeans, u_mean_degc: f64, longest_s: f64) -> Result<Heating, HeatingError> {
    let t = &means.time_s;
    let y = &means.mean_degc;
    let found = t.len().min(y.len());
    if found < LEAST_MEANS {
        return Err(HeatingError::FewCycles { needed: LEAST_MEANS, found });
    }
    let ascends = t.windows(2).all(|pair| pair[0] < pair[1]);
    let numbers = t.iter().chain(y).all(|v| v.is_finite());
    if !(ascends && numbers && u_mean_degc > 0.0 && longest_s > 0.0 && longest_s.is_finite()) {
        return Err(HeatingError::NotANumber);
    }
    let from_s = t[0];
    let shortest_s = (0.2 * (t[1] - from_s)).min(longest_s);
    let trials: Vec<Trial> = (0..=TRIALS)
        .map(|k| shortest_s * (longest_s / shortest_s).powf(f64::from(k) / f64::from(TRIALS)))
        .filter_map(|tau_s| Trial::new(t, y, tau_s))
        .collect();
    let best =
        trials.iter().min_by(|a, b| a.squares.total_cmp(&b.squares)).ok_or(HeatingError::NotANumber)?;
    let dof = (found - 3) as f64;
    let variance = (best.squares / dof).max(u_mean_degc * u_mean_degc);
    let allowed: Vec<&Trial> =
        trials.iter().filter(|trial| trial.squares <= best.squares + CHI_SQUARE * variance).collect();
    // Two standard deviations of the end, whichever time constant it has: those of each fit, and those between fits.
    let reach = |sign: f64| {
        let ends = allowed.iter().map(|trial| sign * (trial.end - best.end));
        ends.fold(0.0, f64::max)
    };
    let between = 0.5 * reach(1.0).max(reach(-1.0));
    let within = (best.end_variance * variance).sqrt();
    let shortest = allowed.first().map_or(0.0, |a| a.tau_s);
    let longest = allowed.last().map_or(0.0, |a| a.tau_s);
    let told = longest < longest_s * (1.0 - 1e-9) && shortest > shortest_s * (1.0 + 1e-9);
    let u_tau = 0.5 * (longest - best.tau_s).max(best.tau_s - shortest);
    Ok(Heating {
        end_degc: Value { value: best.end, u: within.hypot(between) },
        time_constant_s: told.then_some(Value { value: best.tau_s, u: u_tau }),
        difference_k: best.difference,
        from_s,
        fitted_s: best.tau_s,
    })
}

/// The best fit for one time constant.
struct Trial {
    tau_s: f64,
    end: f64,
    /// Difference to the end at the first mean.
    difference: f64,
    squares: f64,
    /// Variance of the end for a variance of 1 of each mean.
    end_variance: f64,
}

impl Trial {
    fn new(t: &[f64], y: &[f64], tau_s: f64) -> Option<Self> {
        let n = t.len() as f64;
        let decay: Vec<f64> = t.iter().map(|t_s| (-(t_s - t[0]) / tau_s).exp()).collect();
        let mean_x = decay.iter().sum::<f64>() / n;
        let mean_y = y.iter().sum::<f64>() / n;
        let sxx: f64 = decay.iter().map(|x| (x - mean_x).powi(2)).sum();
        let sxy: f64 = decay.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
        if sxx <= 1e-12 {
            return None;
        }
        let difference = sxy / sxx;
        let end = mean_y - difference * mean_x;
        let squares = decay.iter().zip(y).map(|(x, y)| (y - end - difference * x).powi(2)).sum();
        let end_variance = 1.0 / n + mean_x * mean_x / sxx;
        Some(Self { tau_s, end, difference, squares, end_variance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first-order body under a load that is on for a third of each cycle, stepped finely; 0.1 K resolution.
    fn record(tau_s: f64, rise_k: f64, cycles: u32, resolution_k: f64) -> CycleMeans {
        const PERIOD_S: f64 = 20.0;
        const STEP_S: f64 = 0.01;
        let count = (f64::from(cycles) * PERIOD_S / STEP_S).round() as u32;
        let mut degc = 40.0;
        let mut time_s = Vec::new();
        let mut seen = Vec::new();
        for k in 0..count {
            let t_s = f64::from(k) * STEP_S;
            let load = if t_s % PERIOD_S < PERIOD_S / 3.0 { 3.0 } else { 0.0 };
            degc += (40.0 + rise_k * load - degc) * STEP_S / tau_s;
            time_s.push(t_s);
            seen.push(if resolution_k > 0.0 { (degc / resolution_k).round() * resolution_k } else { degc });
        }
        let bounds: Vec<f64> = (0..=cycles).map(|k| f64::from(k) * PERIOD_S).collect();
        CycleMeans::new(&time_s, &seen, &bounds)
    }

    #[test]
    fn a_record_of_three_time_constants_tells_end_and_time_constant_though_the_load_comes_in_bursts() {
        let heating = extrapolate(&record(60.0, 30.0, 10, 0.1), 0.03, 1800.0).expect("a record to fit");
        let tau = heating.time_constant_s.expect("a time constant");
        assert!((tau.value - 60.0).abs() < 2.0 * tau.u.max(0.5), "{tau:?}");
        let end = heating.end_degc;
        assert!((end.value - 70.0).abs() < 2.0 * end.u && end.u < 0.5, "{end:?}");
        let early = heating.at(10.0);
        let late = heating.at(190.0);
        assert!((late - 68.8).abs() < 0.5 && early < 50.0, "{early} {late}");
    }

    #[test]
    fn the_cycle_means_of_an_exact_record_lie_on_an_exact_exponential() {
        let heating = extrapolate(&record(60.0, 30.0, 8, 0.0), 1e-4, 1800.0).expect("a record to fit");
        // Euler steps of 10 ms in 60 s: 1e-4 of the time constant; trials lie 2.3 % apart.
        assert!((heating.end_degc.value - 70.0).abs() < 0.6, "{heating:?}");
    }

    #[test]
    fn a_record_too_short_for_the_time_constant_says_so_and_its_end_covers_the_truth() {
        for (tau_s, rise_k) in [(300.0, 1.0), (1500.0, 5.0)] {
            let heating = extrapolate(&record(tau_s, rise_k, 4, 0.1), 0.03, 1800.0).expect("a record to fit");
            assert_eq!(heating.time_constant_s, None);
            let end = heating.end_degc;
            assert!((end.value - 40.0 - rise_k).abs() < 2.0 * end.u, "{tau_s} s: {end:?}");
        }
    }

    #[test]
    fn three_cycles_and_what_is_no_number_are_refused() {
        let few = extrapolate(&record(60.0, 30.0, 3, 0.1), 0.03, 1800.0);
        assert_eq!(few, Err(HeatingError::FewCycles { needed: 4, found: 3 }));
        let mut holes = record(60.0, 30.0, 5, 0.1);
        holes.mean_degc[2] = f64::NAN;
        assert_eq!(extrapolate(&holes, 0.03, 1800.0), Err(HeatingError::NotANumber));
        assert_eq!(extrapolate(&record(60.0, 30.0, 5, 0.1), 0.0, 1800.0), Err(HeatingError::NotANumber));
    }
}
