//! What moves the edge of a round part before one head: one quantity at a time, the gauge's own
//! edge kept, against the head as its config states it.
//!
//! A shift is that of one edge, outwards; a diameter changes by twice it. The last row of an effect
//! is what an ordinary tolerance of its quantity does: which of them is worth money.

use serde::Serialize;

use super::advice::{Advice, FocusOfRatio};
use super::shift::{FittedEdge, LimbHead};
use crate::gauge::calibration::Finish;
use crate::render::optics::edge_spread::CylinderEdge;
use crate::render::optics::edge_spread::cylinder::Material;
use crate::studies::head::error::HeadError;
use crate::studies::head::setup::HeadSetup;

/// A quantity that moves the edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum EffectKind {
    /// Distance of the axis from the plane of focus.
    Focus,
    /// Numerical aperture of the lens; that of the light with it.
    NumericalAperture,
    /// Aperture of the light over that of the lens.
    CoherenceRatio,
    /// Wavelength.
    Wavelength,
    /// Diameter of the part.
    Diameter,
    /// Material.
    Material,
    /// Film on the part.
    Film,
    /// Finish, by roughness around the part.
    Finish,
    /// Temperature of the part.
    Temperature,
}

/// One value of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct EffectPoint {
    /// Its value, or its number where it is a name.
    pub value: f64,
    /// The name, where it is one.
    pub name: Option<&'static str>,
    /// Shift against the head as configured, µm an edge, outwards.
    pub shift_um: f64,
}

/// A quantity and what it does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Effect {
    /// Which.
    pub kind: EffectKind,
    /// Its unit; empty for ratios and names.
    pub unit: &'static str,
    /// The head's own value; none where it is a name.
    pub configured: Option<f64>,
    /// Values and shifts.
    pub points: Vec<EffectPoint>,
    /// An ordinary tolerance, in words.
    pub tolerance: String,
    /// Largest change of the diameter within it, µm.
    pub diameter_um: f64,
}

/// All effects of a head.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LimbEffects {
    /// Name of the head.
    pub name: String,
    /// The file.
    pub config: String,
    /// Diameter of the part, mm.
    pub diameter_mm: f64,
    /// The edge that the gauge fits.
    pub fitted: FittedEdge,
    /// NA of the lens, on the side of the part.
    pub numerical_aperture: f64,
    /// NA of the light over that of the lens.
    pub coherence_ratio: f64,
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Shift of the head as configured, µm an edge: what masters of the same size and surface take
    /// off.
    pub shift_um: f64,
    /// The effects, the largest first.
    pub effects: Vec<Effect>,
    /// Focus and diameter by the ratio of apertures.
    pub by_ratio: Vec<FocusOfRatio>,
    /// What of it can be bought.
    pub advice: Advice,
}

/// Materials by name.
const MATERIALS: [(Material, &str); 5] = [
    (Material::Steel, "steel"),
    (Material::Iron, "iron"),
    (Material::Chromium, "chromium"),
    (Material::Aluminium, "aluminium"),
    (Material::Ceramic, "ceramic"),
];

/// Finishes by name.
const FINISHES: [(Finish, &str); 3] =
    [(Finish::Lapped, "lapped"), (Finish::Ground, "ground"), (Finish::Turned, "turned")];

/// Distances that a part stands out of focus by: spindles and V-blocks hold ±0.3 mm.
const FOCUS_MM: [f64; 9] = [-1.0, -0.5, -0.3, -0.1, 0.0, 0.1, 0.3, 0.5, 1.0];
/// Apertures over the configured one; data sheets and iris rings hold ±10 %.
const APERTURES: [f64; 7] = [0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4];
/// Ratios of apertures; an illuminator's is known to ±0.1.
const RATIOS: [f64; 8] = [0.3, 0.4, 0.5, 0.6, 0.75, 0.85, 1.0, 1.2];
/// Wavelengths of LEDs, nm: blue to red; of one colour they scatter by ±10 nm.
const WAVELENGTHS_NM: [f64; 6] = [450.0, 470.0, 505.0, 525.0, 590.0, 625.0];
/// Diameters over the part's: masters are rarely farther away.
const DIAMETERS: [f64; 7] = [0.3, 0.5, 0.7, 0.85, 1.0, 1.5, 2.0];
/// Films, µm: wiped, damp, wet.
const FILMS_UM: [f64; 11] = [0.0, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0];
/// Temperatures about the one of the masters, K.
const TEMPERATURES_K: [f64; 5] = [-2.0, -1.0, 0.0, 1.0, 2.0];
/// Expansion of steel, µm/(m·K) (ISO 1 practice).
const STEEL_UM_PER_M_K: f64 = 11.5;

