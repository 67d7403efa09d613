//! Nothing that may arrive on a bus takes a node down or moves an axis by itself.

use super::*;

/// Frames near those that mean something, and any others.
fn frames() -> impl Strategy<Value = (u16, Vec<u8>)> {
    let id = prop_oneof![
        Just(0x000),
        Just(0x080),
        Just(0x601),
        (0x201_u16..0x203),
        (0x301_u16..0x303),
        (0x700_u16..0x780),
        0_u16..0x800,
    ];
    let data = prop_oneof![
        prop::collection::vec(any::<u8>(), 0..=8),
        (prop::sample::select(vec![0x01_u8, 0x02, 0x80, 0x81, 0x82]), 0_u8..3).prop_map(|(a, b)| vec![a, b]),
        (0_u8..0x80, 0_u8..4, 0x10_u8..0x1B, 0_u8..4, any::<[u8; 4]>())
            .prop_map(|(command, low, high, sub, [a, b, c, d])| vec![command, low, high, sub, a, b, c, d]),
    ];
    (id, data)
}

proptest! {
    #[test]
    fn no_sequence_of_frames_is_too_strange(frames in prop::collection::vec(frames(), 1..120)) {
        let mut network = Network::silent();
        for (id, data) in &frames {
            network.now += Duration::from_micros(300);
            for sent in network.send(*id, data) {
                prop_assert!(sent.id() < 0x780 && sent.data().len() <= 8);
            }
        }
        // Whatever came before: a reset brings every node back.
        network.line.take(network.now, &frame(0x000, &[0x81, 0]));
        let boots = network.given();
        prop_assert!(boots.contains(&frame(0x701, &[0])) && boots.contains(&frame(0x702, &[0])));
        prop_assert_eq!(network.read(0x1017, 0) & 0xFFFF, 0);
    }
}
