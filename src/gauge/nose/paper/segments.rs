//! Line segments of an edge image by growing regions of like level-line angles (LSD: Grompone von
//! Gioi, Jakubowicz, Morel, Randall, Image Processing On Line 2, 2012), as the paper uses it: the
//! image at 80 % after a Gaussian, gradients over 2 × 2 pixels, regions of angles within τ, made
//! dense, a rectangle about each, kept where it is no false alarm. LSD's later trials of narrower
//! rectangles are left out: the paper has none.

use image::GrayImage;

use super::false_alarms::{binomial_tail, tests};
use super::gradients::Gradients;
use super::limits::PaperNoseLimits;
use super::region::Region;
use super::segment::Segment;

/// The segments of an edge image, the longest first.
pub(super) fn segments(edges: &GrayImage) -> Vec<Segment> {
    let field = Gradients::of(edges);
    let limits = PaperNoseLimits::get();
    let (tau, p) = (limits.tolerance_deg.to_radians(), limits.tolerance_deg / 180.0);
    let count = tests((field.columns as u32, field.rows as u32), limits.exponent, limits.gamma);
    // a smaller region is a false alarm even where all of it is aligned (LSD)
    let least = (-count.ln() / p.ln()).ceil() as usize;
    let mut order: Vec<usize> = (0..field.size.len()).filter(|i| field.angle[*i].is_some()).collect();
    order.sort_by(|a, b| field.size[*b].total_cmp(&field.size[*a]).then(a.cmp(b)));
    let mut used = vec![false; field.size.len()];
    let mut found = Vec::new();
    for seed in order {
        if used[seed] {
            continue;
        }
        let region = Region::grown(&field, seed, tau, &mut used);
        if region.pixels.len() < least {
            continue;
        }
        let Some((_, rectangle)) = region.dense(&field, &mut used) else { continue };
        let (all, aligned) = rectangle.counted(&field, tau);
        if count * binomial_tail(all, aligned, p) <= limits.false_alarms {
            found.push(rectangle.segment());
        }
    }
    found.sort_by(|a, b| b.length().total_cmp(&a.length()));
    found
}

#[cfg(test)]
mod tests {
    use image::Luma;

    use super::*;

    #[test]
    fn a_line_of_pixels_is_found_beside_itself_and_scatter_is_not() {
        let mut image = GrayImage::new(200, 160);
        let line = |c: u32| 20.0 + 0.5 * f64::from(c);
        (20..180).for_each(|c| image.put_pixel(c, line(c).round() as u32, Luma([255])));
        let found = segments(&image);
        assert!(found.len() >= 2, "{found:?}");
        // the gradient of a line has a ridge on either side, a pixel off
        for s in &found[..2] {
            for end in s.ends {
                let off = (-end.y - 20.0 - 0.5 * end.x) / 1.25_f64.sqrt();
                assert!(off.abs() < 1.5, "{off} {s:?}");
            }
            assert!((s.length() - 160.0 * 1.25_f64.sqrt()).abs() < 12.0, "{s:?}");
        }
        // pixels far apart: no region is large enough
        let mut dots = GrayImage::new(200, 160);
        (0..12).for_each(|k| dots.put_pixel(10 + 15 * k, 10 + (k * 37) % 140, Luma([255])));
        assert!(segments(&dots).is_empty(), "{:?}", segments(&dots));
    }
}
