//! The edge-spread function as a table, and the pixel's area as a quadrature over it.
//!
//! The light of a straight edge of slope tan β on pixel (row y, column x) is
//!
//! ```text
//! I = ∫∫ F(d(x + ξ, y + η)) dξ dη over ξ, η in ±1/2,   d = ((e - y) - η) cos β + ξ sin β
//! ```
//!
//! with F over the perpendicular distance d into the light, so that one table is valid for every
//! slope. The integral is a Gauss-Legendre product whose order follows from the blur; its error
//! stays below 1e-6 of the contrast.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::edge_spread::gaussian::gaussian;
use super::edge_spread::quadrature::gauss_legendre;
use super::edge_spread::{
    CylinderEdge, EdgeSpread, FieldGrid, FieldStack, FocusStack, GaussianBlur, GrazingReflection,
    LaserShadow, LimbLayout, LimbStack, PartiallyCoherentEdge, Shifts,
};
use super::settings::{Esf, Optics};
use crate::render::error::RenderError;

/// Knots per σ of the Gaussian's table: cubic Hermite errs by (1/16)⁴/384·max|F⁗| = 2e-8.
const KNOTS_PER_SIGMA: f64 = 16.0;

/// Reach of the Gaussian table in σ: 1 - Φ(5.25) = 8e-8, below the spacing of f32 at 1.
const GAUSSIAN_REACH: f64 = 5.25;

/// Largest error of the blend between two tables of neighbouring focus, share of full intensity.
const BLEND_TOLERANCE: f64 = 1e-4;

/// Largest error of a table derived from another one.
const TOLERANCE: f64 = 1e-6;

/// Nodes of a defocused disc.
const DISC_NODES: usize = 24;

/// Largest ratio of radii whose reflections share a table; the width of the strip has the same
/// relative error.
const RADIUS_RATIO: f64 = 1.01;

/// Most segments of all tables together: 16 MiB.
const MOST_SEGMENTS: usize = 1 << 20;

/// 10-90 % width of a Gaussian in σ.
const WIDTH_10_90: f64 = 2.563;

/// The range that a table must cover beyond a knife edge in focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    /// Size of a pixel on the object, mm.
    pub pixel_mm: f64,
    /// Largest distance of the axis from the plane of focus, mm.
    pub depth_mm: f64,
    /// Smallest and largest mean radius of the shaft, mm.
    pub radius_mm: (f64, f64),
}

/// How the table of an edge out of focus is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Focus {
    /// One for all.
    Fixed,
    /// The scale widens: variance of (y·na/2)², mm².
    Widens { na: f64 },
    /// The scale shrinks with the distance to the sensor, √(1 - y/ℓ).
    Nears { distance_mm: f64 },
    /// Tables at equal steps of |y + offset|, linear between two.
    Stack { offset_mm: f64, step_mm: f64, tables: u32 },
    /// Tables at equal steps of signed y, linear between two.
    Signed { first_mm: f64, step_mm: f64, tables: u32 },
    /// Tables at equal steps of the radius' cube root (mm^(1/3)), linear between two.
    Radii { first: f64, step: f64, tables: u32 },
    /// Tables over the field of a lens with aberrations, by distance; cubic between them.
    Field(FieldGrid),
}

/// Edge-spread functions over u = d/scale, piecewise cubic, 0 in the shadow and 1 in the light.
#[derive(Clone, Debug, PartialEq)]
pub struct EsfTable {
    /// Coefficients c0..c3 of every segment in its own fraction 0..1, table after table.
    pub segments: Vec<[f32; 4]>,
    /// Segments of one table.
    pub per_table: u32,
    /// u of the first knot is -reach, of the last +reach.
    pub reach: f32,
    /// Segments per unit of u.
    pub per_unit: f32,
    /// Pixels per unit of u in focus (σ for the Gaussian).
    pub scale_px: f64,
    /// Standard deviation of a Gaussian of about the same width, px.
    pub blur_px: f64,
    /// Standard deviation of a Gaussian of about the same sharpness, px: the scale that the
    /// quadrature over a pixel must resolve.
    pub sharp_px: f64,
    /// Whether additional blur only widens the scale (true for the Gaussian only).
    pub widens: bool,
    /// Whether the light is already integrated over a pixel: for edges along the rows.
    pub over_pixel: bool,
    origin: Origin,
    folded: Folded,
}

