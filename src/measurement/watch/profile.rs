//! The diameters along a frame as one line of block characters.

/// Eighths of a cell, lowest first.
const BLOCKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
/// A cell without a diameter.
const GAP: char = '·';

/// A profile as text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Profile {
    /// One character a cell.
    pub blocks: String,
    /// Largest minus smallest mean of a cell.
    pub span: f64,
}

/// Means over `cells` equal stretches of the columns, from the lowest block for the smallest to the
/// highest for the largest; all in the middle where they differ by less than `least` altogether, so
/// that noise does not fill the height. `None` without a value.
pub(crate) fn profile(
    values: impl ExactSizeIterator<Item = Option<f64>>,
    cells: usize,
    least: f64,
) -> Option<Profile> {
    let columns = values.len();
    let cells = cells.clamp(1, columns.max(1));
    let mut sums = vec![(0.0, 0_usize); cells];
    for (column, value) in values.enumerate() {
        if let (Some(value), Some(sum)) = (value, sums.get_mut(column * cells / columns)) {
            *sum = (sum.0 + value, sum.1 + 1);
        }
    }
    let means: Vec<Option<f64>> =
        sums.into_iter().map(|(sum, count)| (count > 0).then(|| sum / count as f64)).collect();
    let ends = |(low, high): (f64, f64), mean: &f64| (low.min(*mean), high.max(*mean));
    let (low, high) = means.iter().flatten().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    let span = high - low;
    if !span.is_finite() {
        return None;
    }
    let height = span.max(least).max(f64::MIN_POSITIVE);
    let bottom = 0.5 * (low + high) - 0.5 * height;
    let block = |mean: f64| {
        let eighth = ((mean - bottom) / height * BLOCKS.len() as f64) as usize;
        BLOCKS[eighth.min(BLOCKS.len() - 1)]
    };
    let blocks = means.iter().map(|mean| mean.map_or(GAP, block)).collect();
    Some(Profile { blocks, span })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_taper_climbs_block_by_block_and_gaps_stay_open() {
        let taper = (0..80).map(|c| if (20..30).contains(&c) { None } else { Some(f64::from(c / 10)) });
        let found = profile(taper.collect::<Vec<_>>().into_iter(), 8, 0.0).unwrap();
        assert_eq!((found.blocks.as_str(), found.span), ("▁▂·▄▅▆▇█", 7.0));
    }

    #[test]
    fn what_differs_by_less_than_the_least_is_level() {
        let noise = [10.0, 10.01, 9.99, 10.0].map(Some);
        let found = profile(noise.into_iter(), 4, 1.0).unwrap();
        assert!(found.blocks.chars().all(|c| "▄▅".contains(c)) && (found.span - 0.02).abs() < 1e-12);
        // A cell for each column at most; without a value there is none.
        assert_eq!(profile([Some(1.0), Some(2.0)].into_iter(), 40, 0.0).unwrap().blocks, "▁█");
        assert_eq!(profile([None, None].into_iter(), 4, 0.0), None);
        assert_eq!(profile(std::iter::empty::<Option<f64>>(), 4, 0.0), None);
    }
}
