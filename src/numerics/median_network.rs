//! Medians of blocks of sixteen values, eight blocks at once, by a sorting network (Batcher's
//! odd-even merge sort): no branch depends on the data.

/// Values of a block.
pub(crate) const BLOCK: usize = 16;
/// Blocks sorted together.
pub(crate) const LANES: usize = 8;
/// Comparators of the network for sixteen values.
const COMPARATORS: usize = 63;

const NETWORK: [(usize, usize); COMPARATORS] = network();

const fn network() -> [(usize, usize); COMPARATORS] {
    let mut pairs = [(0, 0); COMPARATORS];
    let (mut count, mut p) = (0, 1);
    while p < BLOCK {
        let mut k = p;
        while k >= 1 {
            let mut j = k % p;
            while j + k < BLOCK {
                let mut i = 0;
                while i < k && i + j + k < BLOCK {
                    if (i + j) / (2 * p) == (i + j + k) / (2 * p) {
                        pairs[count] = (i + j, i + j + k);
                        count += 1;
                    }
                    i += 1;
                }
                j += 2 * k;
            }
            k /= 2;
        }
        p *= 2;
    }
    pairs
}

/// The ninth smallest of each lane's sixteen values, none of which may be NaN.
pub(crate) fn medians(values: &mut [[f32; LANES]; BLOCK]) -> [f32; LANES] {
    for (a, b) in NETWORK {
        let (low, high) = (values[a], values[b]);
        for lane in 0..LANES {
            values[a][lane] = if low[lane] < high[lane] { low[lane] } else { high[lane] };
            values[b][lane] = if low[lane] < high[lane] { high[lane] } else { low[lane] };
        }
    }
    values[BLOCK / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_network_finds_the_element_that_sorting_finds() {
        let mut state = 7_u32;
        for _ in 0..200 {
            let mut values = [[0.0_f32; LANES]; BLOCK];
            for value in values.iter_mut().flatten() {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *value = (state >> 27) as f32 - 12.5;
            }
            let sorted: Vec<f32> = (0..LANES)
                .map(|lane| {
                    let mut column: Vec<f32> = values.iter().map(|row| row[lane]).collect();
                    column.sort_by(f32::total_cmp);
                    column[BLOCK / 2]
                })
                .collect();
            assert_eq!(medians(&mut values).to_vec(), sorted);
        }
    }
}
