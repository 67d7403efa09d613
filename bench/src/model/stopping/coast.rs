//! Without torque: how far an axis coasts, whether it meets an end stop, where it swings when it is let go.

use super::{Loads, StopModel};

/// Steps of the integration over angle.
const STEPS: u32 = 512;

/// Contact with an end of travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Speed there.
    pub speed_rad_per_s: f64,
    /// Kinetic energy there.
    pub energy_j: f64,
}

/// Where an axis ends that loses its torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coast {
    /// Where it stops or meets the end of its travel.
    pub end_rad: f64,
    /// The contact, where there is one: a residual risk that no software takes away.
    pub impact: Option<Impact>,
}

/// Where an axis goes that is let go at rest and does not stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// Where it stops or meets the end of its travel.
    pub to_rad: f64,
    /// Largest speed on the way.
    pub speed_rad_per_s: f64,
}

impl StopModel {
    /// Coasting from an angle with a rate: kinetic energy less the work of friction and brake, angle by angle. The rig
    /// file gives the largest loads and the least friction, so that loads count only where they drive the axis on.
    pub fn coast(&self, angle_rad: f64, rate_rad_per_s: f64) -> Coast {
        let (mut coast, _) = self.without_torque(angle_rad, rate_rad_per_s, Loads::driving);
        if coast.impact.is_none() {
            let ahead = if rate_rad_per_s >= 0.0 { 1.0 } else { -1.0 };
            coast.end_rad += ahead * self.relaxation_rad;
        }
        coast
    }

    /// The largest kinetic energy with which a coasting axis can arrive at the end of its travel, J: viscous friction
    /// left out. Cheap enough for every tick.
    pub fn coast_energy_bound_j(&self, angle_rad: f64, rate_rad_per_s: f64) -> f64 {
        let end_rad = if rate_rad_per_s >= 0.0 { self.travel_rad[1] } else { self.travel_rad[0] };
        let ahead = if rate_rad_per_s >= 0.0 { 1.0 } else { -1.0 };
        let way_rad = ((end_rad - angle_rad) * ahead).max(0.0);
        let loads = &self.loads;
        let stretch = |at: f64| (at - loads.spring_rest_rad) * (at - loads.spring_rest_rad);
        // The spring drives the axis on its way to its rest, the unbalance at the most all the way.
        let slackest_rad = loads.spring_rest_rad.clamp(angle_rad.min(end_rad), angle_rad.max(end_rad));
        let spring_j = 0.5 * loads.spring_nm_per_rad * (stretch(angle_rad) - stretch(slackest_rad)).max(0.0);
        let unbalance_j = loads.unbalance_nm.abs() * way_rad;
        let kinetic_j = 0.5 * self.inertia_kg_m2 * rate_rad_per_s * rate_rad_per_s;
        let losses_nm = self.friction.coulomb_nm + self.brake_nm;
        (kinetic_j + unbalance_j + spring_j - losses_nm * way_rad).max(0.0)
    }

    /// Where the axis goes when it is let go at rest; `None` where static friction keeps it.
    pub fn swing(&self, angle_rad: f64) -> Option<Swing> {
        let load_nm = self.loads.at(angle_rad);
        if load_nm.abs() <= self.friction.static_nm + self.brake_nm {
            return None;
        }
        let together = |loads: &Loads, ahead, angle_rad| ahead * loads.at(angle_rad);
        let (coast, speed_rad_per_s) =
            self.without_torque(angle_rad, f64::MIN_POSITIVE.copysign(load_nm), together);
        Some(Swing { to_rad: coast.end_rad, speed_rad_per_s })
    }

    fn without_torque(
        &self,
        angle_rad: f64,
        rate_rad_per_s: f64,
        drives_nm: impl Fn(&Loads, f64, f64) -> f64,
    ) -> (Coast, f64) {
        let ahead = if rate_rad_per_s >= 0.0 { 1.0 } else { -1.0 };
        let end_rad = if ahead > 0.0 { self.travel_rad[1] } else { self.travel_rad[0] };
        let step_rad = ((end_rad - angle_rad) * ahead).max(0.0) / f64::from(STEPS);
        let speed = |energy_j: f64| (2.0 * energy_j / self.inertia_kg_m2).max(0.0).sqrt();
        let mut energy_j = 0.5 * self.inertia_kg_m2 * rate_rad_per_s * rate_rad_per_s;
        let mut fastest = speed(energy_j);
        for step in 0..STEPS {
            let middle_rad = angle_rad + ahead * (f64::from(step) + 0.5) * step_rad;
            let friction = &self.friction;
            let losses_nm =
                friction.coulomb_nm + self.brake_nm + friction.viscous_nm_s_per_rad * speed(energy_j);
            let gained_j = (drives_nm(&self.loads, ahead, middle_rad) - losses_nm) * step_rad;
            if energy_j + gained_j <= 0.0 {
                // Within this step it comes to rest: where the energy is used up.
                let share = if gained_j < 0.0 { -energy_j / gained_j } else { 0.0 };
                let rest_rad = angle_rad + ahead * (f64::from(step) + share) * step_rad;
                return (Coast { end_rad: rest_rad, impact: None }, fastest);
            }
            energy_j += gained_j;
            fastest = fastest.max(speed(energy_j));
        }
        let impact = Impact { speed_rad_per_s: speed(energy_j), energy_j };
        (Coast { end_rad, impact: Some(impact) }, fastest)
    }
}