/// The sources of the tables.
#[derive(Clone, Debug, PartialEq)]
struct Origin {
    focus: Focus,
    /// Radii of reflecting surfaces and of limbs that have tables of their own, ascending; empty
    /// where the radius has no effect.
    radii_mm: Vec<f64>,
    /// Whether the last table is that of flat faces along the light.
    has_face: bool,
    /// The tables in f64, µm on the object; empty for the plain Gaussian.
    sources: Arc<[EdgeSpread]>,
    pixel_mm: f64,
}

/// The same tables integrated over a pixel, computed on first use; none where that fails.
#[derive(Clone, Debug, Default)]
struct Folded(OnceLock<Option<Box<EsfTable>>>);

impl PartialEq for Folded {
    /// A cache, which follows from the other fields.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Cache of the tables of an optical setup: a partially coherent one takes tenths of a second, and
/// every pose of a part needs it.
#[derive(Clone, Debug, Default)]
pub struct TableCache(Arc<Mutex<Vec<Kept>>>);

#[derive(Clone, Debug)]
struct Kept {
    esf: Esf,
    optics: Optics,
    extent: Extent,
    table: Arc<EsfTable>,
}

/// Most tables kept.
const MOST_KEPT: usize = 8;

impl PartialEq for TableCache {
    /// The contents of a cache do not affect equality.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl TableCache {
    /// [`EsfTable::new`], or its cached result.
    ///
    /// # Errors
    /// As [`EsfTable::new`].
    pub(crate) fn table(
        &self,
        esf: &Esf,
        optics: &Optics,
        extent: &Extent,
    ) -> Result<Arc<EsfTable>, RenderError> {
        let mut extent = *extent;
        if optics.reflection.is_none() && !matches!(esf, Esf::Cylinder(_)) {
            // The radius affects reflections and limbs only.
            extent.radius_mm = (1.0, 1.0);
        }
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(k) = kept.iter().find(|k| k.extent == extent && k.optics == *optics && k.esf == *esf) {
            return Ok(Arc::clone(&k.table));
        }
        let table = Arc::new(EsfTable::new(esf, optics, &extent)?);
        if kept.len() == MOST_KEPT {
            kept.remove(0);
        }
        let (esf, optics) = (esf.clone(), optics.clone());
        kept.push(Kept { esf, optics, extent, table: Arc::clone(&table) });
        Ok(table)
    }
}

/// The table of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TablePlace {
    /// Number of the table.
    pub table: u32,
    /// Share of the next one.
    pub blend: f64,
    /// Pixels per unit of u.
    pub scale_px: f64,
}

impl EsfTable {
    /// Tabulates the edge spread of `esf` (the true one of the family in `optics`) over the range
    /// of `extent`.
    ///
    /// # Errors
    /// Refuses families whose values are out of range or whose tables would be too large.
    pub(crate) fn new(esf: &Esf, optics: &Optics, extent: &Extent) -> Result<Self, RenderError> {
        let reflection = optics.reflection.as_ref().filter(|r| r.polished_share > 0.0);
        if let (Esf::Gaussian(g), None) = (esf, reflection) {
            return Ok(Self::gaussian(g.sigma_px, optics.defocus_na, extent.pixel_mm));
        }
        if let Esf::Cylinder(edge) = esf {
            return Self::limbs(edge, extent);
        }
        if let (Esf::PartiallyCoherent(edge), false) = (esf, optics.aberrations.is_empty()) {
            let FieldStack { tables, grid } = FieldStack::new(edge, &optics.aberrations, extent.depth_mm)?;
            let (focus, pixel_mm) = (Focus::Field(grid), extent.pixel_mm);
            let sources = tables.into();
            return Self::from_tables(Origin {
                focus,
                radii_mm: Vec::new(),
                has_face: false,
                sources,
                pixel_mm,
            });
        }
        let family = Family { esf, na: optics.defocus_na, pixel_um: extent.pixel_mm * 1e3 };
        let (focus, tables) = family.over_focus(extent.depth_mm)?;
        let (radii_mm, tables) = match reflection {
            Some(r) => over_radii(r, &tables, extent.radius_mm)?,
            None => (Vec::new(), tables),
        };
        let sources = tables.into();
        Self::from_tables(Origin { focus, radii_mm, has_face: false, sources, pixel_mm: extent.pixel_mm })
    }

