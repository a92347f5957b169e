//! Golden frames: cases, frames of three kinds with distinct types, and the comparator.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use shadowgauge::frame::{PixelFormat, Pixels};
use shadowgauge::render::contamination::{ContaminationField, FieldGeometry, Rise, TransmissionMap};
use shadowgauge::render::reference::{GaussianReference, StraightReference};
use shadowgauge::render::settings::Esf;
use shadowgauge::render::{FrameRequest, Renderer, Scene};
pub(crate) use shadowgauge::studies::golden_cases::{FrameDifference, GoldenCase, SHIFT_LIMIT_PX};

/// Truth of a golden frame.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Truth {
    pub top_px: Vec<f64>,
    pub bottom_px: Vec<f64>,
}

/// 16-bit pixels with the id of the rendering: no two renderings have the same id.
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

    /// The same pixels as if rendered anew, with some changed.
    pub fn spoiled(&self, spoil: impl FnOnce(&mut Vec<u16>)) -> Self {
        let mut pixels = self.pixels.clone();
        spoil(&mut pixels);
        Self::new(self.rows, self.columns, pixels)
    }
}

/// From the golden file, written by the reference.
pub struct GoldenFrame(pub Shot);
/// Rendered just now by the CPU twin.
pub struct CpuFrame(pub Shot);
/// Rendered just now by a device.
pub struct GpuFrame(pub Shot);

/// A frame under test and the frame that it is compared with; only these pairs exist.
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

/// Why a comparison fails.
#[derive(Clone, Debug, PartialEq)]
pub enum Mismatch {
    Size,
    SameInput,
    Counts(FrameDifference),
    Shift(FrameDifference),
}

/// Compares a frame with its reference.
pub fn compare<J, T: HeldAgainst<J>>(
    test: &T,
    judge: &J,
    scene: &GoldenScene,
) -> Result<FrameDifference, Mismatch> {
    let (a, b) = test.pair(judge);
    if a.id == b.id {
        return Err(Mismatch::SameInput);
    }
    if (a.rows, a.columns) != (b.rows, b.columns) || a.pixels.len() != b.pixels.len() {
        return Err(Mismatch::Size);
    }
    let truth = &scene.truth;
    let edges = truth.top_px.iter().copied().zip(truth.bottom_px.iter().copied());
    let difference = FrameDifference::of(&a.pixels, &b.pixels, b.columns, edges, scene.contrast);
    if !difference.counts_agree() {
        return Err(Mismatch::Counts(difference));
    }
    if !difference.edges_agree() {
        return Err(Mismatch::Shift(difference));
    }
    Ok(difference)
}

/// A case prepared for rendering.
pub struct GoldenScene {
    pub name: String,
    pub folder: PathBuf,
    pub scene: Scene,
    pub request: FrameRequest,
    pub truth: Truth,
    pub sigma_px: Option<f64>,
    pub contrast: f64,
    pub seed: u64,
}

impl GoldenScene {
    pub fn load(folder: &Path) -> Self {
        let text = std::fs::read_to_string(folder.join("case.toml")).unwrap();
        let case: GoldenCase = toml::from_str(&text).unwrap();
        let (scene, request) = (case.scene().unwrap(), case.request());
        let edges = shadowgauge::truth::true_edges(&scene, &request).unwrap();
        let levels = scene.setup().levels(PixelFormat::Mono16);
        let sigma_px = match &scene.setup().esf {
            Esf::Gaussian(g) => Some(g.sigma_px),
            _ => None,
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
            seed: case.seed,
        }
    }

    pub fn draw(&self, renderer: &Renderer) -> Shot {
        let frame = renderer.render(&self.scene, &self.request, None).unwrap();
        let view = frame.view();
        let Pixels::U16(pixels) = view.pixels() else { panic!("not 16 bit") };
        Shot::new(view.rows(), view.columns(), pixels.to_vec())
    }

    /// Whether the light is even and clean, no pixel saturated and the blur Gaussian: the
    /// assumptions of a gauge.
    pub fn is_plain(&self) -> bool {
        let setup = self.scene.setup();
        let levels = self.scene.setup().levels(PixelFormat::Mono16);
        self.sigma_px.is_some()
            && setup.contamination.is_none()
            && setup.nominal.light.field.is_even()
            && levels.black + levels.full_well_e / levels.electrons_per_count > levels.bright
    }

