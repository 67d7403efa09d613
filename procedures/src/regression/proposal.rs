//! A criteria file proposed from a baseline: margins from its distance to the limits.

use super::criteria::kind_of;
use super::measurands::{limits_of, scale_of, worse_of};
use super::{ArmRecord, Scale, Worse};
use crate::quantity::QuantityKind;
use crate::requirement::{Judged, Requirement, Requirements};

/// Share of the distance to the limit that a change may use up.
const SHARE: f64 = 0.1;
/// Least margin in standard uncertainties of a value: below it a shift is not seen.
const LEAST_U: f64 = 0.5;

/// What a baseline measured for one criterion.
#[derive(Clone, Debug, PartialEq)]
pub struct Baseline {
    /// Id of the requirement.
    pub requirement: String,
    /// Measurand.
    pub measurand: String,
    /// Values, one a unit, SI.
    pub values: Vec<f64>,
    /// Standard uncertainty of a single value, SI.
    pub u: f64,
}

impl Baseline {
    /// What an arm measured, for each requirement and measurand in the order of its findings: values of all places, and their largest
    /// uncertainty.
    pub fn of_record(record: &ArmRecord) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for found in record.replicates.iter().flat_map(|replicate| &replicate.values) {
            let is_same =
                |own: &Self| own.requirement == found.requirement && own.measurand == found.measurand;
            let place = all.iter().position(is_same).unwrap_or_else(|| {
                all.push(Self {
                    requirement: found.requirement.clone(),
                    measurand: found.measurand.clone(),
                    values: Vec::new(),
                    u: 0.0,
                });
                all.len() - 1
            });
            all[place].values.extend(found.value);
            all[place].u = all[place].u.max(found.u);
        }
        all
    }
}

/// Text of a criteria file with a margin for each baseline: 10 % of the distance of its mean to the nearest limit, at least half of the
/// standard uncertainty of a value, rounded up to two digits. A log-ratio takes both relative to the mean. Where no margin
/// follows from that, the criterion stands as a comment with the reason.
pub fn propose(requirements: &Requirements, baselines: &[Baseline]) -> String {
    let mut text = "# Proposed from a baseline: 10 % of its distance to the limit, at least half of the standard uncertainty of a\n\
                    # value. Adjust the margins to what a change may cost.\nschema = 1\n"
        .to_owned();
    for baseline in baselines {
        text += "\n";
        text += &match criterion(requirements, baseline) {
            Ok(criterion) => criterion,
            Err(reason) => format!("# {} ({}): {reason}\n", baseline.requirement, baseline.measurand),
        };
    }
    text
}

/// Why no margin is proposed.
#[derive(Debug, thiserror::Error)]
enum NoProposal {
    #[error("the requirements file has no such requirement with this measurand")]
    Unknown,
    #[error("the baseline has no values")]
    NoValues,
    #[error("no limit says which way it becomes worse; write `worse` and a margin")]
    NoLimit,
    #[error("the baseline lies on its limit and has no uncertainty; write a margin")]
    NoDistance,
}

fn criterion(requirements: &Requirements, baseline: &Baseline) -> Result<String, NoProposal> {
    let requirement = requirements.get(&baseline.requirement).ok_or(NoProposal::Unknown)?;
    let judged = requirement.judged(&baseline.measurand).ok_or(NoProposal::Unknown)?;
    let kind = kind_of(judged).ok_or(NoProposal::Unknown)?;
    let n = baseline.values.len() as f64;
    let mean = baseline.values.iter().sum::<f64>() / n;
    if !mean.is_finite() {
        return Err(NoProposal::NoValues);
    }
    let nearest = nearest(judged, mean).ok_or(NoProposal::NoLimit)?;
    let usual = scale_of(&judged.measurand);
    let has_logarithm = nearest.bound > 0.0 && baseline.values.iter().all(|value| *value > 0.0);
    let scale = if has_logarithm { usual } else { Scale::Difference };
    let margin = match scale {
        Scale::Difference => (SHARE * (nearest.bound - mean).abs()).max(LEAST_U * baseline.u),
        Scale::LogRatio => {
            (SHARE * (nearest.bound / mean).ln().abs()).max(LEAST_U * baseline.u / mean).exp_m1()
        }
    };
    let margin_kind = match scale {
        Scale::Difference => kind,
        Scale::LogRatio => QuantityKind::Ratio,
    };
    let margin = rounded_up(margin_kind, margin).ok_or(NoProposal::NoDistance)?;
    Ok(written(requirement, judged, nearest, &Proposed { mean: shown(kind, mean), margin, scale, usual }))
}

/// What is proposed, as text.
struct Proposed {
    mean: String,
    margin: String,
    scale: Scale,
    usual: Scale,
}

/// The bound that a baseline is nearest to.
#[derive(Clone, Copy)]
struct Nearest<'r> {
    bound: f64,
    /// Which way a value comes nearer to it.
    worse: Worse,
    /// The limit as written.
    limit: &'r str,
}

fn nearest(judged: &Judged, mean: f64) -> Option<Nearest<'_>> {
    let bounds = limits_of(judged).flat_map(|limit| {
        let low = limit.low.map(|bound| Nearest { bound, worse: Worse::Lower, limit: &limit.text });
        let high = limit.high.map(|bound| Nearest { bound, worse: Worse::Higher, limit: &limit.text });
        low.into_iter().chain(high)
    });
    bounds.min_by(|a, b| (a.bound - mean).abs().total_cmp(&(b.bound - mean).abs()))
}

