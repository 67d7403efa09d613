//! Analog loop-back: what of a delay is the bench itself.

use analysis::delay::{Band, cross_correlation};
use analysis::estimate::Estimate;

use super::ECHO;
use super::result::{evidence, measurement};
use crate::axis::AxisLimits;
use crate::case::Case;
use crate::log::Window;
use crate::measurement::PointResult;

const TOPIC: &str = "/fsm";
/// Longest delay looked for.
const MOST_LAG_S: f64 = 0.02;
/// Band of the sequence, in parts of the loop rate.
const BAND_RATIO: [f64; 2] = [0.01, 0.4];

pub(super) fn analyse(case: &Case, window: &Window, limits: &AxisLimits) -> Result<PointResult, String> {
    let rows = window.rows(TOPIC).filter(|rows| rows.time_s.len() > 1);
    let rows = rows.ok_or_else(|| format!("the log has no rows of {TOPIC}: no analog loop-back was read"))?;
    let column = |name: &str| rows.channel(name);
    let rate_hz = limits.loop_rate_hz;
    let gap = rows.time_s.windows(2).position(|t| (t[1] - t[0] - 1.0 / rate_hz).abs() > 0.1 / rate_hz);
    if let Some(row) = gap {
        return Err(format!("{TOPIC} is not logged at the loop rate: a gap after row {row} of the point"));
    }
    let band = Band { from_hz: BAND_RATIO[0] * rate_hz, to_hz: BAND_RATIO[1] * rate_hz };
    let found = cross_correlation(column("echo_out_v")?, column("echo_in_v")?, rate_hz, band, MOST_LAG_S);
    let found = found.map_err(|e| e.to_string())?;
    let n = rows.time_s.len();
    // Written and read in the same tick: whatever comes within a tick is seen in the next.
    let u = found.u_s.hypot(1.0 / rate_hz / 12.0_f64.sqrt());
    let estimate = Estimate { value: found.delay_s, u, dof: f64::INFINITY, n };
    let flags = vec![
        format!("{:.3} exchanges, correlation {:.3}", found.delay_s * rate_hz, found.correlation),
        "the half sample of hold is not in it".to_owned(),
    ];
    let mut echo = measurement(ECHO, case, None, estimate, flags);
    echo.evidence = evidence(window, TOPIC, &["echo_out_v", "echo_in_v"]);
    Ok(PointResult { point: case.point.clone(), measurements: vec![echo], ..PointResult::default() })
}
