//! CRC-32/MPEG-2: polynomial 04C11DB7h, initial FFFFFFFFh, no reflection, no final inversion (KVH ICD 56-0298, Sensonor
//! TS1524).

const POLYNOMIAL: u32 = 0x04C1_1DB7;

/// `TABLES[k][b]`: what byte `b` contributes when `k` more bytes of its word follow it.
static TABLES: [[u32; 256]; 4] = tables();

const fn tables() -> [[u32; 256]; 4] {
    let mut tables = [[0; 256]; 4];
    let mut byte = 0;
    while byte < 256 {
        let mut remainder = (byte as u32) << 24;
        let mut bit = 0;
        while bit < 8 {
            let carry = remainder & 0x8000_0000 != 0;
            remainder = (remainder << 1) ^ if carry { POLYNOMIAL } else { 0 };
            bit += 1;
        }
        tables[0][byte] = remainder;
        byte += 1;
    }
    let mut follow = 1;
    while follow < 4 {
        let mut byte = 0;
        while byte < 256 {
            let before = tables[follow - 1][byte];
            tables[follow][byte] = (before << 8) ^ tables[0][(before >> 24) as usize];
            byte += 1;
        }
        follow += 1;
    }
    tables
}

/// Checksum over all bytes that precede it in a frame, four bytes a step.
pub fn crc32(bytes: &[u8]) -> u32 {
    crc32_from(u32::MAX, bytes)
}

/// Goes on from the checksum of the bytes before.
pub(crate) fn crc32_from(before: u32, bytes: &[u8]) -> u32 {
    let mut words = bytes.chunks_exact(4);
    let mut crc = before;
    for word in &mut words {
        let mixed = crc ^ u32::from_be_bytes([word[0], word[1], word[2], word[3]]);
        let [a, b, c, d] = mixed.to_be_bytes().map(usize::from);
        crc = TABLES[3][a] ^ TABLES[2][b] ^ TABLES[1][c] ^ TABLES[0][d];
    }
    let one = |crc: u32, &byte: &u8| (crc << 8) ^ TABLES[0][usize::from((crc >> 24) as u8 ^ byte)];
    words.remainder().iter().fold(crc, one)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_value_of_the_catalogue_is_met() {
        assert_eq!(crc32(b"123456789"), 0x0376_E6E7);
        assert_eq!(crc32(b""), u32::MAX);
    }

    #[test]
    fn four_bytes_a_step_equal_bit_by_bit() {
        let bytes: Vec<u8> = (0..61_u8).map(|k| k.wrapping_mul(37) ^ 0x5A).collect();
        for length in 0..bytes.len() {
            let mut crc = u32::MAX;
            for &byte in &bytes[..length] {
                crc ^= u32::from(byte) << 24;
                for _ in 0..8 {
                    crc = if crc >> 31 == 1 { (crc << 1) ^ POLYNOMIAL } else { crc << 1 };
                }
            }
            assert_eq!(crc32(&bytes[..length]), crc, "{length} bytes");
            let (front, back) = bytes[..length].split_at(length / 3);
            assert_eq!(crc32_from(crc32(front), back), crc, "{length} bytes in two parts");
        }
    }
}
