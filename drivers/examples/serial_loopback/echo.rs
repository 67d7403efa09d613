//! Numbered frames out, and what comes back of them.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::ByteLine;
use drivers::wire::lines::{LineAddress, Lines};

use super::clock;

/// Bytes of a frame: mark, number, filling, checksum.
const FRAME_BYTES: usize = 36;
const MARK: [u8; 4] = [0xFE, 0x81, 0xFF, 0x55];
/// Bits of a character: start, eight data bits, stop.
const BITS_PER_BYTE: f64 = 10.0;
/// Pause between two frames as a share of the time of one on the wire.
const SPACING: f64 = 1.25;
const LEAST_PERIOD_S: f64 = 1e-3;
/// Time between two reads.
const LOOK: Duration = Duration::from_micros(50);
/// A frame that has not come by then is lost.
const PATIENCE: Duration = Duration::from_millis(500);

/// What is measured.
pub(crate) struct Plan {
    address: LineAddress,
    baud: u32,
    lasts: Duration,
    most_s: f64,
}

/// What came of it.
#[derive(Default)]
pub(crate) struct Figures {
    sent_count: u32,
    came_count: u32,
    /// Bytes that belong to no frame: damaged ones, and those of damaged frames.
    stray_bytes_count: u64,
    /// From write to read, less the time on the wire, s.
    ways_s: Vec<f64>,
}

impl Plan {
    /// Address, seconds and milliseconds of a command line; `None` for anything else.
    pub(crate) fn read(arguments: &[String]) -> Option<Self> {
        let [address, rest @ ..] = arguments else { return None };
        let address = LineAddress::parse(address).ok()?;
        let LineAddress::Serial { baud, .. } = address else { return None };
        let positive =
            |text: &String| text.parse().ok().filter(|value: &f64| value.is_finite() && *value > 0.0);
        let (seconds, most_ms) = match rest {
            [] => (10.0, 2.0),
            [seconds] => (positive(seconds)?, 2.0),
            [seconds, most_ms] => (positive(seconds)?, positive(most_ms)?),
            _ => return None,
        };
        Some(Self {
            address,
            baud,
            lasts: Duration::try_from_secs_f64(seconds).ok()?,
            most_s: 1e-3 * most_ms,
        })
    }

    fn frame_s(&self) -> f64 {
        FRAME_BYTES as f64 * BITS_PER_BYTE / f64::from(self.baud)
    }
}

/// Sends frames and takes what comes back.
///
/// # Errors
/// When the port cannot be had, or is gone.
pub(crate) fn measure(plan: &Plan) -> Result<Figures, DeviceError> {
    let begun = clock::now();
    let elapsed = move || clock::now().saturating_sub(begun);
    let mut lines = Lines::start(Box::new(elapsed))?;
    let mut line = lines.open_line(&plan.address)?;
    let period = Duration::from_secs_f64((SPACING * plan.frame_s()).max(LEAST_PERIOD_S));
    let mut figures = Figures::default();
    let mut sent_at = Vec::new();
    let mut waiting = Vec::new();
    let mut newest = elapsed();
    // The first call makes the port keep what arrives.
    line.read(newest, &mut [0; 1])?;
    let first = newest + period;
    loop {
        let now = elapsed();
        let due = first + period * figures.sent_count;
        if now >= due && now < first + plan.lasts {
            sent_at.push(now);
            line.write(now, &frame(figures.sent_count))?;
            figures.sent_count += 1;
        }
        let mut bytes = [0; 512];
        let count = line.read(now, &mut bytes)?;
        if count > 0 {
            newest = now;
            waiting.extend_from_slice(&bytes[..count]);
            figures.take(
                &mut waiting,
                |number| Some(now.saturating_sub(*sent_at.get(number)?)),
                plan.frame_s(),
            );
        }
        let is_over = now >= first + plan.lasts;
        if is_over && (figures.came_count == figures.sent_count || now > newest + PATIENCE) {
            figures.stray_bytes_count += waiting.len() as u64;
            return Ok(figures);
        }
        clock::rest_until(clock::now() + LOOK);
    }
}

fn frame(number: u32) -> [u8; FRAME_BYTES] {
    let mut frame = [0; FRAME_BYTES];
    frame[..4].copy_from_slice(&MARK);
    frame[4..8].copy_from_slice(&number.to_be_bytes());
    for (k, byte) in (0_u32..).zip(&mut frame[8..32]) {
        // All bits of all places change from frame to frame.
        *byte = number.wrapping_mul(0x9E37_79B9).wrapping_add(k.wrapping_mul(0x0101_6B35)).to_be_bytes()[0];
    }
    let checksum = sum(&frame[..32]);
    frame[32..].copy_from_slice(&checksum.to_be_bytes());
    frame
}

/// CRC-32 with the polynomial 04C11DB7h, not reflected, as a KVH 1775 sends it (ICD 56-0298).
fn sum(bytes: &[u8]) -> u32 {
    bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte) << 24, |crc, _| {
            let shifted = crc << 1;
            if crc & 1 << 31 == 0 { shifted } else { shifted ^ 0x04C1_1DB7 }
        })
    })
}

impl Figures {
    fn take(&mut self, waiting: &mut Vec<u8>, way: impl Fn(usize) -> Option<Duration>, frame_s: f64) {
        while let Some(bytes) = waiting.first_chunk::<FRAME_BYTES>() {
            let number = u32::from_be_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]);
            if bytes[..4] != MARK || *bytes != frame(number) {
                self.stray_bytes_count += 1;
                waiting.remove(0);
                continue;
            }
            if let Some(took) = way(number as usize) {
                self.came_count += 1;
                self.ways_s.push(took.as_secs_f64() - frame_s);
            }
            waiting.drain(..FRAME_BYTES);
        }
    }

    /// The way that this share of the frames does not exceed, s.
    fn way_s(&self, share: f64) -> f64 {
        let mut sorted = self.ways_s.clone();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        sorted.get((share * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
    }

    pub(crate) fn is_within(&self, plan: &Plan) -> bool {
        let is_whole = self.came_count == self.sent_count && self.stray_bytes_count == 0;
        self.sent_count > 0 && is_whole && self.way_s(0.99) <= plan.most_s
    }

    pub(crate) fn text(&self, plan: &Plan) -> String {
        let [p50, p99, most] = [0.5, 0.99, 1.0].map(|share| 1e3 * self.way_s(share));
        format!(
            "{}: {} frames of {FRAME_BYTES} bytes sent, {} came back, {} stray bytes; way through adapter and kernel, ms: \
             p50 {p50:.3}, p99 {p99:.3}, largest {most:.3} (limit of p99 {:.3})",
            plan.address,
            self.sent_count,
            self.came_count,
            self.stray_bytes_count,
            1e3 * plan.most_s
        )
    }
}
