//! Rows as CDR, the encoding of ROS 2 messages (OMG DDSI-RTPS 2.5 §10, "plain CDR" XCDR1).
//!
//! A payload is four bytes of encapsulation (`00 01 00 00`: CDR, little endian) and then the fields in order, each
//! aligned to its own size counted from behind the encapsulation. All fields are scalars, so every row of a topic has
//! the same layout: offsets are computed once.

use super::broken::Broken;
use super::{Channel, Width};

/// Encapsulation: representation CDR_LE, no options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

impl Width {
    /// Bytes of one value.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::F64 => 8,
            Self::F32 | Self::I32 | Self::U32 => 4,
            Self::U16 => 2,
            Self::I8 => 1,
        }
    }
}

/// Where each channel of a topic lies in its payload.
#[derive(Debug)]
pub(super) struct Layout {
    fields: Vec<(Width, usize)>,
    size_bytes: usize,
}

impl Layout {
    /// The layout of a message with these channels in this order.
    pub(super) fn new(channels: &[Channel]) -> Self {
        let mut end = 0_usize;
        let mut fields = Vec::with_capacity(channels.len());
        for channel in channels {
            let start = end.next_multiple_of(channel.width.bytes());
            fields.push((channel.width, ENCAPSULATION.len() + start));
            end = start + channel.width.bytes();
        }
        Self { fields, size_bytes: ENCAPSULATION.len() + end }
    }

    /// Values in a row.
    pub(super) fn channel_count(&self) -> usize {
        self.fields.len()
    }

    /// A payload with everything that no row changes: encapsulation and padding.
    pub(super) fn blank(&self) -> Vec<u8> {
        let mut payload = vec![0; self.size_bytes];
        payload[..ENCAPSULATION.len()].copy_from_slice(&ENCAPSULATION);
        payload
    }

    /// Puts the values of a row into a payload made by [`Layout::blank`]; `values` is as long as there are channels.
    pub(super) fn encode(&self, values: &[f64], payload: &mut [u8]) {
        for (&(width, at), &value) in self.fields.iter().zip(values) {
            match width {
                Width::F64 => put(payload, at, value.to_le_bytes()),
                Width::F32 => put(payload, at, (value as f32).to_le_bytes()),
                Width::I32 => put(payload, at, (nearest(value) as i32).to_le_bytes()),
                Width::U32 => put(payload, at, (nearest(value) as u32).to_le_bytes()),
                Width::U16 => put(payload, at, (nearest(value) as u16).to_le_bytes()),
                Width::I8 => put(payload, at, (nearest(value) as i8).to_le_bytes()),
            }
        }
    }

    /// Appends the values of a payload to the columns, one column a channel.
    ///
    /// # Errors
    /// When the payload is not of this layout; the columns are then as before.
    pub(super) fn decode(&self, payload: &[u8], columns: &mut [Vec<f64>]) -> Result<(), Broken> {
        if payload.len() != self.size_bytes {
            return Err(Broken::RowBytes { expected: self.size_bytes, found: payload.len() });
        }
        if !payload.starts_with(&ENCAPSULATION) {
            return Err(Broken::Encapsulation { expected: ENCAPSULATION, found: bytes_at(payload, 0) });
        }
        for (&(width, at), column) in self.fields.iter().zip(columns) {
            column.push(match width {
                Width::F64 => f64::from_le_bytes(bytes_at(payload, at)),
                Width::F32 => f64::from(f32::from_le_bytes(bytes_at(payload, at))),
                Width::I32 => f64::from(i32::from_le_bytes(bytes_at(payload, at))),
                Width::U32 => f64::from(u32::from_le_bytes(bytes_at(payload, at))),
                Width::U16 => f64::from(u16::from_le_bytes(bytes_at(payload, at))),
                Width::I8 => f64::from(i8::from_le_bytes(bytes_at(payload, at))),
            });
        }
        Ok(())
    }
}

/// The nearest whole number (ties away from zero), 0 for NaN; beyond ±2⁶³ it saturates.
///
/// What `f64::round` does, without its call into the mathematics library: this runs for every narrow field of every row.
fn nearest(value: f64) -> f64 {
    let whole = value as i64 as f64;
    let fraction = value - whole;
    whole + f64::from(i8::from(fraction >= 0.5) - i8::from(fraction <= -0.5))
}

/// Puts `N` bytes into a payload that is as long as its layout says.
fn put<const N: usize>(payload: &mut [u8], at: usize, bytes: [u8; N]) {
    payload[at..at + N].copy_from_slice(&bytes);
}