    /// The limbs of cylinders of all radii and distances of the extent, and the face of a shoulder.
    fn limbs(edge: &CylinderEdge, extent: &Extent) -> Result<Self, RenderError> {
        let stack = LimbStack::new(edge, extent.radius_mm, extent.depth_mm, BLEND_TOLERANCE)?;
        let mut tables = stack.tables;
        let (focus, radii_mm) = match stack.layout {
            LimbLayout::Radii { .. } if tables.len() == 1 => (Focus::Fixed, Vec::new()),
            LimbLayout::Radii { first, step } => {
                (Focus::Radii { first, step, tables: tables.len() as u32 }, Vec::new())
            }
            LimbLayout::Distances { first_mm, step_mm, per_radius, radii_mm } => {
                (Focus::Signed { first_mm, step_mm, tables: per_radius }, radii_mm)
            }
        };
        tables.push(edge.face()?);
        let pixel_mm = extent.pixel_mm;
        Self::from_tables(Origin { focus, radii_mm, has_face: true, sources: tables.into(), pixel_mm })
    }

    /// The table of flat faces along the light, where they have one of their own.
    pub(crate) fn face(&self) -> Option<TablePlace> {
        let table = self.origin.sources.len().checked_sub(1)? as u32;
        self.origin.has_face.then_some(TablePlace { table, blend: 0.0, scale_px: self.scale_px })
    }

    /// The tables convolved with a pixel's height: the light on a pixel past an edge along its
    /// rows, so that one look-up replaces the quadrature. `None` where they cannot be computed.
    pub(crate) fn over_pixel(&self) -> Option<&Self> {
        let made = || {
            let origin = &self.origin;
            if self.is_by_field() {
                return None;
            }
            if origin.sources.is_empty() {
                let mut folded = Self::gaussian_over(self.scale_px, 0.0, origin.pixel_mm, true);
                folded.origin.focus = origin.focus;
                return Some(Box::new(folded));
            }
            let over = |t: &EdgeSpread| t.averaged(origin.pixel_mm * 1e3, TOLERANCE);
            let sources = origin.sources.iter().map(over).collect::<Result<Vec<_>, _>>().ok()?.into();
            let folded = Self::from_tables(Origin { sources, ..origin.clone() }).ok()?;
            Some(Box::new(Self { over_pixel: true, ..folded }))
        };
        self.folded.0.get_or_init(made).as_deref()
    }

    fn gaussian(sigma_px: f64, na: f64, pixel_mm: f64) -> Self {
        Self::gaussian_over(sigma_px, na, pixel_mm, false)
    }

    fn gaussian_over(sigma_px: f64, na: f64, pixel_mm: f64, over_pixel: bool) -> Self {
        let half = if over_pixel { 0.5 / sigma_px } else { 0.0 };
        let reach = GAUSSIAN_REACH + half;
        let count = (2.0 * reach * KNOTS_PER_SIGMA).ceil();
        let step = 2.0 * reach / count;
        let knot = |u: f64| if over_pixel { boxed_gaussian(u, half) } else { gaussian(u) };
        let segments: Vec<_> = (0..count as usize)
            .map(|i| {
                let (a, da) = knot(-reach + i as f64 * step);
                let (b, db) = knot(-reach + (i + 1) as f64 * step);
                hermite(a, da * step, b, db * step)
            })
            .collect();
        Self {
            per_table: segments.len() as u32,
            segments,
            reach: reach as f32,
            over_pixel,
            folded: Folded::default(),
            per_unit: (1.0 / step) as f32,
            scale_px: sigma_px,
            blur_px: sigma_px,
            sharp_px: sigma_px,
            widens: true,
            origin: Origin {
                focus: if na == 0.0 { Focus::Fixed } else { Focus::Widens { na } },
                radii_mm: Vec::new(),
                has_face: false,
                sources: Arc::new([]),
                pixel_mm,
            },
        }
    }

