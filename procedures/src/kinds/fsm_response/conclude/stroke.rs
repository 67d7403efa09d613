//! Stroke, and the gauge against the autocollimator: positions up to the end.

use analysis::least_squares::LinearFit;
use analysis::uncertainty::{Component, combine};

use super::Point;
use crate::kinds::frames::MIRROR_AXES;
use crate::kinds::fsm_response::keys::Keys;
use crate::kinds::fsm_response::level::Reading;
use crate::kinds::fsm_response::measure::{complete, measurement};
use crate::kinds::fsm_response::record::{POSITION_WIDTH, POSITIONS};
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;
use crate::trace::{Plot, Scale, Series, Style};

pub(in crate::kinds::fsm_response) const STROKE: &str = "mirror-stroke";
pub(in crate::kinds::fsm_response) const GAUGE_SCALE: &str = "gauge-scale-departure";

/// A position that was held.
#[derive(Clone, Copy, Debug)]
struct Position {
    command_rad: f64,
    gauge_rad: f64,
    gauge_u_rad: f64,
    reference: Option<(f64, f64)>,
    rows: f64,
}

fn positions(point: Point<'_>) -> Vec<Position> {
    let numbers = point.1.numbers.get(POSITIONS).map_or(&[][..], Vec::as_slice);
    let read =
        |&[command_rad, gauge_rad, gauge_u_rad, known, reference, reference_u, rows]: &[f64;
              POSITION_WIDTH]| Position {
            command_rad,
            gauge_rad,
            gauge_u_rad,
            reference: (known > 0.5).then_some((reference, reference_u)),
            rows,
        };
    numbers.as_chunks::<POSITION_WIDTH>().0.iter().map(read).collect()
}

/// One-sided stroke and departure of the gauge's scale.
pub(super) fn measurements(keys: &Keys, point: Point<'_>) -> Vec<Measurement> {
    let (case, result) = point;
    let positions = positions(point);
    let failed = || result.inconclusive.clone().unwrap_or_else(|| "no positions in the log".to_owned());
    let seen = positions.iter().all(|p| p.reference.is_some()) && !positions.is_empty();
    let stroke = if positions.is_empty() { Err(failed()) } else { stroke(keys, &positions, seen) };
    let scale = match seen {
        _ if positions.is_empty() => Err(failed()),
        false => Err("no autocollimator: the gauge alone cannot show its own scale".to_owned()),
        true => gauge_scale(keys, &positions),
    };
    let mut all =
        vec![measurement(STROKE, Q::Angle, case, stroke), measurement(GAUGE_SCALE, Q::Ratio, case, scale)];
    for m in &mut all {
        complete(m, keys, case, &result.numbers);
    }
    let sensor = if seen { "by the autocollimator" } else { "gauge only" };
    all[0].flags.push(sensor.to_owned());
    if seen {
        let axis = &all[0].axis;
        let channel = format!("/fsm reference_{axis}_rad");
        all.iter_mut().flat_map(|m| &mut m.evidence).for_each(|e| e.channels.push(channel.clone()));
    }
    all
}

/// The smaller one of both sides: the farthest position that was reached there.
fn stroke(keys: &Keys, positions: &[Position], seen: bool) -> Result<Reading, String> {
    let scale_u = match (seen, keys.gauge_u_ratio) {
        (true, _) => keys.reference_u_ratio,
        (false, Some(u)) => u,
        (false, None) => {
            return Err("gauge only: the servo follows its own gauge, so that a wrong scale of it does not show; connect \
                 the autocollimator, or state `gauge-u` from a certificate"
                .to_owned());
        }
    };
    let reached = |p: &Position| match p.reference {
        Some(reference) if seen => reference,
        _ => (p.gauge_rad, p.gauge_u_rad),
    };
    let side = |sign: f64| {
        let mine = positions.iter().filter(|p| sign * p.command_rad > 0.0);
        let tilts = mine.map(|p| (sign * reached(p).0, reached(p).1, p.rows));
        tilts.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (Some(up), Some(down)) = (side(1.0), side(-1.0)) else {
        return Err("positions of one side are missing".to_owned());
    };
    let (value, u, rows) = if up.0 < down.0 { up } else { down };
    let spread =
        combine(&[Component { u, dof: (rows - 1.0).max(1.0) }, Component::known(scale_u * value.abs())]);
    Ok(Reading { value, u: spread.u, dof: spread.dof, n: positions.len() })
}

/// Slope of gauge over autocollimator, less 1.
fn gauge_scale(keys: &Keys, positions: &[Position]) -> Result<Reading, String> {
    let x: Vec<f64> = positions.iter().filter_map(|p| p.reference).map(|r| r.0).collect();
    let y: Vec<f64> = positions.iter().map(|p| p.gauge_rad).collect();
    let fit = LinearFit::new(&[vec![1.0; x.len()], x], &y, None).map_err(|e| e.to_string())?;
    let own = Component { u: fit.u(1), dof: fit.dof as f64 };
    let spread = combine(&[own, Component::known(keys.reference_u_ratio)]);
    Ok(Reading { value: fit.coefficients[1] - 1.0, u: spread.u, dof: spread.dof, n: y.len() })
}

/// Departure of what was reached from the command, over the command.
pub(super) fn plot(axis: usize, point: Point<'_>) -> Option<Plot> {
    let positions = positions(point);
    if positions.is_empty() {
        return None;
    }
    let scale =
        |label: &str, unit: &str| Scale { label: label.to_owned(), unit: unit.to_owned(), log: false };
    let series = |label: &str, at: &dyn Fn(&Position) -> Option<f64>| {
        let both =
            positions.iter().filter_map(|p| Some((1e3 * p.command_rad, 1e6 * (at(p)? - p.command_rad))));
        let (x, y): (Vec<f64>, Vec<f64>) = both.unzip();
        let style = Style::Markers;
        (!x.is_empty()).then(|| Series::new(label, style, x, y))
    };
    let all = [
        series("strain gauge", &|p| Some(p.gauge_rad)),
        series("autocollimator", &|p| p.reference.map(|r| r.0)),
    ];
    let name = MIRROR_AXES[axis];
    Some(Plot {
        id: format!("stroke-{name}"),
        title: format!("Positions up to the end of the stroke, {name}"),
        x: scale("command", "mrad"),
        y: scale("reached less command", "urad"),
        series: all.into_iter().flatten().collect(),
        limits: Vec::new(),
        marks: Vec::new(),
        limits_of: None,
        ..Plot::default()
    })
}
