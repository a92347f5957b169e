//! Sizes of the first three workpieces by the lines and arcs that frames show.
//!
//! Both halves of the silhouette are measured: the mean of both does not depend on where the axis
//! stands, nor, in first order, on its tilt. A frame gives one value of the size; the frames at
//! several spindle angles give its mean and scatter, the calibration what all of them share.

use glam::DVec2;

use super::error::WornToolError;
use super::workpieces::{
    ARC_MM, BEHIND_MM, FACE_Z_MM, LARGE_MM, SHOULDER_MM, SHOULDER_Z_MM, SMALL_MM, Workpiece,
};
use crate::frame::Frame;
use crate::gauge::generatrix::{ExpectedPiece, FoundPiece, HalfSilhouette, Placement, measure_generatrix};
use crate::gauge::{Calibration, FrameEdges};
use crate::outline::{Arc, Piece};

/// A size by the gauge, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measured {
    /// Its error.
    pub(super) error_um: f64,
    /// Its standard uncertainty.
    pub(super) u_um: f64,
    /// Calipers in all frames that lie on no piece; none of a diameter by stations.
    pub(super) left_out: Option<usize>,
}

/// A size by frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct SizeOfFrames {
    pub(super) workpiece: Workpiece,
    pub(super) cone_rad: f64,
}

/// What a frame shows.
pub(super) struct Seen {
    /// The pieces above the axis, then those below.
    found: Vec<FoundPiece>,
    axis_row_px: f64,
    central_column_px: f64,
    /// Machine z of that column, mm.
    z_mm: f64,
}

impl Seen {
    fn placement(&self, mm_per_px: f64) -> Placement {
        let zero_column_px = self.central_column_px - self.z_mm / mm_per_px;
        Placement { axis_row_px: self.axis_row_px, zero_column_px, mm_per_px }
    }
}

/// Radius at Z 0 and slope of a line X(Z).
type Slope = (f64, f64);

impl SizeOfFrames {
    /// The pieces that the size needs, as drawn.
    fn pieces(&self) -> Vec<Piece> {
        let (large, small) = (0.5 * LARGE_MM, 0.5 * SMALL_MM);
        let length = (large - small) / self.cone_rad.tan();
        // a tenth of the cone off both ends: beyond the fillet of the largest nose
        let cone = |from: f64| {
            let ends = [DVec2::new(large, from), DVec2::new(small, from + length)];
            Piece::line(ends[0], ends[1], self.cone_rad).between(0.1, 0.9)
        };
        let right = std::f64::consts::FRAC_PI_2;
        match self.workpiece {
            Workpiece::LengthBehindCone => {
                let (face, to) = (SHOULDER_Z_MM, SHOULDER_Z_MM + BEHIND_MM);
                // clear of the fillet of a nose of 2 mm, and of the blur of both corners
                let cylinder = Piece::line(DVec2::new(large, to - 1.0), DVec2::new(large, face + 2.5), 0.0);
                let [inner, outer] = [large + 2.5, 0.5 * SHOULDER_MM - 0.5];
                let face = Piece::line(DVec2::new(inner, face), DVec2::new(outer, face), right);
                vec![cone(to), cylinder, face]
            }
            Workpiece::LargeDiameter => vec![cone(0.0)],
            Workpiece::ArcRadius => {
                let centre = DVec2::new(large - ARC_MM, FACE_Z_MM - ARC_MM);
                let arc = Arc { centre, radius_mm: ARC_MM };
                vec![Piece::arc(arc, 3f64.to_radians(), 87f64.to_radians())]
            }
            Workpiece::BatchDiameter => Vec::new(),
        }
    }

    /// Measures the pieces in a frame.
    pub(super) fn see(
        &self,
        frame: &Frame,
        edges: Option<&FrameEdges>,
        calibration: &Calibration,
    ) -> Result<Seen, WornToolError> {
        let view = frame.view();
        let middle = 0.5 * (view.rows() as f64 - 1.0);
        let mut seen = Seen {
            found: Vec::new(),
            axis_row_px: edges.and_then(axis_row_px).unwrap_or(middle),
            central_column_px: 0.5 * (view.columns() as f64 - 1.0),
            z_mm: frame.meta.z_mm,
        };
        let of =
            |half: HalfSilhouette| self.pieces().into_iter().map(move |piece| ExpectedPiece { piece, half });
        let expected: Vec<_> = of(HalfSilhouette::Above).chain(of(HalfSilhouette::Below)).collect();
        let at = seen.placement(calibration.scale_mm_per_px);
        seen.found = measure_generatrix(&view, &expected, &at)?;
        Ok(seen)
    }

