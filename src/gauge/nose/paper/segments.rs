//! Line segments of an edge image by growing regions of like level-line angles (LSD: Grompone von
//! Gioi, Jakubowicz, Morel, Randall, Image Processing On Line 2, 2012), as the paper uses it: the
//! image at 80 % after a Gaussian, gradients over 2 × 2 pixels, regions of angles within τ, a
//! rectangle about each, kept where it is no false alarm. LSD's later trials of narrower rectangles
//! are left out: the paper has none.

use glam::DVec2;
use image::GrayImage;

use super::false_alarms::{binomial_tail, gradient_threshold, tests};
use super::limits::PaperNoseLimits;

/// A segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// Its ends, (column, −row) of the image.
    pub(super) ends: [DVec2; 2],
}

impl Segment {
    pub(super) fn middle(&self) -> DVec2 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    pub(super) fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }
}

/// Gradients of the smaller image: level-line angle and size; no angle where the gradient is small.
struct Gradients {
    angle: Vec<Option<f32>>,
    size: Vec<f32>,
    columns: usize,
    rows: usize,
}

/// The segments of an edge image, the longest first.
pub(super) fn segments(edges: &GrayImage) -> Vec<Segment> {
    let field = Gradients::of(&smaller(edges), edges.dimensions());
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
        let (region, angle) = field.grow(seed, tau, &mut used);
        if region.len() < least {
            continue;
        }
        let rectangle = field.rectangle(&region, angle);
        let (all, aligned) = field.counted(&rectangle, tau);
        if count * binomial_tail(all, aligned, p) <= limits.false_alarms {
            found.push(rectangle.segment());
        }
    }
    found.sort_by(|a, b| b.length().total_cmp(&a.length()));
    found
}

/// The image at 80 %: every edge pixel's light spread by the Gaussian, row by row.
fn smaller(edges: &GrayImage) -> Vec<f32> {
    let limits = PaperNoseLimits::get();
    let (scale, sigma) = (limits.scale, limits.smooth_px);
    let (columns, rows) = scaled(edges.dimensions());
    let mut out = vec![0.0_f32; columns * rows];
    let weight = |from: usize, to: u32| {
        let off = from as f64 / scale - f64::from(to);
        (-0.5 * (off / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt())
    };
    let near = |at: u32, most: usize| {
        let (low, high) =
            (scale * (f64::from(at) - limits.reach_px), scale * (f64::from(at) + limits.reach_px));
        (low.ceil().max(0.0) as usize)..=(high.floor() as usize).min(most - 1)
    };
    for (column, row, value) in edges.enumerate_pixels().filter(|(_, _, value)| value.0[0] > 0) {
        for r in near(row, rows) {
            let of_row = f64::from(value.0[0]) * weight(r, row);
            for c in near(column, columns) {
                out[r * columns + c] += (of_row * weight(c, column)) as f32;
            }
        }
    }
    out
}

fn scaled((columns, rows): (u32, u32)) -> (usize, usize) {
    let by = |n: u32| ((f64::from(n) * PaperNoseLimits::get().scale).floor() as usize).max(2);
    (by(columns), by(rows))
}

/// Angle between two directions, rad.
fn apart(a: f64, b: f64) -> f64 {
    let off = (a - b).rem_euclid(std::f64::consts::TAU);
    off.min(std::f64::consts::TAU - off)
}

impl Gradients {
    fn of(image: &[f32], size: (u32, u32)) -> Self {
        let limits = PaperNoseLimits::get();
        let (columns, rows) = scaled(size);
        let threshold = gradient_threshold(limits.grey_error, limits.tolerance_deg.to_radians()) as f32;
        let (mut angle, mut sizes) = (vec![None; image.len()], vec![0.0; image.len()]);
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let at = row * columns + column;
                let (a, b, c, d) = (image[at], image[at + 1], image[at + columns], image[at + columns + 1]);
                let (x, y) = (0.5 * (b + d - a - c), 0.5 * (c + d - a - b));
                sizes[at] = x.hypot(y);
                // the direction of the line of equal grey, rows downwards
                angle[at] = (sizes[at] > threshold).then(|| x.atan2(-y));
            }
        }
        Self { angle, size: sizes, columns, rows }
    }

    fn is_aligned(&self, at: usize, angle: f64, tau: f64) -> bool {
        self.angle[at].is_some_and(|a| apart(f64::from(a), angle) <= tau)
    }

    /// Grows a region from a pixel over eight neighbours; its angle is that of the mean direction.
    fn grow(&self, seed: usize, tau: f64, used: &mut [bool]) -> (Vec<usize>, f64) {
        let mut angle = f64::from(self.angle[seed].unwrap_or(0.0));
        let (mut sum, mut region, mut next) = (DVec2::from_angle(angle), vec![seed], 0);
        used[seed] = true;
        while next < region.len() {
            let (row, column) = (region[next] / self.columns, region[next] % self.columns);
            next += 1;
            for r in row.saturating_sub(1)..=(row + 1).min(self.rows - 1) {
                for c in column.saturating_sub(1)..=(column + 1).min(self.columns - 1) {
                    let at = r * self.columns + c;
                    if used[at] || !self.is_aligned(at, angle, tau) {
                        continue;
                    }
                    used[at] = true;
                    region.push(at);
                    sum += DVec2::from_angle(f64::from(self.angle[at].unwrap_or(0.0)));
                    angle = sum.to_angle();
                }
            }
        }
        (region, angle)
    }

    /// The rectangle about a region: through its centre of mass by gradient, along the least moment
    /// of inertia.
    fn rectangle(&self, region: &[usize], angle: f64) -> Rectangle {
        let place = |at: usize| DVec2::new((at % self.columns) as f64, (at / self.columns) as f64);
        let weight = |at: usize| f64::from(self.size[at]);
        let mass: f64 = region.iter().map(|at| weight(*at)).sum();
        let centre = region.iter().map(|at| weight(*at) * place(*at)).sum::<DVec2>() / mass;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for &at in region {
            let (w, d) = (weight(at), place(at) - centre);
            (xx, xy, yy) = (xx + w * d.x * d.x, xy + w * d.x * d.y, yy + w * d.y * d.y);
        }
        let along = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
        let extent = |axis: DVec2| {
            let off = region.iter().map(|at| axis.dot(place(*at) - centre));
            off.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
        };
        Rectangle { centre, along, length: extent(along), width: extent(along.perp()), angle }
    }

    /// Pixels of a rectangle, and those aligned with its region's angle.
    fn counted(&self, r: &Rectangle, tau: f64) -> (u32, u32) {
        let across = r.along.perp();
        let corner = |l: f64, w: f64| r.centre + r.along * l + across * w;
        let corners = [
            corner(r.length.0, r.width.0),
            corner(r.length.0, r.width.1),
            corner(r.length.1, r.width.0),
            corner(r.length.1, r.width.1),
        ];
        let range = |of: fn(&DVec2) -> f64, most: usize| {
            let (low, high) = corners
                .iter()
                .map(of)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            (low.ceil().max(0.0) as usize, high.floor().min(most as f64 - 1.0).max(0.0) as usize)
        };
        let (mut all, mut aligned) = (0, 0);
        let (top, bottom) = range(|c| c.y, self.rows);
        for row in top..=bottom {
            let (first, last) = r.of_row(row as f64, self.columns);
            for column in first..last {
                all += 1;
                aligned += u32::from(self.is_aligned(row * self.columns + column, r.angle, tau));
            }
        }
        (all, aligned)
    }
}

