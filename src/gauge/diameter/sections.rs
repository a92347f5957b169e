//! Form and size of sections over a turn, from the frames of a scan.
//!
//! For every station the diameters and middles of its columns are averaged angle by angle; the
//! angles either divide a whole turn evenly, or half a turn. Half a turn shows every tangent once:
//! with the spindle's axis taken as still, bottom edges stand for the tops of the other half, h(φ +
//! π) = m − bottom(φ), m the height of the axis, and the unknown m is in the u of the odd lobes.
//! Either way odd lobes and odd spindle motion cannot be separated. Every u is at least what the
//! readings scatter by that the form does not explain (`turn_scatter`).
//!
//! While a pass is cut the shaft is bent otherwise at every instant, which moves both edges alike:
//! diameters are means over all frames, the middles those of one burst (`bursts`), less their
//! steady drift while the tool goes on within it. Run-out and straightness from section to section
//! are those of a dial gauge that follows the tool: every section as it was bent when its burst was
//! taken.
//!
//! Everything here is the silhouette's: sizes and roundness of the section's convex hull.

use std::collections::BTreeMap;

use glam::DVec2;
use serde::Serialize;
use std::f64::consts::TAU;

use super::axis_line::{Middle, drift};
use super::bursts::{AtOnePlace, Bursts, Shown as _, Whole};
use super::column_diameters::ColumnDiameters;
use super::reading_scatter::ScatterTest;
use super::station_mean::StationColumns;
use super::station_row::StationRow;
use super::stations::variance_of_mean;
use super::turn_scatter::{TurnScatter, axis_of_half_turn, of_half_turn, of_whole_turn};
use crate::frame::FrameMeta;
use crate::gauge::edge::stream::StreamLimits;
use crate::gauge::form::size::turn_sizes;
use crate::gauge::form::{
    Cutoff, FormError, Reference, StraightnessReference, Turn, TurnHarmonics, circular_run_out,
    circumscribed_cylinder, harmonics, least_squares_circle, polar_profile, roundness, silhouette_cylinder,
    straightness, total_run_out,
};
use crate::gauge::limit::limits;
use crate::profile::Reading;

limits! {
    /// What sections report.
    SectionLimits = "sections";
    /// Most harmonics reported: what the filter of 50 undulations a revolution passes (ISO
    /// 12181-2).
    most_lobes: usize = 50;
    /// Fewest columns of a station at one angle: their scatter then has three degrees of freedom.
    least_columns: usize = 4;
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    n: f64,
    d_mm: StationColumns,
    /// Σ own variance, mm².
    own: f64,
    /// Σ shared variance, mm².
    shared: f64,
    length: f64,
}

/// Gathers a scan's frames by station and angle.
#[derive(Clone, Debug)]
pub(crate) struct TurnAverager {
    row: StationRow<StationSums>,
    stands: bool,
}

/// What is gathered of a station.
#[derive(Clone, Debug, Default)]
struct StationSums {
    /// By angle in microdegrees.
    angles: BTreeMap<i64, Sums>,
    /// Middles of both edges, burst by burst.
    middles: Bursts<StationColumns>,
}

/// Form and size of one section.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SectionForm {
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Angles seen.
    pub angles: usize,
    /// Whether they span half a turn only, so that the spindle is taken as still.
    pub half_turn: bool,
    /// Least-squares size GG of the hull, mm.
    pub gg_mm: f64,
    /// Its random standard uncertainty, mm: the larger one of what the edges state and what the
    /// readings scatter by beyond the form.
    pub u_gg_random_mm: f64,
    /// Minimum circumscribed size GN, mm.
    pub gn_mm: f64,
    /// Maximum inscribed size GX of the hull, mm.
    pub gx_mm: f64,
    /// Mean caliper diameter, mm.
    pub mean_caliper_mm: f64,
    /// Least caliper diameter, mm.
    pub min_caliper_mm: f64,
    /// Greatest caliper diameter, mm.
    pub max_caliper_mm: f64,
    /// Circular radial run-out against the spindle, mm.
    pub run_out_mm: f64,
    /// Roundness RONt about LSCI, MZCI, MICI, MCCI, mm.
    pub roundness_mm: [f64; 4],
    /// Gaussian filter, undulations per revolution.
    pub cutoff_upr: f64,
    /// Standard uncertainty of one edge of a station at one angle, mm, stated or scattered,
    /// whichever is larger.
    pub u_edge_mm: f64,
    /// Standard uncertainty of the height of the spindle's axis, which half a turn must adjust, mm;
    /// it is in the u of the odd lobes.
    pub u_axis_mm: Option<f64>,
    /// χ² of what the form does not explain against the edges' own statements; `None` from too few
    /// angles.
    pub scatter: Option<ScatterTest>,
    /// Harmonics.
    pub harmonics: TurnHarmonics,
    /// Hull's profile over the polar angle, mm from the least-squares centre.
    #[serde(skip)]
    pub profile_mm: Vec<f64>,
}

