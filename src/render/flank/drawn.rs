//! Scenes drawn at random: what the shipped forest is trained on, and what the gauge is tried on.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::settings::{FlankEdge, FlankScene, FlankSurface, FlankWear};

/// Logarithmically even.
fn spread(random: &mut Pcg64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.random_range(0.0..1.0))
}

impl FlankScene {
    /// A scene of a seed: any texture in front light, wear from 15 µm to three tenths of the
    /// height.
    pub(crate) fn drawn(seed: u64, (columns, rows): (u32, u32), um_per_px: f64) -> Self {
        let random = &mut Pcg64::seed_from_u64(seed);
        let vb_um = spread(random, 15.0, 0.3 * f64::from(rows) * um_per_px.min(3.0));
        let turn: f64 = random.random_range(-12.0..12.0);
        let width_um = f64::from(columns) * um_per_px;
        let mut scene = Self { columns, rows, um_per_px, ..Self::default() };
        scene.blur_px = random.random_range(0.6..1.6);
        scene.noise_counts = random.random_range(0.5..2.0);
        let tilt = (0.4 * f64::from(columns) * turn.to_radians().tan()).abs();
        let row = 0.14 * f64::from(rows) + if turn > 0.0 { 0.0 } else { 2.0 * tilt };
        scene.edge = FlankEdge {
            corner_px: [
                random.random_range(0.82..0.9) * f64::from(columns),
                row + random.random_range(0.0..20.0),
            ],
            direction_deg: 180.0 + turn.clamp(-8.0, 8.0),
            camber_um: random.random_range(-3.0..10.0),
            depth_um: vb_um * 1.3 + random.random_range(60.0..500.0),
            end_deg: random.random_range(-40.0..20.0),
        };
        scene.wear = FlankWear {
            vb_um,
            scatter: random.random_range(0.03..0.3),
            taper: if random.random_bool(0.6) { random.random_range(-0.6..0.6) } else { 0.0 },
            length_um: random.random_range(0.45..0.72) * width_um,
            notch_um: if random.random_bool(0.4) { vb_um * random.random_range(0.2..1.2) } else { 0.0 },
            corner_um: if random.random_bool(0.4) { vb_um * random.random_range(0.0..0.4) } else { 0.0 },
            chipping_um: if random.random_bool(0.4) {
                random.random_range(0.0..0.3) * vb_um.min(60.0)
            } else {
                0.0
            },
        };
        scene.surface = surface(random, width_um);
        scene
    }
}

/// Surfaces in front light: the flank well exposed, what stands behind the edge darker (of nine
/// real images the air has 0.55 of the flank's grey value in the median), the land lighter or
/// darker than the flank by a factor, since it lies at another angle to the light.
fn surface(random: &mut Pcg64, width_um: f64) -> FlankSurface {
    let flank = spread(random, 0.25, 0.6);
    let factor = if random.random_bool(0.6) { spread(random, 1.3, 2.2) } else { spread(random, 0.4, 0.75) };
    FlankSurface {
        air: flank * random.random_range(0.1..0.6),
        flank,
        texture: random.random_range(0.25..0.9),
        grinding_deg: random.random_range(30.0..150.0),
        grinding_um: spread(random, 6.0, 40.0),
        land: (flank * factor).min(0.9),
        streaks: random.random_range(0.05..0.5),
        streak_deg: if random.random_bool(0.5) {
            random.random_range(-6.0..6.0)
        } else {
            random.random_range(70.0..110.0)
        },
        line: if random.random_bool(0.7) { random.random_range(0.2..2.0) } else { 0.0 },
        line_um: spread(random, 2.0, 16.0),
        line_at: random.random_range(0.0..0.9),
        rim: if random.random_bool(0.7) { random.random_range(0.0..0.8) } else { 0.0 },
        adhesion: if random.random_bool(0.5) { random.random_range(0.0..0.35) } else { 0.0 },
        adhesion_level: spread(random, 0.15, 0.9),
        adhesion_grain: random.random_range(0.2..1.2),
        sparkles: spread(random, 0.01, 0.2),
        // the spread of real flanks' grey values, of which texture is a part
        shade: random.random_range(0.1..0.5),
        glare: if random.random_bool(0.4) { random.random_range(0.0..0.8) } else { 0.0 },
        glare_at_um: random.random_range(0.1..0.7) * width_um,
    }
}