/// A rectangle of the smaller image, (column, row).
struct Rectangle {
    centre: DVec2,
    along: DVec2,
    length: (f64, f64),
    width: (f64, f64),
    /// Level-line angle of its region, rad.
    angle: f64,
}

impl Rectangle {
    /// Its columns in a row, the second one beyond them.
    fn of_row(&self, row: f64, columns: usize) -> (usize, usize) {
        let (mut low, mut high) = (0.0_f64, columns as f64 - 1.0);
        let y = row - self.centre.y;
        // low ≤ axis·(x, y) ≤ high, for both axes
        for (axis, (from, to)) in [(self.along, self.length), (self.along.perp(), self.width)] {
            if axis.x.abs() < 1e-12 {
                if !(from..=to).contains(&(axis.y * y)) {
                    return (0, 0);
                }
                continue;
            }
            let ends = [(from - axis.y * y) / axis.x, (to - axis.y * y) / axis.x];
            low = low.max(self.centre.x + ends[0].min(ends[1]));
            high = high.min(self.centre.x + ends[0].max(ends[1]));
        }
        if low > high { (0, 0) } else { (low.ceil() as usize, high.floor() as usize + 1) }
    }

    /// Its axis in the image. The gradient of pixel (c, r) stands between four pixels, half a pixel
    /// on.
    fn segment(&self) -> Segment {
        let end = |l: f64| {
            let p = (self.centre + self.along * l + DVec2::splat(0.5)) / PaperNoseLimits::get().scale;
            DVec2::new(p.x, -p.y)
        };
        Segment { ends: [end(self.length.0), end(self.length.1)] }
    }
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

    #[test]
    fn a_rectangle_counts_its_pixels_as_trying_each_does() {
        let field =
            Gradients { angle: vec![Some(0.3); 60 * 50], size: vec![1.0; 60 * 50], columns: 60, rows: 50 };
        for (deg, length, width) in
            [(0.0, 20.0, 3.0), (33.0, 15.0, 4.3), (90.0, 12.0, 2.0), (140.0, 30.0, 1.5)]
        {
            let along = DVec2::from_angle(f64::to_radians(deg));
            let r = Rectangle {
                centre: DVec2::new(29.7, 24.2),
                along,
                length: (-length, length),
                width: (-width, width),
                angle: 0.3,
            };
            let inside = |c: usize, row: usize| {
                let d = DVec2::new(c as f64, row as f64) - r.centre;
                along.dot(d).abs() <= length && along.perp().dot(d).abs() <= width
            };
            let tried =
                (0..50).flat_map(|row| (0..60).map(move |c| (c, row))).filter(|(c, row)| inside(*c, *row));
            let (all, aligned) = field.counted(&r, 0.1);
            assert_eq!((all as usize, aligned), (tried.count(), all), "{deg}");
        }
    }
}