    /// The error of the size over all frames.
    pub(super) fn of_part(
        &self,
        seen: &[Seen],
        calibration: &Calibration,
    ) -> Result<Measured, WornToolError> {
        let n = seen.len() as f64;
        let values = |scale: f64, offset_mm: f64| -> Option<Vec<f64>> {
            seen.iter().map(|s| self.error_mm(&s.found, &s.placement(scale), 0.5 * offset_mm)).collect()
        };
        let (scale, offset) = (calibration.scale_mm_per_px, calibration.offset_mm);
        let mean = |scale: f64, offset_mm: f64| Some(values(scale, offset_mm)?.iter().sum::<f64>() / n);
        let pieces = || seen.iter().flat_map(|s| &s.found);
        let left_out = Some(pieces().map(FoundPiece::left_out).sum::<usize>());
        // few frames may scatter by little, but by no less than one piece does by noise
        let noise_px = pieces().map(|p| p.u_px().powi(2)).sum::<f64>() / pieces().count().max(1) as f64;
        let noise_px = noise_px.sqrt();
        let found = || -> Option<Measured> {
            let each = values(scale, offset)?;
            let middle = mean(scale, offset)?;
            let square = each.iter().map(|v| (v - middle).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
            // a step of 1e-4 of the scale, and of a micrometre
            let steps = (1e-4 * scale, 1e-3);
            let by_scale = (mean(scale + steps.0, offset)? - middle) / steps.0;
            let by_offset = (mean(scale, offset + steps.1)? - middle) / steps.1;
            let random = square.sqrt().max(scale * noise_px) / n.sqrt();
            let u = random.hypot(calibration.u_of_size_mm(by_scale, by_offset));
            Some(Measured { error_um: 1e3 * middle, u_um: 1e3 * u, left_out })
        };
        let what = "no frame that shows its size";
        found().filter(|_| n > 0.0).ok_or(WornToolError::Surface { workpiece: self.workpiece.number(), what })
    }

    /// The size less the drawn one, mm; `offset_mm` lies between the image and each edge.
    fn error_mm(&self, found: &[FoundPiece], at: &Placement, offset_mm: f64) -> Option<f64> {
        let (above, below) = found.split_at(found.len() / 2);
        let pair = |k: usize| Some((above.get(k)?, below.get(k)?));
        let lines = |k: usize| Some([pair(k)?.0.line()?, pair(k)?.1.line()?].map(|l| l.in_mm(at, offset_mm)));
        // X = (d − n_z·Z)/n_x, the mean of both halves
        let slope = |k: usize| -> Option<Slope> {
            let [a, b] = lines(k)?.map(|(n, d)| (d / n.x, -n.y / n.x));
            Some((0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1)))
        };
        match self.workpiece {
            Workpiece::LengthBehindCone => {
                let (cone, cylinder) = (slope(0)?, slope(1)?);
                let corner = (cylinder.0 - cone.0) / (cone.1 - cylinder.1);
                let x = 0.25 * (SHOULDER_MM + LARGE_MM);
                let [a, b] = lines(2)?.map(|(n, d)| (d - n.x * x) / n.y);
                Some(corner - 0.5 * (a + b) - BEHIND_MM)
            }
            Workpiece::LargeDiameter => Some(2.0 * slope(0)?.0 - LARGE_MM),
            Workpiece::ArcRadius => {
                let (a, b) = pair(0)?;
                let [a, b] = [a.arc()?, b.arc()?].map(|arc| arc.in_mm(at, offset_mm).1);
                Some(0.5 * (a + b) - ARC_MM)
            }
            Workpiece::BatchDiameter => None,
        }
    }
}

/// Median row of the middles of both edges; `None` where no column has both.
fn axis_row_px(edges: &FrameEdges) -> Option<f64> {
    let pairs = edges.top.iter().zip(&edges.bottom).filter(|(t, b)| t.is_usable() && b.is_usable());
    let middles: Vec<f64> = pairs.map(|(t, b)| 0.5 * (t.row_px + b.row_px)).collect();
    (!middles.is_empty()).then(|| crate::numerics::robust::median_of(middles))
}