/// Form of the part over all its sections.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PartForm {
    /// Sections that could be evaluated.
    pub sections: Vec<SectionForm>,
    /// Total radial run-out, mm.
    pub total_run_out_mm: Option<f64>,
    /// Straightness of the line of centres (minimum zone, the worse of two planes), mm.
    pub axis_straightness_mm: Option<f64>,
    /// Straightness of the straightest-seen flanks: the worst generatrix over all angles (minimum
    /// zone), mm.
    pub generatrix_straightness_mm: Option<f64>,
    /// Cylindricity CYLt about the least-squares cylinder, mm.
    pub cylindricity_mm: Option<f64>,
    /// Rate of taper dD/dz of the sections' least-squares sizes, mm/mm.
    pub taper: Option<f64>,
    /// Sections left out, with the reason.
    pub refused: Vec<(f64, String)>,
}

/// The least circumscribed cylinder over all sections: the envelope of a shaft (ISO 14405-1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Envelope {
    /// Its diameter, mm.
    pub diameter_mm: f64,
    /// Random standard uncertainty, mm: the tangents it rests on balance, so that none has more
    /// than half the weight, u(2R) ≤ √2·u(edge).
    pub u_random_mm: f64,
    /// Sections it was taken over.
    pub sections: usize,
}

/// What was seen of a station.
struct Station<'s> {
    sums: &'s BTreeMap<i64, Sums>,
    /// Middles of both edges by angle, mm.
    middles: BTreeMap<i64, f64>,
}

/// Middles by angle, their drift while the carriage moved taken off.
fn middles(taken: &AtOnePlace<StationColumns>) -> BTreeMap<i64, f64> {
    let least = SectionLimits::get().least_columns;
    let enough = taken.angles.iter().filter(|(_, m)| m.columns() >= least);
    let plain: Vec<(i64, f64)> = enough.map(|(angle, m)| (*angle, m.mean().mean)).collect();
    let seen: Vec<Middle> = plain.iter().map(|(a, mm)| Middle::at(*a, taken.way_mm(*a)).reads(*mm)).collect();
    let drift = drift(&seen);
    plain.into_iter().map(|(angle, mm)| (angle, mm - drift * taken.way_mm(angle))).collect()
}

struct Section {
    z_mm: f64,
    turn: Turn,
    form: SectionForm,
}

impl TurnAverager {
    /// Stations by their middles, ascending, and their common length.
    pub(crate) fn new(z_mm: Vec<f64>, station_mm: f64) -> Self {
        Self { row: StationRow::new(z_mm, station_mm), stands: false }
    }

    /// For frames that are all taken at one place: what they show is summed up angle by angle, in
    /// memory that does not grow with their number. The result is the same.
    pub(crate) fn standing(self) -> Self {
        Self { stands: true, ..self }
    }

    /// Adds a frame's diameters.
    pub(crate) fn add(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters) {
        let angle = (meta.angle_deg.rem_euclid(360.0) * 1e6).round() as i64 % 360_000_000;
        self.row.pitch_mm = diameters.pitch_mm;
        let mut of_frame: BTreeMap<usize, StationColumns> = BTreeMap::new();
        for (index, column) in diameters.columns.iter().enumerate() {
            let Reading::Value(d) = column.reading else { continue };
            let Some((station, t)) = self.row.place(diameters.z_mm(meta, index)) else { continue };
            let sums = self.row.sums(station).angles.entry(angle).or_default();
            sums.n += 1.0;
            sums.d_mm.add(t, d.d_mm);
            of_frame.entry(station).or_default().add(t, column.middle_mm);
            let shared = column.shared_mm.powi(2);
            sums.own += (d.u_random_mm * d.u_random_mm - shared).max(0.0);
            sums.shared += shared;
            sums.length = diameters.shared_length;
        }
        let half = 0.5 * self.row.station_mm();
        for (station, middles) in of_frame {
            let bursts = &mut self.row.sums(station).middles;
            match diameters.columns.len() < StreamLimits::get().least_columns || self.stands {
                true => bursts.join(angle, meta.z_mm, &middles),
                false => bursts.add(angle, meta.z_mm, &middles, half),
            }
        }
    }

