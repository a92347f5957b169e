//! Packed grey values to words.
//!
//! `p` formats are a stream of bits, the least significant first, that runs on over the ends of
//! rows (PFNC 2.4, 5.2). Mono12Packed is GigE Vision's own: bits 11 to 4 of the first pixel, bits 3
//! to 0 of the first (low nibble) and of the second (high nibble), bits 11 to 4 of the second (GigE
//! Vision 1.2, figure 27-6).

/// Four pixels of 10 bits in five bytes.
pub(super) fn unpack10p(bytes: &[u8], count: usize, words: &mut Vec<u16>) {
    let wide = |b: u8| u16::from(b);
    let (groups, rest) = bytes.as_chunks::<5>();
    for &[a, b, c, d, e] in groups {
        words.extend([
            wide(a) | (wide(b) & 0x03) << 8,
            wide(b) >> 2 | (wide(c) & 0x0f) << 6,
            wide(c) >> 4 | (wide(d) & 0x3f) << 4,
            wide(d) >> 6 | wide(e) << 2,
        ]);
    }
    last_bits(rest, 10, count, words);
}

/// Two pixels of 12 bits in three bytes.
pub(super) fn unpack12p(bytes: &[u8], count: usize, words: &mut Vec<u16>) {
    let wide = |b: u8| u16::from(b);
    let (groups, rest) = bytes.as_chunks::<3>();
    for &[a, b, c] in groups {
        words.extend([wide(a) | (wide(b) & 0x0f) << 8, wide(b) >> 4 | wide(c) << 4]);
    }
    last_bits(rest, 12, count, words);
}

/// Two pixels of 12 bits in three bytes, as GigE Vision packs them.
pub(super) fn unpack12_packed(bytes: &[u8], count: usize, words: &mut Vec<u16>) {
    let wide = |b: u8| u16::from(b);
    let (groups, rest) = bytes.as_chunks::<3>();
    for &[a, b, c] in groups {
        words.extend([wide(a) << 4 | wide(b) & 0x0f, wide(c) << 4 | wide(b) >> 4]);
    }
    if let [a, b] = *rest {
        words.push(wide(a) << 4 | wide(b) & 0x0f);
    }
    words.truncate(count);
}

/// The pixels of an incomplete last group, the least significant bit first.
fn last_bits(rest: &[u8], bits: usize, count: usize, words: &mut Vec<u16>) {
    let all = rest.iter().rev().fold(0_u64, |all, byte| all << 8 | u64::from(*byte));
    let here = (0..8 * rest.len() / bits).map(|k| (all >> (bits * k) & ((1 << bits) - 1)) as u16);
    words.extend(here);
    words.truncate(count);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Bits in a row, the least significant of each value first: the definition of PFNC.
    fn packed_by_bits(values: &[u16], bits: usize) -> Vec<u8> {
        let mut bytes = vec![0_u8; (values.len() * bits).div_ceil(8)];
        for (at, value) in values.iter().enumerate() {
            for bit in 0..bits {
                let place = at * bits + bit;
                bytes[place / 8] |= ((value >> bit & 1) as u8) << (place % 8);
            }
        }
        bytes
    }

    fn packed_by_gige(values: &[u16]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for pair in values.chunks(2) {
            let second = pair.get(1).copied();
            bytes.push((pair[0] >> 4) as u8);
            bytes.push((pair[0] & 0xf | (second.unwrap_or(0) & 0xf) << 4) as u8);
            bytes.extend(second.map(|value| (value >> 4) as u8));
        }
        bytes
    }

    #[test]
    fn the_bytes_of_the_standards_are_read() {
        let unpacked = |unpack: fn(&[u8], usize, &mut Vec<u16>), bytes: &[u8], count| {
            let mut words = Vec::new();
            unpack(bytes, count, &mut words);
            words
        };
        // Pixels 0xABC and 0x123.
        assert_eq!(unpacked(unpack12p, &[0xbc, 0x3a, 0x12], 2), [0xabc, 0x123]);
        assert_eq!(unpacked(unpack12_packed, &[0xab, 0x3c, 0x12], 2), [0xabc, 0x123]);
        assert_eq!(unpacked(unpack10p, &[0xff, 0x03, 0, 0, 0], 4), [0x3ff, 0, 0, 0]);
        assert_eq!(unpacked(unpack10p, &[0, 0, 0, 0xc0, 0xff], 4), [0, 0, 0, 0x3ff]);
    }

    proptest! {
        #[test]
        fn every_value_comes_back(values in prop::collection::vec(0_u16..4096, 1..40)) {
            let count = values.len();
            let mut words = Vec::new();
            unpack12p(&packed_by_bits(&values, 12), count, &mut words);
            prop_assert_eq!(&words, &values);
            words.clear();
            unpack12_packed(&packed_by_gige(&values), count, &mut words);
            prop_assert_eq!(&words, &values);
            let values: Vec<u16> = values.iter().map(|v| v >> 2).collect();
            words.clear();
            unpack10p(&packed_by_bits(&values, 10), count, &mut words);
            prop_assert_eq!(&words, &values);
        }
    }
}
