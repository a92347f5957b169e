//! What a gauge is set up by: focus along the field, alignment, light.
//!
//! In: the pixels of a frame (shaft level) and, where it was measured, its edges. Out: a
//! [`SetupReading`]. `focus` is the blur of a part of an edge, `light` the use of the grey scale,
//! `evenness` the light outside of the part against an even one. None imports another; one more
//! figure is a file here, a field of the reading and a line of `cli/watch/setup_page`.

mod evenness;
mod focus;
mod light;

use self::evenness::Evenness;
use self::focus::EdgeSamples;
use self::light::Light;
use crate::frame::FrameView;
use crate::gauge::{Edge, FrameEdges, Pose};

/// Variance of a pixel's own area, px²: that of a uniform distribution one pixel wide.
const PIXEL_VARIANCE: f64 = 1.0 / 12.0;
/// Most columns of a third that its blur is of: noise of 1 % of the contrast then leaves some 0.2 %
/// of the blur.
const MOST_COLUMNS: usize = 256;

/// Figures that a gauge is set up by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SetupReading {
    /// How the grey scale is used.
    pub light: Light,
    /// Evenness of the light; `None` where too little of the field is lit and known to be so.
    pub evenness: Option<Evenness>,
    /// What the edges show; `None` of a frame that was not measured.
    pub edges: Option<EdgesReading>,
}

/// Figures of the edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgesReading {
    /// Blur at the upper and lower edge in the left, middle and right third of the field, px
    /// (standard deviation without the pixel's own area); `None` where it cannot be found.
    pub blur_px: [[Option<f64>; 3]; 2],
    /// Angle of the axis to the rows, degrees; above 0 where it falls to the right.
    pub tilt_deg: f64,
    /// (light − dark)/(light + dark), mean of both edges, 0 to 1 (Michelson).
    pub contrast: f64,
    /// Largest gradient of the upper and lower edge, counts/px.
    pub gradient: [f64; 2],
    /// Contrast over noise at mid-edge.
    pub snr: f64,
}

impl SetupReading {
    /// The figures of a frame. `black` is the grey value without light; `is_backlit`: what is not
    /// part is light.
    pub(crate) fn of(view: &FrameView<'_>, edges: Option<&FrameEdges>, black: f64, is_backlit: bool) -> Self {
        let light = Light::of(view, black);
        let evenness = is_backlit.then(|| Evenness::of(view, edges, black)).flatten();
        Self { light, evenness, edges: edges.map(|edges| EdgesReading::of(view, edges)) }
    }
}

impl EdgesReading {
    fn of(view: &FrameView<'_>, edges: &FrameEdges) -> Self {
        let figures = &edges.figures;
        let gradient = |side: usize| {
            let sigma_px = (figures.sigma_px[side].powi(2) + PIXEL_VARIANCE).sqrt();
            // That of a Gaussian edge at its place.
            (figures.light[side] - figures.dark[side]).abs() / (std::f64::consts::TAU.sqrt() * sigma_px)
        };
        let contrast = |side: usize| {
            let (light, dark) = (figures.light[side], figures.dark[side]);
            (light - dark) / (light + dark)
        };
        Self {
            blur_px: [thirds(view, edges, 0), thirds(view, edges, 1)],
            tilt_deg: Pose::of(edges).tan_tilt.atan().to_degrees(),
            contrast: 0.5 * (contrast(0) + contrast(1)),
            gradient: [gradient(0), gradient(1)],
            snr: figures.snr,
        }
    }
}

/// Blur of the upper (0) or lower (1) edge in each third of the field, px.
fn thirds(view: &FrameView<'_>, edges: &FrameEdges, side: usize) -> [Option<f64>; 3] {
    let columns = edges.columns().min(view.columns());
    let near_px = edges.figures.sigma_px[side];
    std::array::from_fn(|third| {
        let (from, to) = (third * columns / 3, (third + 1) * columns / 3);
        let step = (to - from).div_ceil(MOST_COLUMNS).max(1);
        let mut samples = EdgeSamples::within(focus::reach_px(near_px));
        for column in (from..to).step_by(step) {
            let (top, bottom) = (&edges.top[column], &edges.bottom[column]);
            if top.is_usable() && bottom.is_usable() {
                add_column(&mut samples, view, column, [top, bottom], side);
            }
        }
        samples.blur_px(near_px)
    })
}

