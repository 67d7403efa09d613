//! External velocity laws of a run, by axis, and where they are stepped.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use controllers::AxisGains;
use controllers::parameter::AXIS_PARAMETERS;
use drivers::device::DeviceError;
use external_law::rows::{LawInput, LawOutput, LawSetup};
use external_law::{Instance, Library, Parameter};
use reports::record::LawRecord;

use crate::cycle::velocity_loop::{External, LawFault};
use crate::model::axis::RigAxis;

mod child;

pub(crate) use child::READY;

/// Longest time for an answer of a law in another process, where time is real.
pub const DEADLINE: Duration = Duration::from_micros(100);

/// Where a law is stepped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Hosting {
    /// In this process: a law that crashes takes the run with it. In virtual time only.
    InProcess,
    /// In a process of its own.
    Child {
        /// The program `bench`.
        program: PathBuf,
        /// Longest time for an answer; `None` in virtual time, which waits.
        deadline: Option<Duration>,
    },
}

/// An external law.
#[derive(Clone, Debug)]
pub struct Law {
    /// The loaded library.
    pub library: Arc<Library>,
    /// Where it is stepped.
    pub hosting: Hosting,
}

/// External laws by the name of their axis; the other axes have the built-in law.
#[derive(Clone, Debug, Default)]
pub struct Laws {
    by_axis: BTreeMap<String, Law>,
}

impl Laws {
    /// Gives an axis an external law; `false` where it has one already.
    pub fn insert(&mut self, axis: &str, law: Law) -> bool {
        self.by_axis.insert(axis.to_owned(), law).is_none()
    }

    /// The law of an axis.
    pub fn of(&self, axis: &str) -> Option<&Law> {
        self.by_axis.get(axis)
    }

    /// Whether any of them is stepped in this process.
    pub fn any_in_process(&self) -> bool {
        self.by_axis.values().any(|law| law.hosting == Hosting::InProcess)
    }

    /// What the record of a run says of them.
    pub fn records(&self) -> Vec<LawRecord> {
        let record = |(axis, law): (&String, &Law)| LawRecord {
            axis: axis.clone(),
            name: law.library.name().to_owned(),
            version: law.library.version().to_owned(),
            file: law.library.file().to_owned(),
            sha256: law.library.sha256().to_owned(),
            hosting: match law.hosting {
                Hosting::InProcess => "in process".to_owned(),
                Hosting::Child { .. } => "process of its own".to_owned(),
            },
        };
        self.by_axis.iter().map(record).collect()
    }
}

impl Law {
    /// An instance for an axis with these gains.
    pub(super) fn start(
        &self,
        axis: &RigAxis,
        gains: &AxisGains,
        period_s: f64,
    ) -> Result<External, DeviceError> {
        let limits = &axis.limits;
        let setup = LawSetup {
            period_s,
            torque_limit_nm: limits.max_torque_nm,
            velocity_limit_rad_per_s: limits.max_velocity_rad_per_s,
            acceleration_limit_rad_per_s2: limits.max_acceleration_rad_per_s2,
            inertia_kg_m2: limits.inertia_kg_m2,
        };
        let failed = |reason: String| DeviceError::Bus { device: format!("law of {}", axis.name), reason };
        let values = self.library.parameters().iter().map(|parameter| value_si(parameter, gains));
        let values: Vec<f64> = values.collect::<Result<_, _>>().map_err(failed)?;
        let law = match &self.hosting {
            Hosting::InProcess => {
                let instance =
                    self.library.create(&setup, &values).map_err(|error| failed(error.to_string()))?;
                Stepped::InProcess(instance)
            }
            Hosting::Child { program, deadline } => {
                let child = child::Child::start(program, &self.library, &setup, &values, *deadline);
                Stepped::Child(child.map_err(failed)?)
            }
        };
        Ok(External { law, limit_nm: limits.max_torque_nm, in_use: true })
    }
}

/// The value of a parameter: that of the axis in the parameter file, or the law's own default.
fn value_si(parameter: &Parameter, gains: &AxisGains) -> Result<f64, String> {
    let of_axis = AXIS_PARAMETERS.iter().find(|known| known.key == parameter.name);
    of_axis.map(|known| (known.get)(gains)).or(parameter.default_si).ok_or_else(|| {
        format!(
            "parameter `{}` is no key of an axis in the parameter file, and the law has no default for it",
            parameter.name
        )
    })
}

/// The law of one axis where it is stepped.
#[derive(Debug)]
pub(super) enum Stepped {
    InProcess(Instance),
    Child(child::Child),
}

impl Stepped {
    pub(super) fn step(&mut self, input: &LawInput) -> Result<LawOutput, LawFault> {
        match self {
            Self::InProcess(instance) => Ok(instance.step(input)),
            Self::Child(child) => child.step(input),
        }
    }
}
