//! Unbalance and spring over the travel against static friction.

use analysis::dwell::mean;
use analysis::least_squares::LinearFit;
use analysis::load_map::LoadMap;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::Pose;

/// Fewest poses: three coefficients and two degrees of freedom for their spread.
const FEWEST_POSES: usize = 5;
/// Step over the travel, rad: half a degree.
const STEP_RAD: f64 = std::f64::consts::PI / 360.0;

/// Net torque [1, cos θ, θ] over the elevation and the friction that must hold it.
pub(in crate::kinds::breakaway::conclude) struct Curve {
    fit: LinearFit,
    /// Coverage factor for 95 %.
    k_factor: f64,
    friction_nm: f64,
    cogging_nm: f64,
    poses: usize,
}

impl Curve {
    /// Fits the poses at which both ramps broke away; `None` if they are too few or too close together.
    pub(super) fn over(poses: &[Pose], map: Option<&LoadMap>) -> Option<Self> {
        let known: Vec<(f64, f64, f64)> =
            poses.iter().filter_map(|p| Some((p.pose_rad, p.net_nm?, p.friction_nm?))).collect();
        if known.len() < FEWEST_POSES {
            return None;
        }
        let columns = [
            vec![1.0; known.len()],
            known.iter().map(|k| k.0.cos()).collect(),
            known.iter().map(|k| k.0).collect(),
        ];
        let net: Vec<f64> = known.iter().map(|k| k.1).collect();
        let fit = LinearFit::new(&columns, &net, None).ok()?;
        let k_factor = StudentsT::new(0.0, 1.0, fit.dof as f64).ok()?.inverse_cdf(0.975);
        Some(Self {
            fit,
            k_factor,
            friction_nm: mean(&known.iter().map(|k| k.2).collect::<Vec<_>>()),
            cogging_nm: map.map_or(0.0, LoadMap::cogging_amplitude_nm),
            poses: known.len(),
        })
    }

    /// Margin left at an angle: friction less |net| less cogging, and its expanded uncertainty.
    pub(in crate::kinds::breakaway::conclude) fn margin(&self, angle_rad: f64) -> (f64, f64) {
        let row = [1.0, angle_rad.cos(), angle_rad];
        let margin = self.friction_nm - self.fit.at(&row).abs() - self.cogging_nm;
        (margin, self.k_factor * self.fit.u_at(&row))
    }

    /// Angles on the grid over the travel.
    pub(in crate::kinds::breakaway::conclude) fn angles(travel_rad: [f64; 2]) -> Vec<f64> {
        let steps = ((travel_rad[1] - travel_rad[0]) / STEP_RAD).round().max(1.0);
        (0..=steps as usize)
            .map(|k| travel_rad[0] + (travel_rad[1] - travel_rad[0]) * k as f64 / steps)
            .collect()
    }

    /// Where the axis does not hold itself, in words.
    pub(super) fn remark(&self, travel_rad: [f64; 2]) -> String {
        let stretches = self.stretches(travel_rad);
        let basis = format!(
            "computed from {} poses, model [1, cos θ, θ], static friction {:.1} N·m, cogging {:.1} N·m on top of the load",
            self.poses, self.friction_nm, self.cogging_nm
        );
        let degrees = |[a, b]: &[f64; 2]| format!("{:.1} … {:.1} deg", a.to_degrees(), b.to_degrees());
        if stretches.is_empty() {
            format!("Holds itself unpowered over the whole travel {} ({basis}).", degrees(&travel_rad))
        } else {
            let list = stretches.iter().map(degrees).collect::<Vec<_>>().join(", ");
            format!(
                "Does not surely hold itself unpowered at {list} ({basis}; uncertainty counted against it)."
            )
        }
    }

    /// Stretches of the travel where |net| + cogging + U exceeds static friction.
    fn stretches(&self, travel_rad: [f64; 2]) -> Vec<[f64; 2]> {
        let mut stretches: Vec<[f64; 2]> = Vec::new();
        let mut open = false;
        for angle in Self::angles(travel_rad) {
            let (margin, expanded_u) = self.margin(angle);
            if margin >= expanded_u {
                open = false;
                continue;
            }
            match stretches.last_mut() {
                Some(last) if open => last[1] = angle,
                _ => stretches.push([angle, angle]),
            }
            open = true;
        }
        stretches
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poses(spring: f64) -> Vec<Pose> {
        [-7.0_f64, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0, 87.0]
            .map(|degrees| {
                let angle = degrees.to_radians();
                let net = spring * (angle - 40.0_f64.to_radians()) - 14.0 * angle.cos();
                let stays = net.abs() < 43.0;
                Pose {
                    pose_rad: angle,
                    margin_nm: 43.0 - net.abs(),
                    u_nm: 0.3,
                    net_nm: stays.then_some(net),
                    friction_nm: stays.then_some(43.0),
                }
            })
            .into()
    }

    const TRAVEL: [f64; 2] = [-10.0 * std::f64::consts::PI / 180.0, std::f64::consts::PI / 2.0];

    #[test]
    fn a_soft_spring_holds_everywhere_and_a_stiff_one_names_where_not() {
        let soft = Curve::over(&poses(20.0), None).expect("nine poses");
        assert!(
            soft.remark(TRAVEL).starts_with("Holds itself unpowered over the whole travel -10.0 … 90.0 deg")
        );
        let stiff = Curve::over(&poses(54.0), None).expect("seven poses hold");
        insta::assert_snapshot!(stiff.remark(TRAVEL), @"Does not surely hold itself unpowered at -10.0 … 9.0 deg, 87.0 … 90.0 deg (computed from 7 poses, model [1, cos θ, θ], static friction 43.0 N·m, cogging 0.0 N·m on top of the load; uncertainty counted against it).");
    }

    #[test]
    fn four_poses_give_no_curve() {
        assert!(Curve::over(&poses(20.0)[..4], None).is_none());
    }
}
