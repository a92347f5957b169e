//! Interpolates defective pixels from the good ones beside them along the shaft, where the picture
//! hardly changes.

/// Which way the shaft runs in the frames as the camera delivers them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum ShaftRuns {
    /// Along the rows: level.
    #[default]
    AlongRows,
    /// Along the columns: upright, measured transposed.
    AlongColumns,
}

/// A grey value in its container.
pub(crate) trait Grey: Copy {
    fn grey(self) -> f32;
    fn of(value: f32) -> Self;
}

impl Grey for u8 {
    fn grey(self) -> f32 {
        f32::from(self)
    }
    fn of(value: f32) -> Self {
        value.round().clamp(0.0, 255.0) as Self
    }
}

impl Grey for u16 {
    fn grey(self) -> f32 {
        f32::from(self)
    }
    fn of(value: f32) -> Self {
        value.round().clamp(0.0, 65535.0) as Self
    }
}

impl Grey for f32 {
    fn grey(self) -> f32 {
        self
    }
    fn of(value: f32) -> Self {
        value
    }
}

/// Interpolates defects (row, column), sorted, of an image of so many columns. A line that is
/// defective from end to end takes what its neighbours across the shaft show.
pub(super) fn interpolate_defects<T: Grey>(
    pixels: &mut [T],
    columns: usize,
    defects: &[[u32; 2]],
    shaft: ShaftRuns,
) {
    let rows = pixels.len() / columns.max(1);
    let turned = |places: &[[u32; 2]]| {
        let mut turned: Vec<[u32; 2]> = places.iter().map(|[a, b]| [*b, *a]).collect();
        turned.sort_unstable();
        turned
    };
    let along_row = Lines { step: 1, stride: columns, length: columns };
    let along_column = Lines { step: columns, stride: 1, length: rows };
    match shaft {
        ShaftRuns::AlongRows => {
            let left = along_row.interpolate_defects(pixels, defects);
            along_column.interpolate_defects(pixels, &turned(&left));
        }
        ShaftRuns::AlongColumns => {
            let left = along_column.interpolate_defects(pixels, &turned(defects));
            along_row.interpolate_defects(pixels, &turned(&left));
        }
    }
}

/// How the lines of an image lie in its memory.
struct Lines {
    /// From a pixel to the next one of its line.
    step: usize,
    /// From a line to the next.
    stride: usize,
    /// Pixels of a line.
    length: usize,
}

impl Lines {
    /// Interpolates runs of defects (line, place), sorted, between the good pixels at their ends;
    /// gives those of lines without any.
    fn interpolate_defects<T: Grey>(&self, pixels: &mut [T], defects: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let mut left = Vec::new();
        for run in defects.chunk_by(|a, b| a[0] == b[0] && a[1] + 1 == b[1]) {
            let [line, from] = run[0].map(|v| v as usize);
            let to = from + run.len();
            let at = |place: usize| line * self.stride + place * self.step;
            let good = |place: usize| pixels.get(at(place)).map(|p| p.grey());
            let before = from.checked_sub(1).and_then(good);
            let after = (to < self.length).then_some(to).and_then(good);
            let (first, slope) = match (before, after) {
                (Some(a), Some(b)) => (a, (b - a) / (run.len() + 1) as f32),
                (Some(one), None) | (None, Some(one)) => (one, 0.0),
                (None, None) => {
                    left.extend_from_slice(run);
                    continue;
                }
            };
            for place in from..to {
                if let Some(pixel) = pixels.get_mut(at(place)) {
                    *pixel = T::of(first + slope * (place + 1 - from) as f32);
                }
            }
        }
        left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = 12;
    const COLUMNS: usize = 20;

    /// An image that is `grey` but for dead defects; the largest error after interpolation.
    fn worst(defects: &[[u32; 2]], shaft: ShaftRuns, grey: impl Fn(usize, usize) -> f32) -> f32 {
        let mut pixels: Vec<f32> = (0..ROWS * COLUMNS).map(|i| grey(i / COLUMNS, i % COLUMNS)).collect();
        for [r, c] in defects {
            pixels[*r as usize * COLUMNS + *c as usize] = 0.0;
        }
        interpolate_defects(&mut pixels, COLUMNS, defects, shaft);
        let off = |i: usize| (pixels[i] - grey(i / COLUMNS, i % COLUMNS)).abs();
        (0..pixels.len()).map(off).fold(0.0, f32::max)
    }

    /// Two dead pixels side by side took half of each other: 1500 and 2250 of 3000.
    #[test]
    fn neighbouring_defects_take_what_good_pixels_show() {
        for defects in [
            &[[3, 7], [3, 8]][..],
            &[[3, 0], [3, 1], [3, 2]],
            &[[3, 18], [3, 19], [4, 0]],
            &[[5, 4], [6, 4], [7, 4], [7, 5]],
        ] {
            for shaft in [ShaftRuns::AlongRows, ShaftRuns::AlongColumns] {
                assert_eq!(worst(defects, shaft, |_, _| 3000.0), 0.0, "{defects:?}");
            }
        }
        assert!(worst(&[[3, 7], [3, 8]], ShaftRuns::AlongRows, |_, c| 100.0 + 30.0 * c as f32) < 1e-3);
    }

    /// The mean must not run across an edge.
    #[test]
    fn an_upright_shaft_is_healed_along_its_columns() {
        let shadow = |c: usize| if c < 8 { 3000.0 } else { 100.0 };
        let defects = [[4, 7], [5, 8], [9, 7], [10, 7]];
        assert_eq!(worst(&defects, ShaftRuns::AlongColumns, |_, c| shadow(c)), 0.0);
        assert!(worst(&defects, ShaftRuns::AlongRows, |_, c| shadow(c)) > 1000.0);
        assert_eq!(worst(&defects, ShaftRuns::AlongRows, |r, _| shadow(r)), 0.0);
    }

    /// A dead row of the sensor has no good pixel along the shaft.
    #[test]
    fn a_dead_line_is_bridged_across() {
        let row: Vec<[u32; 2]> = (0..COLUMNS as u32).map(|c| [5, c]).collect();
        assert!(worst(&row, ShaftRuns::AlongRows, |r, _| 100.0 + 50.0 * r as f32) < 1e-3);
        let column: Vec<[u32; 2]> = (0..ROWS as u32).map(|r| [r, 5]).collect();
        assert!(worst(&column, ShaftRuns::AlongColumns, |_, c| 100.0 + 50.0 * c as f32) < 1e-3);
        let all: Vec<[u32; 2]> =
            (0..ROWS as u32).flat_map(|r| (0..COLUMNS as u32).map(move |c| [r, c])).collect();
        assert_eq!(worst(&all, ShaftRuns::AlongRows, |_, _| 3.0), 3.0);
    }
}
