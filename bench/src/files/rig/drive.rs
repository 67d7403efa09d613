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
                self.mistakes.extend(
                    mistakes.into_iter().filter(|found| !self.mistakes.contains(found)).collect::<Vec<_>>(),
                );
                return None;
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
