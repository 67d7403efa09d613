//! The stations that were found, and the numbers that they go by.

use super::settings::ExpectedStation;
use crate::identity_range::IdentityRange;

/// A SubDevice as it was found on the bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationInfo {
    /// The number by which rig files and drivers call it: its alias where it has one (register 0012h is not 0), else its
    /// position on the line, the first being 1.
    pub station: u16,
    /// Position on the line, the first being 1.
    pub position: u16,
    /// Address that was given to it for this session.
    pub configured_address: u16,
    /// Alias; 0 if it has none.
    pub alias: u16,
    /// Name out of its SII.
    pub name: String,
    /// Vendor.
    pub vendor: u32,
    /// Product code.
    pub product: u32,
    /// Revision.
    pub revision: u32,
    /// Serial number.
    pub serial: u32,
    /// Whether it has a distributed clock that can make SYNC0.
    pub has_sync0: bool,
    /// Whether it has a mailbox.
    pub has_mailbox: bool,
}

impl StationInfo {
    /// The number that a station goes by.
    pub(super) const fn number(alias: u16, position: u16) -> u16 {
        if alias == 0 { position } else { alias }
    }
}

/// What is wrong with the stations that were found; expected, found and what to do.
pub(super) struct Wrong {
    pub(super) expected: String,
    pub(super) found: String,
    pub(super) help: &'static str,
}

/// Refuses stations that go by the same number, and stations other than expected.
pub(super) fn check(found: &[StationInfo], expected: &[ExpectedStation]) -> Result<(), Wrong> {
    for (k, station) in found.iter().enumerate() {
        if let Some(other) = found[..k].iter().find(|other| other.station == station.station) {
            return Err(Wrong {
                expected: "every alias once, and no alias equal to the position of a station without one"
                    .to_owned(),
                found: format!(
                    "number {} at positions {} and {}",
                    station.station, other.position, station.position
                ),
                help: "give one of the two another alias",
            });
        }
    }
    if expected.is_empty() {
        return Ok(());
    }
    let listed = |texts: Vec<String>| if texts.is_empty() { "none".to_owned() } else { texts.join(", ") };
    let is_expected = |found: &&StationInfo| expected.iter().any(|e| e.station == found.station);
    let is_found = |expected: &&ExpectedStation| found.iter().any(|f| f.station == expected.station);
    let missing: Vec<String> = expected.iter().filter(|e| !is_found(e)).map(who_needs).collect();
    let others: Vec<String> = found.iter().filter(|f| !is_expected(f)).map(who_is).collect();
    if missing.is_empty() && others.is_empty() {
        return found.iter().try_for_each(|found| check_identity(found, expected));
    }
    let help = match (missing.is_empty(), others.is_empty()) {
        (false, true) => "check its supply and the cables in front of it, or its address in the rig file",
        (true, _) => "take it off the line, or add it to the rig file as a `[[terminal]]`",
        (false, false) => "check cables, supplies and aliases, or correct the addresses in the rig file",
    };
    Err(match missing.is_empty() {
        true => Wrong { expected: "no other station".to_owned(), found: listed(others), help },
        false => Wrong {
            expected: format!("{} on the line", listed(missing)),
            found: match others.is_empty() {
                true => format!(
                    "stations {} alone",
                    listed(found.iter().map(|f| f.station.to_string()).collect())
                ),
                false => format!("{} instead", listed(others)),
            },
            help,
        },
    })
}

fn who_needs(expected: &ExpectedStation) -> String {
    match expected.name.is_empty() {
        true => format!("station {}", expected.station),
        false => format!("station {} ({})", expected.station, expected.name),
    }
}

fn who_is(found: &StationInfo) -> String {
    let StationInfo { station, name, vendor, product, serial, .. } = found;
    format!("station {station} ({name}, vendor {vendor:08X}h, product {product:08X}h, serial {serial:08X}h)")
}

