//! A kind for tests: moves by `span` at each velocity and "measures" what the window's first row says.

use std::collections::BTreeMap;

use analysis::estimate::Estimate;

use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, Condition, Measurement, PointResult, Reduced};
use crate::quantity::QuantityKind;
use crate::stimulus::{ProfileLimits, Stimulus};
use crate::table::{Field, Shape, TableReader};

/// Registry of the tests.
pub(crate) const SAMPLE_KINDS: &[Kind] =
    &[Kind { name: "sample", doc: "A kind for tests.", fields: FIELDS, measurands: SAMPLE_MEASURANDS, read }];

/// What a point is reduced to.
pub(crate) struct Mean {
    pub(crate) nm: f64,
}

#[derive(Debug)]
struct SampleExperiment {
    velocities_rad_per_s: Vec<f64>,
    span_rad: [f64; 2],
    yields_cogging: bool,
}

pub(crate) const SAMPLE_MEASURANDS: &[Measurand] = &[
    Measurand { name: "friction-torque", kind: QuantityKind::Torque, doc: "Friction." },
    Measurand { name: "cogging-order", kind: QuantityKind::SpatialOrder, doc: "Order." },
    Measurand { name: "cogging-amplitude", kind: QuantityKind::Torque, doc: "Amplitude." },
];

const SWEEP: &[Field] = &[
    Field::required("velocity", Shape::Quantities(QuantityKind::AngularVelocity), "Velocities."),
    Field::default("span", Shape::Range(QuantityKind::Angle), "-60 deg .. 60 deg", "Ends."),
];

const FIELDS: &[Field] = &[
    Field::required("sweep", Shape::Table(SWEEP), "What is swept."),
    Field::default("cogging", Shape::Boolean, "false", "Whether it yields cogging."),
];

fn read(table: &mut TableReader<'_>) -> Option<Box<dyn Experiment>> {
    let yields_cogging = table.boolean("cogging");
    let sweep = table.table("sweep", |sweep| {
        let velocities = sweep.quantities("velocity");
        let span = sweep.range("span");
        Some((velocities?, span?))
    });
    let (velocities_rad_per_s, span_rad) = sweep?;
    Some(Box::new(SampleExperiment { velocities_rad_per_s, span_rad, yields_cogging: yields_cogging? }))
}

impl Experiment for SampleExperiment {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let cogging: &[&str] =
            if self.yields_cogging { &["cogging-order", "cogging-amplitude"] } else { &[] };
        Some(["friction-torque"].into_iter().chain(cogging.iter().copied()).collect())
    }

    fn plan(&self, axis: &str, _axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        Ok(self
            .velocities_rad_per_s
            .iter()
            .map(|&velocity| sample_case(axis, velocity, self.span_rad))
            .collect())
    }

    fn analyse(&self, case: &Case, _window: &Window, _axes: &Axes) -> PointResult {
        let estimate = Estimate { value: 200.0, u: 1.0, dof: 9.0, n: 10 };
        let mut friction =
            Measurement::new("friction-torque", &case.axis, QuantityKind::Torque, Some(estimate), "sample/1");
        let requested = case.requested("velocity").expect("every case has a velocity");
        let kind = QuantityKind::AngularVelocity;
        friction.conditions =
            vec![Condition { name: "velocity".into(), requested, achieved: Some(0.96 * requested), kind }];
        PointResult {
            point: case.point.clone(),
            measurements: vec![friction],
            reduced: Reduced::to(Mean { nm: 200.0 }),
            ..PointResult::default()
        }
    }

    fn conclude(&self, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
        let measurements = points.iter().flat_map(|p| p.measurements.clone()).collect();
        Conclusion { measurements, ..Conclusion::default() }
    }
}

pub(crate) fn sample_case(axis: &str, velocity_rad_per_s: f64, [from_rad, to_rad]: [f64; 2]) -> Case {
    let kind = QuantityKind::AngularVelocity;
    let limits = ProfileLimits { velocity_rad_per_s, acceleration_rad_per_s2: 1.0, jerk_rad_per_s3: 10.0 };
    Case {
        point: format!("velocity={}", kind.format(velocity_rad_per_s)),
        axis: axis.to_owned(),
        requested: vec![Request { name: "velocity".into(), value: velocity_rad_per_s, kind }],
        start_pose_rad: BTreeMap::from([(axis.to_owned(), from_rad)]),
        segments: vec![Segment {
            label: "stroke".into(),
            mode: Mode::Position,
            stimulus: Stimulus::Reversals { from_rad, to_rad, limits, cycles: 1 },
            until: None,
            at_most_s: 60.0,
            then: Then::Stop,
            dithered: false,
            ..Segment::default()
        }],
        ..Case::default()
    }
}

/// A rig with one azimuth axis (director.md §1, §2, §8).
pub(crate) fn sample_axes() -> Axes {
    let limits = AxisLimits {
        travel_rad: [-160f64.to_radians(), 160f64.to_radians()],
        soft_limits_rad: [-159f64.to_radians(), 159f64.to_radians()],
        max_velocity_rad_per_s: 60f64.to_radians(),
        max_acceleration_rad_per_s2: 90f64.to_radians(),
        max_jerk_rad_per_s3: 900f64.to_radians(),
        max_torque_nm: 2556.0,
        torque_constant_nm_per_a: Some(60.0),
        torque_constant_u_ratio: 0.005,
        measured_constant: None,
        inertia_kg_m2: 1200.0,
        inertia_u_ratio: 0.0,
        torque_quantum_nm: 0.12,
        encoder_quantum_rad: 0.0936e-6,
        expected_static_friction_nm: 210.0,
        expected_presliding_stiffness_nm_per_rad: 0.0,
        polarity_torque_nm: 0.0,
        zero_tolerance_rad: 0.0,
        loop_rate_hz: 0.0,
        log_rate_hz: 0.0,
        cogging_orders_per_rev: 144.0,
        reference: None,
    };
    Axes::stacked([("az".to_owned(), limits)])
}
