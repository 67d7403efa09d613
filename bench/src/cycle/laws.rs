//! External velocity laws of a run, by axis, and where they are stepped.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use controllers::AxisGains;
use controllers::parameter::AXIS_PARAMETERS;
use drivers::device::DeviceError;
use external_law::rows::{LawInput, LawOutput, LawSetup};
use external_law::{Description, Instance, Library, Parameter};
use reports::record::LawRecord;

use crate::cycle::velocity_loop::{External, LawFault};
use crate::model::axis::RigAxis;

mod child;

pub(crate) use child::{READY, describe};

/// Where a law is stepped.
#[derive(Clone, Debug)]
pub enum Hosting {
    /// In this process, by the loaded library: a law that crashes takes the run with it. In virtual time only.
    InProcess(Arc<Library>),
    /// In a process of its own, which alone loads the library.
    Child {
        /// The program `bench`.
        program: PathBuf,
        /// Longest time for the answers of a tick; `None` in virtual time, which waits.
        deadline: Option<Duration>,
    },
}

/// An external law.
#[derive(Clone, Debug)]
pub struct Law {
    /// The library as it was named.
    pub file: String,
    /// SHA-256 of the library, hexadecimal.
    pub sha256: String,
    /// What the library says of itself.
    pub description: Description,
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
        self.by_axis.values().any(|law| matches!(law.hosting, Hosting::InProcess(_)))
    }

    /// What the record of a run says of them.
    pub fn records(&self) -> Vec<LawRecord> {
        let record = |(axis, law): (&String, &Law)| LawRecord {
            axis: axis.clone(),
            name: law.description.name.clone(),
            version: law.description.version.clone(),
            file: law.file.clone(),
            sha256: law.sha256.clone(),
            hosting: match law.hosting {
                Hosting::InProcess(_) => "in process".to_owned(),
                Hosting::Child { .. } => "process of its own".to_owned(),
            },
        };
        self.by_axis.iter().map(record).collect()
    }
}

impl Law {
    /// Loads a library whose law is stepped in this process.
    ///
    /// # Errors
    /// As [`Library::load`].
    pub fn in_process(path: &Path, sha256: &str) -> Result<Self, String> {
        let library = Library::load(path, sha256).map_err(|error| error.to_string())?;
        Ok(Self {
            file: library.file().to_owned(),
            sha256: library.sha256().to_owned(),
            description: library.description().clone(),
            hosting: Hosting::InProcess(Arc::new(library)),
        })
    }

    /// A law that is stepped in a process of its own. Its description is read in one, too: this process never runs code of the
    /// library.
    ///
    /// # Errors
    /// As [`Library::load`]; when that process crashes or does not answer.
    pub fn hosted(
        path: &Path,
        sha256: &str,
        program: PathBuf,
        deadline: Option<Duration>,
    ) -> Result<Self, String> {
        let description = child::description(&program, path, sha256)?;
        let file = path.display().to_string();
        Ok(Self {
            file,
            sha256: sha256.to_owned(),
            description,
            hosting: Hosting::Child { program, deadline },
        })
    }

    /// An instance for an axis with these gains. A process of its own keeps off the processor `ticks_on`.
    pub(super) fn start(
        &self,
        axis: &RigAxis,
        gains: &AxisGains,
        period_s: f64,
        ticks_on: Option<usize>,
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
        let values = self.description.parameters.iter().map(|parameter| value_si(parameter, gains));
        let values: Vec<f64> = values.collect::<Result<_, _>>().map_err(failed)?;
        let law = match &self.hosting {
            Hosting::InProcess(library) => {
                let instance = library.create(&setup, &values).map_err(|error| failed(error.to_string()))?;
                Stepped::InProcess(instance)
            }
            Hosting::Child { program, deadline } => {
                let child = child::Child::start(program, self, &setup, &values, *deadline, ticks_on);
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
    /// The next answer belongs to another tick, which has its own time for answers.
    pub(super) fn end_tick(&mut self) {
        match self {
            Self::InProcess(_) => {}
            Self::Child(child) => child.end_tick(),
        }
    }

    pub(super) fn step(&mut self, input: &LawInput) -> Result<LawOutput, LawFault> {
        match self {
            Self::InProcess(instance) => Ok(instance.step(input)),
            Self::Child(child) => child.step(input),
        }
    }
}