    /// Every station: its middle, its sums, and the middles of its edges by angle. While a pass is
    /// cut those of one burst: another saw the shaft bent otherwise.
    fn stations(&self) -> impl Iterator<Item = (f64, Station<'_>)> {
        let (station_mm, columns) = (self.row.station_mm(), self.row.columns());
        self.row.iter().map(move |station| {
            let StationSums { angles: sums, middles: bursts } = &station.sums;
            let whole = Whole { z_mm: station.z_mm, station_mm, columns };
            let taken = if bursts.moved() { bursts.at_one_place(&whole) } else { bursts.all() };
            (station.z_mm, Station { sums, middles: middles(&taken) })
        })
    }

    /// The envelope over all sections, after the filter around each.
    ///
    /// # Errors
    /// The first section that makes no turn, with its place; fewer than three sections.
    pub(crate) fn envelope(&self, cutoff: Cutoff) -> Result<Envelope, String> {
        let mut samples = Vec::new();
        let mut u_edge_mm: f64 = 0.0;
        for (z_mm, station) in self.stations() {
            let (turn, seen) = section_turn(&station).map_err(|e| format!("at z = {z_mm:.3} mm {e}"))?;
            let support = crate::gauge::form::gaussian_closed(&turn.support_mm(), cutoff);
            let n = support.len() as f64;
            samples.extend(support.iter().enumerate().map(|(i, h)| [z_mm, TAU * i as f64 / n, *h]));
            u_edge_mm = u_edge_mm.max(seen.stated_mm);
        }
        if self.row.len() < 3 {
            return Err(format!("{} sections are seen, and three at least show an axis", self.row.len()));
        }
        let cylinder = circumscribed_cylinder(&samples).map_err(|e| e.to_string())?;
        Ok(Envelope {
            diameter_mm: 2.0 * cylinder.radius,
            u_random_mm: std::f64::consts::SQRT_2 * u_edge_mm,
            sections: self.row.len(),
        })
    }

    /// Ends the scan.
    pub(crate) fn finish(&self, cutoff: Cutoff) -> PartForm {
        let mut part = PartForm::default();
        let mut sections = Vec::new();
        for (z_mm, station) in self.stations() {
            match section(z_mm, &station, cutoff) {
                Ok(section) => sections.push(section),
                Err(error) => part.refused.push((z_mm, error.to_string())),
            }
        }
        over_all(&mut part, &sections, cutoff);
        part.sections = sections.into_iter().map(|s| s.form).collect();
        part
    }
}

fn section(z_mm: f64, station: &Station<'_>, cutoff: Cutoff) -> Result<Section, FormError> {
    let (turn, seen) = section_turn(station)?;
    let widths: Vec<f64> = turn.widths_mm();
    let u_width_mm = std::f64::consts::SQRT_2 * seen.stated_mm;
    let scatter = match seen.u_axis_mm {
        Some(_) => of_half_turn(&widths[..seen.angles], cutoff.undulations(), u_width_mm),
        None => Some(of_whole_turn(&widths, u_width_mm)),
    };
    let form = section_form(z_mm, &turn, &SectionReadings { scatter, ..seen }, cutoff)?;
    Ok(Section { z_mm, turn, form })
}

