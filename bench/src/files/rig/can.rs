//! A CAN bus of the drives: whether their frames fit into a period, and whether each drive stops without them.

use drivers::cia402::profile::DriveProfile;
use drivers::wire::canopen::shortest_cycle_s;
use procedures::table::TableReader;

use crate::model::axis::RigAxis;
use crate::model::rig::CanBus;

/// Key of the bit rate.
pub(super) const BIT_RATE: &str = "can-bit-rate";
/// Bit rates of CiA 301, bit/s.
const BIT_RATES: [i64; 8] = [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

/// The bus; `None` for drives that are not on CAN, or a bit rate that is none.
pub(super) fn read(
    t: &mut TableReader<'_>,
    is_can: bool,
    axes: Option<&[RigAxis]>,
    cycle_s: Option<f64>,
) -> Option<CanBus> {
    let is_given = t.has(BIT_RATE);
    let bit_rate = t.integer(BIT_RATE, 1)?;
    if !is_can {
        if is_given {
            let help = "leave it out, or give each axis `ports = { bus = \"can:can0/5\" }`".to_owned();
            t.mistake(BIT_RATE, "no drive of this rig is on a CAN bus", Some(help));
        }
        return None;
    }
    if !BIT_RATES.contains(&bit_rate) {
        let known: Vec<String> = BIT_RATES.iter().map(i64::to_string).collect();
        let help = format!("CiA 301 has {} bit/s", known.join(", "));
        t.mistake(BIT_RATE, format!("`{BIT_RATE}` is {bit_rate}"), Some(help));
        return None;
    }
    let bit_rate_hz = bit_rate as f64;
    if let Some(axes) = axes {
        check_watchdogs(t, axes);
        check_load(t, axes, bit_rate_hz, cycle_s);
    }
    Some(CanBus { bit_rate_hz })
}

/// On CAN nothing but the drive itself notices that process data stay out.
fn check_watchdogs(t: &mut TableReader<'_>, axes: &[RigAxis]) {
    for axis in axes.iter().filter(|axis| axis.drive.profile.watchdog.is_none()) {
        let message = format!(
            "the drive of `{}` is on a CAN bus, and profile `{}` names no watchdog of its process data",
            axis.name, axis.drive.profile.id
        );
        let help = "a CAN bus has no watchdog: without one in the drive it would go on with its last command when the bench falls \
                    silent; copy the profile and name the vendor's object in `[watchdog]`";
        t.mistake("axis", message, Some(help.to_owned()));
    }
}

/// Refuses a rate of the loop at which the frames of all drives do not fit into a period.
fn check_load(t: &mut TableReader<'_>, axes: &[RigAxis], bit_rate_hz: f64, cycle_s: Option<f64>) {
    let profiles: Vec<&DriveProfile> = axes.iter().map(|axis| &*axis.drive.profile).collect();
    let shortest_s = match shortest_cycle_s(&profiles, bit_rate_hz) {
        Ok(shortest_s) => shortest_s,
        Err(why) => {
            t.mistake("axis", format!("a drive cannot be on a CAN bus: {why}"), None);
            return;
        }
    };
    let Some(cycle_s) = cycle_s.filter(|cycle_s| *cycle_s < shortest_s) else { return };
    let message = format!(
        "the frames of {} drives need a period of at least {:.3} ms at {} kbit/s, `loop-rate` leaves {:.3} ms",
        axes.len(),
        shortest_s * 1e3,
        bit_rate_hz / 1e3,
        cycle_s * 1e3
    );
    let help = format!(
        "lower `loop-rate` to at most {:.0} Hz, or raise the bit rate of the bus: process data may fill 90 % of a period",
        (1.0 / shortest_s).floor()
    );
    t.mistake("loop-rate", message, Some(help));
}

#[cfg(test)]
mod tests {
    use super::super::read_rig;
    use super::super::tests::told;
    use crate::files::profile::simulated;
    use crate::files::shipped::{self, Folder};
    use crate::model::rig::{CanBus, Rig, Tier};
    use procedures::diagnostic::{Diagnostic, SourceFile};

    /// The shipped rig on CAN after these replacements, each of the first place where the text stands.
    fn read(edits: &[(&str, &str)]) -> Result<Rig, Vec<Diagnostic>> {
        let mut text = shipped::find(Folder::Rigs, "can", None).expect("a shipped rig").text;
        for (old, new) in edits {
            assert!(text.contains(old), "the rig file no longer says {old}");
            text = text.replacen(old, new, 1);
        }
        read_rig(SourceFile::new("rig.toml", text))
    }

    fn said(edits: &[(&str, &str)]) -> String {
        told(&read(edits).err().unwrap_or_default())
    }

    #[test]
    fn a_rig_on_can_names_interface_and_nodes_and_is_rehearsed_on_the_same_bus() {
        let rig =
            read(&[("can:can0/2", "can:can0/5")]).unwrap_or_else(|mistakes| panic!("{}", told(&mistakes)));
        let stations = |rig: &Rig| rig.axes.iter().map(|axis| axis.drive.station).collect::<Vec<_>>();
        assert_eq!((rig.interface(), rig.can), (Some("can0"), Some(CanBus { bit_rate_hz: 1e6 })));
        assert_eq!((stations(&rig), rig.follows_sync0), (vec![1, 5], false));
        let rehearsed = rig.rehearsed_on(Tier::Virtual, &simulated());
        assert_eq!((rehearsed.interface(), rehearsed.can, stations(&rehearsed)), (None, rig.can, vec![1, 2]));
    }

    #[test]
    fn a_loop_rate_that_the_bit_rate_cannot_carry_is_refused_with_the_numbers() {
        let rate = "loop-rate = \"500 Hz\"";
        let error = said(&[(rate, "loop-rate = \"1 kHz\"")]);
        assert!(error.contains("need a period of at least 1.639 ms at 1000 kbit/s"), "{error}");
        assert!(error.contains("leaves 1.000 ms") && error.contains("at most 610 Hz"), "{error}");
        let error = said(&[(rate, "loop-rate = \"500 Hz\"\ncan-bit-rate = 500000")]);
        assert!(error.contains("3.278 ms at 500 kbit/s") && error.contains("leaves 2.000 ms"), "{error}");
        let error = said(&[(rate, "loop-rate = \"500 Hz\"\ncan-bit-rate = 750000")]);
        assert!(
            error.contains("`can-bit-rate` is 750000") && error.contains("800000, 1000000 bit/s"),
            "{error}"
        );
    }

    #[test]
    fn a_drive_on_can_needs_a_watchdog_of_its_own_and_a_mapping() {
        let bus = "ports = { bus = \"can:can0/1\" }";
        let with = |profile: &str| said(&[(bus, &format!("{bus}\nprofile = \"{profile}\""))]);
        let error = with("generic-cia402");
        assert!(error.contains("profile `generic-cia402` names no watchdog of its process data"), "{error}");
        let error = with("elmo-gold");
        assert!(error.contains("profile `elmo-gold`: its PDOs are fixed"), "{error}");
    }

    #[test]
    fn drives_of_one_rig_are_on_one_sort_of_bus() {
        let error = said(&[("can:can0/2", "ethercat:can0/2")]);
        assert!(error.contains("one drive is on EtherCAT, another one on a CAN bus"), "{error}");
        let error = said(&[("can:can0/2", "can:can0/127")]);
        assert!(error.contains("127 is the bench's own"), "{error}");
    }
}