/// The effects of a head.
///
/// # Errors
/// Optics without a lens and light of known aperture, limbs that cannot be computed or fitted.
pub(crate) fn effects(head: &HeadSetup, fitted: FittedEdge) -> Result<LimbEffects, HeadError> {
    let limb_head = LimbHead::new(head, fitted)?;
    let one = OneAtATime::new(&limb_head)?;
    let mut effects = vec![
        one.focus()?,
        one.aperture(),
        one.ratio(),
        one.wavelength(),
        one.diameter(),
        one.material(),
        one.film()?,
        one.finish(),
        one.temperature(),
    ];
    effects.sort_by(|a, b| b.diameter_um.total_cmp(&a.diameter_um));
    let by_ratio = FocusOfRatio::all(&limb_head);
    let advice = Advice::of(&limb_head.lens, &by_ratio);
    let lens = &limb_head.lens;
    Ok(LimbEffects {
        name: head.config.name.clone(),
        config: head.config.file.clone(),
        diameter_mm: limb_head.diameter_mm,
        fitted,
        numerical_aperture: lens.na,
        coherence_ratio: lens.coherence_ratio,
        wavelength_nm: lens.wavelength_nm,
        shift_um: one.own_um,
        effects,
        by_ratio,
        advice,
    })
}

/// A head and its own shift.
struct OneAtATime<'a> {
    head: &'a LimbHead,
    own_um: f64,
}

impl<'a> OneAtATime<'a> {
    fn new(head: &'a LimbHead) -> Result<Self, HeadError> {
        let own_um = head.shift_um(&head.lens, head.diameter_mm, 0.0)?;
        Ok(Self { head, own_um })
    }

    /// Shift against the head's own, µm.
    fn moved(&self, limb: &CylinderEdge, diameter_mm: f64, y_mm: f64) -> Result<f64, HeadError> {
        Ok(self.head.shift_um(limb, diameter_mm, y_mm)? - self.own_um)
    }

