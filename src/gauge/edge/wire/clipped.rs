//! Whether the light beside a wire is clipped: by the pile of its grey values at the largest one,
//! as for the flat ends of wider shadows.

use crate::gauge::edge::estimation::grey_ends;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::locate::PartLocation;
use crate::gauge::limit::limits;

limits! {
    /// Pixels beside a wire that are looked at for a clip.
    WireClipLimits = "wire_clip";
    /// Rows from a coarse edge outwards from which a pixel is light, px: the reach of an edge of 2
    /// px blur, beyond which wires are refused by their width.
    beside_px: i32 = 8;
    /// Rows from a coarse edge inwards from which a pixel is shadow, px: a wire is too narrow for
    /// more.
    inside_px: i32 = 2;
    /// Number of rows and of columns sampled: 64 x 64 pixels determine a share of 1 % to a sixth of
    /// itself.
    samples: usize = 64;
}

/// Pairs of horizontally neighbouring pixels.
type Pairs = Vec<[f32; 2]>;

/// Share of the light's pixels at their largest grey value, where light is clipped there. A frame
/// without noise on the other side is not clipped but drawn.
pub(super) fn clipped_share<T: Sample>(plane: &Plane<'_, T>, part: &PartLocation) -> Option<f64> {
    if !(part.scale.floor > 0.0) {
        return None;
    }
    let (dark, light) = pairs_beside(plane, part);
    let mean = |pairs: &Pairs| {
        pairs.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / (2 * pairs.len().max(1)) as f64
    };
    let step = part.scale.step();
    let mut pool: Vec<f32> = light.iter().flatten().copied().collect();
    let all = pool.len() as f64;
    let (end, _) = grey_ends::judge(&mut pool, step, mean(&light) - mean(&dark), |end, least, step| {
        let noise = |pairs: &Pairs, end| grey_ends::noise_of_pairs(pairs.iter().copied(), end, step);
        let free = |s: f64| (s * s - step * step / 12.0).max(0.0).sqrt();
        let below = noise(&light, end).map_or(0.0, free);
        let dark = noise(&dark, f32::INFINITY).map_or(0.0, free);
        // A wire's flank shows the noise of neither: the least that light has is that of the dark.
        if below > least { below } else { grey_ends::expected_noise(plane.sign > 0.0, (0.0, 0.0), dark) }
    })?;
    Some(pool.iter().filter(|v| **v >= end).count() as f64 / all)
}

/// Pairs in the shadow and in the light.
fn pairs_beside<T: Sample>(plane: &Plane<'_, T>, part: &PartLocation) -> (Pairs, Pairs) {
    let limits = WireClipLimits::get();
    let strides = [plane.rows, plane.columns].map(|n| (n / limits.samples).max(1));
    let (mut dark, mut light) = (Pairs::new(), Pairs::new());
    for column in (0..plane.columns.saturating_sub(1)).step_by(strides[1]) {
        let (Ok(top), Ok(bottom)) = (part.top[column], part.bottom[column]) else { continue };
        let pair = |row: usize| [plane.at(row, column), plane.at(row, column + 1)];
        let is_light = |row: i32| row < top - limits.beside_px || row > bottom + limits.beside_px;
        light.extend((0..plane.rows).step_by(strides[0]).filter(|row| is_light(*row as i32)).map(pair));
        let inside = (top + limits.inside_px).max(0)..=(bottom - limits.inside_px).min(plane.rows as i32 - 1);
        dark.extend(inside.map(|row| pair(row as usize)));
    }
    (dark, light)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edge::estimation::side_survey::GreyScaleLimits;
    use crate::gauge::edges::ShadowsSeen;
    use crate::numerics::distributions::phi_cdf;

    /// Largest light in the shadow of a wire of 7 px, and least light beside it, in a field of 27
    /// rows.
    fn extremes(sigma: f64) -> Option<[f32; 2]> {
        let (rows, columns) = (27, 128);
        let light = |row: f64| phi_cdf((9.5 - row) / sigma) + phi_cdf((row - 16.5) / sigma);
        let pixels: Vec<f32> = (0..rows * columns).map(|i| light((i / columns) as f64) as f32).collect();
        let plane =
            Plane { pixels: &pixels, rows, columns, row_stride: columns, column_stride: 1, sign: 1.0 };
        let part = PartLocation {
            size: (rows, columns),
            top: vec![Ok(10); columns],
            bottom: vec![Ok(16); columns],
            width_px: Some(7.0),
            shadows: ShadowsSeen::default(),
            scale: GreyScaleLimits::of_step(0.0),
        };
        let (dark, light) = pairs_beside(&plane, &part);
        let [dark, light] = [dark, light].map(|pairs| pairs.into_iter().flatten().collect::<Vec<f32>>());
        Some([dark.into_iter().reduce(f32::max)?, light.into_iter().reduce(f32::min)?])
    }

    /// Of a wire blurred by 2 px, the widest that is measured, light begins where the edge has
    /// ended; of one blurred by 1 px some rows are shadow; and a small field still shows both.
    #[test]
    fn light_and_shadow_are_looked_at_clear_of_the_edges() {
        let [_, least] = extremes(2.0).unwrap();
        assert!(least > 0.9999, "{least}");
        let [most, _] = extremes(1.0).unwrap();
        assert!(most < 0.02, "{most}");
    }
}
