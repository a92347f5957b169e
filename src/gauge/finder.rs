//! The edge finder: from a frame to both edges of every column.
//!
//! Coarse search (or the last frame's edges) → windows → levels, noise and blur from the frame → maximum likelihood by
//! tabulated scoring → residual and neighbourhood tests. Nothing is carried from frame to frame but where the edges were and the tables.

use super::blur::{self, BlurContext, BlurEstimate};
use super::clipped::{self, ClippedStart};
use super::coarse::{CoarseEdge, find_part};
use super::edges::{Edge, EdgeState, FrameEdges, FrameFigures, FrameRefused};
use super::gate::{self, OutlierScratch};
use super::levels::{LevelCurve, pool};
use super::noise::{NoiseModel, variance_of_differences};
use super::pixels::{Plane, Sample, all_finite, with_plane};
use super::score::{locate, normalise};
use super::settings::{Blur, GaugeSettings, Levels, Polarity};
use super::table::{Table, window_width};
use super::window::{Side, Windows};
use crate::frame::FrameView;
use crate::profile::Reason;

/// Fewest rows and columns from which levels and noise can be told.
const LEAST_ROWS: usize = 24;
const LEAST_COLUMNS: usize = 8;
/// Fewest columns with both edges that make a frame believable.
const LEAST_VALID: usize = 8;
/// Least fraction of the measured columns that must lie on unbroken contours.
const LEAST_COHERENT: f64 = 0.5;
/// Differences looked at per level for the noise: its variance is then known to 2 %.
const NOISE_SAMPLES: usize = 8192;
/// Fraction of flat light pixels at full scale above which the light counts as clipped.
const CLIPPED_FRACTION: f64 = 1e-3;

/// Finds edges in the frames of one stream; keeps tables and buffers between them.
#[derive(Clone, Debug)]
pub struct EdgeStream {
    settings: GaugeSettings,
    sides: [Windows; 2],
    blur: [Option<BlurEstimate>; 2],
    tables: Vec<Table>,
    slope: [Vec<f32>; 2],
    differences: Vec<f32>,
    floats: Vec<f32>,
    outliers: OutlierScratch,
    normalised: Vec<f32>,
}

/// What the frame says about itself.
struct Scene {
    dark: [LevelCurve; 2],
    light: [LevelCurve; 2],
    noise: NoiseModel,
    clipped: [bool; 2],
}

impl EdgeStream {
    /// A stream that knows nothing yet.
    pub fn new(settings: GaugeSettings) -> Self {
        Self {
            settings,
            sides: [Windows::new(Side::Top), Windows::new(Side::Bottom)],
            blur: [None; 2],
            tables: Vec::new(),
            slope: [Vec::new(), Vec::new()],
            differences: Vec::new(),
            floats: Vec::new(),
            outliers: OutlierScratch::default(),
            normalised: Vec::new(),
        }
    }

    /// Forgets what earlier frames taught.
    pub fn restart(&mut self) {
        self.blur = [None; 2];
        self.tables.clear();
    }

    /// Measures a frame into `out`.
    ///
    /// # Errors
    /// Refuses frames that show no part with two edges: black, white, noise, too small, not finite.
    pub fn measure(&mut self, view: &FrameView<'_>, out: &mut FrameEdges) -> Result<(), FrameRefused> {
        if view.rows() < LEAST_ROWS || view.columns() < LEAST_COLUMNS {
            return Err(refused(
                Reason::NoEdge,
                format!(
                    "{} rows x {} columns; at least {LEAST_ROWS} x {LEAST_COLUMNS} are needed to tell levels and noise",
                    view.rows(),
                    view.columns()
                ),
            ));
        }
        if !all_finite(view) {
            return Err(refused(Reason::Unreadable, "grey values that are not finite numbers".to_owned()));
        }
        let sign = if self.settings.polarity == Polarity::DarkOnBright { 1.0 } else { -1.0 };
        let clip = view.format().full_scale().map(f32::from).filter(|_| sign > 0.0);
        let floor = if view.format().full_scale().is_some() { 1.0 / 12.0 } else { 0.0 };
        with_plane!(view, sign, plane => self.measure_plane(&plane, clip, floor, out))
    }