    fn from_tables(origin: Origin) -> Result<Self, RenderError> {
        let (tables, pixel_um) = (&origin.sources, origin.pixel_mm * 1e3);
        let reach_um = tables.iter().map(|t| t.range_um().1.max(-t.range_um().0)).fold(0.0, f64::max);
        let step_um = tables.iter().map(EdgeSpread::step_um).fold(f64::INFINITY, f64::min);
        let count = (2.0 * reach_um / step_um).ceil().max(1.0) as usize;
        if count.saturating_mul(tables.len()) > MOST_SEGMENTS {
            return Err(RenderError::setting(
                "optics.esf",
                &format!("{} tables of {count} segments", tables.len()),
                "are too many: shorten the family's reach, bend the shaft less, or take fewer diameters with a reflection",
            ));
        }
        let narrowed = |t: &EdgeSpread| t.cubics(reach_um, count).into_iter().map(|c| c.map(|v| v as f32));
        let width = tables[0].width_10_90_um().unwrap_or(0.0).max(1e-3 * reach_um);
        let sharp_um = tables.iter().map(EdgeSpread::sharpness_um).fold(f64::INFINITY, f64::min);
        Ok(Self {
            segments: tables.iter().flat_map(narrowed).collect(),
            per_table: count as u32,
            reach: (reach_um / pixel_um) as f32,
            per_unit: (0.5 * count as f64 * pixel_um / reach_um) as f32,
            scale_px: 1.0,
            blur_px: width / WIDTH_10_90 / pixel_um,
            sharp_px: sharp_um / pixel_um,
            widens: false,
            over_pixel: false,
            folded: Folded::default(),
            origin,
        })
    }

    /// Whether edges may lie between two tables.
    pub(crate) fn is_stacked(&self) -> bool {
        matches!(self.origin.focus, Focus::Stack { .. } | Focus::Signed { .. } | Focus::Radii { .. })
    }

    /// Whether all edges share one table and scale, independent of depth and radius.
    pub(crate) fn is_even(&self) -> bool {
        self.origin.focus == Focus::Fixed && self.origin.radii_mm.len() < 2
    }

    /// Whether the place in the field has an effect: [`Self::in_field`] has the tables of an edge
    /// then, and [`Self::place`] the one of the middle.
    pub(crate) fn is_by_field(&self) -> bool {
        matches!(self.origin.focus, Focus::Field(_))
    }

    /// Tables and shares of an edge at a place of the field, `out` into its light and `along` it
    /// from the middle in half diagonals; none where the place has no effect.
    pub(crate) fn in_field(&self, place: [f64; 2], y_mm: f64) -> Option<Vec<(TablePlace, f64)>> {
        let Focus::Field(grid) = self.origin.focus else { return None };
        let of = |(table, share)| (TablePlace { table, blend: 0.0, scale_px: self.scale_px }, share);
        Some(grid.shares(place, y_mm).into_iter().map(of).collect())
    }

    /// The table nearest to a place of the field, where that has an effect.
    pub(crate) fn nearest_in_field(&self, place: [f64; 2], y_mm: f64) -> Option<TablePlace> {
        let Focus::Field(grid) = self.origin.focus else { return None };
        Some(TablePlace { table: grid.nearest(place, y_mm), blend: 0.0, scale_px: self.scale_px })
    }

    /// Whether surfaces of different radius have tables of their own.
    pub(crate) fn has_radii(&self) -> bool {
        self.origin.radii_mm.len() > 1 || matches!(self.origin.focus, Focus::Radii { .. })
    }

    /// Table and scale of an edge whose axis lies `y_mm` in front of the plane of focus (towards
    /// the camera), on a surface of mean radius `radius_mm`; `extra_px2` widens the scale of the
    /// Gaussian.
    pub(crate) fn place(&self, y_mm: f64, radius_mm: f64, extra_px2: f64) -> TablePlace {
        let scale = |variance: f64| (self.scale_px * self.scale_px + variance).sqrt();
        match self.origin.focus {
            Focus::Fixed if self.widens => TablePlace { table: 0, blend: 0.0, scale_px: scale(extra_px2) },
            Focus::Widens { na } => {
                let defocus = (0.5 * y_mm * na / self.origin.pixel_mm).powi(2);
                TablePlace { table: 0, blend: 0.0, scale_px: scale(extra_px2 + defocus) }
            }
            Focus::Fixed => TablePlace { table: self.bin(radius_mm), blend: 0.0, scale_px: self.scale_px },
            Focus::Nears { distance_mm } => {
                let nearer = (1.0 - y_mm / distance_mm).max(1e-3).sqrt();
                TablePlace { table: self.bin(radius_mm), blend: 0.0, scale_px: self.scale_px * nearer }
            }
            Focus::Stack { offset_mm, step_mm, tables } => {
                self.between((y_mm + offset_mm).abs() / step_mm, tables, self.bin(radius_mm))
            }
            Focus::Signed { first_mm, step_mm, tables } => {
                self.between((y_mm - first_mm) / step_mm, tables, self.bin(radius_mm))
            }
            Focus::Radii { first, step, tables } => {
                self.between((radius_mm.cbrt() - first) / step, tables, 0)
            }
            Focus::Field(grid) => {
                let table = grid.nearest([0.0, 0.0], y_mm);
                TablePlace { table, blend: 0.0, scale_px: self.scale_px }
            }
        }
    }

