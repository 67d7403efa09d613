//! Scalar settings: those that explain all findings best, the base being weak prior knowledge.

use procedures::identification::{Estimated, Observation, Posterior, Prior};
use sim_devices::unit::{FieldOfPart, PARAMETERS, Setting, UnitSettings};

use super::relations::Relation;
use super::shown::Shown;
use super::{CONTRADICTS_U, Finding, Identified, IdentifiedSetting, Setup, Standing, Value};

mod spread;

pub(super) use spread::{IN_STEPS, with_rounding};

/// A setting is measured if the findings leave at most this share of the uncertainty that it had before.
pub(super) const MEASURED_RATIO: f64 = 0.5;
/// A setting that keeps more than this share of it is left as the base has it.
const UNTOUCHED_RATIO: f64 = 0.99;
/// What a sound unit has none of. Found by less than this many U it counts as none: by chance a twin would have a fault.
const FAULTS: [&str; 2] = [".encoder-slip", ".encoder-backlash"];
const LEAST_FAULT_U: f64 = 2.0;
/// Step that tells whether a finding depends on a setting, in the uncertainty of this before anything was measured.
const PROBE: f64 = 1e-3;
/// A finding with a smaller share in a value is not named as its evidence.
const LEAST_SHARE: f64 = 0.02;

/// A finding that says something of the unit.
struct Used<'a> {
    finding: &'a Finding<'a>,
    relation: &'static Relation,
    /// Places of all that it depends on among the sought settings.
    sought: Vec<usize>,
    /// Findings of one measurand by one procedure about one axis.
    series: usize,
}

impl Used<'_> {
    fn observation(&self) -> Observation {
        Observation {
            value: self.finding.value,
            u: self.finding.measurement.u,
            dof: self.finding.dof(),
            series: self.series,
            parameters: self.sought.clone(),
        }
    }
}

/// The problem: which settings are to explain which findings.
struct Problem<'a> {
    used: Vec<Used<'a>>,
    /// Places in [`PARAMETERS`].
    sought: Vec<usize>,
    setup: &'a Setup,
    base: &'a UnitSettings,
}

/// How far a setting of a unit may be from this value of its base: a standard uncertainty, SI.
pub(super) fn spread_si(setting: &Setting<FieldOfPart<UnitSettings>>, value_si: f64) -> f64 {
    spread::of(setting, value_si)
}

fn setting(place: usize) -> &'static Setting<FieldOfPart<UnitSettings>> {
    &PARAMETERS[place]
}

/// Keys of a relation for an axis: `*` is its name in unit files.
fn keys(relation: &Relation, axis: Option<usize>) -> Option<Vec<String>> {
    let spelled_out = |key: &&str| match (key.contains('*'), axis) {
        (true, Some(axis)) => Some(key.replace('*', ["az", "el"][axis])),
        (true, None) => None,
        (false, _) => Some((*key).to_owned()),
    };
    relation.settings.iter().map(spelled_out).collect()
}