    fn measure_plane<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        clip: Option<f32>,
        floor: f64,
        out: &mut FrameEdges,
    ) -> Result<(), FrameRefused> {
        let coarse = find_part(plane, &self.settings).map_err(|reason| refused(reason, explain(reason)))?;
        let given = match self.settings.blur {
            Blur::Given { sigma_px } => Some(sigma_px),
            Blur::Estimated {} => None,
        };
        let mut sigma = match given {
            Some(sigma) => sigma,
            None => self.rough_blur(plane, [&coarse.top, &coarse.bottom])?,
        };
        let mut scene = self.look(plane, [&coarse.top, &coarse.bottom], sigma, clip, floor)?;
        if given.is_none() {
            let refined = self.refine_blur(&scene, sigma, clip);
            let largest = refined.iter().map(BlurEstimate::mean).fold(0.0, f64::max);
            if window_width(largest) != self.sides[0].width {
                sigma = largest;
                scene = self.look(plane, [&coarse.top, &coarse.bottom], sigma, clip, floor)?;
            }
            self.blur = refined.map(Some);
        } else {
            self.blur = [Some(BlurEstimate::uniform(sigma)); 2];
        }
        let freedom = self.fit(&scene, clip, out);
        self.gate(&scene, freedom, out)
    }

    /// A first blur from wide windows on a few columns.
    fn rough_blur<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        coarse: [&[CoarseEdge]; 2],
    ) -> Result<f64, FrameRefused> {
        let mut rough = Vec::new();
        for width_sigma in [4.0, 2.0, 0.8] {
            for (windows, centres) in self.sides.iter_mut().zip(coarse) {
                windows.centre.clear();
                windows.centre.extend_from_slice(centres);
                windows.prepare(width_sigma, window_width(width_sigma), plane.columns);
                windows.read(plane);
                rough.extend(blur::rough(windows, plane.columns, &mut self.floats));
            }
            if rough.len() == 2 {
                break;
            }
            rough.clear();
        }
        if rough.is_empty() {
            return Err(refused(Reason::Border, "no edge keeps clear of the border of the field".to_owned()));
        }
        Ok(rough.iter().sum::<f64>() / rough.len() as f64)
    }

    /// Reads all windows, then levels and noise.
    fn look<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        coarse: [&[CoarseEdge]; 2],
        sigma: f64,
        clip: Option<f32>,
        floor: f64,
    ) -> Result<Scene, FrameRefused> {
        for (windows, centres) in self.sides.iter_mut().zip(coarse) {
            windows.centre.clear();
            windows.centre.extend_from_slice(centres);
            windows.prepare(sigma, window_width(sigma), plane.columns);
            windows.read(plane);
        }
        for (windows, slope) in self.sides.iter_mut().zip(&mut self.slope) {
            slopes(windows, slope);
            for (centre, slope) in windows.centre.iter_mut().zip(slope.iter()) {
                if centre.is_ok() && !(f64::from(slope.abs()) <= self.settings.max_slope) {
                    *centre = Err(Reason::NoEdge);
                }
            }
        }
        self.scene(clip, floor)
    }

    fn scene(&mut self, clip: Option<f32>, floor: f64) -> Result<Scene, FrameRefused> {
        let none =
            || refused(Reason::NoEdge, "no column shows both light and shadow beside an edge".to_owned());
        let clipped = [0, 1]
            .map(|side| clip.is_some_and(|c| clipped_fraction(&self.sides[side], c) > CLIPPED_FRACTION));
        let mean = |pick: fn(&Windows) -> &[f32], sides: &[Windows; 2]| {
            let values: Vec<f64> = sides
                .iter()
                .flat_map(|s| pick(s).iter())
                .filter(|v| v.is_finite())
                .map(|v| f64::from(*v))
                .collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        let dark = mean(|w| &w.dark, &self.sides).ok_or_else(none)?;
        let light = mean(|w| &w.light, &self.sides).ok_or_else(none)?;
        let floor = floor.max((1e-4 * (light - dark)).powi(2)).max(1e-20);
        let noise = self.noise(dark, light, clipped, floor).ok_or_else(none)?;
        let snr = (light - dark) / noise.variance(0.5 * (dark + light)).sqrt();
        if !(snr >= self.settings.min_snr) {
            return Err(refused(
                Reason::LowContrast,
                format!(
                    "contrast is {snr:.1} times the noise; at least {} are needed",
                    self.settings.min_snr
                ),
            ));
        }
        let knots = match self.settings.levels {
            Levels::Pooled { max_knots } => max_knots,
            Levels::PerColumn {} => 33,
        };
        let curve = |means: &[f32], variance: f64, flat: usize| {
            pool(means, (variance / flat as f64).sqrt() as f32, knots).ok_or_else(none)
        };
        let [top, bottom] = &self.sides;
        let (vd, vl) = (noise.variance(dark), noise.variance(light));
        Ok(Scene {
            dark: [curve(&top.dark, vd, top.flat)?, curve(&bottom.dark, vd, bottom.flat)?],
            light: [curve(&top.light, vl, top.flat)?, curve(&bottom.light, vl, bottom.flat)?],
            noise,
            clipped,
        })
    }

    fn noise(&mut self, dark: f64, light: f64, clipped: [bool; 2], floor: f64) -> Option<NoiseModel> {
        let sign = if self.settings.polarity == Polarity::DarkOnBright { 1.0 } else { -1.0 };
        if let Some(given) = NoiseModel::given(self.settings.noise, sign, floor) {
            return Some(given);
        }
        let least = floor.sqrt() as f32;
        let mut variance = |in_light: bool| {
            self.differences.clear();
            for (windows, clipped) in self.sides.iter().zip(clipped) {
                if !(in_light && clipped) {
                    collect_differences(windows, in_light, &mut self.differences);
                }
            }
            variance_of_differences(&mut self.differences, least)
        };
        let in_dark = variance(false)?;
        let in_light = variance(true).unwrap_or(in_dark);
        Some(NoiseModel::through((dark, in_dark.max(floor)), (light, in_light.max(floor)), floor))
    }

    fn refine_blur(&self, scene: &Scene, sigma: f64, clip: Option<f32>) -> [BlurEstimate; 2] {
        [0, 1].map(|side| {
            if scene.clipped[side] && clip.is_some() {
                return BlurEstimate::uniform(sigma);
            }
            let (dark, light) = typical_levels(scene, side);
            let context = BlurContext {
                windows: &self.sides[side],
                dark: &scene.dark[side],
                light: &scene.light[side],
                slope: &self.slope[side],
                kappa: scene.noise.kappa(dark, light),
                relative_variance: scene.noise.variance(0.5 * (dark + light)) / (light - dark).powi(2),
            };
            blur::refine(&context, sigma)
        })
    }

    /// Index of the table for a blur and noise slope, built where it is missing.
    fn table(&mut self, sigma: f64, kappa: f64, width: usize) -> usize {
        let near = |t: &Table| {
            t.width == width && (t.sigma / sigma).ln().abs() < 0.004 && (t.kappa - kappa).abs() < 0.05
        };
        if let Some(found) = self.tables.iter().position(near) {
            return found;
        }
        if self.tables.len() >= 64 {
            self.tables.clear();
        }
        let free = matches!(self.settings.levels, Levels::PerColumn {});
        self.tables.push(Table::new(sigma, kappa, width, free));
        self.tables.len() - 1
    }

    /// Fits both sides; gives the degrees of freedom of their residuals.
    fn fit(&mut self, scene: &Scene, clip: Option<f32>, out: &mut FrameEdges) -> [f64; 2] {
        let mut freedom = [0.0; 2];
        for side in 0..2 {
            let mut line = std::mem::take(if side == 0 { &mut out.top } else { &mut out.bottom });
            line.clear();
            freedom[side] = match clip.filter(|_| scene.clipped[side]) {
                Some(clip) => self.fit_clipped(scene, side, clip, &mut line),
                None => self.fit_side(scene, side, &mut line),
            };
            out.shared_length[side] = scene.dark[side].length.min(scene.light[side].length);
            *(if side == 0 { &mut out.top } else { &mut out.bottom }) = line;
        }
        freedom
    }

    fn fit_side(&mut self, scene: &Scene, side: usize, line: &mut Vec<Edge>) -> f64 {
        let columns = self.sides[side].centre.len();
        let width = self.sides[side].width;
        let (dark, light) = typical_levels(scene, side);
        let kappa = scene.noise.kappa(dark, light);
        let blur = self.blur[side].unwrap_or(BlurEstimate::uniform(1.0));
        let mut normalised = std::mem::take(&mut self.normalised);
        normalised.resize(width, 0.0);
        let mut last = (f64::NAN, 0);
        for column in 0..columns {
            let sigma =
                blur::at_slope(blur.sigma[BlurEstimate::block(column, columns)], self.slope[side][column]);
            if !((sigma / last.0).ln().abs() < 0.004) {
                last = (sigma, self.table(sigma, kappa, width));
            }
            line.push(self.fit_column(scene, side, column, &self.tables[last.1], &mut normalised));
        }
        self.normalised = normalised;
        self.tables.get(last.1).map_or(1.0, |t| f64::from(t.freedom))
    }

    fn fit_column(
        &self,
        scene: &Scene,
        side: usize,
        column: usize,
        table: &Table,
        normalised: &mut [f32],
    ) -> Edge {
        let windows = &self.sides[side];
        if let Err(reason) = windows.centre[column] {
            return Edge::gap(reason);
        }
        let (dark, light) = (scene.dark[side].level[column], scene.light[side].level[column]);
        let contrast = light - dark;
        let variance = scene.noise.variance(f64::from(0.5 * (dark + light))) as f32;
        if !(f64::from(contrast) >= self.settings.min_snr * f64::from(variance).sqrt()) {
            return Edge::gap(Reason::LowContrast);
        }
        let own = windows.light[column] - windows.dark[column];
        if !((0.5..2.0).contains(&(own / contrast))) {
            return Edge::gap(Reason::Contaminated);
        }
        normalise(windows.of(column), dark, contrast, normalised);
        let Some(found) = locate(normalised, table, windows.start[column]) else {
            return Edge::gap(Reason::Residual);
        };
        let relative = variance / (contrast * contrast);
        let scalars = found.phase.scalars;
        // ∂x/∂light = Σ w E/contrast and ∂x/∂dark = (Σ w − Σ w E)/contrast.
        let by_light = scalars.offset / contrast * scene.light[side].uncertainty[column];
        let by_dark = (scalars.weight_sum - scalars.offset) / contrast * scene.dark[side].uncertainty[column];
        Edge {
            row_px: windows.row(column, found.x),
            u_own_px: scalars.unit_uncertainty * relative.sqrt(),
            u_shared_px: by_light.hypot(by_dark),
            chi2: found.residual / (relative * table.freedom),
            state: EdgeState::Good,
        }
    }

    fn fit_clipped(&mut self, scene: &Scene, side: usize, clip: f32, line: &mut Vec<Edge>) -> f64 {
        let (dark, _) = typical_levels(scene, side);
        let windows = &self.sides[side];
        let start = ClippedStart {
            dark,
            variance: scene.noise.variance(dark),
            clip: f64::from(clip),
            fraction: clipped_fraction(windows, clip),
        };
        clipped::fit_side(windows, &self.slope[side], start, line)
    }

    fn gate(&mut self, scene: &Scene, freedom: [f64; 2], out: &mut FrameEdges) -> Result<(), FrameRefused> {
        let z = gate::upper_normal_quantile(self.settings.residual_false_alarm);
        let mut misfit = 0.0_f64;
        for (line, freedom) in [&mut out.top, &mut out.bottom].into_iter().zip(freedom) {
            let ratio = gate::misfit(line, freedom, &mut self.floats);
            let scale = if ratio > 1.2 { ratio } else { 1.0 };
            for edge in line.iter_mut() {
                edge.u_own_px *= (scale as f32).sqrt();
            }
            gate::refuse_residuals(line, (gate::chi2_ratio_limit(freedom, z) * scale) as f32);
            gate::refuse_outliers(line, self.settings.outlier_px, &mut self.outliers);
            misfit = misfit.max(ratio);
        }
        out.figures = self.figures(scene, misfit);
        let valid = out.valid();
        if valid < LEAST_VALID {
            let reason = most_common(out).unwrap_or(Reason::NoEdge);
            return Err(refused(
                reason,
                format!(
                    "only {valid} of {} columns have both edges; {LEAST_VALID} are needed",
                    out.columns()
                ),
            ));
        }
        let jump_px = self.settings.outlier_px + self.settings.max_slope;
        if gate::coherence(&out.top, &out.bottom, jump_px) < LEAST_COHERENT {
            let detail = "the edges of neighbouring columns do not join to contours".to_owned();
            return Err(refused(Reason::Outlier, detail));
        }
        Ok(())
    }

    fn figures(&self, scene: &Scene, misfit: f64) -> FrameFigures {
        let levels = [0, 1].map(|side| typical_levels(scene, side));
        let (dark, light) = (0.5 * (levels[0].0 + levels[1].0), 0.5 * (levels[0].1 + levels[1].1));
        let mid = scene.noise.variance(0.5 * (dark + light)).sqrt();
        FrameFigures {
            sigma_px: self.blur.map(|b| b.map_or(f64::NAN, |b| b.mean())),
            dark: levels.map(|l| l.0),
            light: levels.map(|l| l.1),
            noise: [scene.noise.variance(dark).sqrt(), scene.noise.variance(light).sqrt()],
            snr: (light - dark) / mid,
            misfit,
        }
    }
}