/// A section's turn and what was seen of it, its scatter left open.
fn section_turn(station: &Station<'_>) -> Result<(Turn, SectionReadings), FormError> {
    let limits = SectionLimits::get();
    let good: Vec<(f64, &Sums, f64)> = station
        .sums
        .iter()
        .filter(|(_, s)| s.n >= limits.least_columns as f64)
        .filter_map(|(angle, s)| Some((*angle as f64 * 1e-6, s, *station.middles.get(angle)?)))
        .collect();
    let readings: Vec<[f64; 3]> = good
        .iter()
        .map(|(angle, s, middle)| {
            let radius = 0.5 * s.d_mm.mean().mean;
            [*angle, middle + radius, middle - radius]
        })
        .collect();
    let noise = |s: &Sums| variance_of_mean(s.n, s.d_mm.mean().gain * s.own, s.shared, s.length);
    let variance = good.iter().map(|(_, s, _)| noise(s)).sum::<f64>() / good.len() as f64;
    let stated_mm = (0.5 * variance).sqrt();
    let (turn, u_axis_mm) = turn_of(&readings, stated_mm)?;
    Ok((turn, SectionReadings { angles: readings.len(), stated_mm, u_axis_mm, scatter: None }))
}

/// What was seen of a section.
struct SectionReadings {
    angles: usize,
    /// Standard uncertainty of one edge by the edges' own statements, mm.
    stated_mm: f64,
    /// That of the spindle's axis; `None` over a whole turn.
    u_axis_mm: Option<f64>,
    scatter: Option<TurnScatter>,
}

/// The turn, and where only half of it was seen the standard uncertainty of the spindle's axis, mm.
fn turn_of(readings: &[[f64; 3]], u_edge_mm: f64) -> Result<(Turn, Option<f64>), FormError> {
    match Turn::from_readings(readings) {
        Err(FormError::UnevenAngles { .. } | FormError::TooFew { .. } | FormError::Argument { .. })
            if readings.len() >= 4 && readings.iter().all(|r| r[0] < 180.0) =>
        {
            let middles: Vec<(f64, f64)> = readings.iter().map(|r| (r[0], 0.5 * (r[1] + r[2]))).collect();
            let u_middle_mm = u_edge_mm * std::f64::consts::FRAC_1_SQRT_2;
            let (middle, u_axis_mm) = axis_of_half_turn(&middles, u_middle_mm).ok_or(FormError::TooFew {
                feature: "half a turn",
                found: readings.len(),
                needed: 4,
            })?;
            let other = readings.iter().map(|r| [r[0] + 180.0, 2.0 * middle - r[2], 2.0 * middle - r[1]]);
            let whole: Vec<[f64; 3]> = readings.iter().copied().chain(other).collect();
            Ok((Turn::from_readings(&whole)?, Some(u_axis_mm)))
        }
        turn => Ok((turn?, None)),
    }
}

fn section_form(
    z_mm: f64,
    turn: &Turn,
    seen: &SectionReadings,
    cutoff: Cutoff,
) -> Result<SectionForm, FormError> {
    let limits = SectionLimits::get();
    let half_turn = seen.u_axis_mm.is_some();
    let scattered_mm = seen.scatter.map_or(0.0, |s| s.sd_width_mm * std::f64::consts::FRAC_1_SQRT_2);
    let u_edge_mm = seen.stated_mm.max(scattered_mm);
    // Over half a turn every edge stands in two places: the turn holds each reading twice.
    let u_reading_mm = if half_turn { u_edge_mm * std::f64::consts::SQRT_2 } else { u_edge_mm };
    let sizes = turn_sizes(turn, cutoff, u_reading_mm)?;
    let profile = polar_profile(&turn.support_mm(), cutoff)?;
    let points = polar(&profile);
    let centre = least_squares_circle(&points)?.fit.circle.centre;
    let references = [
        Reference::LeastSquares,
        Reference::MinimumZone,
        Reference::MaximumInscribed,
        Reference::MinimumCircumscribed,
    ];
    let mut roundness_mm = [0.0; 4];
    for (value, reference) in roundness_mm.iter_mut().zip(references) {
        *value = roundness(&points, reference)?.ron_t;
    }
    Ok(SectionForm {
        z_mm,
        angles: seen.angles,
        half_turn,
        gg_mm: sizes.gg_mm,
        u_gg_random_mm: sizes.u_gg_mm.max(seen.scatter.map_or(0.0, |s| s.u_mean_mm)),
        gn_mm: sizes.gn_mm,
        gx_mm: sizes.gx_mm,
        mean_caliper_mm: sizes.mean_caliper_mm,
        min_caliper_mm: sizes.min_caliper_mm,
        max_caliper_mm: sizes.max_caliper_mm,
        run_out_mm: circular_run_out(turn.top_mm()).unwrap_or(0.0),
        roundness_mm,
        cutoff_upr: cutoff.undulations(),
        u_edge_mm,
        u_axis_mm: seen.u_axis_mm,
        scatter: seen.scatter.and_then(|s| s.test),
        harmonics: harmonics(turn, limits.most_lobes, u_reading_mm).with_axis(seen.u_axis_mm.unwrap_or(0.0)),
        profile_mm: points.iter().map(|p| p.distance(centre)).collect(),
    })
}

