//! Regions of like level-line angles, and how they are made dense (section 2.5 of LSD).

use glam::DVec2;

use super::gradients::{Gradients, apart};
use super::limits::PaperNoseLimits;
use super::rectangle::Rectangle;

/// A region of the smaller image.
#[derive(Clone, Debug)]
pub(super) struct Region {
    /// Its pixels; the seed first.
    pub(super) pixels: Vec<usize>,
    /// Its mean level-line angle, rad.
    pub(super) angle: f64,
}

impl Region {
    /// Grows from a pixel over eight neighbours whose angles are within `tau` of the mean direction
    /// so far.
    pub(super) fn grown(field: &Gradients, seed: usize, tau: f64, used: &mut [bool]) -> Self {
        let mut angle = field.angle_of(seed);
        let (mut sum, mut pixels, mut next) = (DVec2::from_angle(angle), vec![seed], 0);
        used[seed] = true;
        while next < pixels.len() {
            let (row, column) = (pixels[next] / field.columns, pixels[next] % field.columns);
            next += 1;
            for r in row.saturating_sub(1)..=(row + 1).min(field.rows - 1) {
                for c in column.saturating_sub(1)..=(column + 1).min(field.columns - 1) {
                    let at = r * field.columns + c;
                    if used[at] || !field.is_aligned(at, angle, tau) {
                        continue;
                    }
                    used[at] = true;
                    pixels.push(at);
                    sum += DVec2::from_angle(field.angle_of(at));
                    angle = sum.to_angle();
                }
            }
        }
        Self { pixels, angle }
    }

    /// Share of the rectangle about it that its pixels fill.
    fn density(&self, about: &Rectangle) -> f64 {
        self.pixels.len() as f64 / (about.length() * about.width()).max(1.0)
    }

    /// A region whose pixels fill their rectangle, of this one: a straight edge that goes over into
    /// an arc grows on along it, up to τ, into an angle that is no line. It is grown again from its
    /// seed by the tolerance of the angles beside the seed; where that does not do, the pixels
    /// farthest from the seed are left out. `None` where nothing dense is left.
    pub(super) fn dense(self, field: &Gradients, used: &mut [bool]) -> Option<(Self, Rectangle)> {
        let limits = PaperNoseLimits::get();
        let about = Rectangle::about(field, &self.pixels, self.angle);
        if self.density(&about) >= limits.density {
            return Some((self, about));
        }
        let tau = 2.0 * self.spread_at_seed(field, about.width());
        self.pixels.iter().for_each(|at| used[*at] = false);
        let mut region = Self::grown(field, self.pixels[0], tau, used);
        let mut about = Rectangle::about(field, &region.pixels, region.angle);
        let seed = field.place(region.pixels[0]);
        let mut radius = about.ends().iter().map(|end| end.distance(seed)).fold(0.0, f64::max);
        while region.pixels.len() >= 2 && region.density(&about) < limits.density {
            radius *= limits.radius_step;
            region.pixels.retain(|at| {
                let near = field.place(*at).distance(seed) <= radius;
                used[*at] = near;
                near
            });
            about = Rectangle::about(field, &region.pixels, region.angle);
        }
        (region.pixels.len() >= 2).then_some((region, about))
    }

    /// Root mean square of the angles about the seed's within `reach` px of it, rad.
    fn spread_at_seed(&self, field: &Gradients, reach: f64) -> f64 {
        let (seed, angle) = (field.place(self.pixels[0]), field.angle_of(self.pixels[0]));
        let near = || self.pixels.iter().filter(|at| field.place(**at).distance(seed) <= reach);
        let square: f64 = near().map(|at| apart(field.angle_of(*at), angle).powi(2)).sum();
        (square / near().count().max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Level lines of a strip 3 px wide: straight for 60 px, then an arc of 60 px radius that turns
    /// by a radian.
    fn edge_and_arc() -> Gradients {
        let (columns, rows) = (130, 80);
        let mut angle = vec![None; columns * rows];
        let centre = DVec2::new(70.0, 80.0);
        for (at, angle) in angle.iter_mut().enumerate() {
            let p = DVec2::new((at % columns) as f64, (at / columns) as f64);
            let arm = p - centre;
            let turn = arm.x.atan2(-arm.y);
            *angle = if (10.0..=70.0).contains(&p.x) && (p.y - 20.0).abs() <= 1.0 {
                Some(0.0)
            } else if (0.0..=1.0).contains(&turn) && (arm.length() - 60.0).abs() <= 1.0 {
                Some(turn as f32)
            } else {
                None
            };
        }
        let size = angle.iter().map(|a| if a.is_some() { 10.0 } else { 0.0 }).collect();
        Gradients { angle, size, columns, rows }
    }

    #[test]
    fn a_region_that_grew_from_an_edge_onto_an_arc_is_the_edge_again() {
        let field = edge_and_arc();
        let tau = PaperNoseLimits::get().tolerance_deg.to_radians();
        let mut used = vec![false; field.size.len()];
        let grown = Region::grown(&field, 20 * field.columns + 30, tau, &mut used);
        let before = grown.pixels.len();
        assert!(before > 61 * 3 + 30, "{before} px: it should have grown onto the arc");
        let about = Rectangle::about(&field, &grown.pixels, grown.angle);
        assert!(grown.density(&about) < PaperNoseLimits::get().density);
        let (dense, about) = grown.dense(&field, &mut used).unwrap();
        assert!(dense.density(&about) >= PaperNoseLimits::get().density);
        let ends = about.ends();
        let slope = ((ends[1].y - ends[0].y) / (ends[1].x - ends[0].x)).atan();
        assert!(slope.abs() < 0.01 && about.length() > 55.0, "{slope} {}", about.length());
        // what is left out may seed another region
        assert_eq!(used.iter().filter(|u| **u).count(), dense.pixels.len());
    }
}
