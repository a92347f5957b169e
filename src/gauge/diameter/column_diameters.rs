//! From both edges of a column to a diameter, corrected for the tilt of the axis in the image
//! plane.
//!
//! A column cuts a body of diameter D, whose axis is tilted by τ and whose flanks taper by the half
//! angle α, along a chord w = D·cos τ/(cos²τ − sin²τ·tan²α); so D = w·(cos²τ − sin²τ·tan²α)/cos τ,
//! which is w·cos τ for a cylinder. A bent part has a τ at every column ([`AxisSlope`]); a slope
//! towards the camera leaves a telecentric width unchanged. Before that each edge is corrected for
//! the bias of its curvature and, where the optical setup is calibrated, for the lens' distortion;
//! after it the diameter is referred to 20 °C.

use crate::frame::FrameMeta;
use crate::gauge::calibration::gauge_calibration::Calibration;
use crate::gauge::calibration::{ColumnSpread, Conditions, CovariancePart, PARAMETERS, ReadWidth};
use crate::gauge::edges::{Edge, FrameEdges};
use crate::gauge::width::axis_slope::AxisSlope;
use crate::gauge::width::blur_sensitivity::{trend_factor, u_blur_px};
use crate::gauge::width::curvature_bias::curvature_bias;
use crate::gauge::width::reused::Reused;
use crate::profile::{Diameter, Reading, Reason};

/// Diameters of a frame's columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColumnDiameters {
    /// One a column.
    pub columns: Vec<ColumnDiameter>,
    /// Columns over which [`ColumnDiameter::shared_mm`] is shared.
    pub shared_length: f64,
    /// Scale along z, mm per column.
    pub pitch_mm: f64,
}

/// Diameter of one column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColumnDiameter {
    /// The reading; its `u_random_mm` is that of this one column.
    pub reading: Reading,
    /// Part of `u_random_mm` that the columns nearby share, mm; NaN in a gap, as what follows.
    pub shared_mm: f64,
    /// Shadow width across the axis, px.
    pub width_px: f64,
    /// Height of the middle between both edges above a fixed row of the frame, mm.
    pub middle_mm: f64,
    /// Standard uncertainty of that height by what columns and frames share but for the scale (edge
    /// model, rounding, blur), mm.
    pub u_middle_common_mm: f64,
}

impl ColumnDiameter {
    /// A column without a diameter.
    pub(crate) fn gap(reason: Reason) -> Self {
        Self {
            reading: Reading::Gap(reason),
            shared_mm: f64::NAN,
            width_px: f64::NAN,
            middle_mm: f64::NAN,
            u_middle_common_mm: f64::NAN,
        }
    }
}

impl ColumnDiameters {
    /// Machine z of a column of the frame with this metadata, mm.
    pub(crate) fn z_mm(&self, meta: &FrameMeta, column: usize) -> f64 {
        meta.z_mm + (column as f64 - (self.columns.len() as f64 - 1.0) / 2.0) * self.pitch_mm
    }

    /// Means over intervals of about `step_mm` along z, for the record: (z of the interval's
    /// middle, reading). An interval without a good column is a gap with its most frequent reason.
    pub(crate) fn record(&self, meta: &FrameMeta, step_mm: f64) -> impl Iterator<Item = (f64, Reading)> {
        let size = ((step_mm / self.pitch_mm).round() as usize).clamp(1, self.columns.len().max(1));
        (0..self.columns.len()).step_by(size).map(move |from| {
            let to = (from + size).min(self.columns.len());
            let z_mm = 0.5 * (self.z_mm(meta, from) + self.z_mm(meta, to - 1));
            (z_mm, self.mean(from..to))
        })
    }

    /// Mean over columns; the shared part of the uncertainty does not shrink, which is right for
    /// spans up to `shared_length` and cautious beyond.
    pub fn mean(&self, columns: std::ops::Range<usize>) -> Reading {
        let (mut n, mut d, mut own, mut shared, mut common) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for column in self.within(columns.clone()) {
            if let Reading::Value(value) = column.reading {
                let own_share = column.shared_mm.powi(2);
                n += 1.0;
                d += value.d_mm;
                own += (value.u_random_mm.powi(2) - own_share).max(0.0);
                shared += own_share;
                common += value.u_common_mm;
            }
        }
        if n == 0.0 {
            return Reading::Gap(self.frequent_reason(columns));
        }
        Reading::Value(Diameter {
            d_mm: d / n,
            u_random_mm: (own / (n * n) + shared / n).sqrt(),
            u_common_mm: common / n,
        })
    }

