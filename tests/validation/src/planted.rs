//! Changes of a controller whose effect the linear model tells, and how often a comparison calls them rightly.
//!
//! Each change has a criterion, a scenario, a margin and the call that its effect must lead to: an effect of at least two margins is
//! worse or better, one of at most a third of a margin is equivalent. The model is that of the unit `nominal`; the comparison is
//! made over units drawn off it.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU16;

use bench::cycle::laws::Laws;
use bench::files::profile;
use bench::files::rig::read_rig;
use bench::files::shipped::{Folder, find};
use bench::model::rig::{Rig, Tier};
use bench::plan::{CampaignPlan, Wanted, plan};
use bench::regression::population::Units;
use bench::regression::{Arm, ArmFiles, Asked, Course, run_arms};
use controllers::DirectorGains;
use procedures::diagnostic::Diagnostic;
use procedures::quantity::QuantityKind;
use procedures::regression::{
    ArmRecord, Call, Criteria, Criterion, Look, Outcome, Replicate, Scale, Shard, Worse, decide, pair,
};
use sim_devices::unit::{FieldOfPart, PARAMETERS, Setting, UnitSettings};

use crate::blind::draw;
use crate::prediction::predict;
use crate::shipped;

mod anti_windup;

/// A change of one arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Nothing: the same controller, with the same noise.
    Nothing,
    /// Nothing, with other noise in the candidate's arm.
    OtherNoise,
    /// Gains of elevation's velocity loop times this factor.
    VelocityGain(f64),
    /// Delay of elevation's commands, s; the baseline has the nominal delay on every unit.
    CommandDelay(f64),
    /// Notches of the mirror's loop at this many times their frequency.
    MirrorNotch(f64),
    /// Tracking without prediction of the target.
    NoPrediction,
    /// An external law for azimuth whose integral goes on at its torque limit; the baseline is the same law with anti-windup.
    NoAntiWindup,
}

/// A change with what it is compared by.
#[derive(Clone, Copy, Debug)]
pub struct Planted {
    /// What is changed.
    pub name: &'static str,
    /// The change.
    pub change: Change,
    /// What both arms run through.
    pub procedure: Scenario,
    /// Requirement.
    pub requirement: &'static str,
    /// Its measurand.
    pub measurand: &'static str,
    /// Its kind.
    pub kind: QuantityKind,
    /// Place where it is compared: how it begins.
    pub place: &'static str,
    /// Where its effect is known from.
    pub model: Model,
    /// Which way it becomes worse.
    pub worse: Worse,
    /// Margin, SI.
    pub margin: f64,
    /// What must be called.
    pub expected: Call,
}

