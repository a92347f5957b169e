//! Samples of 1 to 15 bits packed without gaps, most significant bit first, rows padded to whole
//! bytes (TIFF 6.0 BitsPerSample, FillOrder 1; PNG 7.2; PBM).

use crate::frame::Buffer;

/// Unpacks rows of `row_samples` samples of `bits` bits: to 8-bit values for up to 8 bits,
/// otherwise to 16-bit ones.
pub(super) fn unpack(packed: &[u8], bits: u8, row_samples: usize) -> Buffer {
    let row_bytes = (row_samples * usize::from(bits)).div_ceil(8).max(1);
    let rows = packed.chunks_exact(row_bytes);
    if bits <= 8 {
        Buffer::U8(rows.flat_map(|row| samples(row, bits, row_samples)).map(|v| v as u8).collect())
    } else {
        Buffer::U16(rows.flat_map(|row| samples(row, bits, row_samples)).collect())
    }
}

fn samples(row: &[u8], bits: u8, count: usize) -> impl Iterator<Item = u16> + '_ {
    let (bits, mask) = (usize::from(bits), (1_u32 << bits) - 1);
    (0..count).map(move |i| {
        let (byte, offset) = (i * bits / 8, i * bits % 8);
        // A sample of up to 15 bits lies within three bytes.
        let at = |k: usize| u32::from(row.get(byte + k).copied().unwrap_or(0));
        let window = at(0) << 16 | at(1) << 8 | at(2);
        (window >> (24 - offset - bits) & mask) as u16
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The packing as a string of binary digits.
    fn pack(rows: &[Vec<u16>], bits: usize) -> Vec<u8> {
        let mut bytes = Vec::new();
        for row in rows {
            let mut digits: String = row.iter().map(|v| format!("{v:0bits$b}")).collect();
            while !digits.len().is_multiple_of(8) {
                digits.push('1');
            }
            let octets = digits.as_bytes().chunks(8);
            bytes.extend(octets.map(|o| u8::from_str_radix(std::str::from_utf8(o).unwrap(), 2).unwrap()));
        }
        bytes
    }

    proptest! {
        #[test]
        fn every_sample_comes_back(bits in 1_usize..=15, columns in 1_usize..20, rows in 1_usize..4, seed: u64) {
            let value = |i: usize| (seed.wrapping_mul(i as u64 * 2 + 1) >> 40) as u16 & ((1 << bits) - 1);
            let all: Vec<Vec<u16>> =
                (0..rows).map(|r| (0..columns).map(|c| value(r * columns + c)).collect()).collect();
            let found = match unpack(&pack(&all, bits), bits as u8, columns) {
                Buffer::U8(v) => v.into_iter().map(u16::from).collect(),
                Buffer::U16(v) => v,
                Buffer::F32(_) => Vec::new(),
            };
            prop_assert_eq!(found, all.concat());
        }
    }
}