fn written(requirement: &Requirement, judged: &Judged, nearest: Nearest<'_>, proposed: &Proposed) -> String {
    let quoted = |text: &str| toml::Value::from(text).to_string();
    let mut text = format!("# baseline {}, limit {}\n[[criterion]]\n", proposed.mean, nearest.limit);
    text += &format!("requirement = {}\n", quoted(&requirement.id));
    if requirement.judges.len() > 1 {
        text += &format!("measurand = {}\n", quoted(&judged.measurand));
    }
    text += &format!("margin = {}\n", quoted(&proposed.margin));
    if proposed.scale != proposed.usual {
        text += &format!("scale = {}\n", quoted(proposed.scale.name()));
    }
    if worse_of(judged).is_none() {
        text += &format!("worse = {}\n", quoted(nearest.worse.name()));
    }
    text
}

/// A quantity as text with two digits, not smaller than `si`; `None` for one that is not above zero.
fn rounded_up(kind: QuantityKind, si: f64) -> Option<String> {
    let number = if is_small_angle(kind, si) { si / MICRORADIAN } else { kind.to_display(si) };
    if !(number.is_finite() && number > 0.0) {
        return None;
    }
    let step = 10.0_f64.powi(number.log10().floor() as i32 - 1);
    // A number of two digits is kept in spite of its rounding.
    let rounded = (number / step - 1e-9).ceil() * step;
    Some(shown(kind, si * (rounded / number)))
}

const MICRORADIAN: f64 = 1e-6;

/// A quantity as people write it: small angles in microradians.
fn shown(kind: QuantityKind, si: f64) -> String {
    if is_small_angle(kind, si) {
        format!("{} urad", QuantityKind::Count.format(si / MICRORADIAN))
    } else {
        kind.format(si)
    }
}

fn is_small_angle(kind: QuantityKind, si: f64) -> bool {
    const SMALL_RAD: f64 = 1e-3;
    kind == QuantityKind::Angle && si.abs() < SMALL_RAD
}

#[cfg(test)]
mod tests {
    use super::super::Criteria;
    use super::*;
    use crate::diagnostic::SourceFile;

    fn requirements() -> Requirements {
        let text = include_str!("../../requirements.toml");
        Requirements::parse(&SourceFile::new("requirements.toml", text)).expect("the shipped requirements")
    }

    fn baseline(requirement: &str, measurand: &str, values: &[f64], u: f64) -> Baseline {
        Baseline {
            requirement: requirement.to_owned(),
            measurand: measurand.to_owned(),
            values: values.to_vec(),
            u,
        }
    }

    fn margins(text: &str) -> Vec<f64> {
        let read = Criteria::parse(&SourceFile::new("regress.toml", text), &requirements());
        let read = read.unwrap_or_else(|mistakes| panic!("{text}\n{}", mistakes[0]));
        read.all.iter().map(|criterion| criterion.margin).collect()
    }

    #[test]
    fn a_proposal_is_a_criteria_file_with_a_tenth_of_each_distance() {
        let text = propose(
            &requirements(),
            &[
                baseline("VEL-BW", "velocity-bandwidth", &[4.4, 4.6], 0.01),
                baseline("VEL-PM", "velocity-phase-margin", &[0.95], 0.001),
                baseline("TRK-RMS-C", "coarse-track-rms", &[50e-6, 50e-6], 1e-6),
                baseline("GYR-SCALE", "gyro-scale-error", &[-200e-6], 1e-6),
                baseline("MOT-CUE", "cue-overshoot-excess", &[-2e-6], 1e-6),
            ],
        );
        insta::assert_snapshot!(text);
        let found = margins(&text);
        assert!((found[0] - 0.1).abs() < 1e-12, "a tenth of 4.5 Hz less 3.5 Hz: {found:?}");
        let distance_rad = 0.95 - 45.0_f64.to_radians();
        assert!(found[1] >= 0.1 * distance_rad && found[1] < 0.111 * distance_rad, "{found:?}");
        let least = 0.1 * 2.0_f64.ln();
        assert!(found[2] >= least && found[2] < 1.1 * least, "a tenth of the logarithm of two: {found:?}");
    }

    #[test]
    fn a_margin_is_at_least_half_of_the_standard_uncertainty() {
        let near = baseline("VEL-BW", "velocity-bandwidth", &[3.51], 0.3);
        assert!((margins(&propose(&requirements(), &[near]))[0] - 0.15).abs() < 1e-12);
        let near = baseline("TRK-RMS-C", "coarse-track-rms", &[99e-6], 9.9e-6);
        let found = margins(&propose(&requirements(), &[near]))[0];
        assert!((0.05..0.055).contains(&found), "half of a tenth: {found}");
    }

    #[test]
    fn without_a_limit_a_distance_or_values_the_file_says_why_there_is_no_margin() {
        let text = propose(
            &requirements(),
            &[
                baseline("VEL-BW", "velocity-bandwidth", &[3.5], 0.0),
                baseline("TRK-RMS-F", "fine-track-rms", &[5e-6], 1e-7),
                baseline("VEL-BW", "velocity-bandwidth", &[], 0.1),
                baseline("VEL-XX", "velocity-bandwidth", &[4.0], 0.1),
            ],
        );
        insta::assert_snapshot!(text);
    }
}
