//! A frame to the widths of its land, zones and uncertainties.

use super::error::FlankError;
use super::land::Land;
use super::limits::FlankLimits;
use super::located::{KnownEdge, Located, locate};
use super::model::{LandModel, ModelErrors};
use super::raster::{Raster, quantile};
use super::reference::other_side;
use super::result::{FlankBudget, FlankMeasurement, Width};
use super::settings::{CornerSide, FlankSettings};
use super::zones::{Zones, largest, mean, worn_range, zones};
use crate::frame::FrameView;

/// Measures a flank by a model of its land, a forest or a network.
///
/// # Errors
/// No flank, or two borders that could be its edge; a land that leaves the field, glare over its
/// border; a model that fails.
pub(crate) fn measure_flank(
    view: &FrameView<'_>,
    settings: &FlankSettings,
    model: &dyn LandModel,
) -> Result<FlankMeasurement, FlankError> {
    let image = Raster::of(view)?;
    let known = KnownEdge { side: settings.side, shape: settings.baseline.as_deref() };
    let flank = locate(&image, settings.um_per_px, known)?;
    flank.certain()?;
    let found = model.land(&flank.strip, &flank.frame, &flank.inside)?;
    assess(&flank, &found, settings, model.errors())
}

/// Width from which a column is worn, µm: more than the rounding of a new edge, and a share of what
/// half of the worn columns have, since borders of new stretches scatter in proportion.
fn least_worn_um(depth_um: &[f64]) -> f64 {
    let limits = FlankLimits::get();
    let worn = depth_um.iter().filter(|d| **d >= limits.least_land_um).map(|d| *d as f32);
    let typical = f64::from(quantile(worn.collect(), 0.5));
    limits.least_land_um.max(limits.worn_share * typical)
}

/// What follows from a border.
fn assess(
    flank: &Located,
    found: &Land,
    settings: &FlankSettings,
    errors: ModelErrors,
) -> Result<FlankMeasurement, FlankError> {
    let limits = FlankLimits::get();
    let frame = &flank.frame;
    let bridge = (limits.bridge_um / frame.column_um()) as usize;
    let least = (limits.least_length_um / frame.column_um()) as usize;
    let least_um = least_worn_um(&found.depth_um);
    let worn = worn_range(&found.depth_um, least_um, bridge).filter(|w| w.1 - w.0 >= least);
    let shortened = settings.viewing_deg.to_radians().cos();
    let widths: Vec<Width> = (0..found.depth_um.len())
        .map(|k| Width { um: found.depth_um[k] / shortened, u_um: found.u_um[k] / shortened })
        .collect();
    let mut flags = if errors.vb_um.is_finite() { Vec::new() } else { vec!["no_uncertainty"] };
    if flank.clearer.is_some() {
        flags.push("side_as_stated");
    }
    let Some(worn) = worn else {
        // without a land nothing speaks for the stated side
        if let Some(line) = &flank.clearer {
            return Err(other_side(settings.side, line));
        }
        // a land that glare hides is none that is absent
        glare(flank, found, (0, found.depth_um.len().saturating_sub(1)), settings.full_scale)?;
        flags.push("no_land");
        return Ok(finished(
            flank,
            settings,
            (widths, Zones { b: 0..0, c: None, n: None }, (0, 0)),
            (errors, &found.by_group_um, flags),
        ));
    };
    leaves_field(flank, found, worn)?;
    glare(flank, found, worn, settings.full_scale)?;
    let first = corner_first(flank, worn, settings.corner);
    if first.is_none() && settings.corner == CornerSide::Found {
        flags.push("corner_not_found");
    }
    let radius_um = settings.nose_radius_mm.map_or(0.0, |r| 1e3 * r);
    let corner_columns = (radius_um / frame.column_um()).round() as usize;
    let zones = zones(worn, first, corner_columns);
    if settings.um_per_px > 1.5 * limits.pitch_um {
        flags.push("coarse_scale");
    }
    Ok(finished(flank, settings, (widths, zones, worn), (errors, &found.by_group_um, flags)))
}