    /// Takes another standard uncertainty that all columns share into them, mm.
    pub(crate) fn widen(&mut self, u_mm: f64) {
        for column in &mut self.columns {
            if let Reading::Value(value) = &mut column.reading {
                value.u_common_mm = value.u_common_mm.hypot(u_mm);
            }
        }
    }

    /// The columns of a range, as far as there are.
    fn within(&self, columns: std::ops::Range<usize>) -> &[ColumnDiameter] {
        let to = columns.end.min(self.columns.len());
        &self.columns[columns.start.min(to)..to]
    }

    fn frequent_reason(&self, columns: std::ops::Range<usize>) -> Reason {
        let mut counts = [(0, Reason::NoEdge); Reason::LAST as usize + 1];
        for column in self.within(columns) {
            if let Reading::Gap(reason) = column.reading {
                let (count, _) = counts[reason as usize];
                counts[reason as usize] = (count + 1, reason);
            }
        }
        // Of equally frequent ones the last in the order of the reasons.
        counts.into_iter().max().map_or(Reason::NoEdge, |(_, reason)| reason)
    }
}

impl Calibration {
    /// Diameters of a frame's columns, corrected for the axis' tilt; gaps stay gaps.
    pub fn diameters(&self, edges: &FrameEdges) -> ColumnDiameters {
        column_diameters(self, edges, &self.conditions())
    }

    /// As [`Self::diameters`], at 20 °C from a part under these conditions.
    pub(crate) fn diameters_under(&self, edges: &FrameEdges, conditions: &Conditions) -> ColumnDiameters {
        column_diameters(self, edges, conditions)
    }

    /// As [`Self::diameters_under`], in the memory of an earlier frame's.
    pub(crate) fn diameters_into(
        &self,
        edges: &FrameEdges,
        conditions: &Conditions,
        out: &mut ColumnDiameters,
    ) {
        fill(out, self, edges, conditions);
    }
}

/// Conversion of a frame's rows into diameters.
struct Reader<'a> {
    calibration: &'a Calibration,
    conditions: &'a Conditions,
    slope: AxisSlope,
    /// Sum of the sources' shares.
    covariance: CovariancePart,
}

impl<'a> Reader<'a> {
    fn new(calibration: &'a Calibration, conditions: &'a Conditions, slope: AxisSlope) -> Self {
        let mut covariance =
            CovariancePart { source: String::new(), matrix: [[0.0; PARAMETERS]; PARAMETERS] };
        for part in calibration.setup.iter().flat_map(|b| &b.parts) {
            let entries = covariance.matrix.iter_mut().flatten().zip(part.matrix.iter().flatten());
            entries.for_each(|(sum, value)| *sum += value);
        }
        Self { calibration, conditions, slope, covariance }
    }

    /// Width across the axis, px, as a perfect lens would have shown it.
    fn width_px(&self, column: usize, top_px: f64, bottom_px: f64) -> f64 {
        let factor = self.slope.factor(column);
        let Some(setup) = &self.calibration.setup else { return (bottom_px - top_px) * factor };
        let row = |row_px| setup.lens.ideal_row(column as f64, row_px);
        let near = 1.0 + setup.lens.telecentricity_per_mm * self.conditions.axis_in_frame_mm();
        (row(bottom_px) - row(top_px)) * factor * near
    }

    /// Height of the middle of two edges above a fixed row of the frame, mm.
    fn middle_mm(&self, column: usize, rows_px: (f64, f64)) -> f64 {
        let middle = |rows: (f64, f64)| -0.5 * (rows.0 + rows.1) * self.calibration.scale_mm_per_px;
        match &self.calibration.setup {
            Some(setup) => {
                let row = |r| setup.lens.ideal_row(column as f64, r) - setup.lens.centre_row_px;
                middle((row(rows_px.0), row(rows_px.1)))
            }
            None => middle(rows_px),
        }
    }

    /// Diameter at 20 °C, mm.
    fn diameter_mm(&self, width_px: f64) -> f64 {
        self.conditions.part_mm(self.calibration.diameter_mm(width_px)) * self.conditions.to_reference()
    }

