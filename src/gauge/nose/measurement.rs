//! The measurement: coarse corner, pooled fits along the contour, lines, centre, sectors, support.

use glam::DVec2;
use nalgebra::{DVector, Matrix2};

use super::bands::{BandPlan, Calipers, collect};
use super::centre::{self, FoundRadius};
use super::contour;
use super::corner::{self, Corner};
use super::error::NoseImageError;
use super::expected::{self, round_px, turned};
use super::hidden_corner::u_of_corners;
use super::limits::NoseLimits;
use super::line::{self, EdgeLine, EdgePoint, LineFit, product};
use super::path::{Path, at_radius};
use super::result::{NoseMeasurement, NoseSector, Reference};
use super::settings::NoseSettings;
use super::support::{SectorNoise, below_hull, support};
use crate::frame::{FrameView, PixelFormat};
use crate::gauge::edge::estimation::light_field::LightField;
use crate::gauge::ring::edge_fit::{Caliper, EdgeFit};
use crate::gauge::ring::edge_pixels::Band;
use crate::gauge::ring::levelled::{fit_levelled, light_of};
use crate::gauge::ring::measurement::RingLightLimits;

/// Measures the nose of the one insert in a frame.
///
/// # Errors
/// No insert, several, its nose not in the frame, out of focus, edges that are not straight, an
/// angle or a direction that is not the tool's.
pub(crate) fn measure_nose(
    view: &FrameView<'_>,
    settings: &NoseSettings,
) -> Result<NoseMeasurement, NoseImageError> {
    let size = (view.rows(), view.columns());
    let seen = contour::runs(view).and_then(|runs| corner::find(&runs, size, settings));
    let corner = seen.map_err(|error| expected::swapped(view, settings).unwrap_or(error))?;
    let measured = along(view, settings, &corner).map_err(|e| expected::cause(e, &corner, settings))?;
    let found = (measured.angle_deg, measured.normals_deg);
    settings.expected.iter().try_for_each(|expected| expected::check(found, 0.0, expected))?;
    Ok(measured)
}

/// The nose along the contour from the coarse corner on.
fn along(
    view: &FrameView<'_>,
    settings: &NoseSettings,
    corner: &Corner,
) -> Result<NoseMeasurement, NoseImageError> {
    let mut work = Work::new(view, settings, corner)?;
    let mut moved = f64::INFINITY;
    for round in 0..NoseLimits::get().rounds {
        moved = work.round()?;
        // the first fit only comes near
        if round > 0 && moved < NoseLimits::get().settled_px {
            break;
        }
    }
    if moved > 0.5 {
        return Err(NoseImageError::Fit(format!("its centre still moves by {moved:.2} px")));
    }
    work.finish()
}

/// The edges and where they end, and the nose, of the coarse contour; for the peers.
pub(super) fn coarse_path(corner: &Corner, settings: &NoseSettings) -> Result<Path, NoseImageError> {
    let lines = corner.edges.each_ref().map(|e| EdgeLine::coarse(e.normal, e.at));
    let nominal = settings.nominal_radius_px.unwrap_or_else(|| round_px(corner));
    let least = NoseLimits::get().least_radius_px;
    if !(nominal >= least) {
        let why = format!("its nose has a radius of {nominal:.1} px, {least} px or more can be measured");
        return Err(NoseImageError::Fit(why));
    }
    Ok(Path::nominal(lines, nominal))
}

struct Work<'a> {
    view: &'a FrameView<'a>,
    settings: &'a NoseSettings,
    corner: &'a Corner,
    path: Path,
    found: FoundRadius,
    half_px: f64,
    field: Option<Option<(LightField, f64)>>,
    last: Option<Round>,
}

/// What a round found.
struct Round {
    fit: EdgeFit,
    lines: [LineFit; 2],
    calipers: [usize; 2],
    sectors: Vec<NoseSector>,
}

impl Round {
    /// Noise of the sectors: by the fit, or as stated of those that no edge fits.
    fn noise(&self) -> Vec<SectorNoise> {
        let calipers = &self.fit.calipers[self.calipers[0]..];
        let of = |(s, c): (&NoseSector, &Caliper)| match s.fitted {
            true => SectorNoise { own: c.u_own * s.u_px / c.u_shift, shared: c.shared },
            false => SectorNoise { own: s.u_px, shared: c.shared.map(|_| 0.0) },
        };
        self.sectors.iter().zip(calipers).map(of).collect()
    }
}