/// A procedure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scenario {
    /// Its shipped name.
    Shipped(&'static str),
    /// Its text.
    Own(&'static str),
}

/// What tells the effect of a change.
#[derive(Clone, Copy, Debug)]
pub enum Model {
    /// A quantity of the linear model.
    Linear {
        /// As predictions call it.
        quantity: &'static str,
        /// 0 azimuth, 1 elevation.
        axis: usize,
        /// As predictions call it.
        condition: &'static str,
    },
    /// A step of azimuth that saturates, on a rigid axis with friction.
    SaturatingStep,
}

const DEG: f64 = std::f64::consts::PI / 180.0;
const EL_LOOP: Scenario = Scenario::Shipped("shipped:regression/el-velocity-loop.toml");

const fn velocity(
    name: &'static str,
    change: Change,
    quantity: [&'static str; 3],
    kind: QuantityKind,
) -> Planted {
    Planted {
        name,
        change,
        procedure: EL_LOOP,
        requirement: quantity[0],
        measurand: quantity[1],
        kind,
        place: "EL-VELOCITY-LOOP el",
        model: Model::Linear { quantity: quantity[2], axis: 1, condition: "elevation 0 deg" },
        worse: Worse::Lower,
        margin: 0.0,
        expected: Call::Equivalent,
    }
}

const BANDWIDTH: [&str; 3] = ["VEL-BW", "velocity-bandwidth", "bandwidth"];
const GAIN_MARGIN: [&str; 3] = ["VEL-GM", "velocity-gain-margin", "gain-margin"];
const PHASE_MARGIN: [&str; 3] = ["VEL-PM", "velocity-phase-margin", "phase-margin"];

/// Every planted change.
pub const PLANTED: &[Planted] = &[
    Planted {
        margin: 0.4,
        expected: Call::Worse,
        ..velocity("velocity gain + 10 %", Change::VelocityGain(1.1), GAIN_MARGIN, QuantityKind::Decibel)
    },
    Planted {
        margin: 0.1,
        expected: Call::Better,
        ..velocity("velocity gain + 10 %", Change::VelocityGain(1.1), BANDWIDTH, QuantityKind::Frequency)
    },
    Planted {
        margin: 0.15 * DEG,
        expected: Call::Worse,
        ..velocity("one tick of delay", Change::CommandDelay(250e-6), PHASE_MARGIN, QuantityKind::Angle)
    },
    Planted {
        margin: 1.1 * DEG,
        ..velocity("one tick of delay", Change::CommandDelay(250e-6), PHASE_MARGIN, QuantityKind::Angle)
    },
    Planted {
        procedure: Scenario::Own(include_str!("planted/fsm-response.toml")),
        place: "FSM-RESPONSE az",
        model: Model::Linear { quantity: "bandwidth", axis: 0, condition: "" },
        margin: 15.0,
        ..velocity(
            "mirror notch 3 % lower",
            Change::MirrorNotch(0.97),
            ["FSM-BW", "mirror-bandwidth", "bandwidth"],
            QuantityKind::Frequency,
        )
    },
    Planted {
        name: "prediction off",
        change: Change::NoPrediction,
        procedure: Scenario::Shipped("shipped:regression/track-rail.toml"),
        requirement: "TRK-RMS-C",
        measurand: "coarse-track-rms",
        kind: QuantityKind::Angle,
        place: "TRACK-RAIL el",
        model: Model::Linear { quantity: "coarse-rms", axis: 1, condition: "rail" },
        worse: Worse::Higher,
        margin: 1e-6,
        expected: Call::Worse,
    },
    Planted {
        name: "anti-windup removed",
        change: Change::NoAntiWindup,
        procedure: Scenario::Shipped("shipped:regression/az-step.toml"),
        requirement: "POS-OVS",
        measurand: "step-overshoot-excess",
        kind: QuantityKind::Angle,
        place: "AZ-STEP az",
        model: Model::SaturatingStep,
        worse: Worse::Higher,
        margin: 200e-6,
        expected: Call::Worse,
    },
    Planted {
        margin: 0.1,
        expected: Call::Identical,
        ..velocity("nothing, same noise", Change::Nothing, BANDWIDTH, QuantityKind::Frequency)
    },
    Planted {
        margin: 0.1,
        ..velocity("nothing, other noise", Change::OtherNoise, BANDWIDTH, QuantityKind::Frequency)
    },
];

/// The planted changes, those together that the same runs tell.
pub fn groups() -> impl Iterator<Item = &'static [Planted]> {
    PLANTED.chunk_by(|one, next| one.change == next.change && one.procedure == next.procedure)
}

impl Planted {
    /// Effect on the nominal unit by the model, SI, + is worse.
    ///
    /// # Panics
    /// For a quantity that the model does not have.
    pub fn effect(&self) -> f64 {
        let unit = UnitSettings::default();
        let gains = shipped::gains();
        let [before, after] = match self.model {
            Model::SaturatingStep => {
                [false, true].map(|winds_up| anti_windup::overshoot_rad(&unit.az, &gains.az, winds_up))
            }
            Model::Linear { quantity, axis, condition } => {
                let mut changed = unit.clone();
                for (key, value_si) in self.settings(1.0) {
                    parameter(key).set(&mut changed, value_si);
                }
                [(&unit, &gains), (&changed, &self.gains(&gains))].map(|(unit, gains)| {
                    let rows = predict(unit, gains);
                    let is_own = |row: &&crate::prediction::Expected| {
                        row.requirement == self.requirement
                            && row.quantity == quantity
                            && row.axis == Some(axis)
                            && row.condition == condition
                    };
                    rows.iter().find(is_own).expect("a quantity of the model").value_si
                })
            }
        };
        match self.worse {
            Worse::Higher => after - before,
            Worse::Lower => before - after,
        }
    }

    /// Settings of the unit that the change sets; `share` 0 those of the baseline, 1 of the candidate.
    fn settings(&self, share: f64) -> Vec<(&'static str, f64)> {
        let nominal = |key: &str| parameter(key).get(&UnitSettings::default());
        match self.change {
            Change::CommandDelay(delay_s) => {
                let key = "el.command-delay";
                vec![(key, nominal(key) + share * delay_s)]
            }
            Change::MirrorNotch(factor) => ["mirror.az-notch-frequency", "mirror.el-notch-frequency"]
                .map(|key| (key, nominal(key) * (1.0 + share * (factor - 1.0))))
                .to_vec(),
            _ => Vec::new(),
        }
    }

    fn gains(&self, gains: &DirectorGains) -> DirectorGains {
        let mut changed = *gains;
        match self.change {
            Change::VelocityGain(factor) => {
                changed.el.velocity_kp_nm_s_per_rad *= factor;
                changed.el.velocity_ki_nm_per_rad *= factor;
            }
            Change::NoPrediction => changed.track.prediction = controllers::Prediction::Off,
            _ => {}
        }
        changed
    }

    /// The criterion that it is compared by.
    pub fn criteria(&self) -> Criteria {
        let criterion = Criterion {
            requirement: self.requirement.to_owned(),
            measurand: self.measurand.to_owned(),
            place: String::new(),
            kind: self.kind,
            margin: self.margin,
            scale: Scale::Difference,
            worse: self.worse,
            blocking: true,
        };
        Criteria { looks: vec![5, 10, 20, 40], all: vec![criterion] }
    }
}

/// What a change is run with.
pub struct Bed {
    rig: Rig,
    plan: CampaignPlan,
    units: Units,
    arms: [Arm; 2],
    /// Seed of the first unit: units of other repetitions have noise of their own.
    seed: u64,
}

impl Bed {
    /// Files of a change in a folder: a campaign of its procedure, and units 1 to `units` of the blind test from `first` on.
    ///
    /// # Errors
    /// Mistakes of files, which would be ours.
    pub fn new(planted: &Planted, folder: &Path, first: u32, units: u32) -> Result<Self, Vec<Diagnostic>> {
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).expect("a writable folder");
            path.to_str().expect("a plain path").to_owned()
        };
        let procedure = match planted.procedure {
            Scenario::Shipped(name) => name.to_owned(),
            Scenario::Own(text) => write("procedure.toml", text),
        };
        let campaign = format!(
            "schema = 1\nid = \"planted\"\ntitle = \"{}\"\nrequirements = \"shipped:requirements.toml\"\nmust-measure = []\n\
             claim = \"screening\"\n[[procedure]]\nfile = \"{procedure}\"\n",
            planted.name
        );
        let campaign = write("planted.toml", &campaign);
        let rig =
            read_rig(find(Folder::Rigs, "sim", None)?)?.rehearsed_on(Tier::Virtual, &profile::simulated());
        let plan = plan(&Wanted { names: vec![campaign], polarity_proven: true, ..Wanted::default() }, &rig)
            .expect("a campaign that the rig can run");
        let names: Vec<String> = (first..first + units)
            .map(|number| {
                write(&format!("unit-{number}.toml"), &draw::unit(&format!("unit-{number}"), number))
            })
            .collect();
        let mut arms = Vec::new();
        for (share, name) in [(0.0, "baseline"), (1.0, "candidate")] {
            let settings = planted.settings(share);
            let states = if settings.is_empty() {
                Vec::new()
            } else {
                vec![write(&format!("{name}-state.toml"), &state(&settings))]
            };
            let laws = match planted.change {
                Change::NoAntiWindup => anti_windup::laws(folder, share > 0.0),
                _ => Laws::default(),
            };
            let mut arm = Arm::read(&ArmFiles { parameters: "director", states: &states, laws }, &rig)?;
            if share > 0.0 {
                arm.gains = planted.gains(&arm.gains);
                arm.gains.axes[1] = arm.gains.el;
            }
            arms.push(arm);
        }
        let [baseline, candidate] = <[Arm; 2]>::try_from(arms).expect("two arms");
        Ok(Self {
            rig,
            plan,
            units: Units::named(&names)?,
            arms: [baseline, candidate],
            seed: u64::from(first),
        })
    }

    /// Runs both arms on all units.
    ///
    /// # Panics
    /// Where a run fails.
    pub fn run(&self, planted: &Planted, folder: &Path, jobs: usize) -> [ArmRecord; 2] {
        let asked = |seed: u64| Asked {
            plan: &self.plan,
            rig: &self.rig,
            units: &self.units,
            seed,
            seeds_per_unit: 1,
            shard: Shard::WHOLE,
            jobs,
            folder: folder.join("runs"),
            keep: false,
            stop: Arc::new(AtomicU16::new(0)),
            tell: &|_, _| {},
        };
        let course = Course { from: 1, to: self.units.count() };
        const OTHER_SEED: u64 = 1_000_000;
        if planted.change == Change::OtherNoise {
            let [baseline, mut candidate] = [self.seed, OTHER_SEED + self.seed].map(|seed| {
                let mut found =
                    run_arms(&asked(seed), &self.arms[..1], course).expect("runs without a failure");
                found.remove(0)
            });
            // The units are the pairs; that their noise differs is what is tried.
            candidate.scenario = baseline.scenario.clone();
            candidate.replicates.iter_mut().for_each(|replicate| replicate.seed -= OTHER_SEED);
            return [baseline, candidate];
        }
        let mut found = run_arms(&asked(self.seed), &self.arms, course).expect("runs without a failure");
        let candidate = found.remove(1);
        [found.remove(0), candidate]
    }
}

