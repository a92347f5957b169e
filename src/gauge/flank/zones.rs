//! Zones of ISO 3685:1993, 7.1: C is the curved part at the corner, N the quarter of the worn
//! length b farthest from the corner, B what remains between them.

use super::limits::FlankLimits;
use super::result::Width;

/// Ranges of columns, each `from..to`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Zones {
    /// The straight part.
    pub b: std::ops::Range<usize>,
    /// The corner.
    pub c: Option<std::ops::Range<usize>>,
    /// The far end.
    pub n: Option<std::ops::Range<usize>>,
}

/// Zones of a worn range; `corner_first` is at which end the corner is, `corner_columns` how many
/// columns its curved part takes.
pub(crate) fn zones(worn: (usize, usize), corner_first: Option<bool>, corner_columns: usize) -> Zones {
    let (from, to) = (worn.0, worn.1 + 1);
    let length = to - from;
    let Some(corner_first) = corner_first else { return Zones { b: from..to, c: None, n: None } };
    let far = (FlankLimits::get().notch_share * length as f64).round() as usize;
    // a corner never takes what zone B needs to exist
    let near = corner_columns.min((length - far).saturating_sub(1));
    let c = |range: std::ops::Range<usize>| (corner_columns > 0).then_some(range);
    if corner_first {
        Zones { b: from + near..to - far, c: c(from..from + near), n: Some(to - far..to) }
    } else {
        Zones { b: from + far..to - near, c: c(to - near..to), n: Some(from..from + far) }
    }
}

/// Mean of widths, µm: u of columns whose scatter is shared over `shared` of them; 0 of none.
pub(crate) fn mean(widths: &[Width], shared: f64) -> Width {
    if widths.is_empty() {
        // a sum of no terms is -0, which would be printed
        return Width::default();
    }
    let n = widths.len() as f64;
    let um = widths.iter().map(|w| w.um).sum::<f64>() / n;
    let variance = widths.iter().map(|w| w.u_um * w.u_um).sum::<f64>() / n;
    Width { um, u_um: (variance / (n / shared).max(1.0)).sqrt() }
}

/// The largest width, with its own u.
pub(crate) fn largest(widths: &[Width]) -> Width {
    widths.iter().copied().max_by(|a, b| a.um.total_cmp(&b.um)).unwrap_or_default()
}

/// The longest run of columns that are at least so wide, over gaps of `bridge` columns.
pub(crate) fn worn_range(widths_um: &[f64], least_um: f64, bridge: usize) -> Option<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for k in (0..widths_um.len()).filter(|k| widths_um[*k] >= least_um) {
        match runs.last_mut() {
            Some(run) if k - run.1 <= bridge => run.1 = k,
            _ => runs.push((k, k)),
        }
    }
    runs.into_iter().max_by_key(|run| run.1 - run.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn widths(um: &[f64]) -> Vec<Width> {
        um.iter().map(|um| Width { um: *um, u_um: 2.0 }).collect()
    }

    /// ISO 3685:1993, figure 2: C at the corner, N the farthest quarter of b, B between.
    #[test]
    fn zones_divide_the_worn_length() {
        let first = zones((100, 499), Some(true), 50);
        assert_eq!((first.c, first.b, first.n), (Some(100..150), 150..400, Some(400..500)));
        let last = zones((100, 499), Some(false), 50);
        assert_eq!((last.n, last.b, last.c), (Some(100..200), 200..450, Some(450..500)));
        assert_eq!(zones((100, 499), None, 50), Zones { b: 100..500, c: None, n: None });
        // without a nose radius there is no zone C, and a long one leaves zone B a column
        assert_eq!(zones((0, 99), Some(true), 0).c, None);
        assert_eq!(zones((0, 99), Some(true), 200).b, 74..75);
    }

    #[test]
    fn means_share_their_scatter_and_the_largest_keeps_its_own() {
        let found = mean(&widths(&[100.0, 120.0, 140.0, 160.0]), 1.0);
        assert!((found.um - 130.0).abs() < 1e-12 && (found.u_um - 1.0).abs() < 1e-12);
        assert!((mean(&widths(&[100.0; 4]), 12.0).u_um - 2.0).abs() < 1e-12);
        assert_eq!(largest(&widths(&[3.0, 9.0, 4.0])).um, 9.0);
        assert_eq!(largest(&[]), Width::default());
        assert!(mean(&[], 1.0).um.is_sign_positive(), "a new edge is 0.0 wide");
    }

    #[test]
    fn a_worn_range_bridges_gaps_up_to_a_length() {
        let um = [0.0, 9.0, 9.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 9.0];
        assert_eq!(worn_range(&um, 6.0, 3), Some((1, 5)));
        assert_eq!(worn_range(&um, 6.0, 4), Some((1, 9)));
        assert_eq!(worn_range(&[5.0; 4], 6.0, 4), None);
    }
}
