//! Pictures of ramps, dwell law, presliding response and hold margins.

use analysis::breakaway::{Peak, STRETCH};
use analysis::dwell::{DwellLaw, Repeats};
use analysis::multisine::Presliding;

use super::Direction;
use super::hold::{Curve, CurveMargin, Pose};
use super::ramps::Course;
use crate::case::Case;
use crate::trace::{MAX_POINTS, Mark, Plot, Scale, Series, Style};

/// Points of a ramp: there are hundreds of them.
const RAMP_POINTS: usize = MAX_POINTS / 2;

fn scale(label: &str, unit: &str, log: bool) -> Scale {
    Scale { label: label.to_owned(), unit: unit.to_owned(), log }
}

fn series(label: &str, style: Style, x: Vec<f64>, y: Vec<f64>, u: Vec<f64>) -> Series {
    Series::new(label, style, x, y).with_u(u)
}

fn plot(id: String, title: String, x: Scale, y: Scale, series: Vec<Series>) -> Plot {
    Plot { series, ..Plot::new(id, title, x, y) }
}

/// A name without spaces and signs.
fn slug(text: &str) -> String {
    let mut slug = String::new();
    for c in text.chars() {
        match c {
            '+' => slug.push_str("plus"),
            '-' if slug.ends_with('-') => slug.push_str("minus"),
            c if c.is_ascii_alphanumeric() => slug.push(c.to_ascii_lowercase()),
            _ if !slug.ends_with('-') => slug.push('-'),
            _ => {}
        }
    }
    slug.trim_matches('-').to_owned()
}

/// Torque over displacement, the stretch that is judged, the onset and the maximum.
pub(super) fn ramp(case: &Case, course: &Course, peak: &Peak, z_ss_rad: f64) -> Plot {
    let millirad: Vec<f64> = course.x_rad.iter().map(|x| 1e3 * x).collect();
    let effort = [&millirad[..], &course.effort_nm];
    let ramp = Series::thinned("torque less inertia and load", Style::Line, effort, RAMP_POINTS);
    let inside = |x: &f64| (STRETCH[0] * z_ss_rad..=STRETCH[1] * z_ss_rad).contains(&(1e-3 * x));
    let points = ramp.x.iter().copied().zip(ramp.y.iter().copied());
    let (judged_x, judged_y) = points.filter(|(x, _)| inside(x)).unzip();
    let breakaway_u = vec![2.0 * peak.u_nm];
    let mut plot = plot(
        slug(&case.point),
        format!("Torque ramp: {}", case.point),
        scale("displacement", "mrad", false),
        scale("friction torque", "N*m", false),
        vec![
            ramp,
            series("3 … 8 z_ss", Style::Line, judged_x, judged_y, Vec::new()),
            series("breakaway", Style::Markers, vec![1e3 * peak.at_rad], vec![peak.torque_nm], breakaway_u),
        ],
    );
    plot.marks = vec![Mark { label: "onset".to_owned(), x: 1e3 * course.x_rad[peak.onset] }];
    plot.limits_of = Some("breakaway-torque".to_owned());
    plot
}

/// Breakaway torque over time at rest, with the law.
pub(super) fn dwell(rate: f64, groups: &[Repeats], law: &DwellLaw) -> Plot {
    let mut all = Vec::new();
    for direction in Direction::BOTH {
        let label = format!("{} direction", direction.word());
        let own = || groups.iter().filter(|g| g.direction_ratio == direction.ratio());
        let x: Vec<f64> = own().flat_map(|g| g.rest_s.iter().copied()).collect();
        let y: Vec<f64> = own().flat_map(|g| g.torque_nm.iter().copied()).collect();
        let u = vec![2.0 * law.repeatability_nm; x.len()];
        if !x.is_empty() {
            all.push(series(&label, Style::Markers, x, y, u));
        }
    }
    let times = || groups.iter().flat_map(|g| g.rest_s.iter().copied());
    let low = times().fold(f64::INFINITY, f64::min).max(1e-3);
    let high = times().fold(low, f64::max);
    let x: Vec<f64> = (0..=100).map(|k| low * (high / low).powf(f64::from(k) / 100.0)).collect();
    let y = x.iter().map(|t| law.at(*t)).collect();
    all.push(series("T0 + slope·ln(1 + t/τ)", Style::Fit, x, y, Vec::new()));
    let mut plot = plot(
        slug(&format!("dwell-{rate} A/s")),
        format!("Breakaway over time at rest, {rate} A/s"),
        scale("time at rest", "s", true),
        scale("breakaway torque", "N*m", false),
        all,
    );
    plot.limits_of = Some("breakaway-torque".to_owned());
    plot
}

/// Magnitude of friction torque over displacement, with the model.
pub(super) fn presliding(found: &Presliding) -> Plot {
    let x: Vec<f64> = found.lines.iter().map(|l| l.frequency_hz).collect();
    let magnitude = found.lines.iter().map(|l| l.stiffness.norm()).collect();
    let model = found.lines.iter().map(|l| l.model.norm()).collect();
    let u = found.lines.iter().map(|l| 2.0 * l.u).collect();
    plot(
        "presliding-response".to_owned(),
        "Presliding: friction torque over displacement, magnitude".to_owned(),
        scale("frequency", "Hz", true),
        scale("dynamic stiffness", "N*m/rad", true),
        vec![
            series("measured lines", Style::Markers, x.clone(), magnitude, u),
            series("(σ0 + jω(σ1 + σ2))·Z/X", Style::Fit, x, model, Vec::new()),
        ],
    )
}

/// Margins at the poses and the computed curve over the travel.
pub(super) fn hold(poses: &[Pose], curve: Option<&Curve>, travel_rad: [f64; 2]) -> Plot {
    let x = poses.iter().map(|p| p.pose_rad.to_degrees()).collect();
    let y = poses.iter().map(|p| p.margin_nm).collect();
    let u = poses.iter().map(|p| 2.0 * p.u_nm).collect();
    let mut all = vec![series("measured", Style::Markers, x, y, u)];
    if let Some(curve) = curve {
        let angles = Curve::angles(travel_rad);
        let margins: Vec<CurveMargin> = angles.iter().map(|a| curve.margin(*a)).collect();
        let y: Vec<f64> = margins.iter().map(|m| m.margin_nm).collect();
        let u = margins.iter().map(|m| m.expanded_u_nm).collect();
        let x: Vec<f64> = angles.iter().map(|a| a.to_degrees()).collect();
        all.push(series("computed, 95 %", Style::Band, x.clone(), y.clone(), u));
        all.push(series("computed, worst over cogging", Style::Fit, x, y, Vec::new()));
    }
    let mut plot = plot(
        "hold-margin".to_owned(),
        "Static friction less unbalance and spring".to_owned(),
        scale("elevation", "deg", false),
        scale("hold margin", "N*m", false),
        all,
    );
    plot.limits_of = Some("hold-margin".to_owned());
    plot
}