/// `N` bytes of a payload that is as long as its layout says.
fn bytes_at<const N: usize>(payload: &[u8], at: usize) -> [u8; N] {
    payload[at..at + N].try_into().expect("a slice of N bytes is an array of N bytes")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn channels(widths: &[Width]) -> Vec<Channel> {
        let channel =
            |(k, &width): (usize, &Width)| Channel { name: format!("c{k}"), unit: String::new(), width };
        widths.iter().enumerate().map(channel).collect()
    }

    fn round_trip(width: Width, value: f64) -> f64 {
        let layout = Layout::new(&channels(&[width]));
        let mut payload = layout.blank();
        layout.encode(&[value], &mut payload);
        let mut columns = [Vec::new()];
        layout.decode(&payload, &mut columns).expect("the payload was written with this layout");
        columns[0][0]
    }

    #[test]
    fn alignment_counts_from_behind_the_encapsulation() {
        use Width::{F64, I8, U16};
        let layout = Layout::new(&channels(&[I8, U16, I8, F64, I8]));
        let offsets: Vec<usize> = layout.fields.iter().map(|f| f.1 - 4).collect();
        assert_eq!(offsets, [0, 2, 4, 8, 16]);
        assert_eq!(layout.blank().len(), 4 + 17);
    }

    #[test]
    fn a_row_is_the_bytes_that_ros_2_writes() {
        let layout = Layout::new(&channels(&[Width::F64, Width::I8, Width::U16]));
        let mut payload = layout.blank();
        layout.encode(&[1.0, -2.0, 513.0], &mut payload);
        assert_eq!(payload, [0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0xfe, 0, 1, 2]);
    }

    #[test]
    fn integers_round_to_nearest_saturate_and_have_no_nan() {
        assert_eq!(round_trip(Width::I32, -1.5), -2.0);
        assert_eq!(round_trip(Width::I32, 1e12), 2_147_483_647.0);
        assert_eq!(round_trip(Width::U32, -3.0), 0.0);
        assert_eq!(round_trip(Width::U32, 4_294_967_295.0), 4_294_967_295.0);
        assert_eq!(round_trip(Width::U16, 65_535.4), 65_535.0);
        assert_eq!(round_trip(Width::I8, -129.0), -128.0);
        for width in [Width::I32, Width::U32, Width::U16, Width::I8] {
            assert_eq!(round_trip(width, f64::NAN), 0.0);
        }
        assert!(round_trip(Width::F32, f64::NAN).is_nan());
        assert_eq!(round_trip(Width::F32, 1e40), f64::INFINITY);
    }

    #[test]
    fn payloads_of_another_layout_are_refused_and_leave_the_columns_alone() {
        let layout = Layout::new(&channels(&[Width::F64]));
        let mut columns = [vec![7.0]];
        let short = layout.decode(&[0, 1, 0, 0, 1], &mut columns).expect_err("eight bytes are missing");
        assert_eq!(short.to_string(), "expected a row of 12 bytes, found 5");
        let mut big_endian = layout.blank();
        big_endian[1] = 0;
        let order = layout.decode(&big_endian, &mut columns).expect_err("this is CDR_BE");
        assert_eq!(order.to_string(), "expected encapsulation [00, 01, 00, 00], found [00, 00, 00, 00]");
        assert_eq!(columns[0], [7.0]);
    }

    proptest! {
        #[test]
        fn nearest_is_round(value in prop_oneof![-1e17..1e17, -300.0..300.0, (-600_i32..600).prop_map(|h| f64::from(h) / 2.0)]) {
            prop_assert_eq!(nearest(value), value.round());
            let below_half = 0.5_f64.next_down();
            prop_assert_eq!((nearest(below_half), nearest(-below_half)), (0.0, 0.0));
        }

        #[test]
        fn every_double_survives(bits: u64) {
            let value = f64::from_bits(bits);
            prop_assert_eq!(round_trip(Width::F64, value).to_bits(), bits);
        }

        #[test]
        fn every_integer_of_the_width_survives(value: i32, count: u32, status: u16, mode: i8) {
            prop_assert_eq!(round_trip(Width::I32, f64::from(value)), f64::from(value));
            prop_assert_eq!(round_trip(Width::U32, f64::from(count)), f64::from(count));
            prop_assert_eq!(round_trip(Width::U16, f64::from(status)), f64::from(status));
            prop_assert_eq!(round_trip(Width::I8, f64::from(mode)), f64::from(mode));
        }
    }
}
