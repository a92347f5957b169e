//! Golden frames: cases, frames of three kinds that cannot be mixed up, and the comparator.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use shadowgauge::frame::{PixelFormat, Pixels};
use shadowgauge::render::contamination::Contamination;
use shadowgauge::render::form::form_shaft;
use shadowgauge::render::reference::GaussianReference;
use shadowgauge::render::settings::{BenchSettings, Camera, Departures, Esf, Light, Optics, Sensor};
use shadowgauge::render::{FrameRequest, OpticalBench, Renderer, Scene};
use shadowgauge::shaft::{ProfileKnot, ShaftForm};

/// Largest edge-equivalent shift, px: a thousandth of a pixel is the gauge's smallest term.
pub const SHIFT_LIMIT_PX: f64 = 0.001;

/// What a case says.
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Case {
    pub diameter_mm: f64,
    pub taper_deg: f64,
    pub length_mm: f64,
    pub z_mm: f64,
    pub angle_deg: f64,
    pub seed: u64,
    pub shaft: ShaftForm,
    pub camera: Camera,
    pub optics: Optics,
    pub light: Light,
    pub sensor: Sensor,
    pub contamination: Contamination,
}

impl Default for Case {
    fn default() -> Self {
        Self {
            diameter_mm: 1.0,
            taper_deg: 0.0,
            length_mm: 20.0,
            z_mm: 10.0,
            angle_deg: 0.0,
            seed: 0,
            shaft: ShaftForm::default(),
            camera: Camera::default(),
            optics: Optics::default(),
            light: Light::default(),
            sensor: Sensor::default(),
            contamination: Contamination::default(),
        }
    }
}

/// Truth of a golden frame.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Truth {
    pub top_px: Vec<f64>,
    pub bottom_px: Vec<f64>,
}

/// 16-bit pixels with the act that made them: no two acts share an id.
#[derive(Clone, Debug)]
pub struct Shot {
    pub rows: usize,
    pub columns: usize,
    pub pixels: Vec<u16>,
    id: u64,
}

impl Shot {
    pub fn new(rows: usize, columns: usize, pixels: Vec<u16>) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self { rows, columns, pixels, id: NEXT.fetch_add(1, Ordering::Relaxed) }
    }

    /// The same pixels as if made anew, with some changed.
    pub fn spoiled(&self, spoil: impl FnOnce(&mut Vec<u16>)) -> Self {
        let mut pixels = self.pixels.clone();
        spoil(&mut pixels);
        Self::new(self.rows, self.columns, pixels)
    }
}

/// From the file that the reference blessed.
pub struct GoldenFrame(pub Shot);
/// Rendered just now by the CPU twin.
pub struct CpuFrame(pub Shot);
/// Rendered just now by a device.
pub struct GpuFrame(pub Shot);

/// A frame under test and the frame it is held against; only these pairs exist.
pub trait HeldAgainst<Judge> {
    fn pair<'a>(&'a self, judge: &'a Judge) -> (&'a Shot, &'a Shot);
}
impl HeldAgainst<GoldenFrame> for CpuFrame {
    fn pair<'a>(&'a self, judge: &'a GoldenFrame) -> (&'a Shot, &'a Shot) {
        (&self.0, &judge.0)
    }
}
impl HeldAgainst<CpuFrame> for GpuFrame {
    fn pair<'a>(&'a self, judge: &'a CpuFrame) -> (&'a Shot, &'a Shot) {
        (&self.0, &judge.0)
    }
}

/// How far two frames lie apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Metrics {
    /// Largest |Δ|, 16-bit counts, and its limit.
    pub worst_counts: f64,
    pub limit_counts: f64,
    /// Largest signed edge-equivalent shift of an edge in a column, px.
    pub worst_shift_px: f64,
    /// Largest mean shift of an edge over all columns, px.
    pub mean_shift_px: f64,
}

/// Why a comparison fails.
#[derive(Clone, Debug, PartialEq)]
pub enum Mismatch {
    Size,
    SameInput,
    Counts(Metrics),
    Shift(Metrics),
}