    /// An effect of values; those whose limb cannot be computed are left out.
    fn over(
        &self,
        (kind, unit, configured): (EffectKind, &'static str, f64),
        values: impl IntoIterator<Item = f64>,
        moved: impl Fn(f64) -> Result<f64, HeadError>,
    ) -> Effect {
        let found = values.into_iter().filter_map(|value| Some((value, moved(value).ok()?)));
        let points = found.map(|(value, shift_um)| EffectPoint { value, name: None, shift_um }).collect();
        Effect {
            kind,
            unit,
            configured: Some(configured),
            points,
            tolerance: String::new(),
            diameter_um: 0.0,
        }
    }

    fn focus(&self) -> Result<Effect, HeadError> {
        let lens = &self.head.lens;
        let moved = |y_mm: f64| self.moved(lens, self.head.diameter_mm, y_mm);
        let mut effect = self.over((EffectKind::Focus, "mm", 0.0), FOCUS_MM, moved);
        let worst = moved(0.3)?.abs().max(moved(-0.3)?.abs());
        effect.tolerance("±0.3 mm of depth", worst);
        Ok(effect)
    }

    fn aperture(&self) -> Effect {
        let lens = &self.head.lens;
        let moved = |na: f64| self.moved(&CylinderEdge { na, ..lens.clone() }, self.head.diameter_mm, 0.0);
        let values = APERTURES.map(|share| share * lens.na);
        let mut effect = self.over((EffectKind::NumericalAperture, "", lens.na), values, moved);
        effect.within("±10 % of NA", 0.9 * lens.na, 1.1 * lens.na);
        effect
    }

    fn ratio(&self) -> Effect {
        let lens = &self.head.lens;
        let own = lens.coherence_ratio;
        let of = |coherence_ratio: f64| CylinderEdge { coherence_ratio, ..lens.clone() };
        let moved = |ratio: f64| self.moved(&of(ratio), self.head.diameter_mm, 0.0);
        let (low, high) = ((own - 0.1).max(0.0), own + 0.1);
        let values = merged(&RATIOS, &[low, own, high]);
        let mut effect = self.over((EffectKind::CoherenceRatio, "", own), values, moved);
        effect.within("±0.1 of the ratio", low, high);
        effect
    }

    fn wavelength(&self) -> Effect {
        let lens = &self.head.lens;
        let own = lens.wavelength_nm;
        let of = |wavelength_nm: f64| CylinderEdge { wavelength_nm, ..lens.clone() };
        let moved = |nm: f64| self.moved(&of(nm), self.head.diameter_mm, 0.0);
        let values = merged(&WAVELENGTHS_NM, &[own - 10.0, own, own + 10.0]);
        let mut effect = self.over((EffectKind::Wavelength, "nm", own), values, moved);
        effect.within("±10 nm within one colour", own - 10.0, own + 10.0);
        effect
    }

    fn diameter(&self) -> Effect {
        let own = self.head.diameter_mm;
        let moved = |mm: f64| self.moved(&self.head.lens, mm, 0.0);
        let mut effect =
            self.over((EffectKind::Diameter, "mm", own), DIAMETERS.map(|share| share * own), moved);
        effect.within("masters of 0.5 to 1.5 times the diameter", 0.5 * own, 1.5 * own);
        effect
    }

    fn material(&self) -> Effect {
        let of = |material| CylinderEdge {
            material,
            refractive_index: None,
            extinction: None,
            ..self.head.lens.clone()
        };
        let found = MATERIALS.iter().enumerate().filter_map(|(k, (material, name))| {
            let shift_um = self.moved(&of(*material), self.head.diameter_mm, 0.0).ok()?;
            Some(EffectPoint { value: k as f64, name: Some(name), shift_um })
        });
        let points = found.collect();
        named(EffectKind::Material, points, "another material than the masters'")
    }

    fn film(&self) -> Result<Effect, HeadError> {
        let own = self.head.lens.film_um;
        // The film's outside is what the limb is computed for: its thickness comes on top.
        let moved = |film_um: f64| {
            let limb = CylinderEdge { film_um, ..self.head.lens.clone() };
            Ok(self.moved(&limb, self.head.diameter_mm, 0.0)? + film_um - own)
        };
        let mut effect = self.over((EffectKind::Film, "µm", own), FILMS_UM, moved);
        effect.tolerance("0.5 µm of oil", moved(0.5)?.abs());
        Ok(effect)
    }

    fn finish(&self) -> Effect {
        let wavelength_um = 1e-3 * self.head.lens.wavelength_nm;
        let found = FINISHES.iter().enumerate().map(|(k, (finish, name))| EffectPoint {
            value: k as f64,
            name: Some(name),
            shift_um: finish.shift_in_um(wavelength_um),
        });
        let points = found.collect();
        named(EffectKind::Finish, points, "smooth to the roughest of turned surfaces, around the part")
    }

    fn temperature(&self) -> Effect {
        let per_k = 0.5 * self.head.diameter_mm * 1e-3 * STEEL_UM_PER_M_K;
        let mut effect = self.over((EffectKind::Temperature, "K", 0.0), TEMPERATURES_K, |k| Ok(per_k * k));
        effect.tolerance("±1 K of steel", per_k);
        effect
    }
}

/// An effect of names.
fn named(kind: EffectKind, points: Vec<EffectPoint>, tolerance: &str) -> Effect {
    let worst = points.iter().fold(0.0, |most: f64, p| most.max(p.shift_um.abs()));
    let mut effect =
        Effect { kind, unit: "", configured: None, points, tolerance: String::new(), diameter_um: 0.0 };
    effect.tolerance(tolerance, worst);
    effect
}

/// Values of both in rising order, those of the first that lie on one of the second left out.
fn merged(values: &[f64], own: &[f64]) -> Vec<f64> {
    let is_new = |v: &&f64| own.iter().all(|o| (o - **v).abs() > 1e-6 * o.abs());
    let mut all: Vec<f64> = values.iter().filter(is_new).chain(own).copied().collect();
    all.sort_by(f64::total_cmp);
    all
}

impl Effect {
    fn tolerance(&mut self, words: &str, shift_um: f64) {
        self.tolerance = words.to_owned();
        self.diameter_um = 2.0 * shift_um;
    }

    /// The largest shift of the points of an interval.
    fn within(&mut self, words: &str, low: f64, high: f64) {
        let slack = 1e-9 * high.abs();
        let inside = self.points.iter().filter(|p| (low - slack..=high + slack).contains(&p.value));
        let worst = inside.fold(0.0, |most: f64, p| most.max(p.shift_um.abs()));
        self.tolerance(words, worst);
    }
}

impl EffectKind {
    /// Its name in tables.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Focus => "focus: distance of the axis",
            Self::NumericalAperture => "numerical aperture",
            Self::CoherenceRatio => "aperture of the light over the lens's",
            Self::Wavelength => "wavelength",
            Self::Diameter => "diameter",
            Self::Material => "material",
            Self::Film => "film",
            Self::Finish => "finish",
            Self::Temperature => "temperature of the part",
        }
    }
}
