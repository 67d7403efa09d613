//! What the drive of an axis is told, and which type it is of.

use std::sync::Arc;

use drivers::cia402::DriveSettings;
use drivers::cia402::profile::DriveProfile;
use procedures::diagnostic::Diagnostic;
use procedures::table::TableReader;

use super::counts_per_rev;
use crate::files::profile::{self, GENERIC, SIMULATED};
use crate::model::rig::Tier;
use crate::model::safety::Safety;

/// Drives while the axes are read.
#[derive(Default)]
pub(super) struct Drives {
    /// What is wrong in profiles, which are files of their own.
    pub(super) mistakes: Vec<Diagnostic>,
}

impl Drives {
    /// Reads what stands about the drive in the table of an axis.
    pub(super) fn read(
        &mut self,
        t: &mut TableReader<'_>,
        name: &str,
        tier: Option<Tier>,
        cycle_s: Option<f64>,
        safety: Option<&Safety>,
        station: Option<u16>,
    ) -> Option<DriveSettings> {
        let profile = self.profile(t, tier, cycle_s);
        let safety = safety?;
        Some(DriveSettings {
            name: name.to_owned(),
            station: station?,
            profile: profile?,
            torque_constant_nm_per_a: t.positive("torque-constant")?,
            rated_current_a: t.positive("rated-current")?,
            rated_torque_nm: t.positive("rated-torque")?,
            max_torque_nm: t.positive("max-torque")?,
            encoder_counts_per_rev: counts_per_rev(t.integer("encoder-bits", 8)?),
            encoder_offset_rad: t.quantity("encoder-offset")?,
            encoder_sign: if t.text("encoder-sign")? == "-" { -1.0 } else { 1.0 },
            soft_limits_rad: t.range("soft-limits")?,
            max_velocity_rad_per_s: safety.trip_velocity_rad_per_s,
            quick_stop_deceleration_rad_per_s2: safety.braking_deceleration_rad_per_s2,
            // Ramp down, then stay in quick stop active with torque on: an axis is released by `make_safe` alone, where
            // friction holds it.
            quick_stop_option: 6,
            fault_reaction_option: 2,
            abort_connection_option: 3,
            watchdog_s: safety.watchdog_s,
            cycle_s: cycle_s?,
            transition_timeout_s: 2.0,
        })
    }