/// Refuses a station that is another device than the one that is expected under its number.
fn check_identity(found: &StationInfo, all: &[ExpectedStation]) -> Result<(), Wrong> {
    let Some(expected) = all.iter().find(|expected| expected.station == found.station) else { return Ok(()) };
    let fields = [
        ("vendor", expected.vendor.map(IdentityRange::one), found.vendor),
        ("product code", expected.product.map(IdentityRange::one), found.product),
        ("revision", expected.revisions.map(IdentityRange), found.revision),
        ("serial number", expected.serial.map(IdentityRange::one), found.serial),
    ];
    for (name, wanted, value) in fields {
        let Some(wanted) = wanted.filter(|wanted| !wanted.contains(value)) else { continue };
        // A serial number that belongs elsewhere tells of swapped cables.
        let belongs = all.iter().find(|other| name == "serial number" && other.serial == Some(value));
        return Err(Wrong {
            expected: format!("{name} {wanted} at {}", who_needs(expected)),
            found: match belongs {
                Some(other) => {
                    format!("{value:08X}h ({}), which belongs at {}", found.name, who_needs(other))
                }
                None => format!("{value:08X}h ({})", found.name),
            },
            help: match belongs {
                Some(_) => "devices or cables are swapped: restore the order of the line",
                None => {
                    "another device is at this address: check the line, or correct the identity in the rig file"
                }
            },
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn station(position: u16, alias: u16) -> StationInfo {
        StationInfo {
            station: StationInfo::number(alias, position),
            position,
            configured_address: 0x0FFF + position,
            alias,
            name: "Twin".to_owned(),
            vendor: 0x9A,
            product: 0x30924,
            revision: 1,
            serial: 7,
            has_sync0: true,
            has_mailbox: true,
        }
    }

    #[test]
    fn an_alias_goes_before_the_position() {
        assert_eq!([station(1, 0).station, station(2, 1001).station], [1, 1001]);
        assert!(check(&[station(1, 0), station(2, 1001)], &[]).is_ok());
        let twice = check(&[station(1, 2), station(2, 0)], &[]).expect_err("both are 2");
        assert_eq!(twice.found, "number 2 at positions 1 and 2");
    }

    fn expected(station: u16, name: &str) -> ExpectedStation {
        ExpectedStation { station, name: name.to_owned(), ..Default::default() }
    }

    /// Expected and found, as the message has them.
    fn wrong(found: &[StationInfo], expected: &[ExpectedStation]) -> [String; 2] {
        let wrong = check(found, expected).expect_err("another line than expected");
        [wrong.expected, wrong.found]
    }

    #[test]
    fn a_missing_an_extra_and_another_station_are_named() {
        let line = [station(1, 0), station(2, 1001)];
        let [az, el] = [expected(1, "az"), expected(1001, "el")];
        assert!(check(&line, &[el.clone(), az.clone()]).is_ok(), "the order of the rig file does not matter");
        let card = expected(3, "reference");
        let missing = wrong(&line, &[az.clone(), el, card.clone()]);
        assert_eq!(missing, ["station 3 (reference) on the line", "stations 1, 1001 alone"]);
        let extra = wrong(&line, std::slice::from_ref(&az));
        let twin = "station 1001 (Twin, vendor 0000009Ah, product 00030924h, serial 00000007h)";
        assert_eq!(extra, ["no other station", twin]);
        let another = wrong(&line, &[az, card]);
        assert_eq!(another, ["station 3 (reference) on the line".to_owned(), format!("{twin} instead")]);
    }

    #[test]
    fn another_product_and_a_revision_out_of_range_are_named() {
        let line = [station(1, 0), station(2, 0)];
        let product = ExpectedStation { product: Some(5), ..expected(2, "el") };
        let found = wrong(&line, &[expected(1, "az"), product]);
        assert_eq!(found, ["product code 00000005h at station 2 (el)", "00030924h (Twin)"]);
        let revisions = |range| ExpectedStation { revisions: Some(range), ..expected(2, "el") };
        assert!(check(&line, &[expected(1, "az"), revisions([0, 1])]).is_ok());
        let found = wrong(&line, &[expected(1, "az"), revisions([2, 3])]);
        assert_eq!(found[0], "revision 00000002h to 00000003h at station 2 (el)");
    }

    #[test]
    fn swapped_drives_are_told_by_their_serial_numbers() {
        let serial =
            |name, station, serial| ExpectedStation { serial: Some(serial), ..expected(station, name) };
        let line = [StationInfo { serial: 11, ..station(1, 0) }, StationInfo { serial: 10, ..station(2, 0) }];
        let found = wrong(&line, &[serial("az", 1, 10), serial("el", 2, 11)]);
        assert_eq!(found[0], "serial number 0000000Ah at station 1 (az)");
        assert_eq!(found[1], "0000000Bh (Twin), which belongs at station 2 (el)");
    }
}
