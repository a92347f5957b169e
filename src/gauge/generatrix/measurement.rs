//! The measurement: one pooled fit along all pieces, then each piece by its own calipers.

use glam::DVec2;
use thiserror::Error;

use super::arc::{ArcFit, arc_fit};
use super::band::Shape;
use super::expected::{ExpectedPiece, HalfSilhouette, Placement};
use super::found::{FoundArc, FoundLine, FoundPiece};
use super::limits::GeneratrixLimits;
use crate::frame::{FrameView, PixelFormat};
use crate::gauge::edge::estimation::light_field::LightField;
use crate::gauge::nose::bands::Calipers;
use crate::gauge::nose::line::{self, EdgeLine, EdgePoint, LineFit};
use crate::gauge::ring::edge_fit::{Caliper, EdgeFit};
use crate::gauge::ring::edge_pixels::Band;
use crate::gauge::ring::levelled::{fit_levelled, light_of};
use crate::gauge::ring::measurement::RingLightLimits;

/// Why a frame gives no generatrix.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub(crate) enum GeneratrixError {
    /// A piece too short for the scale.
    #[error(
        "piece {piece} is {calipers} calipers of 8 px long, {least} or more are needed: a longer piece or a finer scale"
    )]
    Short {
        /// Number of the piece, from 1.
        piece: usize,
        /// Its calipers.
        calipers: usize,
        /// How many are needed.
        least: usize,
    },
    /// No edge along the pieces.
    #[error("no edge fits along the expected outline: {0}; is the part where its program has it?")]
    Fit(String),
    /// Too blurred.
    #[error("focus lost: the edges' blur is {sigma_px:.1} px, {most_px} px at most")]
    Focus {
        /// Blur found.
        sigma_px: f64,
        /// Largest blur.
        most_px: f64,
    },
    /// Calipers that form no such piece.
    #[error(
        "piece {piece} (row {row:.0}, column {column:.0}): {on} of {calipers} calipers lie on one line or circle; look \
         for contamination, or for another contour than the expected one"
    )]
    OffPiece {
        /// Number of the piece, from 1.
        piece: usize,
        /// Its middle.
        row: f64,
        /// Its middle.
        column: f64,
        /// Calipers on it.
        on: usize,
        /// All of its calipers.
        calipers: usize,
    },
}

/// Measures the expected pieces in a frame.
///
/// # Errors
/// A piece that is too short, not where it is expected, or no line or circle; lost focus.
pub(crate) fn measure_generatrix(
    view: &FrameView<'_>,
    expected: &[ExpectedPiece],
    at: &Placement,
) -> Result<Vec<FoundPiece>, GeneratrixError> {
    let limits = GeneratrixLimits::get();
    let shapes: Vec<Shape> = expected.iter().map(|e| Shape::of(e, at)).collect();
    if let Some((k, short)) = shapes.iter().enumerate().find(|(_, s)| s.count() < limits.least_calipers) {
        let (piece, calipers, least) = (k + 1, short.count(), limits.least_calipers);
        return Err(GeneratrixError::Short { piece, calipers, least });
    }
    let mut work = Work { view, shapes, half_px: limits.first_half_px, light: None, last: None };
    let mut found = Vec::new();
    for round in 0..limits.rounds {
        let moved = work.round(&mut found)?;
        // the first fit only comes near
        if round > 0 && moved < limits.settled_px {
            break;
        }
    }
    let half = |k: usize| expected[k].half;
    Ok(found.iter().enumerate().map(|(k, fit)| fit.piece(half(k), work.shapes[k].count())).collect())
}

struct Work<'a> {
    view: &'a FrameView<'a>,
    shapes: Vec<Shape>,
    half_px: f64,
    light: Option<Option<(LightField, f64)>>,
    last: Option<EdgeFit>,
}

/// A piece by its calipers.
enum PieceFit {
    Line(LineFit),
    Arc(ArcFit),
}

impl PieceFit {
    fn piece(&self, half: HalfSilhouette, calipers: usize) -> FoundPiece {
        match self {
            Self::Line(fit) => FoundPiece::Line(FoundLine {
                half,
                at_px: fit.line.at,
                normal: fit.line.normal,
                u_px: fit.line.u_at(fit.line.at).0,
                left_out: calipers - fit.on_line,
            }),
            Self::Arc(fit) => FoundPiece::Arc(FoundArc {
                half,
                centre_px: fit.centre,
                radius_px: fit.radius,
                convex: fit.convex,
                u_px: fit.u_radius,
                left_out: calipers - fit.on_arc,
            }),
        }
    }

