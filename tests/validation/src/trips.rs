//! One random trip: a random motion of a simulated director, a random cause at a random instant, and what became of it.
//!
//! The run goes through the real loop on the simulated rig; what happened is read off the wire and off the truth of the
//! world, never from what the loop says of itself. It is compared with figures of [`bench::model::stopping`],
//! which knows the rig file only.

mod cause;
mod draw;
mod judge;
mod run;
mod tap;
mod variation;

#[cfg(test)]
mod tests;

use bench::files::parameters;
use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::model::rig::Rig;
use bench::model::stopping::Impact;
use controllers::DirectorGains;
use sim_devices::unit::UnitSettings;

use crate::shipped::director;

pub use cause::{Braking, CAUSES, Cause};
pub use draw::Plan;
pub use variation::Variation;

/// The units that trips are tried on.
pub const UNITS: [&str; 2] = ["nominal", "as-measured"];

/// What all trials share.
pub struct Bed {
    rig: Rig,
    gains: DirectorGains,
    units: [UnitSettings; 2],
}

/// Angle and rate of an axis as they really are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// rad.
    pub angle_rad: f64,
    /// rad/s.
    pub rate_rad_per_s: f64,
}

/// What became of a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// What was planned.
    pub plan: Plan,
    /// Where the axis was when the cause set in.
    pub caused: Pose,
    /// Where it was when the cause could be seen at the wire.
    pub seen: Pose,
    /// Ticks from the cause to the first inputs that show it.
    pub hidden_ticks: u64,
    /// Ticks from those inputs to the first command that differs; `None` where nothing changed.
    pub answered_ticks: Option<u64>,
    /// What tripped first, or the order that stopped it.
    pub first_out: String,
    /// Whether the axis lost its torque while it moved.
    pub lost_torque: bool,
    /// Angle that it may take at the worst, from where it was seen or lost its torque.
    pub computed_rad: f64,
    /// Angle that it took.
    pub reached_rad: f64,
    /// Time that it may take at the worst; `None` without torque.
    pub computed_s: Option<f64>,
    /// Time to standstill.
    pub reached_s: f64,
    /// Angle left to the soft limit from the farthest place that it reached.
    pub room_rad: f64,
    /// The contact with the end of travel that was predicted: a residual risk.
    pub predicted: Option<Impact>,
    /// Speed of the contact that there was.
    pub impact_rad_per_s: Option<f64>,
    /// Rules of the safety concept that this trial broke.
    pub breaches: Vec<String>,
}

impl Bed {
    /// The shipped simulated rig with an enabling switch, and the shipped units.
    ///
    /// # Panics
    /// When a shipped file is not readable.
    pub fn shipped() -> Self {
        let mut source = shipped::find(Folder::Rigs, "sim", None).expect("the rig is shipped");
        source.text =
            source.text.replace("emergency-stop-bit", "enabling-switch-bit = 16\nemergency-stop-bit");
        let rig = read_rig(source).expect("a shipped rig with one more key is readable");
        let gains = parameters::load(&rig).expect("shipped parameters are readable");
        Self { rig, gains, units: UNITS.map(director) }
    }

    /// The trial of a seed.
    pub fn trial(&self, seed: u64) -> Trial {
        let plan = Plan::draw(seed, &self.rig);
        let witnessed = run::run(self, &plan);
        judge::judge(self, plan, &witnessed)
    }
}
