//! Results of the edge finder: both edges of every column, each with its uncertainty, or a gap with
//! its reason.

use thiserror::Error;

use crate::profile::Reason;

/// Whether an edge may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeState {
    /// Usable without reservation.
    Good,
    /// Usable with the larger uncertainty stated; the reason is what impairs it.
    Impaired(Reason),
    /// Refused.
    Gap(Reason),
}

/// One edge of one column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Row of the edge, px, pixel centres at integers; NaN in a gap.
    pub row_px: f64,
    /// Standard uncertainty that is independent from column to column, px.
    pub u_own_px: f32,
    /// Standard uncertainty shared with the columns nearby (pooled levels), px.
    pub u_shared_px: f32,
    /// Residual χ² over its degrees of freedom, with the frame's noise.
    pub chi2: f32,
    /// Whether it may be used.
    pub state: EdgeState,
}

impl Edge {
    /// A refused edge.
    pub fn gap(reason: Reason) -> Self {
        Self {
            row_px: f64::NAN,
            u_own_px: f32::NAN,
            u_shared_px: f32::NAN,
            chi2: f32::NAN,
            state: EdgeState::Gap(reason),
        }
    }

    /// Whether the edge has a value.
    pub fn is_usable(&self) -> bool {
        !matches!(self.state, EdgeState::Gap(_))
    }

    /// Combined standard uncertainty of this one edge, px.
    pub fn u_px(&self) -> f64 {
        // squares of single precision neither overflow nor vanish in double precision
        let (own, shared) = (f64::from(self.u_own_px), f64::from(self.u_shared_px));
        (own * own + shared * shared).sqrt()
    }

    /// The reason reported for a column of two edges: that of a gap takes precedence over an
    /// impairment's.
    pub fn reason_of_both(top: &Self, bottom: &Self) -> Option<Reason> {
        let gap = [top, bottom].into_iter().find(|e| !e.is_usable()).and_then(Self::reason);
        gap.or_else(|| top.reason()).or_else(|| bottom.reason())
    }

    /// The reason of a gap or an impairment.
    pub fn reason(&self) -> Option<Reason> {
        match self.state {
            EdgeState::Good => None,
            EdgeState::Impaired(reason) | EdgeState::Gap(reason) => Some(reason),
        }
    }
}

/// Φ⁻¹(¾): from a quarter of a Gaussian edge's light to half of it, in σ.
const QUARTER_TO_HALF: f64 = 0.674_489_75;

/// Figures of a frame, found while its edges were measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct FrameFigures {
    /// Blur at the upper and lower edge, px (standard deviation without the pixel's own area).
    pub sigma_px: [f64; 2],
    /// How far into the shadow of the place stated the geometric edge may lie because its
    /// edge-spread function was learnt from the frame itself, px; 0 with any other. Masters
    /// measured in the same way take it out.
    #[serde(rename = "unknown_place_px")]
    pub position_ambiguity_px: [f64; 2],
    /// Mean dark level at the upper and lower edge, counts.
    pub dark: [f64; 2],
    /// Mean light level at the upper and lower edge, counts.
    pub light: [f64; 2],
    /// Noise (standard deviation) in the dark and in the light, counts.
    pub noise: [f64; 2],
    /// Contrast over noise at mid-edge.
    pub snr: f64,
    /// Residual χ² of the best fitting fifth over its expectation: 1 where model and noise describe
    /// the frame, or where the edges leave what the calibration's masters left. Uncertainties are
    /// multiplied by its root where it exceeds 1.2.
    #[serde(rename = "misfit")]
    pub reduced_chi2: f64,
    /// Whether grey values are whole counts.
    pub quantised: bool,
    /// Standard uncertainty of the upper and lower edge by rounding that repeats in neighbouring
    /// columns and in every frame, px: noise below half a count leaves some.
    pub rounding_px: [f64; 2],
    /// Other shadows in the frame.
    pub shadows: ShadowsSeen,
}

impl FrameFigures {
    /// Standard uncertainty of a width by the unknown place of learnt edges, px: both may lie
    /// inwards by anything up to the limits.
    pub fn u_position_px(&self) -> f64 {
        (self.position_ambiguity_px[0] + self.position_ambiguity_px[1]) / 3.0_f64.sqrt()
    }

    /// Variance of a width by rounding that repeats, px².
    pub(crate) fn rounding_variance(&self) -> f64 {
        self.rounding_px.iter().map(|u| u * u).sum()
    }

    /// Limit of a width's error where edges that could not be learnt were fitted by the Gaussian
    /// and the masters' were learnt, px: the distance from a quarter of the light to half of it,
    /// 0.6745 σ, at each such edge.
    pub fn unlearnt_position_px(&self) -> f64 {
        let of = |side: usize| {
            if self.position_ambiguity_px[side] == 0.0 { QUARTER_TO_HALF * self.sigma_px[side] } else { 0.0 }
        };
        of(0) + of(1)
    }

    /// Whether both edges were fitted by an edge-spread function estimated from the frame.
    pub fn is_learnt(&self) -> bool {
        self.position_ambiguity_px.iter().all(|p| *p > 0.0)
    }
}

/// Columns over which residuals are averaged to find a systematic residual that neighbours share.
pub(crate) const RESIDUAL_BLOCK: usize = 128;