fn refused(reason: Reason, detail: String) -> FrameRefused {
    FrameRefused { reason, detail }
}

fn explain(reason: Reason) -> String {
    match reason {
        Reason::LowContrast => "the grey values do not fall into light and shadow".to_owned(),
        Reason::OneEdge => {
            "the shadow reaches the border of the field, so that only one edge is seen; both must lie inside"
                .to_owned()
        }
        _ => "no shadow as large as min_diameter_px lies in the field".to_owned(),
    }
}

/// Mean levels of one side over the frame, counts.
fn typical_levels(scene: &Scene, side: usize) -> (f64, f64) {
    let mean = |curve: &LevelCurve| {
        curve.level.iter().map(|v| f64::from(*v)).sum::<f64>() / curve.level.len().max(1) as f64
    };
    (mean(&scene.dark[side]), mean(&scene.light[side]))
}

/// Fraction of the flat light pixels that stand at full scale.
fn clipped_fraction(windows: &Windows, clip: f32) -> f64 {
    let (mut at_clip, mut all) = (0_u32, 0_u32);
    let used = windows.width - 1;
    for column in (0..windows.centre.len()).filter(|c| windows.centre[*c].is_ok()).step_by(4) {
        for value in &windows.of(column)[used - windows.flat..used] {
            at_clip += u32::from(*value >= clip);
            all += 1;
        }
    }
    f64::from(at_clip) / f64::from(all.max(1))
}