    /// A place, in steps, in a stack of tables.
    fn between(&self, at: f64, tables: u32, stack: u32) -> TablePlace {
        let last = f64::from(tables - 2);
        let at = at.clamp(0.0, last + 1.0);
        let below = at.floor().min(last);
        TablePlace { table: stack * tables + below as u32, blend: at - below, scale_px: self.scale_px }
    }

    /// Index of the radius whose tables are used for a surface.
    fn bin(&self, radius_mm: f64) -> u32 {
        let after = self.origin.radii_mm.partition_point(|r| *r < radius_mm);
        match (after.checked_sub(1).map(|i| self.origin.radii_mm[i]), self.origin.radii_mm.get(after)) {
            (Some(a), Some(b)) if radius_mm * radius_mm < a * b => after as u32 - 1,
            (Some(_), None) => after as u32 - 1,
            _ => after as u32,
        }
    }

    /// Light at a distance (px) into the light of an edge of the table given, in f64: for profiles,
    /// figures and tests.
    pub(crate) fn light(&self, at: &TablePlace, distance_px: f64) -> f64 {
        let u = distance_px / at.scale_px;
        let one = |table: u32| match self.origin.sources.get(table as usize) {
            Some(source) => source.value(u * self.origin.pixel_mm * 1e3),
            None => gaussian(u).0,
        };
        let near = one(at.table);
        if at.blend == 0.0 { near } else { near + at.blend * (one(at.table + 1) - near) }
    }

    /// As [`Self::light`], from the kernel's own cubics: twenty times as fast, accurate to 1e-7.
    pub(crate) fn sample(&self, at: &TablePlace, distance_px: f64) -> f64 {
        let count = self.per_table as usize;
        let place = ((distance_px / at.scale_px + f64::from(self.reach)) * f64::from(self.per_unit))
            .clamp(0.0, count as f64);
        let segment = (place as usize).min(count - 1);
        let t = place - segment as f64;
        let one = |table: u32| {
            let [a, b, c, d] = self.segments[table as usize * count + segment].map(f64::from);
            a + t * (b + t * (c + t * d))
        };
        let near = one(at.table);
        if at.blend == 0.0 { near } else { near + at.blend * (one(at.table + 1) - near) }
    }

    /// The tables in f64, µm on the object; none for the plain Gaussian.
    pub(crate) fn sources(&self) -> &[EdgeSpread] {
        &self.origin.sources
    }
}

/// A family with the data for its focus.
struct Family<'a> {
    esf: &'a Esf,
    na: f64,
    pixel_um: f64,
}

impl Family<'_> {
    /// Tables up to `depth_mm` out of focus, and the choice among them.
    fn over_focus(&self, depth_mm: f64) -> Result<(Focus, Vec<EdgeSpread>), RenderError> {
        let (na, pixel_um) = (self.na, self.pixel_um);
        let stack = |offset_mm: f64, table: &(dyn Fn(f64) -> Result<EdgeSpread, RenderError> + Sync)| {
            let stack = FocusStack::of(depth_mm + offset_mm.abs(), BLEND_TOLERANCE, table)?;
            let tables = stack.tables().len() as u32;
            let focus = Focus::Stack { offset_mm, step_mm: stack.step_mm(), tables };
            Ok((focus, stack.tables().to_vec()))
        };
        let flat = depth_mm == 0.0;
        match self.esf {
            Esf::Gaussian(g) => {
                let table = |y: f64| {
                    let lens_sigma_um = g.sigma_px * pixel_um;
                    GaussianBlur { lens_sigma_um, defocus_mm: y, effective_na: na, motion_um: 0.0 }
                        .edge_spread()
                };
                if flat || na == 0.0 { Ok((Focus::Fixed, vec![table(0.0)?])) } else { stack(0.0, &table) }
            }
            Esf::PartiallyCoherent(p) if flat => Ok((Focus::Fixed, vec![p.edge_spread()?])),
            Esf::PartiallyCoherent(p) => stack(p.defocus_mm, &|defocus_mm| {
                PartiallyCoherentEdge { defocus_mm, ..p.clone() }.edge_spread()
            }),
            // Limbs are stacked by [`EsfTable::limbs`]; what is flat or thin has the face.
            Esf::Cylinder(c) => Ok((Focus::Fixed, vec![c.face()?])),
            Esf::Fresnel(f) => {
                let focus = if flat { Focus::Fixed } else { nears(f, depth_mm)? };
                Ok((focus, vec![f.edge_spread()?]))
            }
            Esf::Measured(m) => {
                let edge = m.edge()?.edge_spread()?;
                let table = |y: f64| {
                    if y == 0.0 {
                        return Ok(edge.clone());
                    }
                    edge.spread(&Shifts::disc(y.abs() * na * 1e3, DISC_NODES), TOLERANCE)
                };
                if flat || na == 0.0 { Ok((Focus::Fixed, vec![edge])) } else { stack(0.0, &table) }
            }
        }
    }
}

