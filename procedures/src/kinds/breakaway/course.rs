//! A ramp as the estimators see it: displacement and effort in its own direction, load taken off.

use analysis::breakaway::{Peak, peak};
use analysis::presliding::RampFit;

use super::plan::{RAMP, sign};
use super::record::Numbers;

/// Displacement, in z_ss, that still counts as rest: over it the contact renews itself by 5 %.
const REST_FACTOR: f64 = 0.05;

/// One ramp from rest, in its own direction.
#[derive(Clone, Debug)]
pub(super) struct Course {
    /// +1 or −1.
    pub(super) direction: f64,
    /// Time of each block on the log's axis, s.
    pub(super) time_s: Vec<f64>,
    /// Displacement from the start of the ramp, in its direction, rad.
    pub(super) x_rad: Vec<f64>,
    /// F̂ in its direction less load, N·m.
    pub(super) effort_nm: Vec<f64>,
    /// Angle at the start of the ramp, rad.
    pub(super) start_rad: f64,
    /// Start and end of the ramp on the log's axis, s.
    pub(super) span_s: [f64; 2],
    /// Rate of the motor torque in the ramp's direction, N·m/s.
    pub(super) rate_nm_per_s: Option<f64>,
    /// Time from row to row, s.
    pub(super) sample_s: f64,
    /// Time and position of the rest before.
    rest: (Vec<f64>, Vec<f64>),
}

/// Numbers of this name; empty if there are none.
pub(super) fn values<'a>(numbers: &'a Numbers, name: &str) -> &'a [f64] {
    numbers.get(name).map_or(&[], Vec::as_slice)
}

/// The first number of this name.
pub(super) fn first(numbers: &Numbers, name: &str) -> Result<f64, String> {
    values(numbers, name).first().copied().ok_or_else(|| format!("the point has no `{name}`"))
}

/// Start and end kept under this name.
pub(super) fn span(numbers: &Numbers, name: &str) -> Result<[f64; 2], String> {
    match values(numbers, name) {
        [from, to] => Ok([*from, *to]),
        _ => Err(format!("the point has no `{name}`")),
    }
}

impl Course {
    /// The ramp of a direction out of a point's numbers; `load` gives the load torque at an angle.
    ///
    /// # Errors
    /// Why it is no breakaway: slid during the dwell, never moved, moved the wrong way.
    pub(super) fn of_ramp(
        numbers: &Numbers,
        direction: f64,
        load: impl Fn(f64) -> f64,
    ) -> Result<Self, String> {
        let name = |part: &str| format!("{RAMP}{}.{part}", sign(direction));
        let [slid, moved] = span(numbers, &name("ended"))?;
        if slid > 0.0 {
            return Err("the axis slid off during the dwell: it does not hold there".to_owned());
        }
        let parts = ["time", "position", "effort"].map(|part| values(numbers, &name(part)));
        let span_s = span(numbers, &name("span"))?;
        let mut course = Self::new(parts, first(numbers, &name("start"))?, direction, span_s, load);
        let reached = course.x_rad.last().copied().unwrap_or(0.0);
        if moved <= 0.0 {
            let most = course.effort_nm.iter().copied().fold(0.0, f64::max);
            return Err(format!(
                "no breakaway within {:.1} s: {:.3} mrad moved, {most:.1} N·m reached",
                span_s[1] - span_s[0],
                1e3 * reached
            ));
        }
        if reached < 0.0 {
            return Err(format!(
                "the axis moved against the ramp, by {:.3} mrad: it does not hold there",
                -1e3 * reached
            ));
        }
        course.sample_s = first(numbers, &name("sample")).unwrap_or(0.0);
        course.rate_nm_per_s = first(numbers, &name("rate")).ok().map(|rate| direction * rate);
        course.rest =
            (values(numbers, &name("rest-time")).to_vec(), values(numbers, &name("rest-position")).to_vec());
        Ok(course)
    }

    /// The slide of a release, in the direction in which the axis went.
    ///
    /// # Errors
    /// When the point holds none.
    pub(super) fn of_slide(numbers: &Numbers) -> Result<Self, String> {
        let parts = ["time", "position", "effort"].map(|part| values(numbers, &format!("release.{part}")));
        let start_rad = first(numbers, "release.start")?;
        let end_rad = parts[1].last().copied().unwrap_or(start_rad);
        let direction = (end_rad - start_rad).signum();
        Ok(Self::new(parts, start_rad, direction, span(numbers, "release.span")?, |_| 0.0))
    }

    fn new(
        [time, position, effort]: [&[f64]; 3],
        start_rad: f64,
        direction: f64,
        span_s: [f64; 2],
        load: impl Fn(f64) -> f64,
    ) -> Self {
        Self {
            direction,
            time_s: time.to_vec(),
            x_rad: position.iter().map(|p| direction * (p - start_rad)).collect(),
            effort_nm: position.iter().zip(effort).map(|(p, f)| direction * (f - load(*p))).collect(),
            start_rad,
            span_s,
            rate_nm_per_s: None,
            sample_s: 0.0,
            rest: (Vec::new(), Vec::new()),
        }
    }

    /// The exponential of its start.
    pub(super) fn fit(&self) -> Option<RampFit> {
        RampFit::new(&self.time_s, &self.x_rad, &self.effort_nm)
    }

    /// Its breakaway torque.
    pub(super) fn peak(&self, z_ss_rad: f64) -> Result<Peak, String> {
        peak(&self.x_rad, &self.effort_nm, z_ss_rad).map_err(|e| e.to_string())
    }

    /// Time at rest from the last motion before the ramp to the onset of breakaway, s.
    pub(super) fn rest_s(&self, z_ss_rad: f64, peak: &Peak) -> f64 {
        let (time, position) = &self.rest;
        let away = |p: &f64| (p - self.start_rad).abs() > REST_FACTOR * z_ss_rad;
        let since = match position.iter().rposition(away) {
            Some(last) => time[last],
            None => time.first().copied().unwrap_or(self.span_s[0]),
        };
        self.time_s[peak.onset] - since
    }
}