/// Both edges of every column of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameEdges {
    /// Upper edges, one a column.
    pub top: Vec<Edge>,
    /// Lower edges, one a column.
    pub bottom: Vec<Edge>,
    /// Columns over which `u_shared_px` is shared, at the upper and lower edge.
    pub shared_length: [f32; 2],
    /// The part of `u_shared_px` that a systematic residual of the edge model states, one for every
    /// `RESIDUAL_BLOCK` columns of the upper and lower edge.
    pub model_uncertainty_px: [Vec<f32>; 2],
    /// The part of `u_shared_px` that the unknown shape of what is clipped of the upper and lower
    /// edge states, px, √2 for their common lens included; 0 where nothing is clipped.
    pub clipped_px: [f64; 2],
    /// The frame's own figures.
    pub figures: FrameFigures,
}

/// Mean edge (or width) over columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mean {
    /// Mean, px.
    pub value_px: f64,
    /// Standard uncertainty with the shared part carried, px.
    pub u_px: f64,
    /// Columns in it.
    pub columns: usize,
}

impl FrameEdges {
    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.top.len()
    }

    /// Columns in which both edges are usable.
    pub fn valid(&self) -> usize {
        self.top.iter().zip(&self.bottom).filter(|(t, b)| t.is_usable() && b.is_usable()).count()
    }

    /// Variance of a column's width by what a systematic residual of the edge model states at both
    /// edges, px².
    pub(crate) fn model_variance(&self, column: usize) -> f64 {
        let side = |side: &Vec<f32>| side.get(column / RESIDUAL_BLOCK).map_or(0.0, |u| f64::from(*u).powi(2));
        self.model_uncertainty_px.iter().map(side).sum()
    }

    /// Variance of a width by what is clipped of both edges' shapes, px².
    pub(crate) fn clipped_variance(&self) -> f64 {
        self.clipped_px.iter().map(|u| u * u).sum()
    }

    /// Variance of a column's width that averages neither over columns nor over frames: model
    /// uncertainty, clipped parts of the edges' shapes, and rounding that repeats, px².
    pub(crate) fn repeated_variance(&self, column: usize) -> f64 {
        self.model_variance(column) + self.clipped_variance() + self.figures.rounding_variance()
    }

    /// Shadow width (bottom − top) of a column, px, where both edges are usable.
    pub fn width_px(&self, column: usize) -> Option<f64> {
        let (top, bottom) = (self.top.get(column)?, self.bottom.get(column)?);
        (top.is_usable() && bottom.is_usable()).then_some(bottom.row_px - top.row_px)
    }

    /// Moves the edges to where their windows lie on the sensor, for a camera that reads two
    /// windows out as one frame, the one around the upper edge above the one around the lower edge:
    /// `top_px` and `bottom_px` are what a row of the frame lacks of its row on the sensor in
    /// either.
    pub fn place_windows(&mut self, top_px: f64, bottom_px: f64) {
        self.top.iter_mut().for_each(|edge| edge.row_px += top_px);
        self.bottom.iter_mut().for_each(|edge| edge.row_px += bottom_px);
    }

    /// Unweighted mean of one line's usable edges over `columns`; `None` without any.
    pub(crate) fn mean(line: &[Edge], shared_length: f32, columns: std::ops::Range<usize>) -> Option<Mean> {
        let used: Vec<(usize, &Edge)> = columns
            .filter_map(|c| line.get(c).map(|edge| (c, edge)))
            .filter(|(_, edge)| edge.is_usable())
            .collect();
        if used.is_empty() {
            return None;
        }
        let n = used.len() as f64;
        let value_px = used.iter().map(|(_, e)| e.row_px).sum::<f64>() / n;
        let own: f64 = used.iter().map(|(_, e)| f64::from(e.u_own_px).powi(2)).sum::<f64>() / (n * n);
        let shared = shared_variance(&used, shared_length);
        Some(Mean { value_px, u_px: (own + shared).sqrt(), columns: used.len() })
    }
}

/// Variance of the shared part of a mean: errors of two columns correlate by a triangle of twice
/// the knots' distance.
fn shared_variance(used: &[(usize, &Edge)], length: f32) -> f64 {
    let n = used.len() as f64;
    let reach = 1.5 * f64::from(length.max(1.0));
    let mean_square = used.iter().map(|(_, e)| f64::from(e.u_shared_px).powi(2)).sum::<f64>() / n;
    // Mean over all pairs of max(0, 1 − |i − j|/reach), from the spread of the columns alone.
    let span = (used[used.len() - 1].0 - used[0].0) as f64;
    let correlation = if span <= reach {
        1.0 - span / (3.0 * reach)
    } else {
        let q = reach / span;
        q - q * q / 3.0
    };
    mean_square * correlation
}

/// A frame that gives no diameter.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("no diameter from this frame ({reason}): {detail}")]
pub struct FrameRefused {
    /// Why.
    pub reason: Reason,
    /// What was seen and what would be right.
    pub detail: String,
}

/// Other shadows in a frame beside the one measured. Rows and thicknesses are those of the coarse
/// search, accurate to a few pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ShadowsSeen {
    /// Shadows with both edges in the field that run along it; bright lines part what they part.
    pub seen: u16,
    /// Which of them was measured, counted from the top from 1; the uppermost one where several
    /// were measured as one.
    pub measured: u16,
    /// Shadows measured together as one part: 1, or the strips beside a bright line.
    pub joined: u16,
    /// Thickness of the light between strips measured as one part, px; 0 without any.
    pub light_inside_px: f64,
    /// Thickness of the largest shadow left out that is at least half as thick as the one measured,
    /// px; 0 without any.
    pub left_out_px: f64,
    /// Mean row of that shadow, px.
    pub left_out_row_px: f64,
}

impl ShadowsSeen {
    /// One shadow and nothing beside it.
    pub(crate) fn one() -> Self {
        Self { seen: 1, measured: 1, joined: 1, ..Self::default() }
    }
}
