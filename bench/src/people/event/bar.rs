//! One line that says how far a run is, drawn anew several times a second.

use std::collections::BTreeMap;

use crate::people::event::RunEvent;
use crate::people::underway::Standing;

/// Before so much has passed, s, and so much is done, as a ratio, nobody can say how long it takes.
const LEAST_S: f64 = 5.0;
const LEAST_DONE_RATIO: f64 = 0.01;

/// How far a run is, in planned seconds: points differ in length by orders of magnitude.
#[derive(Debug, Default)]
pub(crate) struct Extent {
    planned_s: f64,
    /// Of procedures that are over, whole.
    over_s: f64,
    /// Of points that are over, by procedure.
    points_s: BTreeMap<String, f64>,
}

impl Extent {
    /// Takes an event of the run.
    pub(crate) fn hear(&mut self, event: &RunEvent) {
        match event {
            RunEvent::RunStarted { planned_s, .. } => self.planned_s = *planned_s,
            RunEvent::PointEnded { procedure, planned_s, .. } => {
                *self.points_s.entry(procedure.clone()).or_default() += planned_s;
            }
            RunEvent::ProcedureEnded { procedure, planned_s, .. } => {
                // What was left out is not to be waited for.
                self.points_s.remove(procedure);
                self.over_s += planned_s;
            }
            _ => {}
        }
    }

    /// Share that is done, 0 to 1, with what runs now.
    pub(crate) fn done_ratio(&self, now: &[Standing]) -> f64 {
        let running = now.iter().map(|point| point.seen.loop_s.min(point.planned_s)).sum::<f64>();
        let done_s = self.over_s + self.points_s.values().sum::<f64>() + running;
        if self.planned_s > 0.0 { (done_s / self.planned_s).clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// Time that is left, s, if it goes on as it did; `None` where too little is done to say.
fn left_s(elapsed_s: f64, done_ratio: f64) -> Option<f64> {
    let known = elapsed_s >= LEAST_S && done_ratio >= LEAST_DONE_RATIO;
    known.then(|| elapsed_s * (1.0 - done_ratio) / done_ratio)
}

/// `12:34`, `1:02:03`.
pub(crate) fn clock(s: f64) -> String {
    let whole = s.max(0.0) as u64;
    let [h, min, s] = [whole / 3600, whole / 60 % 60, whole % 60];
    if h > 0 { format!("{h}:{min:02}:{s:02}") } else { format!("{min}:{s:02}") }
}

/// The line at this time, no wider than `columns`.
pub(crate) fn line(columns: usize, elapsed_s: f64, extent: &Extent, now: &[Standing]) -> String {
    let done = extent.done_ratio(now);
    let cells = match columns {
        0..70 => 8,
        70..120 => 16,
        _ => 32,
    };
    let full = (done * cells as f64) as usize;
    let bar = format!("[{}{}]", "=".repeat(full), "-".repeat(cells - full));
    let left = left_s(elapsed_s, done).map_or_else(String::new, |left| format!("  {} left", clock(left)));
    let what = now.first().map_or_else(String::new, what);
    let more = match now.len() {
        0 | 1 => String::new(),
        count => format!(" (+{} more)", count - 1),
    };
    let line = format!("{} {bar} {:3.0} %{left}  {what}{more}", clock(elapsed_s), 100.0 * done);
    cut(line.trim_end(), columns)
}

/// `AZ-FRICTION 3/5 12:30/24:10 running: velocity=10 deg/s, segment 3/8 stroke`.
pub(crate) fn what(point: &Standing) -> String {
    let Standing { procedure, point: name, number, of, planned_s, segment, seen } = point;
    let segment = segment.as_ref().map_or_else(String::new, |segment| {
        format!(", segment {}/{} {}", segment.number, segment.of, segment.label)
    });
    let time = format!("{}/{}", clock(seen.loop_s), clock(*planned_s));
    format!("{procedure} {number}/{of} {time} {}: {name}{segment}", seen.doing)
}

/// The beginning of a line, as wide as a terminal has columns; one is left free, where a cursor wraps.
fn cut(line: &str, columns: usize) -> String {
    let room = columns.saturating_sub(1);
    if line.chars().count() <= room {
        return line.to_owned();
    }
    let kept: String = line.chars().take(room.saturating_sub(1)).collect();
    format!("{kept}…")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cycle::progress::Seen;
    use crate::people::underway::Segment;

    fn begun(planned_s: f64) -> Extent {
        let mut extent = Extent::default();
        extent.hear(&RunEvent::RunStarted {
            campaign: "fat".to_owned(),
            rig: "sim".to_owned(),
            unit: "nominal".to_owned(),
            procedures: 2,
            planned_s,
            folder: "runs/1".to_owned(),
        });
        extent
    }

    fn cogging(loop_s: f64) -> Standing {
        let segment = Some(Segment { number: 2, of: 2, label: "strokes".to_owned() });
        Standing {
            procedure: "EL-COGGING".to_owned(),
            point: "velocity=0.5 deg/s".to_owned(),
            number: 1,
            of: 1,
            planned_s: 1459.0,
            segment,
            seen: Seen { loop_s, segment: Some(1), doing: "running" },
        }
    }

    #[test]
    fn a_line_is_no_wider_than_the_terminal() {
        let extent = begun(2918.0);
        let now = [cogging(750.0), cogging(10.0)];
        let lines: Vec<String> = [20, 60, 80, 200].map(|columns| line(columns, 83.0, &extent, &now)).into();
        for (line, columns) in lines.iter().zip([20, 60, 80, 200]) {
            assert!(line.chars().count() < columns, "{line}");
        }
        insta::assert_snapshot!(lines.join("\n"), @"
        1:23 [==------]  2…
        1:23 [==------]  26 %  3:55 left  EL-COGGING 1/1 12:30/24:…
        1:23 [====------------]  26 %  3:55 left  EL-COGGING 1/1 12:30/24:19 running: …
        1:23 [========------------------------]  26 %  3:55 left  EL-COGGING 1/1 12:30/24:19 running: velocity=0.5 deg/s, segment 2/2 strokes (+1 more)
        ");
    }

    #[test]
    fn within_one_point_of_24_minutes_the_line_never_stands_still() {
        let extent = begun(1459.0);
        let lines: Vec<String> =
            (0..1459).map(|s| line(80, f64::from(s), &extent, &[cogging(f64::from(s))])).collect();
        assert!(lines.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn what_is_left_is_said_once_enough_is_done_and_counts_what_was_left_out_as_over() {
        assert_eq!(left_s(3.0, 0.5), None);
        assert_eq!(left_s(60.0, 0.005), None);
        assert_eq!(left_s(60.0, 0.25), Some(180.0));
        let mut extent = begun(1000.0);
        let ended = |planned_s: f64| RunEvent::ProcedureEnded {
            procedure: "P".to_owned(),
            status: "skipped: polarity".to_owned(),
            planned_s,
            verdicts: Vec::new(),
        };
        let point = |planned_s: f64| RunEvent::PointEnded {
            procedure: "P".to_owned(),
            point: "one".to_owned(),
            status: "completed".to_owned(),
            planned_s,
            reason: None,
        };
        extent.hear(&point(100.0));
        assert_eq!(extent.done_ratio(&[]), 0.1);
        extent.hear(&ended(400.0));
        assert_eq!(
            extent.done_ratio(&[]),
            0.4,
            "its points are not counted twice, nor those that it left out missed"
        );
        let slow = cogging(5000.0);
        assert_eq!(
            extent.done_ratio(&[slow]),
            1.0,
            "a point that takes longer than planned is not more than whole"
        );
    }
}
