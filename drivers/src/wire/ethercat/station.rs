//! The stations that were found, and the numbers that they go by.

use super::settings::ExpectedStation;

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
    let numbers = |stations: &mut dyn Iterator<Item = u16>| {
        stations.map(|number| number.to_string()).collect::<Vec<_>>().join(", ")
    };
    if found.len() != expected.len() || found.iter().zip(expected).any(|(f, e)| f.station != e.station) {
        return Err(Wrong {
            expected: format!("stations {}", numbers(&mut expected.iter().map(|e| e.station))),
            found: format!("stations {}", numbers(&mut found.iter().map(|f| f.station))),
            help: "check cables, supplies and order, or correct the stations in the rig file",
        });
    }
    found.iter().zip(expected).try_for_each(|(found, expected)| check_identity(found, expected))
}

fn check_identity(found: &StationInfo, expected: &ExpectedStation) -> Result<(), Wrong> {
    let fields = [
        ("vendor", expected.vendor, found.vendor),
        ("product code", expected.product, found.product),
        ("revision", expected.revision, found.revision),
        ("serial number", expected.serial, found.serial),
    ];
    for (name, expected, value) in fields {
        if let Some(wanted) = expected.filter(|wanted| *wanted != value) {
            return Err(Wrong {
                expected: format!("{name} {wanted:08X}h at station {}", found.station),
                found: format!("{value:08X}h ({})", found.name),
                help: "another device is on this place: check the line, or correct the identity in the rig file",
            });
        }
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

    #[test]
    fn other_stations_than_expected_are_named() {
        let expected = |station, product| ExpectedStation { station, product, ..Default::default() };
        let line = [station(1, 0), station(2, 0)];
        assert!(check(&line, &[expected(1, None), expected(2, Some(0x30924))]).is_ok());
        let missing = check(&line, &[expected(1, None)]).expect_err("one too many");
        assert_eq!((missing.expected.as_str(), missing.found.as_str()), ("stations 1", "stations 1, 2"));
        let other = check(&line, &[expected(1, None), expected(2, Some(5))]).expect_err("another product");
        assert_eq!(other.expected, "product code 00000005h at station 2");
        assert_eq!(other.found, "00030924h (Twin)");
    }
}
