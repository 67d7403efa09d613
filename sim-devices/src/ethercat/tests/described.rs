//! What a drive says of its objects.

use super::bench::*;
use super::faults::{RigLine, rig};

/// SDO information of a drive: the body behind its six bytes of header.
fn information(bench: &mut Bench<RigLine>, counter: u8, request: &[u8]) -> Vec<u8> {
    let message = [&[0, 0x80][..], request].concat();
    assert_eq!(bench.post(FIRST, 3 | counter << 4, &message), 1);
    bench.fetch(FIRST).expect("an answer").1[6..].to_vec()
}

#[test]
fn a_drive_tells_types_access_and_names() {
    let mut bench = rig();
    bench.reach_pre_op(FIRST);
    // Index and sub-index; data type, bits, access; readable 7, writable 38h, in PRE-OP 08h, output 40h, input 80h.
    let rows: [(u16, u8, [u8; 3], &str); 10] = [
        (0x6040, 0, [6, 16, 0x7F], "Controlword"),
        (0x6041, 0, [6, 16, 0x87], "Statusword"),
        (0x6060, 0, [2, 8, 0x7F], "Modes of operation"),
        (0x6064, 0, [4, 32, 0x87], "Position actual value"),
        (0x6071, 0, [3, 16, 0x7F], "Target torque"),
        (0x6065, 0, [7, 32, 0x3F], "Following error window"),
        (0x1008, 0, [9, 120, 0x07], "Device name"),
        (0x1018, 1, [7, 32, 0x07], "Sub-index 1"),
        (0x1600, 1, [7, 32, 0x0F], "Sub-index 1"),
        (0x1C12, 0, [5, 8, 0x0F], "Number of entries"),
    ];
    for (k, (index, sub, [data_type, bits, access], name)) in (0_u8..).zip(rows) {
        let [low, high] = index.to_le_bytes();
        let found = information(&mut bench, k % 7 + 1, &[5, 0, 0, 0, low, high, sub, 0]);
        assert_eq!(found[..10], [low, high, sub, 0, data_type, 0, bits, 0, access, 0], "{index:04X}h");
        assert_eq!(found[10..], *name.as_bytes());
    }
}

#[test]
fn lists_are_lists_even_while_they_are_empty() {
    let mut bench = rig();
    bench.reach_pre_op(FIRST);
    let rows: [(u16, [u8; 4], &str); 4] = [
        (0x1001, [5, 0, 0, 7], "Error register"),
        (0x1601, [5, 0, 0, 9], "RxPDO mapping"),
        (0x1C13, [6, 0, 1, 8], "TxPDO assignment"),
        (0x607D, [4, 0, 2, 8], "Software position limit"),
    ];
    for (k, (index, shape, name)) in (1_u8..).zip(rows) {
        let [low, high] = index.to_le_bytes();
        let found = information(&mut bench, k, &[3, 0, 0, 0, low, high]);
        assert_eq!(found[2..6], shape, "{index:04X}h");
        assert_eq!(found[6..], *name.as_bytes());
    }
}

#[test]
fn lists_of_what_outputs_and_inputs_may_hold_are_not_empty() {
    let mut bench = rig();
    bench.reach_pre_op(FIRST);
    let lengths = information(&mut bench, 1, &[1, 0, 0, 0, 0, 0]);
    let length = |k: usize| u16::from_le_bytes([lengths[2 * k], lengths[2 * k + 1]]);
    assert_eq!([0, 1, 2, 3, 4, 5].map(length), [0, 57, 6, 13, 0, 0]);
    let outputs = information(&mut bench, 2, &[1, 0, 0, 0, 2, 0]);
    assert_eq!(outputs[..4], [2, 0, 0x40, 0x60]);
    assert_eq!(outputs.len(), 2 + 2 * 6);
}