fn polar(radii: &[f64]) -> Vec<DVec2> {
    let n = radii.len() as f64;
    radii.iter().enumerate().map(|(i, r)| DVec2::from_angle(TAU * i as f64 / n) * *r).collect()
}

fn over_all(part: &mut PartForm, sections: &[Section], cutoff: Cutoff) {
    let heights: Vec<&[f64]> = sections.iter().map(|s| s.turn.top_mm()).collect();
    part.total_run_out_mm = total_run_out(&heights);
    if sections.len() < 3 {
        return;
    }
    let support: Vec<Vec<f64>> =
        sections.iter().map(|s| crate::gauge::form::gaussian_closed(&s.turn.support_mm(), cutoff)).collect();
    let angles = support.iter().map(Vec::len).min().unwrap_or(0);
    if support.iter().any(|s| s.len() != angles) {
        return;
    }
    let zone =
        |points: &[DVec2]| straightness(points, StraightnessReference::MinimumZone).ok().map(|s| s.str_t);
    let worst = |lines: &mut dyn Iterator<Item = Vec<DVec2>>| {
        lines.filter_map(|l| zone(&l)).fold(None, |w: Option<f64>, v| Some(w.map_or(v, |w| w.max(v))))
    };
    part.generatrix_straightness_mm = worst(
        &mut (0..angles)
            .map(|k| sections.iter().zip(&support).map(|(s, h)| DVec2::new(s.z_mm, h[k])).collect()),
    );
    let centre = |h: &Vec<f64>, x: bool| {
        let n = h.len() as f64;
        let wave = |i: usize| {
            let a = TAU * i as f64 / n;
            if x { a.cos() } else { a.sin() }
        };
        h.iter().enumerate().map(|(i, v)| 2.0 / n * v * wave(i)).sum::<f64>()
    };
    part.axis_straightness_mm = worst(
        &mut [true, false]
            .into_iter()
            .map(|x| sections.iter().zip(&support).map(|(s, h)| DVec2::new(s.z_mm, centre(h, x))).collect()),
    );
    let samples: Vec<[f64; 3]> = sections
        .iter()
        .zip(&support)
        .flat_map(|(s, h)| {
            h.iter()
                .enumerate()
                .map(|(i, v)| [s.z_mm, TAU * i as f64 / h.len() as f64, *v])
                .collect::<Vec<_>>()
        })
        .collect();
    part.cylindricity_mm = silhouette_cylinder(&samples).ok().map(|c| c.cyl_t);
    let n = sections.len() as f64;
    let mean = |f: &dyn Fn(&Section) -> f64| sections.iter().map(f).sum::<f64>() / n;
    let (z, d) = (mean(&|s| s.z_mm), mean(&|s| s.form.gg_mm));
    let square = mean(&|s| (s.z_mm - z).powi(2));
    part.taper = (square > 0.0).then(|| mean(&|s| (s.z_mm - z) * (s.form.gg_mm - d)) / square);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::diameter::column_diameters::ColumnDiameter;
    use crate::profile::Diameter;

    /// A section with two and three lobes and eccentricity, at n angles over a span.
    fn scan(n: usize, span_deg: f64, stations: &[f64]) -> TurnAverager {
        let mut averager = TurnAverager::new(stations.to_vec(), 1.0);
        for z_mm in stations {
            for i in 0..n {
                let angle_deg = span_deg * i as f64 / n as f64;
                let phi = angle_deg.to_radians();
                let h = |a: f64| {
                    10.0 + 1e-4 * z_mm
                        + 2e-3 * (2.0 * a).cos()
                        + 1e-3 * (3.0 * a + 0.4).cos()
                        + 5e-3 * (a - 1.0).cos()
                };
                let (top, bottom) = (3.0 + h(phi), 3.0 - h(phi + std::f64::consts::PI));
                let value =
                    Reading::Value(Diameter { d_mm: top - bottom, u_random_mm: 1e-5, u_common_mm: 0.0 });
                let column = ColumnDiameter {
                    reading: value,
                    shared_mm: 0.0,
                    width_px: 1.0,
                    middle_mm: 0.5 * (top + bottom),
                    u_middle_common_mm: 0.0,
                };
                let diameters =
                    ColumnDiameters { columns: vec![column; 11], shared_length: 1.0, pitch_mm: 0.05 };
                averager.add(&FrameMeta { angle_deg, z_mm: *z_mm, ..FrameMeta::default() }, &diameters);
            }
        }
        averager
    }

    #[test]
    fn whole_and_half_turn_of_a_still_spindle_agree() {
        for (n, span, half) in [(72, 360.0, false), (36, 180.0, true)] {
            let part = scan(n, span, &[5.0, 15.0, 25.0]).finish(Cutoff::UPR_50);
            let s = &part.sections[1];
            assert_eq!((s.half_turn, s.angles), (half, n));
            // Filter at 50 upr passes lobe 2 by .9989 and 3 by .9975.
            let lobe = |k: usize| s.harmonics.section[k - 1].amplitude_mm;
            assert!((lobe(2) - 2e-3).abs() < 1e-9 && (lobe(3) - 1e-3).abs() < 1e-9, "{}", lobe(3));
            assert!((s.gg_mm - 20.003).abs() < 2e-5, "{}", s.gg_mm);
            assert!(s.gn_mm > s.gg_mm && s.gx_mm < s.gg_mm && s.gn_mm < s.gg_mm + 6e-3);
            assert!(s.roundness_mm[1] <= s.roundness_mm[0] && s.roundness_mm[0] < 6e-3);
            assert!((part.taper.unwrap() - 2e-4).abs() < 1e-9);
            assert!(
                part.axis_straightness_mm.unwrap() < 1e-9 && part.generatrix_straightness_mm.unwrap() < 1e-8
            );
            // Cylindricity of a cone of 2e-4 over 20 mm and lobes.
            assert!((4e-3..9e-3).contains(&part.cylindricity_mm.unwrap()));
        }
    }

    /// While a pass is cut two fields see a station, the far one of a shaft bent by .01 mm more,
    /// and in both it bends by .03 mm a mm on: the run-out is the eccentricity's alone.
    #[test]
    fn middles_of_two_instants_are_not_mixed() {
        let mut averager = TurnAverager::new(vec![5.0], 1.0);
        let value = Reading::Value(Diameter { d_mm: 20.0, u_random_mm: 1e-5, u_common_mm: 0.0 });
        for (start_mm, bend_mm) in [(5.9, 0.01), (5.16, 0.0)] {
            for i in 0..16 {
                let angle_deg = 22.5 * f64::from(i);
                let z_mm = start_mm - 0.02 * f64::from(i);
                let middle_mm = 3.0 + bend_mm + 0.03 * z_mm + 5e-3 * angle_deg.to_radians().cos();
                let column = ColumnDiameter {
                    reading: value,
                    shared_mm: 0.0,
                    width_px: 1.0,
                    middle_mm,
                    u_middle_common_mm: 0.0,
                };
                let diameters =
                    ColumnDiameters { columns: vec![column; 41], shared_length: 1.0, pitch_mm: 0.05 };
                averager.add(&FrameMeta { angle_deg, z_mm, ..FrameMeta::default() }, &diameters);
            }
        }
        let part = averager.finish(Cutoff::UPR_50);
        let section = &part.sections[0];
        assert!((section.run_out_mm - 0.01).abs() < 1e-9, "{}", section.run_out_mm);
        assert!(section.roundness_mm[1] < 1e-5, "{:?}", section.roundness_mm);
    }

    #[test]
    fn too_few_or_uneven_angles_are_said_so() {
        let part = scan(3, 180.0, &[5.0]).finish(Cutoff::UPR_50);
        assert!(part.sections.is_empty() && part.refused.len() == 1);
    }
}
