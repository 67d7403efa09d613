//! DC link: voltage by the drives, currents by clamps.

use analysis::estimate::Estimate;
use analysis::load_cycle::{extremes, rms};

use super::measure::{Found, Point, known};
use super::pictures;
use super::record::Course;
use super::{BUS_HIGH, BUS_LOW, SHUNT, SUPPLY_PEAK, SUPPLY_RMS};

const SUPPLY: &str = "/supply";
const VOLTAGE: &str = "bus_v";

/// Everything about supply, shunt and voltage. They belong to no axis; the point's own stands for them.
pub(super) fn measure(point: &Point<'_>) -> Found {
    let axis = &point.case.axis;
    let drive = Course::of(point.window, &format!("/{axis}"));
    let volts = drive.as_ref().map_err(Clone::clone).and_then(|drive| drive.column(VOLTAGE));
    let span = volts.clone().and_then(|volts| extremes(volts).ok_or_else(|| "no samples".to_owned()));
    let count = volts.as_ref().map_or(0, |volts| volts.len());
    let of_bus = |end: usize| {
        let channels = [format!("/{axis} {VOLTAGE}")];
        let found = span.clone().map(|span| known(span[end], point.keys.voltage_u_v, count));
        (found, channels)
    };
    let mut all = Found::default();
    for (name, end) in [(BUS_LOW, 0), (BUS_HIGH, 1)] {
        let (found, channels) = of_bus(end);
        all.measurements.push(point.measurement(name, axis, found, &channels));
    }
    let clamps = Clamps::of(point, drive.as_ref().ok());
    let channel = |name: &str| [format!("{SUPPLY} {name}")];
    let (root, peak, power) = match &clamps {
        Ok(clamps) => (clamps.rms(point), clamps.peak(point), clamps.shunt_power(point, volts)),
        Err(reason) => (Err(reason.clone()), Err(reason.clone()), Err(reason.clone())),
    };
    all.measurements.push(point.measurement(SUPPLY_RMS, axis, point.whole(root), &channel("supply_a")));
    all.measurements.push(point.measurement(SUPPLY_PEAK, axis, peak, &channel("supply_a")));
    all.measurements.push(point.measurement(SHUNT, axis, power, &channel("shunt_a")));
    if let (Ok(drive), Ok(volts)) =
        (&drive, drive.as_ref().map_err(Clone::clone).and_then(|d| d.column(VOLTAGE)))
    {
        all.plots.extend(pictures::dc_link(
            point,
            (drive.time_s, volts),
            clamps.ok().map(|c| (c.course.time_s, c.supply_a)),
        ));
    }
    all
}

/// Currents in the leads.
struct Clamps<'a> {
    course: Course<'a>,
    supply_a: &'a [f64],
    shunt_a: &'a [f64],
    drive_time_s: &'a [f64],
}

impl<'a> Clamps<'a> {
    fn of(point: &'a Point<'_>, drive: Option<&Course<'a>>) -> Result<Self, String> {
        let course = Course::of(point.window, SUPPLY)
            .map_err(|reason| format!("{reason}: the rig has no current clamps on the DC link"))?;
        let supply_a = course.column("supply_a")?;
        let shunt_a = course.column("shunt_a")?;
        Ok(Self { course, supply_a, shunt_a, drive_time_s: drive.map_or(&[], |drive| drive.time_s) })
    }

    fn rms(&self, point: &Point<'_>) -> Result<Estimate, String> {
        let cycles = self.course.between(&point.bounds_s);
        let load = rms(self.supply_a, &cycles, point.keys.current_u_ratio);
        let load = load.ok_or_else(|| "no whole cycle".to_owned())?;
        Ok(Estimate { value: load.value, u: load.u, dof: load.dof, n: load.n })
    }

    fn peak(&self, point: &Point<'_>) -> Result<Estimate, String> {
        let [_, high] = extremes(self.supply_a).ok_or_else(|| "no samples".to_owned())?;
        Ok(known(high, point.keys.current_u_ratio * high.abs(), self.supply_a.len()))
    }

    /// Largest product of the clamp's current and the voltage at that instant.
    fn shunt_power(&self, point: &Point<'_>, volts: Result<&[f64], String>) -> Result<Estimate, String> {
        let volts = volts?;
        let row = |t_s: f64| {
            let next = self.drive_time_s.partition_point(|&t| t < t_s).min(volts.len() - 1);
            volts[next]
        };
        let power = self
            .course
            .time_s
            .iter()
            .zip(self.shunt_a)
            .map(|(&t_s, &current_a)| (current_a * row(t_s), row(t_s)));
        let most = power.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|_| !volts.is_empty());
        let (value, volts_there) = most.ok_or_else(|| "no samples".to_owned())?;
        let u_ratio = point.keys.current_u_ratio.hypot(point.keys.voltage_u_v / volts_there.abs().max(1.0));
        Ok(known(value, u_ratio * value.abs(), self.shunt_a.len()))
    }
}