/// Records of the same arms on further units, behind those that there are; units and seeds are counted on.
pub fn append(all: &mut [ArmRecord; 2], more: [ArmRecord; 2]) {
    for (arm, more) in all.iter_mut().zip(more) {
        for replicate in more.replicates {
            let number = arm.replicates.len() as u32 + 1;
            arm.replicates.push(Replicate { unit: number, seed: u64::from(number), ..replicate });
        }
        arm.scenario.population.units = arm.replicates.len() as u32;
    }
}

/// The setting of a unit with this key.
fn parameter(key: &str) -> &'static Setting<FieldOfPart<UnitSettings>> {
    PARAMETERS.iter().find(|parameter| parameter.key == key).expect("a setting of units")
}

/// A state file with these settings.
fn state(settings: &[(&'static str, f64)]) -> String {
    let mut text = "schema = 1\nid = \"planted\"\ntitle = \"Planted\"\n".to_owned();
    let mut table = "";
    for (key, value_si) in settings {
        let parameter = parameter(key);
        let (own_table, own) = parameter.table_and_key();
        if own_table != table {
            text += &format!("[{own_table}]\n");
            table = own_table;
        }
        text += &format!("{own} = \"{}\"\n", draw::text(parameter.quantity, *value_si));
    }
    text
}

/// What the criterion of a change comes to on some of the units, from `from` on (its place in the records).
///
/// # Panics
/// Where the arms cannot be compared.
pub fn outcome(planted: &Planted, arms: &[ArmRecord; 2], from: usize, units: usize) -> Outcome {
    let part = |arm: &ArmRecord| ArmRecord {
        replicates: arm.replicates[from..from + units].to_vec(),
        ..arm.clone()
    };
    let [baseline, candidate] = [part(&arms[0]), part(&arms[1])];
    let mut paired = pair(&planted.criteria(), &baseline, &candidate).expect("arms that were run alike");
    let place =
        paired.criteria.all.iter().position(|c| c.place.starts_with(planted.place)).expect("its place");
    paired.criteria.all = vec![paired.criteria.all.remove(place)];
    paired.samples = vec![paired.samples.remove(place)];
    decide(&paired.criteria, &paired.samples, Look::Single).expect("good samples").outcomes.remove(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_is_two_margins_and_more_or_a_third_and_less_as_its_call_says() {
        let mut misfits = Vec::new();
        for planted in PLANTED {
            let margins = planted.effect() / planted.margin;
            let fits = match planted.expected {
                Call::Worse => margins >= 2.0,
                Call::Better => margins <= -2.0,
                Call::Identical => margins == 0.0,
                _ => margins.abs() <= 1.0 / 3.0,
            };
            if !fits {
                misfits.push(format!("{} ({}): {margins:.3} margins", planted.name, planted.measurand));
            }
        }
        assert!(misfits.is_empty(), "{misfits:#?}");
    }
}
