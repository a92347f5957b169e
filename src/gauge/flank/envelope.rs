//! The smooth curve that bounds a traced edge towards the air.
//!
//! Wear and chips displace an edge into the flank alone, and over more than half of its length
//! where the land is as dark as the air. What is left of the new edge lies on one smooth curve
//! above which nothing lies: of all straight lines and parabolas through places of the trace, that
//! with most places on it and none above it (consensus: Fischler and Bolles 1981, over all pairs
//! and triples instead of random ones).

use super::limits::FlankLimits;
use super::raster::quantile;

/// A stretch of the trace: its place and its median depth, µm.
type Block = (f64, f64);

/// A candidate: coefficients by powers of the place, µm.
type Curve = [f64; 3];

/// Which columns lie on the bounding curve; `None` where no curve bounds the trace. `places` are 0
/// to 1 along the edge, `depth_um` grows into the flank, `powers` 2 (straight) or 3.
pub(super) fn envelope(places: &[f64], depth_um: &[f64], powers: usize) -> Option<Vec<bool>> {
    let limits = FlankLimits::get();
    let blocks = blocks(places, depth_um, limits.envelope_blocks);
    let mut best: Option<(f64, Curve)> = None;
    for curve in curves(&blocks, powers) {
        let score = score(&blocks, &curve);
        if score > best.map_or(0.0, |b| b.0) {
            best = Some((score, curve));
        }
    }
    let (_, curve) = best?;
    let on = |k: usize| (depth_um[k] - at(&curve, places[k])).abs() <= 2.0 * limits.envelope_um;
    Some((0..places.len()).map(on).collect())
}

fn blocks(places: &[f64], depth_um: &[f64], count: usize) -> Vec<Block> {
    let size = places.len().div_ceil(count.max(1)).max(1);
    let one = |(t, d): (&[f64], &[f64])| {
        let depths = d.iter().map(|v| *v as f32).collect();
        (t.iter().sum::<f64>() / t.len() as f64, f64::from(quantile(depths, 0.5)))
    };
    places.chunks(size).zip(depth_um.chunks(size)).map(one).collect()
}

/// All lines through two blocks and, of three powers, parabolas through three.
fn curves(blocks: &[Block], powers: usize) -> Vec<Curve> {
    let mut all = Vec::new();
    for (i, a) in blocks.iter().enumerate() {
        for (j, b) in blocks.iter().enumerate().skip(i + 1) {
            let slope = (b.1 - a.1) / (b.0 - a.0);
            all.push([a.1 - slope * a.0, slope, 0.0]);
            if powers < 3 {
                continue;
            }
            for c in &blocks[j + 1..] {
                // Newton's divided differences
                let second = ((c.1 - b.1) / (c.0 - b.0) - slope) / (c.0 - a.0);
                let line = slope - second * (a.0 + b.0);
                all.push([a.1 - slope * a.0 + second * a.0 * b.0, line, second]);
            }
        }
    }
    all
}

/// Share of the blocks on a curve, less what its bend costs; 0 of one that does not bound them.
fn score(blocks: &[Block], curve: &Curve) -> f64 {
    let limits = FlankLimits::get();
    let n = blocks.len() as f64;
    let sagitta_um = 0.25 * curve[2].abs();
    if sagitta_um > limits.most_sagitta_um {
        return 0.0;
    }
    let off = |b: &Block| b.1 - at(curve, b.0);
    let above = blocks.iter().filter(|b| off(b) < -2.0 * limits.envelope_um).count() as f64;
    let on = blocks.iter().filter(|b| off(b).abs() <= limits.envelope_um).count() as f64;
    if above > limits.envelope_above * n || on < limits.envelope_share * n {
        return 0.0;
    }
    on / n - limits.envelope_bend * sagitta_um / limits.most_sagitta_um
}

fn at(curve: &Curve, t: f64) -> f64 {
    curve[0] + t * (curve[1] + t * curve[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cambered edge of which three quarters are worn by 60 µm: the quarter that is not bounds
    /// it.
    #[test]
    fn a_quarter_that_is_not_worn_bounds_the_trace() {
        let places: Vec<f64> = (0..400).map(|k| f64::from(k) / 399.0).collect();
        let new_um = |t: f64| 10.0 * t * (1.0 - t);
        let worn = |t: f64| t > 0.25;
        let scatter = |k: usize| (0.618_034 * k as f64).fract() - 0.5;
        let depth: Vec<f64> = places
            .iter()
            .enumerate()
            .map(|(k, t)| new_um(*t) + scatter(k) + if worn(*t) { 60.0 } else { 0.0 })
            .collect();
        let on = envelope(&places, &depth, 3).unwrap();
        for (t, on) in places.iter().zip(&on) {
            assert_eq!(*on, !worn(*t), "{t}");
        }
    }

    #[test]
    fn nothing_bounds_a_trace_without_order() {
        let places: Vec<f64> = (0..400).map(|k| f64::from(k) / 399.0).collect();
        let depth: Vec<f64> = (0..400_u32)
            .map(|k| f64::from(k.wrapping_mul(2_654_435_761) >> 24) + 40.0 * f64::from(k / 25 % 7))
            .collect();
        assert_eq!(envelope(&places, &depth, 3), None);
    }
}
