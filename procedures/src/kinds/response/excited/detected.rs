//! Lines that an odd grid leaves out: what stands there was made of other lines.

use analysis::frf::C64;
use analysis::periodic::{self, Distortion, LineKind, Windows};

use super::channels::{Channel, Record};
use super::course::Course;

/// Fewer lines are no grid.
const FEWEST: usize = 5;

/// Odd and even distortion of torque to rate, where lines are odd multiples of 1/T_w and some are left out.
pub(super) fn distortion(
    windows: &Windows,
    excited_hz: &[f64],
    course: &Course,
    record: &Record<'_>,
    nuisance: &[&[f64]],
) -> Option<Distortion> {
    let orders: Vec<u32> = excited_hz.iter().map(|hz| (hz * course.window_s).round() as u32).collect();
    let odd =
        |(order, hz): (&u32, &f64)| order % 2 == 1 && (f64::from(*order) - hz * course.window_s).abs() < 1e-6;
    if orders.len() < FEWEST || !orders.iter().zip(excited_hz).all(odd) {
        return None;
    }
    let first = *orders.first()?;
    let last = *orders.last()?;
    let kind = |order: u32| match order {
        order if orders.contains(&order) => LineKind::Excited,
        order if order % 2 == 1 => LineKind::Odd,
        _ => LineKind::Even,
    };
    let lines: Vec<(f64, LineKind)> =
        (first..=last).map(|order| (f64::from(order) / course.window_s, kind(order))).collect();
    let grid: Vec<f64> = lines.iter().map(|(hz, _)| *hz).collect();
    let all = 0..record.time_s.len();
    let [torque, rate] = [Channel::Torque, Channel::Rate].map(|c| record.values(c, all.clone()));
    let torque = torque?;
    let rate = rate?;
    let channels = [
        periodic::Channel { name: "torque", samples: &torque },
        periodic::Channel { name: "rate", samples: &rate },
    ];
    let mut spectra: Vec<Vec<Vec<C64>>> = periodic::spectra(windows, &grid, &channels, nuisance).ok()?;
    let rate = spectra.pop()?;
    let torque = spectra.pop()?;
    periodic::fast(&lines, &torque, &rate).ok()
}
