//! How late the ticks of a loop came, as its log tells it.

use std::path::Path;

use procedures::log::{LogReader, Window};
use reports::record::LatenessRecord;

/// The lateness of a point; `None` where time was virtual. A point that was lost has its stalls alone.
pub(super) fn of_point(
    file: &str,
    point: &str,
    loop_rate_hz: f64,
    window: &Window,
) -> Option<LatenessRecord> {
    let known = window.lateness.is_some() || !window.stalls.is_empty();
    known.then(|| LatenessRecord {
        log: file.to_owned(),
        point: point.to_owned(),
        loop_rate_hz,
        histogram: window.lateness.unwrap_or_default(),
        stalls: window.stalls.clone(),
    })
}

/// Lateness in a log that is not judged: that of a session. `file` is its name in the run folder. A log that cannot be read has
/// none.
pub fn lateness_of_log(path: &Path, file: &str) -> Vec<LatenessRecord> {
    let Ok(mut reader) = LogReader::open(path) else { return Vec::new() };
    let plan = reader.plan().clone();
    let windows = std::iter::from_fn(|| reader.next_window());
    let of_window = |window: Window| {
        let case = plan.cases.get(window.point)?;
        of_point(file, &case.point, plan.loop_rate_hz, &window)
    };
    windows.filter_map(of_window).collect()
}