    /// The profile that an axis names, with the start-up entries of its own behind those of the profile.
    fn profile(
        &mut self,
        t: &mut TableReader<'_>,
        tier: Option<Tier>,
        cycle_s: Option<f64>,
    ) -> Option<Arc<DriveProfile>> {
        let written = t.has("profile").then(|| t.text("profile")).flatten();
        let usual = if tier == Some(Tier::Hardware) { GENERIC } else { SIMULATED };
        let name = written.as_deref().unwrap_or(usual);
        let found = match profile::load(name, Some(&t.source().name)) {
            Ok(found) => found,
            Err(mistakes) => {
                let new = mistakes.into_iter().filter(|found| !self.mistakes.contains(found));
                let new: Vec<Diagnostic> = new.collect();
                self.mistakes.extend(new);
                // The rest of the rig is checked all the same.
                return Some(profile::simulated());
            }
        };
        let in_process = tier.is_some_and(|tier| !tier.is_wired());
        if in_process && found.id != SIMULATED {
            let message = format!("profile `{}` is not that of the drives in this process", found.id);
            let help = "leave `profile` out on tiers `virtual` and `paced`; `--tier virtual` rehearses a rig of another tier";
            t.mistake("profile", message, Some(help.to_owned()));
        }
        if let Some((shortest_s, cycle_s)) = found.clock.shortest_cycle_s.zip(cycle_s)
            && cycle_s < shortest_s * (1.0 - 1e-9)
        {
            let message = format!(
                "a drive of profile `{}` follows cycles of {} us and longer, `loop-rate` asks for {} us",
                found.id,
                shortest_s * 1e6,
                cycle_s * 1e6
            );
            t.mistake("profile", message, Some("lower `loop-rate`".to_owned()));
        }
        if !t.has("start-up") {
            return Some(found);
        }
        let own = t.tables("start-up", profile::read_start_up)?;
        let own = profile::check_start_up(t, &found, own);
        let start_up = [found.start_up.clone(), own].concat();
        Some(Arc::new(DriveProfile { start_up, ..(*found).clone() }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_rig;
    use super::super::tests::told;
    use crate::files::profile::simulated;
    use crate::files::shipped::{self, Folder};
    use crate::model::rig::{Rig, Tier};
    use procedures::diagnostic::{Diagnostic, SourceFile};

    /// A shipped rig after these replacements, each of the first place where the text stands.
    fn read(rig: &str, edits: &[(&str, &str)]) -> Result<Rig, Vec<Diagnostic>> {
        let mut text = shipped::find(Folder::Rigs, rig, None).expect("a shipped rig").text;
        for (old, new) in edits {
            assert!(text.contains(old), "the rig file no longer says {old}");
            text = text.replacen(old, new, 1);
        }
        read_rig(SourceFile::new("rig.toml", text))
    }

    const BUS: &str = "ports = { bus = \"ethercat:ecm/1\" }";

    fn with(lines: &str) -> (&'static str, String) {
        (BUS, format!("{BUS}\n{lines}"))
    }

    fn said(rig: &str, edits: &[(&str, &str)]) -> String {
        told(&read(rig, edits).err().unwrap_or_default())
    }

    #[test]
    fn drives_that_are_simulated_have_their_profile_and_those_of_hardware_the_generic_one() {
        let profiles = |rig: Result<Rig, Vec<Diagnostic>>| {
            let rig = rig.unwrap_or_else(|mistakes| panic!("{}", told(&mistakes)));
            rig.axes.iter().map(|axis| axis.drive.profile.id.clone()).collect::<Vec<_>>()
        };
        assert_eq!(profiles(read("sim", &[])), ["simulated"; 2]);
        assert_eq!(profiles(read("wired", &[])), ["simulated"; 2]);
        let hardware = ("tier = \"wired\"", "tier = \"hardware\"");
        assert_eq!(profiles(read("wired", &[hardware])), ["generic-cia402"; 2]);
        let (old, new) = with("profile = \"elmo-gold\"");
        assert_eq!(profiles(read("wired", &[(old, &new)])), ["elmo-gold", "simulated"]);
    }

    #[test]
    fn a_rig_that_is_rehearsed_in_process_has_the_drives_of_this_process() {
        let (old, new) = with("profile = \"elmo-gold\"");
        let rig = read("wired", &[(old, &new)]).expect("it parses");
        let quantum = rig.axes[0].limits.torque_quantum_nm;
        assert!((quantum - 0.12).abs() < 1e-12, "2 A at 60 N*m/A: {quantum}");
        let rehearsed = rig.rehearsed_on(Tier::Virtual, &simulated());
        assert!(rehearsed.axes.iter().all(|axis| axis.drive.profile.id == "simulated"));
    }

    #[test]
    fn an_axis_may_demand_a_serial_number_and_add_to_the_start_up_list() {
        let lines = "profile = \"elmo-gold\"\nserial = 0x00B9B366\nstart-up = [{ object = \"10F1h:02\", type = \"u32\", \
                     value = 4, why = \"four lost SYNC0\" }]";
        let (old, new) = with(lines);
        let rig = read("wired", &[(old, &new)]).unwrap_or_else(|mistakes| panic!("{}", told(&mistakes)));
        let list = &rig.axes[0].drive.profile.start_up;
        let written: Vec<_> =
            list.iter().map(|entry| (entry.place.index, entry.place.sub, entry.value)).collect();
        assert_eq!(written, [(0x1C32, 1, 2), (0x1C33, 1, 2), (0x10F1, 2, 4)]);
        assert_eq!((rig.axes[0].serial, rig.axes[1].serial), (Some(0x00B9_B366), None));
    }

    #[test]
    fn profiles_that_are_none_that_do_not_fit_the_tier_or_are_too_slow_are_refused() {
        let (old, new) = with("profile = \"elmo-glod\"");
        insta::assert_snapshot!(said("wired", &[(old, &new)]));
        let (old, new) = with("profile = \"wired\"");
        insta::assert_snapshot!(said("wired", &[(old, &new)]));
        insta::assert_snapshot!(said("sim", &[("station = 1", "station = 1\nprofile = \"elmo-gold\"")]));
        let (old, new) = with("profile = \"elmo-gold\"");
        let fast = ("loop-rate = \"1 kHz\"", "loop-rate = \"5 kHz\"");
        insta::assert_snapshot!(said("wired", &[(old, &new), fast]));
        let entry = "start-up = [{ object = \"6072h\", type = \"u16\", value = 1, why = \"no\" }]";
        let (old, new) = with(entry);
        insta::assert_snapshot!(said("wired", &[(old, &new)]));
    }
}
