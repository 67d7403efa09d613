//! The requirements of the sample.

use procedures::quantity::QuantityKind;
use reports::record::{ComparatorCode, DecisionRule, JudgedFindings, LimitFindings, RequirementFindings};

fn limit(kind: QuantityKind, low: Option<f64>, high: Option<f64>, text: &str) -> LimitFindings {
    let comparator = match (low, high) {
        (Some(_), Some(_)) => ComparatorCode::Gele,
        (Some(_), None) => ComparatorCode::Ge,
        _ => ComparatorCode::Le,
    };
    LimitFindings { comparator, low, high, kind, unit: kind.si_unit().to_owned(), text: text.to_owned() }
}

fn demand(id: &str, text: &str, measurand: &str, limit: Option<LimitFindings>) -> RequirementFindings {
    RequirementFindings {
        evidence: None,
        id: id.to_owned(),
        text: text.to_owned(),
        source: "2.1.1, 3.1.1.1".to_owned(),
        method: "test".to_owned(),
        measurands: vec![measurand.to_owned()],
        axis: Some(if id.ends_with("AZ") { "az" } else { "el" }.to_owned()),
        conditions: Vec::new(),
        claims: Vec::new(),
        limit_text: limit.as_ref().map_or(String::new(), |l| l.text.clone()),
        judges: vec![JudgedFindings {
            special: Vec::new(),
            measurand: measurand.to_owned(),
            limit,
            goal: None,
            rule: DecisionRule::GuardedU,
        }],
        required: true,
    }
}

/// All of them.
pub(super) fn all() -> Vec<RequirementFindings> {
    let torque = |bound: f64| limit(QuantityKind::Torque, None, Some(bound), &format!("<= {bound} N*m"));
    let mut friction = demand(
        "FRC-AZ",
        "Friction torque at ≤ 10 °/s and breakaway torque, azimuth",
        "friction-torque",
        Some(torque(260.0)),
    );
    friction.conditions = vec!["velocity <= 10 deg/s".to_owned()];
    let mut unbalance =
        demand("UNB-EL", "Unbalance moment, elevation", "unbalance-torque", Some(torque(65.0)));
    unbalance.judges[0].goal = Some(torque(50.0));
    let order = limit(QuantityKind::SpatialOrder, Some(143.5), Some(144.5), "143.5 1/rev .. 144.5 1/rev");
    let mut hold = demand(
        "HOLD-EL",
        "The axis holds itself unpowered",
        "holding-margin",
        Some(limit(QuantityKind::Torque, Some(0.0), None, ">= 0 N*m")),
    );
    hold.judges[0].rule = DecisionRule::Simple;
    let mut pointing = demand("POS-ACC", "Positioning accuracy", "pointing-error", None);
    pointing.required = false;
    pointing.judges[0].limit = Some(limit(QuantityKind::Angle, None, Some(75e-6), "< 75 urad"));
    let mut mirror = demand("FSM-BW", "Closed-loop bandwidth of the mirror", "bandwidth", None);
    mirror.required = false;
    vec![
        friction,
        demand("FRC-EL", "Breakaway torque, elevation", "breakaway-torque", Some(torque(130.0))),
        unbalance,
        demand("SPR-AZ", "Spring torque of cables, azimuth", "spring-torque", Some(torque(5.0))),
        demand("SPR-EL", "Spring torque of cables and hoses, elevation", "spring-torque", Some(torque(65.0))),
        demand("COG-AZ", "Cogging order, azimuth", "cogging-order", Some(order)),
        hold,
        pointing,
        mirror,
    ]
}