/// The edge-spread function of a thin edge in the plane of focus, on an object whose pixels measure
/// `pixel_um`.
///
/// # Errors
/// Families whose values are out of range.
pub(crate) fn knife_edge(esf: &Esf, pixel_um: f64) -> Result<EdgeSpread, RenderError> {
    let (_, mut tables) = Family { esf, na: 0.0, pixel_um }.over_focus(0.0)?;
    Ok(tables.remove(0))
}

/// A laser's shadow scales with the root of the distance to the sensor.
fn nears(laser: &LaserShadow, depth_mm: f64) -> Result<Focus, RenderError> {
    if depth_mm < 0.5 * laser.distance_mm {
        return Ok(Focus::Nears { distance_mm: laser.distance_mm });
    }
    let right = format!("must be more than twice the {depth_mm} mm by which the axis comes nearer");
    Err(RenderError::setting("optics.esf.fresnel.distance_mm", &laser.distance_mm, right))
}

/// The tables with the reflection of every radius between the two given.
fn over_radii(
    reflection: &GrazingReflection,
    tables: &[EdgeSpread],
    (least, most): (f64, f64),
) -> Result<(Vec<f64>, Vec<EdgeSpread>), RenderError> {
    let steps = ((most / least).ln() / RADIUS_RATIO.ln()).ceil().max(0.0);
    let radii: Vec<f64> =
        (0..=steps as usize).map(|i| least * (most / least).powf(i as f64 / steps.max(1.0))).collect();
    let mut made = Vec::new();
    for radius in &radii {
        for table in tables {
            made.push(reflection.edge_spread(table, *radius)?);
        }
    }
    Ok((radii, made))
}

/// Φ averaged over u ± half, and its derivative.
fn boxed_gaussian(u: f64, half: f64) -> (f64, f64) {
    let ((high, dense_high), (low, dense_low)) = (gaussian(u + half), gaussian(u - half));
    let integral = (u + half) * high + dense_high - (u - half) * low - dense_low;
    (integral / (2.0 * half), (high - low) / (2.0 * half))
}

fn hermite(a: f64, da: f64, b: f64, db: f64) -> [f32; 4] {
    let c2 = 3.0 * (b - a) - 2.0 * da - db;
    let c3 = 2.0 * (a - b) + da + db;
    [a as f32, da as f32, c2 as f32, c3 as f32]
}

/// One node of the quadrature over a pixel: offsets from its centre and weight.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Node {
    /// Along the row, px.
    pub along: f32,
    /// Down the column, px.
    pub down: f32,
    /// Weight; all weights add up to one.
    pub weight: f32,
    /// Pads to 16 bytes.
    pub padding: f32,
}

/// Nodes for edges of the sharpness of a Gaussian of `blur_px` and slopes up to `max_sin` =
/// max |sin β|.
pub(crate) fn pixel_quadrature(blur_px: f64, max_sin: f64) -> Vec<Node> {
    let down = gauss_legendre(order(0.5 / blur_px));
    let along = gauss_legendre(order(0.5 * max_sin / blur_px));
    let node = |(x, wx): &(f64, f64), (y, wy): &(f64, f64)| Node {
        along: (0.5 * x) as f32,
        down: (0.5 * y) as f32,
        weight: (0.25 * wx * wy) as f32,
        padding: 0.0,
    };
    along.iter().flat_map(|a| down.iter().map(move |d| node(a, d))).collect()
}

/// Order of the rule over a half width `a` in units of the blur; limits from the error term
/// `2^2n (n!)^4 / ((2n+1) (2n)!^3) a^2n F^(2n)` at 1e-6.
fn order(a: f64) -> usize {
    match a {
        a if a <= 0.004 => 1,
        a if a <= 0.15 => 2,
        a if a <= 0.45 => 3,
        a if a <= 0.9 => 4,
        _ => 8,
    }
}