impl<'a> Problem<'a> {
    fn new(findings: &'a [Finding<'a>], setup: &'a Setup, base: &'a UnitSettings) -> Self {
        let mut problem = Self { used: Vec::new(), sought: Vec::new(), setup, base };
        let mut series: Vec<[&str; 3]> = Vec::new();
        for finding in findings {
            let Some(relation) = Relation::of(finding) else { continue };
            let shown = (relation.shown)(&Shown { finding, unit: base, setup });
            let Some(keys) = keys(relation, finding.axis).filter(|_| shown.is_some_and(f64::is_finite))
            else {
                continue;
            };
            let own = [&finding.procedure.id, &finding.measurement.measurand, &finding.measurement.axis];
            let own = own.map(String::as_str);
            let known = series.iter().position(|one| *one == own);
            if known.is_none() {
                series.push(own);
            }
            let sought = keys.iter().map(|key| problem.place(key)).collect();
            problem.used.push(Used { finding, relation, sought, series: known.unwrap_or(series.len() - 1) });
        }
        problem.find_dependences();
        problem
    }

    /// A finding depends on more settings than it is looked at for: the phase of cogging on the zero of the encoder. The descent
    /// has to know all of them.
    fn find_dependences(&mut self) {
        let priors = self.priors();
        let base: Vec<f64> = priors.iter().map(|prior| prior.value).collect();
        let shown = |used: &Used<'_>, unit: &UnitSettings| {
            (used.relation.shown)(&Shown { finding: used.finding, unit, setup: self.setup })
        };
        let at_base: Vec<Option<f64>> = self.used.iter().map(|used| shown(used, self.base)).collect();
        let mut all: Vec<Vec<usize>> = self.used.iter().map(|used| used.sought.clone()).collect();
        for (k, prior) in priors.iter().enumerate() {
            let mut values = base.clone();
            values[k] += prior.step_from(base[k], PROBE * prior.u);
            let unit = self.unit(&values);
            for ((used, at_base), own) in self.used.iter().zip(&at_base).zip(&mut all) {
                if !own.contains(&k) && shown(used, &unit) != *at_base {
                    own.push(k);
                }
            }
        }
        self.used.iter_mut().zip(all).for_each(|(used, all)| used.sought = all);
    }

    /// Place of a setting among the sought ones; it becomes one of them.
    fn place(&mut self, key: &str) -> usize {
        let of_all =
            PARAMETERS.iter().position(|p| p.key == key).expect("relations name settings that exist");
        if let Some(place) = self.sought.iter().position(|one| *one == of_all) {
            return place;
        }
        self.sought.push(of_all);
        self.sought.len() - 1
    }

    fn priors(&self) -> Vec<Prior> {
        let prior = |&place: &usize| {
            let setting = setting(place);
            let value = setting.get(self.base);
            Prior { value, u: spread::of(setting, value), range: setting.range_si, is_fixed: false }
        };
        self.sought.iter().map(prior).collect()
    }

    /// The base with these values of the sought settings.
    fn unit(&self, values: &[f64]) -> UnitSettings {
        let mut unit = self.base.clone();
        for (place, value) in self.sought.iter().zip(values) {
            setting(*place).set(&mut unit, *value);
        }
        unit
    }

    /// Solves for the settings that are not fixed, by the findings that depend on one of them.
    fn solve(&self, priors: &[Prior]) -> Posterior {
        let is_free = |used: &&Used<'_>| used.sought.iter().any(|&k| !priors[k].is_fixed);
        let used: Vec<&Used<'_>> = self.used.iter().filter(is_free).collect();
        let observations: Vec<Observation> = used.iter().map(|used| used.observation()).collect();
        let predicted = |index: usize, values: &[f64]| {
            let unit = self.unit(values);
            let shown = Shown { finding: used[index].finding, unit: &unit, setup: self.setup };
            // Settings under which the measurand does not exist do not explain that it was found.
            (used[index].relation.shown)(&shown).filter(|shown| shown.is_finite()).unwrap_or(f64::MAX.sqrt())
        };
        Posterior::new(priors, &observations, &predicted)
    }

    /// Delays of the drives come in whole steps of the simulation: one after the other is rounded, and the other delays take up
    /// what it was rounded by.
    fn rounded(&self, priors: &[Prior], free: &Posterior) -> Vec<f64> {
        let key = |k: usize| setting(self.sought[k]).key;
        let found =
            |k: usize| if self.is_untouched(free, k) { priors[k].value } else { free.parameters[k].value };
        let mut values: Vec<f64> = (0..priors.len()).map(found).collect();
        let settled = |k: usize| {
            let stays = !spread::is_delay(key(k)) || self.is_untouched(free, k);
            Prior { value: if stays { found(k) } else { priors[k].value }, is_fixed: stays, ..priors[k] }
        };
        let mut settled: Vec<Prior> = (0..priors.len()).map(settled).collect();
        for name in spread::IN_STEPS {
            let Some(place) = (0..priors.len()).find(|&k| key(k) == name && !settled[k].is_fixed) else {
                continue;
            };
            let rate_hz = self.base.step_rate_hz;
            let [least, most] = priors[place].range;
            let value = ((values[place] * rate_hz).round() / rate_hz).clamp(least, most);
            settled[place] = Prior { value, is_fixed: true, ..settled[place] };
            values = self.solve(&settled).parameters.iter().map(|one| one.value).collect();
        }
        values
    }

    fn is_untouched(&self, free: &Posterior, k: usize) -> bool {
        free.parameters[k].prior_ratio > UNTOUCHED_RATIO
    }

    /// Findings with a share in a value that counts.
    fn sharing<'s>(&'s self, estimated: &'s Estimated) -> impl Iterator<Item = &'s Used<'a>> {
        estimated
            .shares
            .iter()
            .filter(|(_, share)| *share >= LEAST_SHARE)
            .map(|(index, _)| &self.used[*index])
    }

    fn standing(&self, estimated: &Estimated) -> Standing {
        let magnitudes = || self.sharing(estimated).filter(|used| used.relation.is_magnitude);
        if estimated.prior_ratio > MEASURED_RATIO || magnitudes().any(|used| used.sought.len() > 1) {
            return Standing::InPart;
        }
        if magnitudes().next().is_some() { Standing::Magnitude } else { Standing::Measured }
    }

    /// Where the findings stand; several that stand in one place are counted.
    fn evidence(&self, estimated: &Estimated) -> Vec<String> {
        let mut places: Vec<(String, usize)> = Vec::new();
        for place in self.sharing(estimated).map(|used| used.finding.evidence()) {
            match places.iter_mut().find(|(known, _)| *known == place) {
                Some((_, count)) => *count += 1,
                None => places.push((place, 1)),
            }
        }
        let text = |(place, count)| if count == 1 { place } else { format!("{count} x {place}") };
        places.into_iter().map(text).collect()
    }

    /// Findings that the twin does not show.
    fn contradictions(&self, found: &Posterior) -> Vec<String> {
        let far =
            self.used.iter().zip(&found.residuals_u).filter(|(_, residual)| residual.abs() > CONTRADICTS_U);
        let text = |(used, residual): (&Used<'_>, &f64)| {
            let m = used.finding.measurement;
            let [value, shown] =
                [used.finding.value, used.finding.value - residual * m.u].map(|value| m.kind.format(value));
            let point = m.point.as_ref().map_or_else(String::new, |point| format!(" at {point}"));
            format!(
                "{} {}{point}: {value} found, {shown} explained by the settings, {:.1} u apart",
                used.finding.evidence(),
                m.axis,
                residual.abs()
            )
        };
        far.map(text).collect()
    }
}