/// The measurement with its uncertainties.
fn finished(
    flank: &Located,
    settings: &FlankSettings,
    (widths, zones, worn): (Vec<Width>, Zones, (usize, usize)),
    (errors, by_group_um, flags): (ModelErrors, &[Vec<f64>], Vec<&'static str>),
) -> FlankMeasurement {
    let frame = &flank.frame;
    let shortened = settings.viewing_deg.to_radians().cos();
    let common = |um: f64, model_um: f64| FlankBudget {
        border_um: 0.0,
        reference_um: flank.u_reference_um / shortened,
        model_um,
        scale_um: um * settings.u_scale,
        viewing_um: um * settings.viewing_deg.to_radians().tan().abs() * settings.u_viewing_deg.to_radians(),
    };
    let with = |width: Width, model_um: f64| {
        let budget = FlankBudget { border_um: width.u_um, ..common(width.um, model_um) };
        (Width { um: width.um, u_um: budget.combined_um() }, budget)
    };
    let model_um = |range: &std::ops::Range<usize>, of: fn(&[f64]) -> f64, error_um: f64| {
        let by_group: Vec<f64> = by_group_um.iter().map(|depth| of(&depth[range.clone()])).collect();
        error_um.hypot(deviation(&by_group) / shortened)
    };
    let model_vbb_um = model_um(&zones.b, average, errors.vb_um);
    let (vbb, budget) = with(mean(&widths[zones.b.clone()], FlankLimits::get().shared_columns), model_vbb_um);
    let of = |range: &std::ops::Range<usize>| {
        let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        with(largest(&widths[range.clone()]), model_um(range, most, errors.vb_max_um)).0
    };
    let worn_length_um = if worn.1 > worn.0 { (worn.1 - worn.0 + 1) as f64 * frame.column_um() } else { 0.0 };
    FlankMeasurement {
        vbb,
        vbb_max: of(&zones.b),
        vc: zones.c.as_ref().map(of),
        vn: zones.n.as_ref().map(of),
        worn_length_um,
        budget,
        places: (0..widths.len())
            .map(|k| [0.0, widths[k].um * shortened].map(|depth| frame.place(k as f64, depth)))
            .collect(),
        widths,
        column_um: frame.column_um(),
        worn,
        curve: frame.curve.clone(),
        flags,
    }
}

fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Standard deviation of a few values; 0 of fewer than two.
fn deviation(values: &[f64]) -> f64 {
    let mean = average(values);
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (square / values.len().saturating_sub(1).max(1) as f64).sqrt()
}

impl FlankBudget {
    /// Root of the sum of squares, µm.
    pub(crate) fn combined_um(&self) -> f64 {
        [self.border_um, self.reference_um, self.model_um, self.scale_um, self.viewing_um]
            .iter()
            .map(|u| u * u)
            .sum::<f64>()
            .sqrt()
    }
}

/// Refuses a land that reaches the border of the image or the depth that is looked at, or comes so
/// close that too little of the flank is seen below it.
fn leaves_field(flank: &Located, found: &Land, worn: (usize, usize)) -> Result<(), FlankError> {
    let (frame, limits) = (&flank.frame, FlankLimits::get());
    for k in worn.0..=worn.1 {
        let rows = flank.inside[k].saturating_sub(frame.above);
        let end_um = rows as f64 * frame.row_um();
        let depth_um = found.depth_um[k];
        let below_um = (limits.least_below * depth_um).max(4.0 * frame.row_um());
        if depth_um >= limits.least_land_um && depth_um + below_um > end_um {
            let p = frame.place(k as f64, found.depth_um[k]);
            return Err(FlankError::LeavesField { row: p.y, column: p.x });
        }
    }
    Ok(())
}

/// Refuses a border of which too much lies in saturated light.
fn glare(flank: &Located, found: &Land, worn: (usize, usize), full_scale: f32) -> Result<(), FlankError> {
    let limits = FlankLimits::get();
    let frame = &flank.frame;
    let level = limits.saturated as f32 * full_scale;
    let half = (limits.glare_um / frame.row_um()) as usize;
    let hidden = |k: &usize| {
        let middle = frame.above + (found.depth_um[*k].max(limits.glare_um) / frame.row_um()) as usize;
        let rows = middle.saturating_sub(half)..(middle + half).min(flank.strip.rows);
        rows.into_iter().all(|r| flank.strip.at(r, *k) >= level)
    };
    let columns: Vec<usize> = (worn.0..=worn.1).filter(hidden).collect();
    let share = 100.0 * columns.len() as f64 / (worn.1 - worn.0 + 1) as f64;
    if share <= limits.most_glare_percent {
        return Ok(());
    }
    let k = columns[columns.len() / 2];
    let p = frame.place(k as f64, found.depth_um[k]);
    Err(FlankError::Glare { share, most: limits.most_glare_percent, row: p.y, column: p.x })
}

/// Whether the corner lies before the first worn column; `None` where neither end of the flank is
/// in the image.
fn corner_first(flank: &Located, worn: (usize, usize), corner: CornerSide) -> Option<bool> {
    let frame = &flank.frame;
    let to_the_right = frame.line.along.x > 0.0;
    match corner {
        CornerSide::Left => Some(to_the_right),
        CornerSide::Right => Some(!to_the_right),
        CornerSide::None => None,
        CornerSide::Found => {
            let last = frame.columns() - 1;
            // the nearer end; an edge that wears over the whole flank has no corner to find
            let (before, behind) = (worn.0, last.saturating_sub(worn.1));
            (before != behind).then_some(before < behind)
        }
    }
}