/// Adds the grey values around one edge of a column, as far as the middle of the part.
fn add_column(
    samples: &mut EdgeSamples,
    view: &FrameView<'_>,
    column: usize,
    [top, bottom]: [&Edge; 2],
    side: usize,
) {
    let (edge_px, outwards) = if side == 0 { (top.row_px, -1.0) } else { (bottom.row_px, 1.0) };
    let inside_px = (0.5 * (bottom.row_px - top.row_px)).min(samples.reach_px());
    let (inner, outer) = (edge_px - outwards * inside_px, edge_px + outwards * samples.reach_px());
    let (first, last) =
        (inner.min(outer).ceil().max(0.0) as usize, inner.max(outer).floor().max(0.0) as usize);
    for row in first..=last {
        if let Some(grey) = view.get(row, column) {
            samples.push(outwards * (row as f64 - edge_px), f64::from(grey));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Frame, FrameMeta};
    use crate::gauge::{EdgeState, FrameFigures};
    use crate::numerics::distributions::phi_cdf;

    const COLUMNS: usize = 240;
    const ROWS: usize = 120;
    const TILT: f64 = 0.02;

    fn rows_of(column: usize) -> [f64; 2] {
        let off = TILT * (column as f64 - 120.0);
        [40.3 + off, 80.6 + off]
    }

    /// A shadow whose blur grows along the field from 1.0 to 1.6 px; pixels are sampled at their
    /// centres, so that no pixel's area is in it.
    fn frame() -> Frame {
        let sigma = |column: usize| 1.0 + 0.6 * column as f64 / COLUMNS as f64;
        let grey = |row: usize, column: usize| {
            let ([top, bottom], s) = (rows_of(column), sigma(column));
            let light = phi_cdf((top - row as f64) / s) + phi_cdf((row as f64 - bottom) / s);
            (100.0 + 800.0 * light) as f32
        };
        let all = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| grey(row, column)));
        Frame::linear(all.collect(), ROWS, COLUMNS, Some(1000.0), FrameMeta::default())
    }

    fn edges() -> FrameEdges {
        let edge =
            |row_px| Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good };
        let figures = FrameFigures {
            sigma_px: [1.3; 2],
            dark: [100.0; 2],
            light: [900.0; 2],
            snr: 50.0,
            ..FrameFigures::default()
        };
        FrameEdges {
            top: (0..COLUMNS).map(|c| edge(rows_of(c)[0])).collect(),
            bottom: (0..COLUMNS).map(|c| edge(rows_of(c)[1])).collect(),
            figures,
            ..FrameEdges::default()
        }
    }

    #[test]
    fn blur_tilt_contrast_and_gradient_are_those_drawn() {
        let frame = frame();
        let reading = SetupReading::of(&frame.view(), Some(&edges()), 0.0, true);
        let found = reading.edges.unwrap();
        for side in found.blur_px {
            for (blur_px, mean_px) in side.into_iter().zip([1.1, 1.3, 1.5]) {
                // Sampled without a pixel's area, of which one is taken off.
                let drawn_px = f64::sqrt(mean_px * mean_px - PIXEL_VARIANCE);
                assert!((blur_px.unwrap() / drawn_px - 1.0).abs() < 0.02, "{blur_px:?} {drawn_px}");
            }
        }
        assert!((found.tilt_deg - TILT.atan().to_degrees()).abs() < 1e-6, "{}", found.tilt_deg);
        assert!((found.contrast - 0.8).abs() < 1e-12 && found.snr == 50.0);
        let wanted = 800.0 / (std::f64::consts::TAU * (1.69 + PIXEL_VARIANCE)).sqrt();
        assert!((found.gradient[0] - wanted).abs() < 1e-9, "{:?}", found.gradient);
        assert!(reading.light.saturated_share == 0.0 && (reading.light.brightest - 900.0).abs() < 1.0);
        assert!(reading.evenness.unwrap().lowest.abs() < 1e-3, "{:?}", reading.evenness);
    }

    #[test]
    fn a_frame_without_edges_has_its_light() {
        let frame = frame();
        let reading = SetupReading::of(&frame.view(), None, 0.0, false);
        assert!(reading.edges.is_none() && reading.evenness.is_none());
        assert!((reading.light.brightest - 900.0).abs() < 1.0);
    }
}