    /// Counts by the f64 reference, its edges moved down by `shift_px`.
    pub fn reference(&self, shift_px: f64) -> Vec<f64> {
        let setup = self.scene.setup();
        let levels = self.scene.setup().levels(PixelFormat::Mono16);
        let (rows, columns) = (setup.rows(), setup.columns());
        let clear = self.clear_light();
        let factor = |r: usize, c: usize| {
            let field = setup.nominal.light.field.at_px(r as f64, c as f64, rows, columns);
            field * clear.as_ref().map_or(1.0, |map| f64::from(map.values()[r * columns + c]))
        };
        let edges = self.drawn_edges(shift_px);
        let counts = match self.sigma_px {
            Some(sigma_px) => GaussianReference { sigma_px, shadow: levels.shadow, bright: levels.bright }
                .lit_frame(rows, columns, edges, factor),
            None => self.straight(edges, factor),
        };
        let full = levels.black + levels.full_well_e / levels.electrons_per_count;
        counts.into_iter().map(|v| v.min(full)).collect()
    }

    /// Edges as drawn: those of the part, raised by its films.
    fn drawn_edges(&self, shift_px: f64) -> impl Fn(f64) -> [f64; 2] + '_ {
        let setup = self.scene.setup();
        let shaft = self.scene.outline().shaft();
        let radius_mm = shaft.profile.iter().map(|k| k.radius_mm).fold(0.0, f64::max);
        let half_mm = setup.columns() as f64 * setup.pixel_mm;
        let z = self.request.z_mm;
        let films = setup
            .contamination
            .as_ref()
            .map(|contamination| contamination.films(radius_mm, z - half_mm..z + half_mm).unwrap())
            .unwrap_or_default();
        let turned = self.scene.outline().turned(self.request.angle_deg);
        move |column: f64| {
            let e = self.scene.edges_at(&turned, z, column);
            let radius_mm = 0.5 * (e.bottom_px - e.top_px) * setup.pixel_mm;
            let rise = setup.contamination.as_ref().map_or_else(Rise::default, |contamination| {
                contamination.rise(&films, radius_mm, setup.column_z_mm(z, column), self.request.angle_deg)
            });
            [e.top_px - rise.top_px + shift_px, e.bottom_px + rise.bottom_px + shift_px]
        }
    }

    /// Transmission of window and air, drawn independently of the renderer.
    fn clear_light(&self) -> Option<TransmissionMap> {
        let setup = self.scene.setup();
        setup.contamination.as_ref().filter(|s| s.dims())?;
        let geometry = FieldGeometry {
            rows: setup.rows(),
            columns: setup.columns(),
            pixel_um: setup.pixel_mm * 1e3,
            effective_na: setup.nominal.optics.defocus_na,
            sigma_um: self.sigma_px? * setup.pixel_mm * 1e3,
        };
        let field =
            ContaminationField::new(&setup.nominal.contamination, geometry, self.seed ^ 0x736f_696c).unwrap();
        Some(field.frame(self.request.frame_id, [0, 0], [setup.rows(), setup.columns()]).unwrap())
    }

    /// A frame of straight edges of any family.
    fn straight(&self, edges: impl Fn(f64) -> [f64; 2], factor: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let setup = self.scene.setup();
        let levels = self.scene.setup().levels(PixelFormat::Mono16);
        let esf = self.scene.edge_spreads().first().expect("a family has a table");
        let judge = StraightReference { esf, pixel_um: setup.pixel_mm * 1e3 };
        let mut counts = vec![0.0; setup.rows() * setup.columns()];
        for column in 0..setup.columns() {
            let [here, next] = [0.0, 1.0].map(|ahead| edges(column as f64 + ahead));
            for row in 0..setup.rows() {
                let y = row as f64;
                let light =
                    judge.light(here[0] - y, next[0] - here[0]) + judge.light(y - here[1], here[1] - next[1]);
                counts[row * setup.columns() + column] =
                    levels.shadow + (levels.bright - levels.shadow) * light * factor(row, column);
            }
        }
        counts
    }

    /// The reference as a 16-bit frame.
    pub fn quantised(&self, shift_px: f64) -> Shot {
        let setup = self.scene.setup();
        let pixels = self.reference(shift_px).iter().map(|v| v.round().clamp(0.0, 65535.0) as u16).collect();
        Shot::new(setup.rows(), setup.columns(), pixels)
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

/// All cases.
pub fn cases() -> Vec<GoldenScene> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    let mut folders: Vec<PathBuf> =
        std::fs::read_dir(root).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir()).collect();
    folders.sort();
    folders.iter().map(|f| GoldenScene::load(f)).collect()
}
