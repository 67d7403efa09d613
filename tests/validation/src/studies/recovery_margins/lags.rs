//! The current loop: corner within 1 %, delay within 2 µs at 40 dB.

use analysis::frf::{C64, Line};
use analysis::lag::{LagError, Order, Settings, current_loop, sampled_response};
use nalgebra::Matrix3;

use super::table::{Demand, Gauss, study};

const PERIOD_S: f64 = 250e-6;

pub(crate) fn rows(seeds: u64) {
    for (delay_s, corner_hz, count) in [
        (2.5e-3, 700.0, 60),
        (2.7e-3, 1000.0, 60),
        (3.0e-3, 1000.0, 100),
        (3.1e-3, 1500.0, 60),
        (2.85e-3, 1300.0, 150),
    ] {
        let bound = bound(delay_s, corner_hz, count);
        let name = format!("I loop {corner_hz} Hz {:.2} ms {count} l.", 1e3 * delay_s);
        let settings = Settings { period_s: PERIOD_S, order: Order::First, most_delay_s: 0.01 };
        let demands = [
            (
                format!("{name}: f_c, % (CRLB {:.2})", 100.0 * bound[0]),
                Demand { truth: corner_hz, rms: 0.01 * corner_hz, unit: 0.01 * corner_hz },
            ),
            (
                format!("{name}: delay, us (CRLB {:.2})", 1e6 * bound[1]),
                Demand { truth: delay_s, rms: 2e-6, unit: 1e-6 },
            ),
        ];
        study(&demands, seeds, |seed| {
            let lines = measured(seed, delay_s, corner_hz, None, PERIOD_S, [5.0, 1500.0], count);
            let Ok(fit) = current_loop(&lines, &settings) else { return vec![None; 2] };
            vec![
                Some([fit.corner_hz, fit.corner_u_hz, f64::INFINITY]),
                Some([fit.transport_s, fit.transport_u_s, f64::INFINITY]),
            ]
        });
    }
    refusals(seeds);
}

/// Cramér–Rao bound of ln f_c and of the delay (s): one-sided below where the delay is a whole number of periods.
fn bound(delay_s: f64, corner_hz: f64, count: u32) -> [f64; 2] {
    let at = |gain: f64, ln: f64, delay_s: f64| {
        let hz = |k: u32| 5.0 + 1495.0 * f64::from(k) / f64::from(count - 1);
        (0..count)
            .map(|k| gain * sampled_response(hz(k), PERIOD_S, corner_hz * ln.exp(), None, delay_s))
            .collect::<Vec<_>>()
    };
    let base = at(0.98, 0.0, delay_s);
    let sd = 0.01 * 0.5_f64.sqrt();
    let column = |moved: Vec<C64>, step: f64| {
        let each = moved.iter().zip(&base).map(move |(m, b)| (m - b) / (step * sd * b.norm()));
        each.flat_map(|c| [c.re, c.im]).collect::<Vec<f64>>()
    };
    let columns = [
        column(at(0.98, 1e-6, delay_s), 1e-6),
        column(at(0.98, 0.0, delay_s - 1e-10), 1e-10),
        column(at(0.98 + 1e-6, 0.0, delay_s), 1e-6),
    ];
    let information =
        Matrix3::from_fn(|i, k| columns[i].iter().zip(&columns[k]).map(|(a, b)| a * b).sum::<f64>());
    let covariance = information.try_inverse().expect("three parameters of the response differ");
    [covariance[(0, 0)].sqrt(), covariance[(1, 1)].sqrt()]
}

/// At 1 kHz up to 400 Hz the corner must be refused; a loop of second order must be flagged.
fn refusals(seeds: u64) {
    let one = Demand { truth: 1.0, rms: 0.1, unit: 1.0 };
    let names = [
        "part refused at 1 kHz, lines to 400 Hz",
        "part flagged: zeta 0.5 fitted as first order",
        "part flagged: first order as it is",
    ];
    let rows = [
        (names[0].to_owned(), one),
        (names[1].to_owned(), one),
        (names[2].to_owned(), Demand { truth: 0.0, ..one }),
    ];
    study(&rows, seeds, |seed| {
        let slow = Settings { period_s: 1e-3, order: Order::First, most_delay_s: 0.01 };
        let fast = Settings { period_s: PERIOD_S, ..slow };
        let lines = measured(seed, 2.8e-3, 1000.0, None, 1e-3, [5.0, 400.0], 80);
        let refused = matches!(current_loop(&lines, &slow), Err(LagError::NotDetermined { .. }));
        let second = measured(seed, 2.8e-3, 1000.0, Some(0.5), PERIOD_S, [5.0, 1500.0], 80);
        let first = measured(seed, 2.8e-3, 1000.0, None, PERIOD_S, [5.0, 1500.0], 80);
        let flagged = |lines: &[Line]| current_loop(lines, &fast).is_ok_and(|fit| fit.misfit);
        [refused, flagged(&second), flagged(&first)]
            .map(|b| Some([f64::from(u8::from(b)), 0.0, 0.0]))
            .to_vec()
    });
}

fn measured(
    seed: u64,
    delay_s: f64,
    corner_hz: f64,
    damping: Option<f64>,
    period_s: f64,
    [from, to]: [f64; 2],
    count: u32,
) -> Vec<Line> {
    let mut random = Gauss::new(seed);
    (0..count)
        .map(|k| from + (to - from) * f64::from(k) / f64::from(count - 1))
        .map(|hz| random.line(hz, 0.98 * sampled_response(hz, period_s, corner_hz, damping, delay_s), 0.01))
        .collect()
}
