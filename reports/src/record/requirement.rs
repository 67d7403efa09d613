//! A requirement as it was judged.

use procedures::quantity::{Comparator, Limit, QuantityKind};
use procedures::requirement::{Judged, Requirement, Rule};
use serde::{Deserialize, Serialize};

/// Decision rule, by its name in requirement files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum DecisionRule {
    /// Simple acceptance, shared risk.
    #[serde(rename = "simple")]
    Simple,
    /// Guard band w = 1.65 u.
    #[serde(rename = "guarded-1.65u")]
    GuardedNinetyFive,
    /// Guard band w = U.
    #[serde(rename = "guarded-u")]
    GuardedU,
}

impl From<Rule> for DecisionRule {
    fn from(rule: Rule) -> Self {
        match rule {
            Rule::Simple => Self::Simple,
            Rule::GuardedNinetyFive => Self::GuardedNinetyFive,
            Rule::GuardedU => Self::GuardedU,
        }
    }
}

impl DecisionRule {
    /// Name as in requirement files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Simple => "simple",
            Self::GuardedNinetyFive => "guarded-1.65u",
            Self::GuardedU => "guarded-u",
        }
    }

    /// Short form for a table column.
    pub fn short(self) -> &'static str {
        match self {
            Self::Simple => "simple",
            Self::GuardedNinetyFive => "w\u{a0}=\u{a0}1.65\u{a0}u",
            Self::GuardedU => "w\u{a0}=\u{a0}U",
        }
    }

    /// What the rule means, for the statement of conformity. Sources: ILAC-G8:09/2019, ISO 14253-1:2017,
    /// JCGM 106:2012.
    pub fn statement(self) -> &'static str {
        match self {
            Self::Simple => {
                "simple acceptance (ILAC-G8:09/2019) without guard band; the risk is shared: the probability of \
                 false accept is up to 50 % for a result on the limit"
            }
            Self::GuardedNinetyFive => {
                "non-binary statement with guard band w\u{a0}=\u{a0}1.65\u{a0}u (ISO 14253-1:2017 default, 95 %); \
                 the probability of false accept is below 5 % for a result that passes"
            }
            Self::GuardedU => {
                "non-binary statement with guard band w\u{a0}=\u{a0}U (ILAC-G8:09/2019), \
                 U\u{a0}=\u{a0}k·u with k\u{a0}=\u{a0}t(0.97725,\u{a0}ν); the probability of false accept is below \
                 2.5 % for a result that passes"
            }
        }
    }
}

/// Comparator as data formats of test equipment write it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum ComparatorCode {
    /// Less than.
    Lt,
    /// Less or equal.
    Le,
    /// Greater than.
    Gt,
    /// Greater or equal.
    Ge,
    /// Inside both bounds, these included.
    Gele,
}

/// A limit as it was judged: canonical SI bounds and the text as a person wrote it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitFindings {
    /// How to compare.
    pub comparator: ComparatorCode,
    /// Lower bound, SI.
    pub low: Option<f64>,
    /// Upper bound, SI.
    pub high: Option<f64>,
    /// Kind of quantity of the bounds.
    pub kind: QuantityKind,
    /// SI unit of the bounds.
    pub unit: String,
    /// As a person wrote it.
    pub text: String,
}

impl From<&Limit> for LimitFindings {
    fn from(limit: &Limit) -> Self {
        let comparator = match limit.comparator {
            Comparator::Less => ComparatorCode::Lt,
            Comparator::AtMost => ComparatorCode::Le,
            Comparator::Greater => ComparatorCode::Gt,
            Comparator::AtLeast => ComparatorCode::Ge,
            Comparator::Within => ComparatorCode::Gele,
        };
        Self {
            comparator,
            low: limit.low,
            high: limit.high,
            kind: limit.kind,
            unit: limit.kind.si_unit().to_owned(),
            text: limit.text.clone(),
        }
    }
}

/// One measurand that a requirement judges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JudgedFindings {
    /// Name of the measurand.
    pub measurand: String,
    /// The limit; `None` for report-only.
    pub limit: Option<LimitFindings>,
    /// Limits that hold under conditions only (bands, masks), as text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub special: Vec<String>,
    /// A goal beside the limit.
    pub goal: Option<LimitFindings>,
    /// Decision rule.
    pub rule: DecisionRule,
}

/// A requirement as it was judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RequirementFindings {
    /// E.g. `FRC-AZ`.
    pub id: String,
    /// What it demands, one sentence.
    pub text: String,
    /// Where it comes from.
    pub source: String,
    /// `test`, `analysis`, `inspection` or `demonstration`.
    pub method: String,
    /// Measurands that it judges.
    pub measurands: Vec<String>,
    /// Axis that it belongs to; every axis if `None`.
    pub axis: Option<String>,
    /// Only measurements under these conditions are judged, as text, e.g. `velocity <= 10 deg/s`.
    pub conditions: Vec<String>,
    /// Axes and stretches of conditions over which it must have been measured, as text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<String>,
    /// What it judges: each measurand with its limit and rule; empty while no kind measures it.
    pub judges: Vec<JudgedFindings>,
    /// All limits as written.
    pub limit_text: String,
    /// Where the evidence lies, if it is declared and not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<String>,
    /// Whether the campaign must measure it.
    pub required: bool,
}

impl RequirementFindings {
    /// The requirement as a campaign judges it.
    pub fn new(requirement: &Requirement, required: bool) -> Self {
        Self {
            id: requirement.id.clone(),
            text: requirement.text.clone(),
            source: requirement.source.clone(),
            method: requirement.method.clone(),
            measurands: requirement.measurands().map(str::to_owned).collect(),
            axis: requirement.axis.clone(),
            conditions: requirement
                .conditions
                .iter()
                .map(|w| format!("{} {}", w.condition, w.meets.text()))
                .collect(),
            claims: requirement.claims(),
            judges: requirement.judges.iter().map(JudgedFindings::from).collect(),
            limit_text: requirement.limit_text.clone(),
            evidence: requirement.evidence.clone(),
            required,
        }
    }

    /// What it says about this measurand, if it judges it.
    pub fn judged(&self, measurand: &str) -> Option<&JudgedFindings> {
        self.judges.iter().find(|j| j.measurand == measurand)
    }
}

impl JudgedFindings {
    /// Whether anything is compared with a limit.
    pub fn is_limited(&self) -> bool {
        self.limit.is_some() || !self.special.is_empty()
    }
}

impl From<&Judged> for JudgedFindings {
    fn from(judged: &Judged) -> Self {
        Self {
            measurand: judged.measurand.clone(),
            limit: judged.limit.as_ref().map(LimitFindings::from),
            special: judged.special_texts(),
            goal: judged.goal.as_ref().map(LimitFindings::from),
            rule: judged.rule.into(),
        }
    }
}