/// Holds a frame against its judge.
pub fn compare<J, T: HeldAgainst<J>>(test: &T, judge: &J, scene: &GoldenScene) -> Result<Metrics, Mismatch> {
    let (a, b) = test.pair(judge);
    if a.id == b.id {
        return Err(Mismatch::SameInput);
    }
    if (a.rows, a.columns) != (b.rows, b.columns) || a.pixels.len() != b.pixels.len() {
        return Err(Mismatch::Size);
    }
    let m = metrics(a, b, scene);
    if m.worst_counts > m.limit_counts {
        return Err(Mismatch::Counts(m));
    }
    if m.worst_shift_px > SHIFT_LIMIT_PX || m.mean_shift_px > SHIFT_LIMIT_PX {
        return Err(Mismatch::Shift(m));
    }
    Ok(m)
}

fn metrics(a: &Shot, b: &Shot, scene: &GoldenScene) -> Metrics {
    let delta =
        |r: usize, c: usize| f64::from(a.pixels[r * a.columns + c]) - f64::from(b.pixels[r * a.columns + c]);
    let mut worst_counts: f64 = 0.0;
    let mut worst_shift: f64 = 0.0;
    let mut sums = [0.0; 2];
    for (c, e) in scene.truth.top_px.iter().zip(&scene.truth.bottom_px).enumerate() {
        let middle = ((e.0 + e.1) / 2.0).round() as usize;
        for (side, rows) in [0..middle, middle..a.rows].into_iter().enumerate() {
            let shift = rows.clone().map(|r| delta(r, c)).sum::<f64>() / scene.contrast;
            worst_counts = rows.map(|r| delta(r, c).abs()).fold(worst_counts, f64::max);
            worst_shift = worst_shift.max(shift.abs());
            sums[side] += shift / a.columns as f64;
        }
    }
    Metrics {
        worst_counts,
        limit_counts: SHIFT_LIMIT_PX * scene.contrast / (scene.sigma_px * std::f64::consts::TAU.sqrt()) + 1.0,
        worst_shift_px: worst_shift,
        mean_shift_px: sums[0].abs().max(sums[1].abs()),
    }
}

/// A case made ready to be drawn.
pub struct GoldenScene {
    pub name: String,
    pub folder: PathBuf,
    pub scene: Scene,
    pub request: FrameRequest,
    pub truth: Truth,
    pub sigma_px: f64,
    pub contrast: f64,
}

impl GoldenScene {
    pub fn load(folder: &Path) -> Self {
        let text = std::fs::read_to_string(folder.join("case.toml")).unwrap();
        let case: Case = toml::from_str(&text).unwrap();
        let settings = BenchSettings {
            camera: case.camera.clone(),
            optics: case.optics.clone(),
            light: case.light.clone(),
            sensor: case.sensor.clone(),
            motion: Default::default(),
            contamination: case.contamination.clone(),
            departures: Departures::none(),
        };
        let bench = OpticalBench::resolve(&settings, case.seed).unwrap();
        let radius = case.diameter_mm / 2.0;
        let half = 0.1 * case.length_mm;
        let rise = half * case.taper_deg.to_radians().tan();
        let knots = vec![
            ProfileKnot { z_mm: case.z_mm - half, radius_mm: radius + rise },
            ProfileKnot { z_mm: case.z_mm + half, radius_mm: (radius - rise).max(1e-3) },
        ];
        let knots =
            if case.taper_deg == 0.0 { knots[..1].to_vec() } else { taper(&knots, case.z_mm, radius) };
        let scene =
            Scene::new(&bench, form_shaft(knots, &case.shaft, case.length_mm, case.seed).unwrap()).unwrap();
        let request = FrameRequest {
            z_mm: case.z_mm,
            angle_deg: case.angle_deg,
            format: Some(PixelFormat::Mono16),
            ..Default::default()
        };
        let edges = shadowgauge::truth::true_edges(&scene, &request).unwrap();
        let levels = scene.levels(PixelFormat::Mono16);
        let sigma_px = match &bench.esf {
            Esf::Gaussian(g) => g.sigma_px,
            other => panic!("the reference does not know {other:?}"),
        };
        Self {
            name: folder.file_name().unwrap().to_string_lossy().into_owned(),
            folder: folder.to_owned(),
            truth: Truth {
                top_px: edges.iter().map(|e| e.top_px).collect(),
                bottom_px: edges.iter().map(|e| e.bottom_px).collect(),
            },
            scene,
            request,
            sigma_px,
            contrast: levels.bright - levels.shadow,
        }
    }

