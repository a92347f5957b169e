//! A flank found in its image: the reference curve and the strip along it.

use super::edge::{Air, reference, trace};
use super::error::FlankError;
use super::lift::lifted;
use super::limits::FlankLimits;
use super::raster::Raster;
use super::reference::{EdgeLine, edge_line};
use super::settings::FlankSide;
use super::strip::Frame;

/// A rectified flank.
#[derive(Clone, Debug)]
pub(crate) struct Located {
    /// Where its strip lies.
    pub frame: Frame,
    /// The strip's grey values.
    pub strip: Raster,
    /// Rows of each column inside of the image.
    pub inside: Vec<usize>,
    /// Standard uncertainty of the reference curve's level, µm.
    pub u_reference_um: f64,
    /// The line that was taken, and another that could be the edge.
    rival: Option<[EdgeLine; 2]>,
    /// A border at another side than the one that was stated, which stands out more.
    pub clearer: Option<EdgeLine>,
}

/// What is known of an edge before it is looked for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct KnownEdge<'a> {
    /// At which side of it the flank lies.
    pub side: FlankSide,
    /// The baseline's curve.
    pub shape: Option<&'a [f64]>,
}

impl Located {
    /// # Errors
    /// Another border that could be the cutting edge as well.
    pub(crate) fn certain(&self) -> Result<(), FlankError> {
        let Some(lines) = self.rival else { return Ok(()) };
        let [middle, other] = lines.map(|line| line.middle());
        Err(FlankError::TwoEdges {
            row: middle.y,
            column: middle.x,
            other_row: other.y,
            other_column: other.x,
        })
    }
}

/// Finds the cutting edge and cuts the strip along it; where two borders could be the edge, along
/// the likelier one ([`Located::certain`]).
///
/// # Errors
/// No flank; an image that is too small; an edge without a smooth reference.
pub(crate) fn locate(image: &Raster, um_per_px: f64, known: KnownEdge<'_>) -> Result<Located, FlankError> {
    let limits = FlankLimits::get();
    if image.rows.min(image.columns) < limits.least_side_px {
        let (rows, columns, least) = (image.rows, image.columns, limits.least_side_px);
        return Err(FlankError::TooSmall { rows, columns, least });
    }
    let smooth;
    let step_px = limits.pitch_um / um_per_px;
    let sampled = if step_px > 1.0 {
        // what a strip's pitch cannot carry is taken out before it is sampled
        let sigma = 0.5 * (step_px * step_px - 1.0).sqrt();
        smooth = image.blurred(sigma, sigma);
        &smooth
    } else {
        image
    };
    let edge = edge_line(image, known.side)?;
    let line = lifted(sampled, edge.line, um_per_px);
    let mut frame = Frame::about(line, um_per_px, (2.0 * limits.above_um, 2.0 * limits.above_um));
    let mut u_reference_um = 0.0;
    // the second round follows an edge that bends out of the first strip's middle
    for round in 0..2 {
        let (strip, _) = frame.cut(sampled);
        // of both courses of the air that along which the edge is the smoother curve
        let curves = [Air::Even, Air::Changing].into_iter().filter_map(|air| {
            let mut traced = trace(&strip, &frame, air);
            for (k, depth) in traced.depth_um.iter_mut().enumerate() {
                *depth += frame.reference_px(frame.s_px(k as f64)) * um_per_px;
            }
            reference(&traced, &frame, known.shape)
        });
        let found = curves
            .min_by(|a, b| a.u_um.total_cmp(&b.u_um))
            .ok_or_else(|| FlankError::Reference("no smooth curve passes along the edge".to_owned()))?;
        frame.curve = found.curve;
        u_reference_um = found.u_um;
        if round == 0 {
            frame.above = (limits.above_um / frame.row_um()) as usize;
            frame.below = frame.above;
        }
    }
    if u_reference_um > limits.most_reference_u_um {
        return Err(FlankError::Reference(format!(
            "the border that is found scatters about a smooth curve so much that its level has a standard uncertainty of \
             {u_reference_um:.0} µm, at most {:.0} are allowed: it is no cutting edge, or hardly visible",
            limits.most_reference_u_um
        )));
    }
    frame.above = (limits.above_um / frame.row_um()) as usize;
    frame.below = (limits.depth_um / frame.row_um()) as usize;
    let (strip, inside) = frame.cut(sampled);
    let rival = edge.rival.map(|other| [edge.line, other]);
    Ok(Located { frame, strip, inside, u_reference_um, rival, clearer: edge.clearer })
}
