//! The simulated probe: where a ball touches the part's surface, how far the machine overtravels,
//! and the position that the control stores.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use crate::probe::pretravel::Pretravel;
use crate::probe::{ProbeSettings, TouchOrder};
use crate::process::GuidewayPoint;
use crate::render::silhouette::{Outline, Turned};

/// Stream of the job's seed.
const PROBE_STREAM: u64 = 0x0070_726f_6265;
const DRIFT_STREAM: u64 = 0x6472_6966_7421;
/// Standard deviation of the ball's true diameter about the nominal one, mm: tolerance of stylus
/// balls of grade 5 to 10 (ISO 3290-1: mean diameters of a lot within ±1 µm and better).
const U_BALL_MM: f64 = 0.0003;
/// Largest distance between the point of contact and that on a cylinder, mm: there the ball's own
/// surface lies 20 µm lower, more than roughness and form of a turned part.
const NEAR_MM: f64 = 0.4;
/// Half widths, in steps, of the coarse and of the fine grid of candidate points of contact.
const GRID: (i32, i32) = (8, 8);

/// True values of a probe, which neither probe nor control is given.
#[derive(Clone, Debug)]
pub(super) struct TrueProbe {
    settings: ProbeSettings,
    pretravel: Pretravel,
    guideway: Vec<GuidewayPoint>,
    length_mm: f64,
    ball_mm: f64,
    height_mm: f64,
    pub(super) part_c: f64,
    pub(super) master_c: f64,
    seed: u64,
}

/// The object that is touched.
pub(super) struct Target<'a> {
    pub(super) outline: &'a Outline,
    pub(super) warmth_c: f64,
    pub(super) is_part: bool,
    pub(super) drift_mm: f64,
}

impl TrueProbe {
    pub(super) fn new(
        settings: &ProbeSettings,
        guideway: &[GuidewayPoint],
        length_mm: f64,
        seed: u64,
    ) -> Self {
        let mut random = Pcg64::seed_from_u64(seed ^ PROBE_STREAM);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let t = &settings.temperature;
        Self {
            pretravel: Pretravel::new(settings),
            guideway: guideway.to_vec(),
            length_mm,
            ball_mm: settings.ball_mm + U_BALL_MM * draw(),
            height_mm: 1e-3 * settings.u_height_um * draw(),
            part_c: t.part_c + t.u_k * draw(),
            master_c: t.master_c + t.u_k * draw(),
            settings: settings.clone(),
            seed,
        }
    }

    /// Drift of the machine's X since the calibration, mm.
    pub(super) fn drift_mm(&self, pass: u32) -> f64 {
        if pass == 0 {
            return 0.0;
        }
        let mut random = Pcg64::seed_from_u64(self.seed ^ DRIFT_STREAM ^ (u64::from(pass) << 40));
        let draw: f64 = StandardNormal.sample(&mut random);
        1e-3 * self.settings.u_drift_um * draw
    }

    /// Compliance of the part at z, mm/N: the shape of a beam clamped at 0 and supported at its end
    /// under a load that travels, u ∝ s³(1 − s)²(4 − s), largest at s = 2 − √2 (Euler-Bernoulli).
    fn yield_mm_per_n(&self, z: f64) -> f64 {
        let shape = |s: f64| s.powi(3) * (1.0 - s).powi(2) * (4.0 - s);
        let s = (z / self.length_mm).clamp(0.0, 1.0);
        1e-3 * self.settings.part_yield_um_per_n * shape(s) / shape(2.0 - std::f64::consts::SQRT_2)
    }

