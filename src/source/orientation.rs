//! Orientation tags (TIFF 6.0 tag 274, EXIF 4.6.5.1): the places of a file's first row and column
//! in the scene.
//!
//! ```text
//! 1 top left  2 top right  3 bottom right  4 bottom left      rows stay rows
//! 5 left top  6 right top  7 right bottom  8 left bottom      rows are columns of the scene
//! ```

use crate::frame::Buffer;

/// Whether rows and columns are exchanged.
pub(super) fn exchanges(orientation: u64) -> bool {
    (5..=8).contains(&orientation)
}

/// The upright image of a row-major one with `columns` columns. Orientation 1 and undefined numbers
/// change nothing.
pub(super) fn upright(buffer: Buffer, columns: usize, orientation: u64) -> Buffer {
    match buffer {
        Buffer::U8(v) => Buffer::U8(turned(v, columns, orientation)),
        Buffer::U16(v) => Buffer::U16(turned(v, columns, orientation)),
        Buffer::F32(v) => Buffer::F32(turned(v, columns, orientation)),
    }
}

fn turned<T: Copy>(mut values: Vec<T>, columns: usize, orientation: u64) -> Vec<T> {
    match orientation {
        2 => values.chunks_exact_mut(columns).for_each(<[T]>::reverse),
        3 => values.reverse(),
        4 => {
            values.reverse();
            values.chunks_exact_mut(columns).for_each(<[T]>::reverse);
        }
        5..=8 => return exchanged(&values, columns, orientation),
        _ => {}
    }
    values
}

fn exchanged<T: Copy>(values: &[T], columns: usize, orientation: u64) -> Vec<T> {
    let rows = values.len() / columns;
    let (from_right, from_bottom) = (matches!(orientation, 7 | 8), matches!(orientation, 6 | 7));
    let mut out = Vec::with_capacity(values.len());
    for r in 0..columns {
        let column = if from_right { columns - 1 - r } else { r };
        out.extend(
            (0..rows).map(|c| values[(if from_bottom { rows - 1 - c } else { c }) * columns + column]),
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of the stored first row and column in the upright image, in the words of the
    /// standard.
    #[test]
    fn the_stored_first_row_and_column_come_to_their_sides() {
        // Stored 2 x 3:  1 2 3 / 4 5 6.
        let stored = vec![1_u8, 2, 3, 4, 5, 6];
        for (orientation, upright_picture) in [
            (1, [1, 2, 3, 4, 5, 6]),
            (2, [3, 2, 1, 6, 5, 4]),
            (3, [6, 5, 4, 3, 2, 1]),
            (4, [4, 5, 6, 1, 2, 3]),
            (5, [1, 4, 2, 5, 3, 6]),
            (6, [4, 1, 5, 2, 6, 3]),
            (7, [6, 3, 5, 2, 4, 1]),
            (8, [3, 6, 2, 5, 1, 4]),
            (0, [1, 2, 3, 4, 5, 6]),
        ] {
            let found = upright(Buffer::U8(stored.clone()), 3, orientation);
            assert_eq!(found, Buffer::U8(upright_picture.to_vec()), "{orientation}");
        }
    }
}
