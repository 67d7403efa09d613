//! Mailbox messages of the bus and of ethercrab's mapping go to the same stations.

use std::time::Duration;

use drivers::wire::ethercat::EtherCatBus;
use drivers::wire::{EthernetLink, Fieldbus, SdoAbort, SdoRequest, SdoWire};

use super::bench::{SharedLink, settings};

fn serial(bus: &mut EtherCatBus, link: &SharedLink) -> Result<Vec<u8>, SdoAbort> {
    let mut read = Vec::new();
    let begun = link.now();
    bus.start(begun, &SdoRequest { station: 2, index: 0x1018, sub: 4, write: None });
    while !bus.poll(link.now(), &mut read)? {
        assert!(link.now() < begun + Duration::from_secs(1), "a transfer ends by itself");
    }
    Ok(read)
}

#[test]
fn after_any_number_of_transfers_the_bus_is_mapped_and_goes_on_with_transfers() {
    for before in 0..8 {
        let link = SharedLink::new();
        let mut bus = EtherCatBus::open(Box::new(link.clone()), settings()).expect("the line answers");
        let expected = serial(&mut bus, &link);
        for _ in 0..before {
            assert_eq!(serial(&mut bus, &link), expected);
        }
        // A message with the counter of the one before is taken for its repeat and not answered.
        let mapped = bus.map();
        assert!(mapped.is_ok(), "after {} transfers: {mapped:?}", before + 1);
        assert_eq!(serial(&mut bus, &link), expected, "behind the mapping");
    }
}
