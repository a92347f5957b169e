//! The light that a place sends into the camera, as a share of full scale.

use super::noise::{corner, noise, rough};
use super::settings::FlankScene;
use super::wear::{chip_um, land_um};

/// A scene with its seed.
pub(super) struct Surface<'a> {
    pub(super) scene: &'a FlankScene,
    pub(super) seed: u64,
    /// Where the flank begins: −µm along the edge by µm below it.
    pub(super) end_slope: f64,
}

impl Surface<'_> {
    /// Light of a place `s` µm from the corner along the edge and `v` µm below the new edge.
    pub(super) fn light(&self, s: f64, v: f64) -> f64 {
        let (scene, surface) = (self.scene, &self.scene.surface);
        if v < 0.0 || s < -v * self.end_slope {
            return self.background(s, v);
        }
        let land = land_um(&scene.wear, s, self.seed);
        let chipped = chip_um(&scene.wear, s, land, self.seed);
        if v < chipped {
            return self.background(s, v);
        }
        let light = if v < land { self.land(s, v, v / land) } else { self.flank(s, v) };
        let rim = if land > 0.0 {
            near(bell((v - land) / 3.0), || surface.rim * self.broken(s, 25.0, 21))
        } else {
            0.0
        };
        // an edge is rounded by some micrometres and shines: a new one throughout, a worn one here
        // and there
        let edge = if land > 0.0 {
            near(bell((v - chipped) / 2.5), || 0.5 * self.broken(s, 40.0, 22))
        } else {
            bell(v / 4.0)
        };
        light + rim + 0.5 * surface.line.max(0.5) * edge
    }

    /// What stands behind the edge, out of focus.
    fn background(&self, s: f64, v: f64) -> f64 {
        let wide = rough(s / 900.0, v / 900.0, self.seed ^ 31);
        self.scene.surface.air * (1.0 + 0.8 * wide)
    }

    /// A factor that comes and goes along the edge, 0 to 1.
    fn broken(&self, s: f64, um: f64, stream: u64) -> f64 {
        (0.6 + 0.9 * rough(s / um, 0.5, self.seed ^ stream)).clamp(0.0, 1.0)
    }

    /// Light that a place receives, of flank and land alike, over its median.
    fn illumination(&self, s: f64, v: f64) -> f64 {
        // `rough` spreads by 0.35
        (self.scene.surface.shade / 0.35 * rough(s / 700.0, v / 700.0, self.seed ^ 44)).exp()
    }

    fn flank(&self, s: f64, v: f64) -> f64 {
        let surface = &self.scene.surface;
        let (sin, cos) = surface.grinding_deg.to_radians().sin_cos();
        let (along, across) = (s * cos + v * sin, s * sin - v * cos);
        let pitch = surface.grinding_um;
        let lines = rough(across / pitch, along / (9.0 * pitch), self.seed ^ 41);
        let grain = noise(s / 5.0, v / 5.0, self.seed ^ 42);
        // facets that happen to lie in the direction of the light; `corner` is even over −1 to 1
        let cell = corner((s / 5.0).floor() as i64, (v / 5.0).floor() as i64, self.seed ^ 43);
        let sparkle = if cell > 1.0 - 2.0 * surface.sparkles { 1.2 } else { 0.0 };
        let shade = self.illumination(s, v);
        let glare = surface.glare * (-0.5 * ((s - surface.glare_at_um) / 220.0).powi(2)).exp();
        let facet = if v > self.scene.edge.depth_um { 0.5 } else { 1.0 };
        let texture = 1.0 + surface.texture * (0.9 * lines + 0.8 * grain + sparkle);
        (surface.flank * shade + glare) * facet * texture.max(0.1)
    }

    /// Land; `t` is the depth over its width.
    fn land(&self, s: f64, v: f64, t: f64) -> f64 {
        let surface = &self.scene.surface;
        let (sin, cos) = surface.streak_deg.to_radians().sin_cos();
        let (along, across) = (s * cos + v * sin, s * sin - v * cos);
        let streaks = rough(across / 7.0, along / 140.0, self.seed ^ 51);
        let shade = 1.0 + 0.6 * rough(s / 350.0, v / 120.0, self.seed ^ 52);
        let wanders = surface.line_at + 0.3 * rough(s / 400.0, 1.0, self.seed ^ 53);
        let width = surface.line_um * (0.6 + 0.8 * self.broken(s, 200.0, 54));
        let from_line_um = v - wanders * v / t.max(1e-6);
        let line = near(bell(from_line_um / width), || surface.line * self.broken(s, 300.0, 55));
        let grains = noise(s / 6.0, v / 6.0, self.seed ^ 56);
        // what was cut adheres where the land ends rather than at the edge
        let adheres =
            rough(s / 120.0, v / 50.0, self.seed ^ 57) + 0.5 * (t - 0.5) > 0.65 - 1.6 * surface.adhesion;
        if adheres && surface.adhesion > 0.0 {
            let lumps = rough(s / 25.0, v / 18.0, self.seed ^ 58);
            let level = surface.adhesion_level * self.illumination(s, v);
            return level * (1.0 + surface.adhesion_grain * (grains + 0.8 * lumps)).max(0.1);
        }
        let level = surface.land * shade * (1.0 + surface.streaks * streaks + 0.08 * grains);
        (level.max(0.0) + line) * self.illumination(s, v)
    }
}

/// What a light adds at a share of it; far from it nothing is to be computed.
fn near(share: f64, light: impl FnOnce() -> f64) -> f64 {
    if share > 0.0 { light() * share } else { 0.0 }
}

fn bell(x: f64) -> f64 {
    (-0.5 * x * x).exp()
}
