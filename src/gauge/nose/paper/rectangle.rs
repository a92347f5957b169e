//! The rectangle about a region of the smaller image.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use super::gradients::{Gradients, apart};
use super::limits::PaperNoseLimits;
use super::segment::Segment;

/// A rectangle of the smaller image, (column, row).
pub(super) struct Rectangle {
    centre: DVec2,
    along: DVec2,
    /// Its ends along and across, px from the centre.
    length: (f64, f64),
    width: (f64, f64),
    /// Level-line angle along it, rad.
    angle: f64,
}

impl Rectangle {
    /// About a region of a mean level-line angle, rad: through its centre of mass by gradient,
    /// along the least moment of inertia, in the sense of its level lines.
    pub(super) fn about(field: &Gradients, pixels: &[usize], angle: f64) -> Self {
        let weight = |at: usize| f64::from(field.size[at]);
        let mass: f64 = pixels.iter().map(|at| weight(*at)).sum();
        let centre = pixels.iter().map(|at| weight(*at) * field.place(*at)).sum::<DVec2>() / mass;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for &at in pixels {
            let (w, d) = (weight(at), field.place(at) - centre);
            (xx, xy, yy) = (xx + w * d.x * d.x, xy + w * d.x * d.y, yy + w * d.y * d.y);
        }
        let along = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
        let against = apart(along.to_angle(), angle) > FRAC_PI_2;
        let along = if against { -along } else { along };
        let extent = |axis: DVec2| {
            let off = pixels.iter().map(|at| axis.dot(field.place(*at) - centre));
            off.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
        };
        Self { centre, along, length: extent(along), width: extent(along.perp()), angle: along.to_angle() }
    }

    /// Its length, px.
    pub(super) fn length(&self) -> f64 {
        self.length.1 - self.length.0
    }

    /// Its width, px; that of a pixel at least (LSD).
    pub(super) fn width(&self) -> f64 {
        (self.width.1 - self.width.0).max(1.0)
    }

    /// Its ends.
    pub(super) fn ends(&self) -> [DVec2; 2] {
        [self.length.0, self.length.1].map(|l| self.centre + self.along * l)
    }

    /// Pixels of a rectangle, and those aligned with it.
    pub(super) fn counted(&self, field: &Gradients, tau: f64) -> (u32, u32) {
        let across = self.along.perp();
        let corner = |l: f64, w: f64| self.centre + self.along * l + across * w;
        let corners = [
            corner(self.length.0, self.width.0),
            corner(self.length.0, self.width.1),
            corner(self.length.1, self.width.0),
            corner(self.length.1, self.width.1),
        ];
        let range = |of: fn(&DVec2) -> f64, most: usize| {
            let (low, high) = corners
                .iter()
                .map(of)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            (low.ceil().max(0.0) as usize, high.floor().min(most as f64 - 1.0).max(0.0) as usize)
        };
        let (mut all, mut aligned) = (0, 0);
        let (top, bottom) = range(|c| c.y, field.rows);
        for row in top..=bottom {
            let (first, last) = self.of_row(row as f64, field.columns);
            for column in first..last {
                all += 1;
                aligned += u32::from(field.is_aligned(row * field.columns + column, self.angle, tau));
            }
        }
        (all, aligned)
    }

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
    pub(super) fn segment(&self) -> Segment {
        let end = |l: f64| {
            let p = (self.centre + self.along * l + DVec2::splat(0.5)) / PaperNoseLimits::get().scale;
            DVec2::new(p.x, -p.y)
        };
        Segment { ends: [end(self.length.0), end(self.length.1)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let (all, aligned) = r.counted(&field, 0.1);
            assert_eq!((all as usize, aligned), (tried.count(), all), "{deg}");
        }
    }
}