impl Round {
    /// Uncertainty of the sectors' radii by corners, px; `noise` is that of the sectors.
    fn u_corners(&self, path: &Path, noise: &[SectorNoise], blur_px: f64) -> Vec<f64> {
        let departures = self.sectors.iter().map(|s| s.radius_px - path.nominal_px);
        let departures = DVector::from_iterator(self.sectors.len(), departures);
        let own: Vec<f64> = noise.iter().map(|n| n.own).collect();
        u_of_corners(&departures, &own, blur_px / (path.nominal_px * path.step_rad()))
    }
}

impl<'a> Work<'a> {
    fn new(
        view: &'a FrameView<'a>,
        settings: &'a NoseSettings,
        corner: &'a Corner,
    ) -> Result<Self, NoseImageError> {
        let mut path = coarse_path(corner, settings)?;
        let reference = Reference::Nominal;
        let found = FoundRadius { radius_px: path.nominal_px, u_px: 0.0, reference };
        follow(&mut path, &corner.nose);
        let half_px = 2.0 * NoseLimits::get().least_band_px;
        Ok(Self { view, settings, corner, path, found, half_px, field: None, last: None })
    }

    /// Calipers of both edges: from their far ends to where the nose begins.
    fn calipers(&self) -> Result<[Calipers; 2], NoseImageError> {
        let limits = NoseLimits::get();
        let (path, corner) = (&self.path, self.corner);
        let beyond = limits.beyond_nose * path.nominal_px;
        let margin = limits.border_px + 2.0 * self.half_px;
        let of = |k: usize| {
            let line = &path.lines[k];
            let place = |p: DVec2| line.along().dot(p - line.at);
            let nose = place(path.centre + line.normal * path.nominal_px);
            let (from, to) = match k {
                0 => (place(corner.ends[0][0]) + margin, nose - beyond),
                _ => (nose + beyond, place(corner.ends[1][1]) - margin),
            };
            let count = ((to - from) / limits.caliper_px).floor();
            if count < 5.0 {
                let (at, length) = (corner.edges[k].at, (to - from).max(0.0));
                let round =
                    if to > from { "" } else { " (a round insert has no edges to measure a nose by)" };
                return Err(NoseImageError::Fit(format!(
                    "{length:.0} px of the edge about row {:.0}, column {:.0} stand beyond the nose, {:.0} or more are \
                     needed: show more of it{round}",
                    -at.y,
                    at.x,
                    5.0 * limits.caliper_px
                )));
            }
            Ok(Calipers { from, length: (to - from) / count, count: count as usize })
        };
        Ok([of(0)?, of(1)?])
    }

    /// One pooled fit along the path, and the path that follows from it; its movement, px.
    fn round(&mut self) -> Result<f64, NoseImageError> {
        let limits = NoseLimits::get();
        let calipers = self.calipers()?;
        let fit = self.fit(&calipers)?;
        if fit.sigma > limits.most_sigma_px {
            return Err(NoseImageError::Focus { sigma_px: fit.sigma, most_px: limits.most_sigma_px });
        }
        self.half_px = (limits.band_sigmas * fit.sigma).hypot(0.5).max(limits.least_band_px);
        let lines = [self.line(0, &calipers, &fit)?, self.line(1, &calipers, &fit)?];
        let sectors = self.sectors(calipers[0].count, &fit)?;
        let before = self.path.clone();
        self.path.lines = lines.each_ref().map(|l| l.line);
        self.turn(&before, &sectors);
        let counts = calipers.map(|c| c.count);
        let moved = self.path.centre.distance(before.centre);
        let shifts = &fit.calipers[counts[0]..counts[0] + sectors.len()];
        let moved = shifts.iter().filter(|c| c.good).map(|c| c.shift.abs()).fold(moved, f64::max);
        self.last = Some(Round { fit, lines, calipers: counts, sectors: self.about(&before, sectors) });
        Ok(moved)
    }

