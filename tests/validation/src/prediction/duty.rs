//! Duty cycle: currents, heat, DC link.

use controllers::profile::{MotionLimits, ProfileGenerator};
use sim_devices::physics::supply::{Supply, drive_w};

use super::drivetrain::{Drivetrain, POSES_DEG, REQUIRED_RAD_PER_S};
use super::{Expected, Subject, rig_limits, row};

const STEP_S: f64 = 0.5e-3;
const DEG: f64 = std::f64::consts::PI / 180.0;
/// Rate of the rail target, tracked between the slews.
const TRACKED_RAD_PER_S: f64 = 0.674 * DEG;
const TRACKED_S: f64 = 6.0;
/// Slews of MOT-DUTY, from and to.
const SLEWS_RAD: [[f64; 2]; 2] = [[-90.0 * DEG, 90.0 * DEG], [-5.0 * DEG, 85.0 * DEG]];
/// Both axes starting and stopping together: the most that is fed back at once.
const TOGETHER_RAD: [[f64; 2]; 2] = [[-45.0 * DEG, 45.0 * DEG], [-5.0 * DEG, 85.0 * DEG]];
/// RMS limits of MOT-CUR: continuous torque.
const CONTINUOUS_A: [f64; 2] = [14.2, 16.8];

/// Current of the drive against a current probe.
const CURRENT_U: f64 = 0.01;
/// Sensor of the heat sink.
const HEAT_SINK_U_DEGC: f64 = 2.0;
/// Voltage of the DC link as the drives report it.
const VOLTAGE_U_V: f64 = 2.0;
/// Supply current and shunt power.
const POWER_U: f64 = 0.01;
/// A sample of the log and what the current's own noise moves.
const TIME_U_S: f64 = 0.01;

/// Torque, rate and current of an axis, sampled.
struct Trace {
    torque_nm: Vec<f64>,
    rate_rad_per_s: Vec<f64>,
    current_a: Vec<f64>,
}

impl Trace {
    fn rms_a(&self) -> f64 {
        (self.current_a.iter().map(|i| i * i).sum::<f64>() / self.current_a.len() as f64).sqrt()
    }

    fn peak_a(&self) -> f64 {
        self.current_a.iter().fold(0.0, |most: f64, i| most.max(i.abs()))
    }

    fn longest_above_s(&self, limit_a: f64) -> f64 {
        let mut longest = 0_u32;
        let mut now = 0_u32;
        for current in &self.current_a {
            now = if current.abs() > limit_a { now + 1 } else { 0 };
            longest = longest.max(now);
        }
        f64::from(longest) * STEP_S
    }
}

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    let mut rows = Vec::new();
    let duty = [0, 1].map(|axis| {
        let worst = POSES_DEG.map(|pose| cycle(&Drivetrain::new(subject, axis, pose), SLEWS_RAD[axis]));
        let [a, b] = worst;
        if a.rms_a() >= b.rms_a() { a } else { b }
    });
    for (axis, trace) in duty.iter().enumerate() {
        let rms_a = trace.rms_a();
        let peak_a = trace.peak_a();
        let requirement = ["MOT-CUR-AZ", "MOT-CUR-EL"][axis];
        let names = [["rms-current-az", "peak-current-az"], ["rms-current-el", "peak-current-el"]][axis];
        for id in [requirement, "MOT-DUTY"] {
            rows.push(row(id, axis, names[0], "duty cycle", rms_a, CURRENT_U * rms_a));
            rows.push(row(id, axis, names[1], "duty cycle", peak_a, CURRENT_U * peak_a));
        }
        let above_s = trace.longest_above_s(CONTINUOUS_A[axis]);
        rows.push(row("PWR-BUS", axis, "time-above-continuous", "duty cycle", above_s, TIME_U_S));
        let settings = subject.axis(axis);
        let loss_w = settings.loss_power_w * (rms_a / settings.loss_current_a).powi(2);
        let rise_degc = settings.heat_sink_rise_degc / settings.heat_sink_power_w * loss_w;
        // Hotter than this the drive has switched off.
        let end_degc = (settings.ambient_degc + rise_degc).min(settings.heat_sink_shutdown_degc);
        rows.push(row("THM-SINK", axis, "heat-sink", "duty cycle without end", end_degc, HEAT_SINK_U_DEGC));
    }
    rows.extend(dc_link(subject, &duty, "duty cycle"));
    let together =
        [0, 1].map(|axis| cycle(&Drivetrain::new(subject, axis, POSES_DEG[0]), TOGETHER_RAD[axis]));
    rows.extend(dc_link(subject, &together, "both axes stop together"));
    rows
}