    fn on(&self) -> usize {
        match self {
            Self::Line(fit) => fit.on_line,
            Self::Arc(fit) => fit.on_arc,
        }
    }
}

impl Work<'_> {
    /// One pooled fit and the pieces that follow from it; the farthest movement of one, px.
    fn round(&mut self, found: &mut Vec<PieceFit>) -> Result<f64, GeneratrixError> {
        let limits = GeneratrixLimits::get();
        let raw = self.band(self.half_px);
        if self.light.is_none() {
            let wide = self.band(self.half_px + RingLightLimits::get().field_px);
            self.light = Some(light_of(&wide, self.half_px));
        }
        let light = self.light.as_ref().and_then(Option::as_ref);
        let whole = self.view.format() != PixelFormat::F32;
        let begun = self.last.as_ref().and_then(|last| last.begun);
        let fit = fit_levelled(&raw, light, whole, begun).map_err(GeneratrixError::Fit)?;
        if fit.sigma > limits.most_sigma_px {
            return Err(GeneratrixError::Focus { sigma_px: fit.sigma, most_px: limits.most_sigma_px });
        }
        self.half_px = (limits.band_sigmas * fit.sigma).hypot(0.5).max(limits.least_band_px);
        let (mut first, mut moved) = (0, 0.0_f64);
        found.clear();
        for k in 0..self.shapes.len() {
            let count = self.shapes[k].count();
            let calipers = &fit.calipers[first..first + count];
            let piece = self.piece(k, calipers, fit.sigma)?;
            moved = moved.max(self.follow(k, &piece));
            found.push(piece);
            first += count;
        }
        self.last = Some(fit);
        Ok(moved)
    }

    /// The pixels of all pieces, `light` px towards the light.
    fn band(&self, light: f64) -> Band {
        let middles: Vec<DVec2> = self.shapes.iter().map(Shape::middle).collect();
        let origin = middles.iter().sum::<DVec2>() / middles.len().max(1) as f64;
        let unit_px = middles.iter().map(|m| m.distance(origin)).fold(1.0, f64::max);
        let of = |shape: &Shape| shape.pixels(self.view, (self.half_px, light), (origin, unit_px));
        Band { sectors: self.shapes.iter().flat_map(of).collect(), turned: false, origin, unit_px }
    }

    /// The piece that its calipers lie on.
    fn piece(&self, k: usize, calipers: &[Caliper], sigma: f64) -> Result<PieceFit, GeneratrixError> {
        let fitted = match &self.shapes[k] {
            Shape::Line(line, own) => line_fit(line, own, calipers).map(PieceFit::Line),
            Shape::Arc(arc) => arc_fit(arc, calipers, sigma).map(PieceFit::Arc),
        };
        let on = fitted.as_ref().map_or(0, PieceFit::on);
        let middle = self.shapes[k].middle();
        fitted.filter(|_| on as f64 >= GeneratrixLimits::get().least_on_piece * calipers.len() as f64).ok_or(
            GeneratrixError::OffPiece {
                piece: k + 1,
                row: -middle.y,
                column: middle.x,
                on,
                calipers: calipers.len(),
            },
        )
    }

    /// Lets the band follow a piece; its movement, px.
    fn follow(&mut self, k: usize, piece: &PieceFit) -> f64 {
        match (&mut self.shapes[k], piece) {
            (Shape::Line(line, calipers), PieceFit::Line(fit)) => {
                // the same calipers along it: their middle, on the new line
                let at = line.at - fit.line.normal * fit.line.distance(line.at);
                let reach = 0.5 * calipers.length * calipers.count as f64;
                let turn = line.normal.angle_to(fit.line.normal).abs();
                let moved = at.distance(line.at).max(turn * reach);
                *line = EdgeLine::coarse(fit.line.normal, at);
                moved
            }
            (Shape::Arc(arc), PieceFit::Arc(fit)) => {
                let moved = fit.centre.distance(arc.centre).max((fit.radius - arc.radius).abs());
                (arc.centre, arc.radius) = (fit.centre, fit.radius);
                moved
            }
            _ => 0.0,
        }
    }
}

/// The line through the calipers of a line.
fn line_fit(line: &EdgeLine, own: &Calipers, calipers: &[Caliper]) -> Option<LineFit> {
    let good = calipers.iter().enumerate().filter(|(_, c)| c.good);
    let point = |(k, c): (usize, &Caliper)| EdgePoint {
        along: own.middle(k),
        shift: c.shift,
        u: c.u_own,
        shared: c.shared,
    };
    let points: Vec<EdgePoint> = good.map(point).collect();
    line::fit(line, &points)
}