    /// The pooled fit, in even light.
    fn fit(&mut self, calipers: &[Calipers; 2]) -> Result<EdgeFit, NoseImageError> {
        let whole = self.view.format() != PixelFormat::F32;
        let half = (self.half_px, self.half_px);
        let raw = collect(self.view, &BandPlan { path: &self.path, calipers: *calipers, half });
        if self.field.is_none() {
            self.field = Some(self.light(calipers));
        }
        let light = self.field.as_ref().and_then(Option::as_ref);
        // the plane of the levels counts from the path's centre, which moves by fractions of a
        // pixel
        let begun = self.last.as_ref().and_then(|last| last.fit.begun);
        fit_levelled(&raw, light, whole, begun).map_err(NoseImageError::Fit)
    }

    /// The field of an uneven light, and the shadow's level.
    fn light(&self, calipers: &[Calipers; 2]) -> Option<(LightField, f64)> {
        let half = (self.half_px, self.half_px + RingLightLimits::get().field_px);
        let band: Band = collect(self.view, &BandPlan { path: &self.path, calipers: *calipers, half });
        light_of(&band, self.half_px)
    }

    /// The line of an edge.
    fn line(&self, k: usize, calipers: &[Calipers; 2], fit: &EdgeFit) -> Result<LineFit, NoseImageError> {
        let first = if k == 0 { 0 } else { calipers[0].count + self.path.radii.len() };
        let own = &calipers[k];
        let points: Vec<EdgePoint> = (0..own.count)
            .map(|i| (own.middle(i), fit.calipers[first + i]))
            .filter(|(_, c)| c.good)
            .map(|(along, c)| EdgePoint { along, shift: c.shift, u: c.u_own, shared: c.shared })
            .collect();
        let from = &self.path.lines[k];
        let least = NoseLimits::get().least_on_line * own.count as f64;
        let at = from.at + from.along() * own.middle(own.count / 2);
        let (row, column, fitted) = (-at.y, at.x, points.len());
        if (fitted as f64) < least {
            let (refused, calipers) = (own.count - fitted, own.count);
            return Err(NoseImageError::NoEdgeModel { row, column, refused, calipers });
        }
        let found = line::fit(from, &points);
        let on_line = found.as_ref().map_or(0, |f| f.on_line);
        found.filter(|_| on_line as f64 >= least).ok_or(NoseImageError::NotStraight {
            row,
            column,
            on_line,
            fitted,
        })
    }

    /// Radii of the sectors about the path's centre.
    fn sectors(&self, first: usize, fit: &EdgeFit) -> Result<Vec<NoseSector>, NoseImageError> {
        let limits = NoseLimits::get();
        let path = &self.path;
        let blur = fit.sigma * fit.sigma + 1.0 / 12.0;
        let sectors: Vec<NoseSector> = (0..path.radii.len())
            .map(|k| {
                let c = fit.calipers[first + k];
                let (radius, slope) = path.radius((k as f64 + 0.5) * path.step_rad());
                let lean = (slope / radius).atan().cos();
                // a blurred edge stands towards the inside of its curve
                let bend = path.curvature(k);
                let curvature = 0.5 * blur * bend / lean;
                let u_bend = limits.u_bend * 0.5 * blur * (bend - path.nominal_px.recip()).abs();
                let (shift, u_px) = match (c.good, c.crossing) {
                    (true, _) => (c.shift, c.u_shift / lean),
                    (false, Some(crossing)) => (crossing, limits.u_crossing_px),
                    (false, None) => (0.0, limits.u_bridged_px),
                };
                NoseSector {
                    direction_deg: path.direction_rad(k).to_degrees(),
                    radius_px: path.shifted_from(k) + shift / lean + curvature,
                    u_px: u_px.hypot(u_bend),
                    fitted: c.good,
                }
            })
            .collect();
        let refused = sectors.iter().filter(|s| !s.fitted).count();
        if refused as f64 > limits.most_refused * sectors.len() as f64 {
            let s = sectors.iter().find(|s| !s.fitted).unwrap_or(&sectors[0]);
            let at = path.centre + DVec2::from_angle(s.direction_deg.to_radians()) * s.radius_px;
            return Err(NoseImageError::Sectors {
                refused,
                sectors: sectors.len(),
                direction_deg: s.direction_deg.rem_euclid(360.0),
                row: -at.y,
                column: at.x,
            });
        }
        Ok(sectors)
    }