    /// Common standard uncertainty of the diameter at 20 °C, mm.
    fn u_common_mm(&self, column: usize, rows_px: (f64, f64), width_px: f64) -> f64 {
        let d_mm = self.calibration.diameter_mm(width_px);
        let conditions = conditions_variance(self.calibration, self.conditions, d_mm);
        let Some(setup) = &self.calibration.setup else {
            return self.calibration.u_common_mm(width_px).hypot(conditions.sqrt());
        };
        let scale = self.calibration.scale_mm_per_px;
        let read = ReadWidth {
            columns: ColumnSpread::at(column as f64),
            rows_px,
            chord: self.slope.factor(column),
            axis_y_mm: self.conditions.axis_in_frame_mm(),
        };
        let by = setup.diameter_by(scale, &read);
        (self.covariance.variance(&by) + conditions).sqrt()
    }
}

/// Variance by the conditions, mm².
fn conditions_variance(calibration: &Calibration, conditions: &Conditions, d_mm: f64) -> f64 {
    let (t, u_t) = calibration
        .setup
        .as_ref()
        .map_or((0.0, 0.0), |b| (b.lens.telecentricity_per_mm, b.u_telecentricity_per_mm()));
    [
        conditions.u_temperature_mm(d_mm),
        conditions.u_expansion_mm(d_mm),
        conditions.u_focus_mm(d_mm, t, u_t),
        conditions.u_machine_mm(d_mm, t, u_t),
        conditions.u_edges_mm(),
        conditions.u_limb_mm(d_mm, t),
        conditions.u_drift_mm(d_mm),
    ]
    .iter()
    .map(|u| u * u)
    .sum()
}

pub(crate) fn column_diameters(
    calibration: &Calibration,
    edges: &FrameEdges,
    conditions: &Conditions,
) -> ColumnDiameters {
    let mut out = ColumnDiameters::default();
    fill(&mut out, calibration, edges, conditions);
    out
}

fn fill(out: &mut ColumnDiameters, calibration: &Calibration, edges: &FrameEdges, conditions: &Conditions) {
    let reader = Reader::new(calibration, conditions, AxisSlope::of(edges));
    let both: Reused<usize> = (0..edges.columns()).filter(|c| edges.width_px(*c).is_some()).collect();
    // All columns share the frame's blur; a stream takes it from every frame anew, so that frames
    // average it.
    let (u_blur_px, _) = u_blur_px(edges, &both);
    let u_position_px = calibration.u_position_px(&edges.figures);
    let scale = calibration.scale_mm_per_px * conditions.to_reference();
    let [bias_top, bias_bottom] = [
        curvature_bias(&edges.top, edges.figures.sigma_px[0]),
        curvature_bias(&edges.bottom, edges.figures.sigma_px[1]),
    ];
    out.shared_length = f64::from(edges.shared_length[0].min(edges.shared_length[1]));
    out.pitch_mm = calibration.scale_mm_per_px;
    out.columns.clear();
    for (column, (top, bottom)) in edges.top.iter().zip(&edges.bottom).enumerate() {
        if let Some(reason) = gap(top, bottom) {
            out.columns.push(ColumnDiameter::gap(reason));
            continue;
        }
        let rows_px = (top.row_px - bias_top[column], bottom.row_px - bias_bottom[column]);
        let width_px = reader.width_px(column, rows_px.0, rows_px.1);
        // The residual of the edge model is the same in every frame of one light, and so is
        // rounding that noise does not dither.
        let repeated = edges.repeated_variance(column);
        let blur = (u_blur_px * trend_factor(column as f64, edges.columns())).powi(2);
        let random =
            |top: f64, bottom: f64| scale * ((top * top + bottom * bottom - repeated).max(0.0) + blur).sqrt();
        let reading = Reading::Value(Diameter {
            d_mm: reader.diameter_mm(width_px),
            u_random_mm: random(top.u_px(), bottom.u_px()),
            u_common_mm: reader
                .u_common_mm(column, rows_px, width_px)
                .hypot(scale * repeated.sqrt().hypot(u_position_px)),
        });
        out.columns.push(ColumnDiameter {
            reading,
            shared_mm: random(f64::from(top.u_shared_px), f64::from(bottom.u_shared_px)),
            width_px,
            middle_mm: reader.middle_mm(column, rows_px),
            // The mean of two edges that are off by themselves is off by half of what their
            // distance is.
            u_middle_common_mm: 0.5 * scale * repeated.sqrt().hypot(u_blur_px),
        });
    }
}

fn gap(top: &Edge, bottom: &Edge) -> Option<Reason> {
    [top, bottom].into_iter().find(|e| !e.is_usable()).and_then(Edge::reason)
}