/// Differences of neighbouring columns' flat pixels, thinned to about [`NOISE_SAMPLES`].
fn collect_differences(windows: &Windows, in_light: bool, out: &mut Vec<f32>) {
    let columns = windows.centre.len();
    let used = windows.width - 1;
    let flat = if in_light { used - windows.flat..used } else { 0..windows.flat };
    let step = (columns * windows.flat).div_ceil(NOISE_SAMPLES / 2).max(2);
    for column in (0..columns.saturating_sub(1)).step_by(step) {
        if windows.centre[column].is_ok() && windows.centre[column + 1].is_ok() {
            let (a, b) = (&windows.of(column)[flat.clone()], &windows.of(column + 1)[flat.clone()]);
            out.extend(a.iter().zip(b).map(|(a, b)| a - b));
        }
    }
}

/// Slope of the edge line, rows per column, from first estimates eight columns either side; steep where neighbours are missing.
fn slopes(windows: &Windows, out: &mut Vec<f32>) {
    const ARM: usize = 8;
    let columns = windows.centre.len();
    out.clear();
    for column in 0..columns {
        let (from, to) = (column.saturating_sub(ARM), (column + ARM).min(columns - 1));
        let known = |mut range: std::ops::RangeInclusive<usize>| range.find(|c| windows.centre[*c].is_ok());
        let left = known(from..=column);
        let right = (column..=to).rev().find(|c| windows.centre[*c].is_ok());
        out.push(match (left, right) {
            (Some(l), Some(r)) if r > l => {
                let rise = windows.row(r, windows.start[r]) - windows.row(l, windows.start[l]);
                (rise / (r - l) as f64) as f32
            }
            _ => 0.0,
        });
    }
}

fn most_common(edges: &FrameEdges) -> Option<Reason> {
    let mut counts = std::collections::BTreeMap::<Reason, usize>::new();
    for reason in edges.top.iter().chain(&edges.bottom).filter_map(Edge::reason) {
        *counts.entry(reason).or_default() += 1;
    }
    counts.into_iter().max_by_key(|(_, n)| *n).map(|(reason, _)| reason)
}