    /// The next path: lines as found, the nominal radius as given or as found, the nose's places.
    fn turn(&mut self, before: &Path, sectors: &[NoseSector]) {
        let places: Vec<DVec2> = sectors
            .iter()
            .map(|s| before.centre + DVec2::from_angle(s.direction_deg.to_radians()) * s.radius_px)
            .collect();
        let lines = self.path.lines;
        if self.settings.nominal_radius_px.is_none() {
            let about = Path { centre: at_radius(&lines, before.nominal_px), ..before.clone() };
            let rebased = rebase(before, &about, sectors.to_vec());
            self.found = centre::radius(&about, &rebased, self.settings.um_per_px);
        }
        self.path = Path::nominal(lines, self.found.radius_px);
        follow(&mut self.path, &places);
    }

    /// Sectors about the path's present centre.
    fn about(&self, before: &Path, sectors: Vec<NoseSector>) -> Vec<NoseSector> {
        rebase(before, &self.path, sectors)
    }

    fn finish(self) -> Result<NoseMeasurement, NoseImageError> {
        let Some(last) = &self.last else { return Err(NoseImageError::Fit("not measured".to_owned())) };
        let path = &self.path;
        let mut covariance = centre::covariance(path);
        let towards = DVec2::from_angle(path.from_rad + 0.5 * path.sweep_rad);
        let by_radius = self.found.u_px / (0.5 * path.sweep_rad).cos();
        let b = nalgebra::Vector2::new(towards.x, towards.y);
        covariance += b * b.transpose() * (by_radius * by_radius);
        let blur_px = last.fit.sigma.hypot(12f64.sqrt().recip());
        let Some(support) = support(path, &last.sectors, &last.noise(), blur_px) else {
            return Err(NoseImageError::Fit("its sectors have no smooth contour".to_owned()));
        };
        let m = last.sectors.len() as f64;
        let noise = last.noise();
        let u_corners = last.u_corners(path, &noise, blur_px);
        let own = noise.iter().map(|n| n.own * n.own).sum::<f64>() / (m * m);
        let shared = std::array::from_fn(|k| noise.iter().map(|n| n.shared[k]).sum::<f64>() / m);
        let [a, b] = &path.lines;
        let turn = std::array::from_fn(|k| a.shared_angle[k] - b.shared_angle[k]);
        let u_angle = (a.u_angle_rad.powi(2) + b.u_angle_rad.powi(2) + product(&turn, &turn)).sqrt();
        let u_normals = path.lines.map(|l| l.u_direction_rad().to_degrees());
        let mut flags = flags(path, last, &self.found);
        if support.u_corner_px > NoseLimits::get().most_u_corner_px {
            flags.push("corner_hidden");
        }
        Ok(NoseMeasurement {
            angle_deg: 180.0 - path.sweep_rad.to_degrees(),
            u_angle_deg: u_angle.to_degrees(),
            centre: path.centre,
            u_centre_px: centre::u_largest(&covariance),
            normals_deg: path.lines.map(|l| turned(l.normal.to_angle().to_degrees())),
            u_normals_deg: u_normals,
            nominal_radius_px: path.nominal_px,
            reference: self.found.reference,
            mean_radius_px: last.sectors.iter().map(|s| s.radius_px).sum::<f64>() / m,
            u_mean_radius_px: (own + product(&shared, &shared) + centre::variance_of_mean(path, &covariance))
                .sqrt(),
            sectors: last.sectors.iter().zip(u_corners).map(|(s, u)| with_rest(s, u, &covariance)).collect(),
            support: support.values,
            support_covariance: support.covariance,
            sigma_px: last.fit.sigma,
            levels: [last.fit.levels.0, last.fit.levels.1],
            flags,
        })
    }
}

/// A sector whose u has that of the centre and of corners.
fn with_rest(s: &NoseSector, u_corner_px: f64, covariance: &Matrix2<f64>) -> NoseSector {
    let n = DVec2::from_angle(s.direction_deg.to_radians());
    let n = nalgebra::Vector2::new(n.x, n.y);
    let variance = n.dot(&(covariance * n)).max(0.0) + u_corner_px * u_corner_px;
    NoseSector { direction_deg: turned(s.direction_deg), u_px: (s.u_px * s.u_px + variance).sqrt(), ..*s }
}

