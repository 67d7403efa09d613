//! Datagrams as bytes (TS1524 rev. 31, tables 5-13 to 5-22): written here on its own, the driver's reader must agree.

use drivers::stim300::{AccelerometerRange, Content, Input, SpecialKind, checksum};

/// Three sensors of a kind as they go onto the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cluster {
    pub(super) counts: [i32; 3],
    pub(super) status: u8,
}

/// What a measurement says, in counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Body {
    pub(super) gyros: Cluster,
    pub(super) accelerometers: Cluster,
    pub(super) inclinometers: Cluster,
    /// The same temperature for all sensors, 1/256 °C.
    pub(super) temperature: i16,
    /// Status bits that speak of the whole unit.
    pub(super) unit_status: u8,
    /// Time since the last edge of PPS, µs, or counts of AUX.
    pub(super) input: i32,
    pub(super) counter: u8,
    pub(super) latency_us: u16,
}

/// A datagram with its checksum and, if it has one, its line end.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Datagram(Vec<u8>);

/// Identifier of a measurement: 90h to 94h, then A5h to A7h; 8 more with AUX; F0h to F7h with PPS.
fn id(content: Content) -> u8 {
    let place = u8::from(content.accelerometers)
        + 2 * u8::from(content.inclinometers)
        + 4 * u8::from(content.temperatures);
    let block = if place < 5 { 0x90 } else { 0xA0 };
    match content.input {
        Input::None => block + place,
        Input::Pps => 0xF0 + place,
        Input::Aux => block + 8 + place,
    }
}

/// Bytes of a measurement datagram without its line end.
pub(super) fn length(content: Content) -> usize {
    Datagram::measurement(content, &Body::default(), false).0.len()
}

impl Datagram {
    pub(super) fn measurement(content: Content, body: &Body, line_end: bool) -> Self {
        let mut datagram = Self(Vec::with_capacity(65));
        datagram.0.push(id(content));
        datagram.put_cluster(&body.gyros);
        let present = [true, content.accelerometers, content.inclinometers];
        for (cluster, is_present) in
            [&body.accelerometers, &body.inclinometers].into_iter().zip(&present[1..])
        {
            if *is_present {
                datagram.put_cluster(cluster);
            }
        }
        if content.temperatures {
            for _ in present.into_iter().filter(|is_present| *is_present) {
                (0..3).for_each(|_| datagram.0.extend(body.temperature.to_be_bytes()));
                datagram.0.push(body.unit_status);
            }
        }
        if content.input != Input::None {
            datagram.put_i24(body.input);
            datagram.0.push(body.unit_status);
        }
        datagram.0.push(body.counter);
        datagram.0.extend(body.latency_us.to_be_bytes());
        datagram.closed(line_end)
    }

    pub(super) fn special(kind: SpecialKind, payload: &[u8], line_end: bool) -> Self {
        let (plain, with_line_end) = match kind {
            SpecialKind::PartNumber => (0xB1, 0xB3),
            SpecialKind::SerialNumber => (0xB5, 0xB7),
            SpecialKind::Configuration => (0xBC, 0xBD),
            SpecialKind::BiasTrim => (0xD1, 0xD2),
            SpecialKind::ExtendedError => (0xBE, 0xBF),
        };
        let mut datagram = Self(vec![if line_end { with_line_end } else { plain }]);
        datagram.0.extend(payload);
        datagram.closed(line_end)
    }

    fn put_i24(&mut self, value: i32) {
        self.0.extend(&value.to_be_bytes()[1..]);
    }

    fn put_cluster(&mut self, cluster: &Cluster) {
        cluster.counts.iter().for_each(|&count| self.put_i24(count));
        self.0.push(cluster.status);
    }

    fn closed(mut self, line_end: bool) -> Self {
        let crc = checksum(&self.0);
        self.0.extend(crc.to_be_bytes());
        if line_end {
            self.0.extend(b"\r\n");
        }
        self
    }

    pub(super) fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Turns one bit of the last byte of the checksum.
    pub(super) fn spoil_checksum(&mut self, line_end: bool) {
        let place = self.0.len() - if line_end { 3 } else { 1 };
        self.0[place] ^= 1;
    }
}

/// Counts per g of a range.
pub(super) fn counts_per_g(range: AccelerometerRange) -> f64 {
    let power = match range {
        AccelerometerRange::G5 => 20,
        AccelerometerRange::G10 => 19,
        AccelerometerRange::G30 => 18,
        AccelerometerRange::G80 => 16,
    };
    f64::from(1_u32 << power)
}

/// Range in g.
pub(super) fn range_g(range: AccelerometerRange) -> f64 {
    match range {
        AccelerometerRange::G5 => 5.0,
        AccelerometerRange::G10 => 10.0,
        AccelerometerRange::G30 => 30.0,
        AccelerometerRange::G80 => 80.0,
    }
}

/// Part number of the simulated unit: fifteen digits and the revision letter in their half bytes.
pub(super) fn part_number() -> [u8; 15] {
    let d = PART_DIGITS;
    let pair = |high: usize, low: usize| d[high] << 4 | d[low];
    let mut bytes = [0; 15];
    bytes[0] = d[0];
    bytes[1..4].copy_from_slice(&[pair(1, 2), pair(3, 4), b'-']);
    bytes[4..8].copy_from_slice(&[pair(5, 6), pair(7, 8), pair(9, 10), b'-']);
    // Digits 13 and 15 have their upper halves in other bytes: 0 for a figure.
    bytes[8..11].copy_from_slice(&[pair(12, 13), d[14] << 4, d[11]]);
    bytes[14] = b'S';
    bytes
}

/// Serial number of the simulated unit: fourteen digits, and `SIM` in bytes that a real unit does not use.
pub(super) fn serial_number() -> [u8; 15] {
    *b"N\x00\x00\x00\x00\x00\x03\x00SIM\x00\x00\x00\x00"
}

const PART_DIGITS: [u8; 15] = [0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1];
/// The part number in the text of service mode.
pub(super) const PART_NUMBER: &str = "00300-0000000-001 REV S";
/// The serial number in the text of service mode.
pub(super) const SERIAL_NUMBER: &str = "N00000000000300-SIM";