    pub fn draw(&self, renderer: &Renderer) -> Shot {
        let frame = renderer.render(&self.scene, &self.request, None).unwrap();
        let view = frame.view();
        let Pixels::U16(pixels) = view.pixels() else { panic!("not 16 bit") };
        Shot::new(view.rows(), view.columns(), pixels.to_vec())
    }

    /// Counts by the f64 reference, its edges moved down by `shift_px`.
    pub fn reference(&self, shift_px: f64) -> Vec<f64> {
        let bench = self.scene.bench();
        let levels = self.scene.levels(PixelFormat::Mono16);
        let turned = self.scene.outline().turned(self.request.angle_deg);
        let edges = |column: f64| {
            let e = self.scene.edges_at(&turned, self.request.z_mm, column);
            [e.top_px + shift_px, e.bottom_px + shift_px]
        };
        GaussianReference { sigma_px: self.sigma_px, shadow: levels.shadow, bright: levels.bright }.frame(
            bench.rows(),
            bench.columns(),
            edges,
        )
    }

    /// The reference as a 16-bit frame.
    pub fn quantised(&self, shift_px: f64) -> Shot {
        let bench = self.scene.bench();
        let pixels = self.reference(shift_px).iter().map(|v| v.round().clamp(0.0, 65535.0) as u16).collect();
        Shot::new(bench.rows(), bench.columns(), pixels)
    }

    pub fn golden(&self) -> Option<(GoldenFrame, Truth)> {
        let image = image::open(self.folder.join("frame.png")).ok()?;
        let image::DynamicImage::ImageLuma16(grey) = image else { panic!("{}: not 16-bit grey", self.name) };
        let truth = std::fs::read_to_string(self.folder.join("truth.json")).ok()?;
        let (columns, rows) = (grey.width() as usize, grey.height() as usize);
        Some((GoldenFrame(Shot::new(rows, columns, grey.into_raw())), serde_json::from_str(&truth).unwrap()))
    }

    /// Writes the reference's frame and truth under temporary names, then renames them.
    pub fn bless(&self) {
        let shot = self.quantised(0.0);
        let grey: image::ImageBuffer<image::Luma<u16>, Vec<u16>> =
            image::ImageBuffer::from_raw(shot.columns as u32, shot.rows as u32, shot.pixels).unwrap();
        let (frame, truth) = (self.folder.join("frame.part.png"), self.folder.join("truth.part.json"));
        grey.save(&frame).unwrap();
        std::fs::write(&truth, serde_json::to_string(&self.truth).unwrap()).unwrap();
        std::fs::rename(frame, self.folder.join("frame.png")).unwrap();
        std::fs::rename(truth, self.folder.join("truth.json")).unwrap();
    }
}

/// A cone through `radius` at `z_mm`, cut off where the radius would vanish.
fn taper(knots: &[ProfileKnot], z_mm: f64, radius: f64) -> Vec<ProfileKnot> {
    let slope = (knots[0].radius_mm - radius) / (z_mm - knots[0].z_mm);
    let reach = 0.95 * radius / slope;
    vec![
        ProfileKnot { z_mm: z_mm - reach, radius_mm: radius + slope * reach },
        ProfileKnot { z_mm: z_mm + reach, radius_mm: radius - slope * reach },
    ]
}

/// Every case there is.
pub fn cases() -> Vec<GoldenScene> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    let mut folders: Vec<PathBuf> =
        std::fs::read_dir(root).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir()).collect();
    folders.sort();
    folders.iter().map(|f| GoldenScene::load(f)).collect()
}
