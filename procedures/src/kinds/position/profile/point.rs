//! One point: the error of all rows that count.

use analysis::estimate::Estimate;
use analysis::following::{delay, following};

use super::named;
use super::plan::{FOLLOWED, VELOCITY};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::position::positioned::{self, Record};
use crate::log::{SegmentSpan, Window};
use crate::measurement::{Condition, Measurement, PointResult};
use crate::reason::{PositionReason, Reason};
use crate::stimulus::Stimulus;
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

pub(super) const ESTIMATOR: &str = "following/1";
/// Rate counts as constant within this part.
const CONSTANT_RATIO: f64 = 1e-3;
/// Loops settle for this long: five times the time constant of the position loop.
const SETTLE_S: f64 = 1.0;
/// Block of the bootstrap.
const BLOCK_S: f64 = 1.0;

/// Rows that count: time since the point's beginning, error, rate of the reference, rate of the axis.
#[derive(Default)]
struct Followed {
    time_s: Vec<f64>,
    errors_rad: Vec<f64>,
    rates: Vec<f64>,
}

pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> Result<PointResult, Reason> {
    let record = Record::new(&case.axis, window)?;
    let spans = Record::spans(case, window, FOLLOWED);
    let mut all = Followed::default();
    for span in &spans {
        take(&mut all, &record, &case.segments[span.segment].stimulus, span);
    }
    let [first, .., last] = all.time_s.as_slice() else {
        return Err(PositionReason::NothingFollowed.into());
    };
    let rows = record.range(spans[0].start_s, spans[0].end_s);
    let lasts_s = (spans[0].end_s - spans[0].start_s).max(1e-9);
    let block = (rows.len() as f64 * BLOCK_S / lasts_s).round() as usize;
    let as_is = following(&all.errors_rad, block)?;
    let delay_s = delay(&all.errors_rad, &all.rates).ok_or(PositionReason::ReferenceRests)?;
    let aligned: Vec<f64> = all.errors_rad.iter().zip(&all.rates).map(|(e, r)| e - delay_s * r).collect();
    let aligned = following(&aligned, block)?;
    let of_delay = Estimate { value: delay_s, u: as_is.rms.u / rms(&all.rates), ..as_is.rms };
    let none = "alignment: none".to_owned();
    let removed = format!("alignment: pure delay of {:.3} ms removed", 1e3 * delay_s);
    let values = [
        (as_is.percentile, none.clone()),
        (as_is.rms, none.clone()),
        (as_is.peak, none.clone()),
        (aligned.percentile, removed),
        (of_delay, none),
    ];
    let evidence = record.evidence(&["position_setpoint_rad", "position_rad"], [*first, *last]);
    let conditions = conditions(positioned::conditions(case, window, axes), &record, &spans);
    let measured = named(case).iter().zip(values).map(|((name, kind), (estimate, flag))| Measurement {
        point: Some(case.point.clone()),
        conditions: conditions.clone(),
        evidence: evidence.clone(),
        flags: vec![
            flag,
            format!(
                "mean {:.2} urad, {:.1} s",
                1e6 * as_is.mean,
                all.time_s.len() as f64 * lasts_s / rows.len().max(1) as f64
            ),
        ],
        ..Measurement::new(name, &case.axis, *kind, Some(estimate), ESTIMATOR)
    });
    Ok(PointResult {
        point: case.point.clone(),
        measurements: measured.collect(),
        plots: vec![picture(case, &all)],
        ..PointResult::default()
    })
}

/// Takes the rows of a span that count.
fn take(all: &mut Followed, record: &Record<'_>, stimulus: &Stimulus, span: &SegmentSpan) {
    let prepared = stimulus.prepare(span.start_position_rad);
    let lasts_s = stimulus.duration_s(span.start_position_rad).unwrap_or(0.0);
    let counts: Box<dyn Fn(f64, f64) -> bool> = match stimulus {
        Stimulus::Move { limits, .. } => {
            let most = limits.velocity_rad_per_s * (1.0 - CONSTANT_RATIO);
            let begins_s = (0..).map(|k| f64::from(k) * 1e-3).take_while(|t| *t < lasts_s);
            let mut begins_s = begins_s.filter(|t| prepared.at(*t).velocity_rad_per_s.abs() >= most);
            let from_s = begins_s.next().unwrap_or(lasts_s) + SETTLE_S;
            Box::new(move |t, rate| t >= from_s && rate.abs() >= most)
        }
        Stimulus::Sine { fade_s, .. } => {
            let from_s = fade_s + SETTLE_S;
            let to_s = lasts_s - fade_s;
            Box::new(move |t, _| t >= from_s && t < to_s)
        }
        _ => Box::new(move |t, _| t < lasts_s),
    };
    for row in record.range(span.start_s, span.end_s) {
        let t = record.time_s[row] - span.start_s;
        let rate = prepared.at(t).velocity_rad_per_s;
        if counts(t, rate) {
            all.time_s.push(record.time_s[row]);
            all.errors_rad.push(record.setpoint_rad[row] - record.position_rad[row]);
            all.rates.push(rate);
        }
    }
}

/// Conditions with the rate that the axis had on the ramp.
fn conditions(mut all: Vec<Condition>, record: &Record<'_>, spans: &[&SegmentSpan]) -> Vec<Condition> {
    for condition in all.iter_mut().filter(|c| c.name == VELOCITY) {
        let rates = spans.iter().filter_map(|span| {
            let quarter_s = 0.25 * (span.end_s - span.start_s);
            let middle_s = 0.5 * (span.start_s + span.end_s);
            let [from_s, to_s] = [middle_s - quarter_s, middle_s + quarter_s];
            let rows = record.range(from_s, to_s);
            let first = rows.start;
            let last = rows.end.checked_sub(1)?;
            let way = record.position_rad[last] - record.position_rad[first];
            let took_s = record.time_s[last] - record.time_s[first];
            (took_s > 0.0).then(|| (way / took_s).abs())
        });
        let rates: Vec<f64> = rates.collect();
        condition.achieved = (!rates.is_empty()).then(|| rates.iter().sum::<f64>() / rates.len() as f64);
    }
    all
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn picture(case: &Case, all: &Followed) -> Plot {
    let t0 = all.time_s.first().copied().unwrap_or(0.0);
    let time: Vec<f64> = all.time_s.iter().map(|t| t - t0).collect();
    let errors: Vec<f64> = all.errors_rad.iter().map(|e| 1e6 * e).collect();
    let name = case.point.split(' ').next().unwrap_or_default();
    Plot {
        series: vec![Series::thinned(
            "command less encoder, not aligned",
            Style::Line,
            [&time, &errors],
            MAX_POINTS,
        )],
        ..Plot::new(
            format!("following-{name}"),
            format!("Following error, {}", case.point),
            Scale::linear("time", "s"),
            Scale::linear("error", "urad"),
        )
    }
}