/// Slew, track, slew home, track.
fn cycle(train: &Drivetrain<'_>, [from, to]: [f64; 2]) -> Trace {
    let limits = MotionLimits {
        velocity_rad_per_s: REQUIRED_RAD_PER_S,
        acceleration_rad_per_s2: rig_limits::ACCELERATION_RAD_PER_S2,
        jerk_rad_per_s3: rig_limits::JERK_RAD_PER_S3,
    };
    let mut trace = Trace { torque_nm: vec![], rate_rad_per_s: vec![], current_a: vec![] };
    for [start, end] in [[from, to], [to, from]] {
        // The limits are constants above 0.
        let Some(mut profile) = ProfileGenerator::new(limits, start) else { return trace };
        profile.move_to(end);
        while !profile.is_at_rest() {
            let at = profile.advance(STEP_S);
            trace.push(train, at.position_rad, at.velocity_rad_per_s, at.acceleration_rad_per_s2);
        }
        for _ in 0..(TRACKED_S / STEP_S) as u32 {
            trace.push(train, end, TRACKED_RAD_PER_S, 0.0);
        }
    }
    trace
}

impl Trace {
    fn push(&mut self, train: &Drivetrain<'_>, angle: f64, rate: f64, acceleration: f64) {
        let most = train.torque_nm();
        let asked = train.inertia_kg_m2 * acceleration + train.friction_nm(rate) - train.load_nm(angle);
        let torque = asked.clamp(-most, most);
        self.torque_nm.push(torque);
        self.rate_rad_per_s.push(rate);
        self.current_a.push(torque / train.axis.torque_constant_nm_per_a);
    }
}

/// What supply and shunt see of two traces at once.
fn dc_link(subject: &Subject<'_>, traces: &[Trace; 2], condition: &str) -> Vec<Expected> {
    let mut supply = Supply::new(&subject.unit.supply, STEP_S);
    let steps = traces[0].current_a.len().max(traces[1].current_a.len());
    let (mut low_v, mut high_v): (f64, f64) = (f64::INFINITY, 0.0);
    let (mut square_a2, mut peak_a, mut shunt_w): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for k in 0..steps {
        let power = |axis: usize| {
            let trace = &traces[axis];
            let loss_ohm = subject.axis(axis).loss_resistance_ohm();
            let at = |values: &[f64]| values.get(k).copied().unwrap_or(0.0);
            drive_w(loss_ohm, at(&trace.torque_nm), at(&trace.rate_rad_per_s), at(&trace.current_a))
        };
        let total_w = power(0) + power(1);
        let bus_v = supply.step(total_w);
        (low_v, high_v) = (low_v.min(bus_v), high_v.max(bus_v));
        square_a2 += supply.supply_a().powi(2);
        peak_a = peak_a.max(supply.supply_a());
        shunt_w = shunt_w.max(supply.shunt_w());
    }
    let rms_a = (square_a2 / steps as f64).sqrt();
    let of = |quantity, value, u| row("PWR-BUS", None, quantity, condition, value, u);
    vec![
        of("bus-low", low_v, VOLTAGE_U_V),
        of("bus-high", high_v, VOLTAGE_U_V),
        of("supply-rms", rms_a, POWER_U * rms_a),
        of("supply-peak", peak_a, POWER_U * peak_a),
        of("shunt-power", shunt_w, POWER_U * shunt_w),
    ]
}