/// The twin without its curves over elevation.
pub(super) fn identify(findings: &[Finding<'_>], setup: &Setup, base: &UnitSettings) -> Identified {
    let problem = Problem::new(findings, setup, base);
    let priors = problem.priors();
    let free = problem.solve(&priors);
    let values = problem.rounded(&priors, &free);
    let mut found = Identified {
        unit: base.clone(),
        settings: Vec::new(),
        curves: Vec::new(),
        contradictions: problem.contradictions(&free),
        remarks: Vec::new(),
    };
    let mut order: Vec<usize> = (0..problem.sought.len()).collect();
    order.sort_by_key(|&k| problem.sought[k]);
    for k in order {
        let setting = setting(problem.sought[k]);
        let estimated = &free.parameters[k];
        if problem.is_untouched(&free, k) {
            continue;
        }
        let value_si = spread::as_whole(setting.key, values[k]);
        if is_fault_by_chance(setting.key, &priors[k], estimated) {
            let shown = |si: f64| super::text::of_setting(setting, si);
            found.remarks.push(format!(
                "{}: {} found, less than {LEAST_FAULT_U} times its U of {}: as in the base",
                setting.key,
                shown(value_si),
                shown(2.0 * estimated.spread.u)
            ));
            continue;
        }
        setting.set(&mut found.unit, value_si);
        if estimated.is_at_end {
            let range = setting.range_si.map(|end| super::text::of_setting(setting, end));
            found.remarks.push(format!(
                "{}: the findings lie outside of what can be simulated ({} .. {}), the twin gets the nearest value",
                setting.key, range[0], range[1]
            ));
        }
        let u_si = spread::with_rounding(setting.key, estimated.spread.u, base.step_rate_hz);
        let dof = Some(estimated.spread.dof).filter(|dof| dof.is_finite());
        found.settings.push(IdentifiedSetting {
            key: setting.key,
            value: Value { value_si, u_si, dof },
            standing: problem.standing(estimated),
            evidence: problem.evidence(estimated),
        });
    }
    keep_order(&mut found);
    found
}

/// Whether what was found of a fault that the base has not is too little to make one of it.
fn is_fault_by_chance(key: &str, prior: &Prior, estimated: &Estimated) -> bool {
    let is_fault = FAULTS.iter().any(|end| key.ends_with(end));
    is_fault && prior.value == 0.0 && estimated.value.abs() < LEAST_FAULT_U * 2.0 * estimated.spread.u
}

/// Static friction is never below sliding friction: where only the sliding one was found, the static one gives way.
fn keep_order(found: &mut Identified) {
    for (axis, name) in [(0, "az"), (1, "el")] {
        let own = found.unit.axis(axis);
        let sliding_nm = own.coulomb_torque_nm;
        if own.static_torque_nm >= sliding_nm {
            continue;
        }
        let key = format!("{name}.static-torque");
        let setting = PARAMETERS.iter().find(|p| p.key == key).expect("every axis has a static torque");
        setting.set(&mut found.unit, sliding_nm);
        if let Some(own) = found.settings.iter_mut().find(|own| own.key == key) {
            own.value.value_si = sliding_nm;
        }
        found.remarks.push(format!("{key}: raised to {name}.coulomb-torque, below which it cannot be"));
    }
}
