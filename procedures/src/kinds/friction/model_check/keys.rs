//! What a procedure says.

use super::point::Model;
use crate::kinds::ReadKeys;
use crate::kinds::friction::hysteresis::Strokes;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::default(
        "velocity",
        Shape::Quantity(Q::AngularVelocity),
        "15 deg/s",
        "Velocity of the strokes; choose one to which the model was not fitted.",
    ),
    Field::required("span", Shape::Range(Q::Angle), "Limits between which the axis runs."),
    Field::default("cycles", Shape::Integer, "2", "Strokes out and back."),
    Field::optional(
        "acceleration",
        Shape::Quantity(Q::AngularAcceleration),
        "Acceleration at the reversals; default: that of the axis.",
    ),
    Field::required("model", Shape::Table(MODEL), "Friction model with which the run is compared."),
];

/// Keys of the table `[model]`.
const MODEL: &[Field] = &[
    Field::required("coulomb", Shape::Quantity(Q::Torque), "Coulomb torque T_C."),
    Field::required("static", Shape::Quantity(Q::Torque), "Static torque T_S."),
    Field::required("stribeck-velocity", Shape::Quantity(Q::AngularVelocity), "Stribeck velocity ω_s."),
    Field::required(
        "stribeck-shape",
        Shape::Quantity(Q::Ratio),
        "Stribeck shape δ, an exponent: a plain number such as `1`.",
    ),
    Field::required("viscous", Shape::Quantity(Q::Damping), "Viscous coefficient σ2."),
    Field::default(
        "unbalance",
        Shape::Quantity(Q::Torque),
        "0 N*m",
        "Amplitude A_u of the unbalance moment.",
    ),
    Field::default(
        "spring",
        Shape::Quantity(Q::Stiffness),
        "0 N*m/rad",
        "Stiffness K_s of the cable spring.",
    ),
    Field::default("spring-rest", Shape::Quantity(Q::Angle), "0 deg", "Rest angle θ_0 of the spring."),
];

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) strokes: Strokes,
    pub(super) model: Model,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let velocity_rad_per_s = table.positive("velocity");
        let span_rad = table.range("span");
        let cycles = table.count("cycles", 1);
        let acceleration_rad_per_s2 =
            if table.has("acceleration") { Some(table.positive("acceleration")?) } else { None };
        let model = table.table("model", model);
        let strokes = Strokes {
            velocity_rad_per_s: velocity_rad_per_s?,
            span_rad: span_rad?,
            cycles: cycles?,
            acceleration_rad_per_s2,
        };
        Some(Self { strokes, model: model? })
    }
}

fn model(table: &mut TableReader<'_>) -> Option<Model> {
    let coulomb = table.quantity("coulomb");
    let most = table.quantity("static");
    let velocity = table.positive("stribeck-velocity");
    let shape = table.positive("stribeck-shape");
    let viscous = table.quantity("viscous");
    let unbalance = table.quantity("unbalance");
    let spring = table.quantity("spring");
    let rest = table.quantity("spring-rest");
    let mut refuse = |key: &'static str, wrong: bool, words: &str| {
        if wrong {
            table.mistake(key, words, None);
        }
    };
    refuse("coulomb", coulomb.is_some_and(|nm| nm < 0.0), "`coulomb` must not be below zero");
    refuse("viscous", viscous.is_some_and(|v| v < 0.0), "`viscous` must not be below zero");
    refuse("static", most < coulomb && most.is_some(), "`static` must not be below `coulomb`");
    Some(Model {
        coulomb_nm: coulomb?,
        static_nm: most?,
        stribeck_rad_per_s: velocity?,
        shape_ratio: shape?,
        viscous_nm_s_per_rad: viscous?,
        unbalance_nm: unbalance?,
        spring_nm_per_rad: spring?,
        rest_rad: rest?,
    })
}