    /// X that the control stores for a touch.
    pub(super) fn touch(&self, target: &Target<'_>, order: &TouchOrder, id: u64) -> Option<f64> {
        let s = &self.settings;
        let sign = order.side.sign();
        let kelvin = target.warmth_c - 20.0;
        let growth = 1.0 + 1e-6 * s.temperature.expansion_um_per_m_k * kelvin;
        let (ball_x, normal) = self.contact(&target.outline.turned(order.angle_deg), order, growth);
        let within = sign * ball_x - 0.5 * s.ball_mm >= 0.5 * order.expected_mm - s.reach_mm;
        let softness = if target.is_part { self.yield_mm_per_n(order.z_mm) } else { 0.0 };
        let late_mm = s.delay_ms * s.feed_mm_per_min / 60e3;
        let on = self.pretravel.travel_mm(normal) + self.pretravel.force_n(normal) * softness + late_mm;
        let mut random =
            Pcg64::seed_from_u64(self.seed ^ PROBE_STREAM ^ id.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let draw: f64 = StandardNormal.sample(&mut random);
        // The scale does not measure by how much the carrier stands away from the part.
        let guideway = if target.is_part { GuidewayPoint::away_mm(&self.guideway, order.z_mm) } else { 0.0 };
        let x = ball_x - sign * on + 1e-3 * s.repeatability_um * draw + target.drift_mm - guideway;
        let step = 1e-3 * s.resolution_um;
        within.then(|| if step > 0.0 { step * (x / step).round() } else { x })
    }

    /// X of the ball's centre at contact, and the direction in which the surface pushes.
    fn contact(&self, turned: &Turned<'_>, order: &TouchOrder, growth: f64) -> (f64, [f64; 3]) {
        let (z, sign, ball) = (order.z_mm, order.side.sign(), 0.5 * self.ball_mm);
        let radius = 0.5 * order.expected_mm;
        // angle of the point of contact on a centred cylinder
        let aside = (self.height_mm / (radius + ball)).clamp(-0.5, 0.5).asin();
        let out = |dz: f64, along: f64| -> Option<(f64, [f64; 3])> {
            let angle = aside + along / radius;
            let machine = if sign > 0.0 { angle } else { std::f64::consts::PI - angle };
            let (sin, cos) = machine.sin_cos();
            let r = growth * turned.radius_at(z + dz, machine);
            let (axis_x, axis_y) = turned.axis_mm(z + dz);
            let (px, py) = (axis_x + r * cos, axis_y + r * sin);
            let depth = ball * ball - (py - self.height_mm).powi(2) - dz * dz;
            (depth > 0.0).then(|| {
                let x = px + sign * depth.sqrt();
                (sign * x, [(x - px) / ball, (self.height_mm - py) / ball, -dz / ball])
            })
        };
        let search = |middle: (f64, f64), half: f64, steps: i32| {
            let at = |i: i32| half * f64::from(i) / f64::from(steps);
            let places = (-steps..=steps).flat_map(|i| (-steps..=steps).map(move |j| (i, j)));
            let met = places.filter_map(|(i, j)| {
                let place = (middle.0 + at(i), middle.1 + at(j));
                out(place.0, place.1).map(|met| (place, met))
            });
            met.max_by(|a, b| a.1.0.total_cmp(&b.1.0))
        };
        let coarse = search((0.0, 0.0), NEAR_MM, GRID.0);
        let place = coarse.map_or((0.0, 0.0), |c| c.0);
        let met = search(place, NEAR_MM / f64::from(GRID.0), GRID.1).or(coarse);
        met.map_or((f64::NEG_INFINITY, [sign, 0.0, 0.0]), |(_, (x, normal))| (sign * x, normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe::{Side, Sides, Stylus};
    use crate::shaft::{Lobe, ProfileKnot, Shaft};

    fn still(settings: &ProbeSettings) -> TrueProbe {
        let quiet = ProbeSettings {
            repeatability_um: 1e-9,
            resolution_um: 0.0,
            delay_ms: 0.0,
            u_height_um: 0.0,
            temperature: crate::probe::ProbeTemperature { u_k: 0.0, ..settings.temperature.clone() },
            ..settings.clone()
        };
        TrueProbe { ball_mm: 6.0, ..TrueProbe::new(&quiet, &[], 500.0, 1) }
    }

    fn met(probe: &TrueProbe, shaft: Shaft, z_mm: f64, angle_deg: f64, side: Side) -> f64 {
        let outline = Outline::new(shaft).unwrap();
        let order = TouchOrder { z_mm, angle_deg, side, expected_mm: 25.0 };
        probe.contact(&outline.turned(angle_deg), &order, 1.0).0
    }

    #[test]
    fn the_ball_meets_cylinder_and_cone_as_geometry_has_it() {
        let probe = still(&ProbeSettings::default());
        assert!((met(&probe, Shaft::cylinder(25.0), 10.0, 0.0, Side::Carrier) - 15.5).abs() < 1e-9);
        assert!((met(&probe, Shaft::cylinder(25.0), 10.0, 0.0, Side::Opposite) + 15.5).abs() < 1e-9);
        // beside the axis: √((R + ρ)² − y²)
        let beside = TrueProbe { height_mm: 0.5, ..probe.clone() };
        let wanted = (15.5_f64.powi(2) - 0.25).sqrt();
        assert!((met(&beside, Shaft::cylinder(25.0), 10.0, 0.0, Side::Carrier) - wanted).abs() < 2e-6);
        // a cone of slope t: R + ρ·√(1 + t²)
        let t = 0.05_f64;
        let knots = [(0.0, 12.0), (20.0, 13.0)].map(|(z_mm, radius_mm)| ProfileKnot { z_mm, radius_mm });
        let cone = Shaft { profile: knots.to_vec(), ..Shaft::cylinder(25.0) };
        let wanted = 12.5 + 3.0 * (1.0 + t * t).sqrt();
        assert!((met(&probe, cone, 10.0, 0.0, Side::Carrier) - wanted).abs() < 1e-5);
        // two lobes: high and low a quarter of a turn apart
        let oval = Shaft {
            lobes: vec![Lobe { order_upr: 2, amplitude_mm: 0.004, phase_deg: 0.0 }],
            ..Shaft::cylinder(25.0)
        };
        let across = met(&probe, oval.clone(), 10.0, 0.0, Side::Carrier)
            - met(&probe, oval, 10.0, 90.0, Side::Carrier);
        assert!((across - 0.008).abs() < 2e-6, "{across}");
    }

    #[test]
    fn both_sides_meet_different_lobes_of_the_pretravel() {
        let settings =
            ProbeSettings { stylus: Stylus::AlongY, sides: Sides::Two, ..ProbeSettings::default() };
        let probe = still(&settings);
        let outline = Outline::new(Shaft::cylinder(25.0)).unwrap();
        let target = Target { outline: &outline, warmth_c: 20.0, is_part: false, drift_mm: 0.0 };
        let order = |side| TouchOrder { z_mm: 10.0, angle_deg: 0.0, side, expected_mm: 25.0 };
        let late = |side: Side| 15.5 - side.sign() * probe.touch(&target, &order(side), 7).unwrap();
        let (near, far) = (late(Side::Carrier), late(Side::Opposite));
        assert!(near > 1e-3 && (far / near - 2.0).abs() < 1e-3, "{near} {far}");
        // beyond reach nothing is touched
        let far_off = TouchOrder { expected_mm: 27.1, ..order(Side::Carrier) };
        assert_eq!(probe.touch(&target, &far_off, 7), None);
    }
}
