//! The simulated unit for one point: as its file says, with the target, the frame rate and the pull that the point asks for.
//!
//! On metal the operator brings the target there, asked by the procedure's prompts; drivers and loop see no difference.

use std::borrow::Cow;

use procedures::case::Case;
use procedures::pull::Pull;
use procedures::target::{Target, TargetCourse};
use sim_devices::operator::PullSettings;
use sim_devices::unit::{TargetSettings, UnitSettings};
use sim_devices::world::AXIS_NAMES;

use crate::model::rig::Rig;

/// A unit with the target of a point before it, its fine camera set as the point asks for; as its file says where the
/// point asks for neither.
pub(crate) fn sim_unit_for_case<'a>(unit: &'a UnitSettings, case: &Case, rig: &Rig) -> Cow<'a, UnitSettings> {
    if case.target.is_none() && case.fine_frame_rate_hz.is_none() && case.pull.is_none() {
        return Cow::Borrowed(unit);
    }
    let mut own = unit.clone();
    if let Some(target) = &case.target {
        own.target = target_settings(&unit.target, target);
    }
    if let Some(rate_hz) = case.fine_frame_rate_hz {
        own.trackers.fine.frame_rate_hz = rate_hz;
    }
    own.pull = case.pull.and_then(|pull| Some(pull_settings(world_axis(rig, &case.axis)?, &pull)));
    Cow::Owned(own)
}

/// Index in the simulated director of an axis of a rig: its drives stand on stations 1 (azimuth) and 2 (elevation).
pub(super) fn world_axis(rig: &Rig, name: &str) -> Option<usize> {
    let axis = rig.axes.iter().find(|axis| axis.name == name)?;
    let index = usize::from(axis.drive.station).checked_sub(1)?;
    (index < AXIS_NAMES.len()).then_some(index)
}

/// The pull that is asked for.
fn pull_settings(axis: usize, pull: &Pull) -> PullSettings {
    let Pull { rate_rad_per_s, begins_s, way_rad, at_most_nm } = *pull;
    PullSettings { axis, rate_rad_per_s, begins_s, way_rad, at_most_nm }
}

/// The course and place that are asked for; how a rail or a drone moves is the unit file's.
fn target_settings(of_unit: &TargetSettings, target: &Target) -> TargetSettings {
    let mut settings = TargetSettings {
        azimuth_rad: target.azimuth_rad,
        elevation_rad: target.elevation_rad,
        standing_s: target.stands_s,
        ..of_unit.clone()
    };
    settings.kind_count = match target.course {
        TargetCourse::Star => 0.0,
        TargetCourse::Rail => 1.0,
        TargetCourse::Drone => 2.0,
        TargetCourse::Sweep { azimuth_rad_per_s, elevation_rad_per_s, leg_s, turn_s } => {
            settings.sweep_azimuth_rate_rad_per_s = azimuth_rad_per_s;
            settings.sweep_elevation_rate_rad_per_s = elevation_rad_per_s;
            (settings.sweep_leg_s, settings.sweep_turn_s) = (leg_s, turn_s);
            3.0
        }
    };
    settings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::rig::read_rig;
    use crate::files::shipped::{self, Folder};

    fn rig() -> Rig {
        read_rig(shipped::find(Folder::Rigs, "sim", None).expect("shipped")).expect("a shipped rig parses")
    }

    #[test]
    fn a_point_brings_its_target_before_a_unit_that_stays_as_it_is() {
        let unit = UnitSettings::default();
        let course = TargetCourse::Sweep {
            azimuth_rad_per_s: 0.0,
            elevation_rad_per_s: 0.1,
            leg_s: 20.0,
            turn_s: 5.0,
        };
        let target = Target { course, azimuth_rad: 0.2, elevation_rad: 0.7, stands_s: 9.0 };
        let case = Case { target: Some(target), ..Case::default() };
        let own = sim_unit_for_case(&unit, &case, &rig()).into_owned();
        let t = &own.target;
        assert_eq!((t.kind_count, t.sweep_elevation_rate_rad_per_s, t.sweep_turn_s), (3.0, 0.1, 5.0));
        assert_eq!((t.azimuth_rad, t.elevation_rad, t.standing_s), (0.2, 0.7, 9.0));
        assert_eq!(UnitSettings { target: unit.target.clone(), ..own }, unit);
    }

    #[test]
    fn a_point_may_ask_for_another_frame_rate_alone() {
        let unit = UnitSettings::default();
        let case = Case { fine_frame_rate_hz: Some(100.0), ..Case::default() };
        let own = sim_unit_for_case(&unit, &case, &rig()).into_owned();
        assert_eq!((own.trackers.fine.frame_rate_hz, own.trackers.coarse.frame_rate_hz), (100.0, 50.0));
        assert_eq!(own.target, unit.target);
    }

    #[test]
    fn a_point_without_a_target_leaves_the_unit_file_s() {
        let mut unit = UnitSettings::default();
        unit.target.kind_count = 2.0;
        assert_eq!(sim_unit_for_case(&unit, &Case::default(), &rig()).target.kind_count, 2.0);
    }
}