/// The same places of the contour about another centre, by small movements.
fn rebase(before: &Path, after: &Path, sectors: Vec<NoseSector>) -> Vec<NoseSector> {
    let by = after.centre - before.centre;
    let about = |s: NoseSector| {
        let n = DVec2::from_angle(s.direction_deg.to_radians());
        NoseSector { radius_px: s.radius_px - by.dot(n), ..s }
    };
    sectors.into_iter().map(about).collect()
}

/// Gives a path the radii of places of the contour: straight between those beside each sector's
/// middle, the nominal radius where none are.
fn follow(path: &mut Path, places: &[DVec2]) {
    let mut polar: Vec<(f64, f64)> = places
        .iter()
        .map(|p| {
            let arm = *p - path.centre;
            let turn = DVec2::from_angle(path.from_rad).angle_to(arm);
            (turn, arm.length())
        })
        .collect();
    polar.sort_by(|a, b| a.0.total_cmp(&b.0));
    let step = path.step_rad();
    for k in 0..path.radii.len() {
        let turn = (k as f64 + 0.5) * step;
        let i = polar.partition_point(|p| p.0 < turn);
        let before = i.checked_sub(1).map(|i| polar[i]);
        let after = polar.get(i).copied();
        path.radii[k] = match (before, after) {
            (Some(a), Some(b)) if b.0 > a.0 => a.1 + (b.1 - a.1) * (turn - a.0) / (b.0 - a.0),
            (Some(a), _) if turn - a.0 < step => a.1,
            (_, Some(b)) if b.0 - turn < step => b.1,
            _ => path.nominal_px,
        };
    }
}

/// What limits the use of a measurement.
fn flags(path: &Path, last: &Round, found: &FoundRadius) -> Vec<&'static str> {
    let limits = NoseLimits::get();
    let mut flags = Vec::new();
    let departures: Vec<f64> = last.sectors.iter().map(|s| s.radius_px - path.nominal_px).collect();
    let mean = departures.iter().sum::<f64>() / departures.len() as f64;
    if mean.abs() > limits.worn_px {
        flags.push("worn");
    }
    let beyond = |k: &usize| departures[*k] > limits.bump_px.max(limits.bump_u * last.sectors[*k].u_px);
    match (0..departures.len()).filter(beyond).count() {
        0 => {}
        n if 2 * n < departures.len() => flags.push("built_up_edge"),
        _ => flags.push("beyond_nominal"),
    }
    let radii = DVector::from_iterator(departures.len(), departures.iter().copied());
    let hollow = below_hull(path, &radii);
    if (0..hollow.len()).any(|k| hollow[k] > limits.bump_px.max(limits.bump_u * last.sectors[k].u_px)) {
        flags.push("chipped");
    }
    let off = |sign: f64| last.lines.iter().flat_map(|l| &l.off).any(|d| sign * d > limits.bump_px);
    if off(1.0) {
        flags.push("edge_dirty");
    }
    if off(-1.0) {
        flags.push("edge_worn");
    }
    // no caliper stands on the edge beside the nose: wear that has not ended here may go on there
    let worn = |k: usize| -departures[k] > limits.bump_px.max(limits.bump_u * last.sectors[k].u_px);
    let ends = limits.end_sectors.min(departures.len());
    if (0..ends).any(|k| worn(k) || worn(departures.len() - 1 - k)) {
        flags.push("nose_end_worn");
    }
    let fitted = last.fit.calipers.iter().filter(|c| c.good).count();
    if last.sectors.iter().any(|s| !s.fitted) {
        flags.push("sectors_refused");
    }
    if (fitted as f64) < 0.9 * (last.sectors.len() + last.calipers[0] + last.calipers[1]) as f64 {
        flags.push("calipers_refused");
    }
    if last.fit.misfit > limits.most_misfit {
        flags.push("edge_profile");
    }
    if found.reference == Reference::Iso1832 {
        flags.push("radius_of_iso_1832");
    }
    flags
}
