//! Force and pre-travel of a probe whose stylus rests on three seats.
//!
//! The stylus tilts about the line through two seats, which lies r/2 from its axis (seats 120°
//! apart on a circle of radius r), when the moment of the touch about it exceeds that of the
//! spring. A touch in direction n, n_a along the stylus and n_q across it, α' (|α'| ≤ 60°) from the
//! normal of the nearest such line, L from the ball to the seats:
//!
//! ```text
//! F·(n_q·L·cos α' + n_a·r/2) = S·r/2     F = S / (n_a + (2L/r)·n_q·cos α')
//! ```
//!
//! Across the stylus F rises by a factor of 2 from the middle of a lobe to between two lobes, of
//! which there are three per turn. Until the stylus tilts its stem bends, and the signal is late by
//! F·(n_q²·L³/3EI + n_a²·L/EA). This is the model of Estler et al., Error compensation for CMM
//! touch trigger probes, Precision Engineering 19 (1996) 85-97, without friction and gravity.

use super::settings::{ProbeSettings, Stylus};

/// Force and pre-travel of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pretravel {
    spring_n: f64,
    /// 2L/r.
    lever: f64,
    /// Bending across and compression along the stylus, mm/N.
    across_mm_per_n: f64,
    along_mm_per_n: f64,
    stylus: Stylus,
    lobe: f64,
}

impl Pretravel {
    /// The model of these settings.
    pub(crate) fn new(s: &ProbeSettings) -> Self {
        let section = std::f64::consts::PI * s.stem_mm.powi(2) / 4.0;
        let inertia = std::f64::consts::PI * s.stem_mm.powi(4) / 64.0;
        Self {
            spring_n: s.spring_n,
            lever: 2.0 * s.stylus_mm / s.seat_radius_mm,
            across_mm_per_n: s.stylus_mm.powi(3) / (3.0 * s.modulus_n_per_mm2 * inertia),
            along_mm_per_n: s.stylus_mm / (s.modulus_n_per_mm2 * section),
            stylus: s.stylus,
            lobe: s.lobe_deg.to_radians(),
        }
    }

    /// Share of a unit direction along the stylus (away from the part), and both shares across it.
    fn shares(&self, [x, y, z]: [f64; 3]) -> (f64, [f64; 2]) {
        match self.stylus {
            Stylus::AlongX => (x, [y, z]),
            Stylus::AlongY => (y, [x, z]),
            Stylus::AlongZ => (z, [x, y]),
        }
    }

    /// Force at the signal of a touch whose surface pushes along the unit vector `normal`, N.
    pub(crate) fn force_n(&self, normal: [f64; 3]) -> f64 {
        let (along, across) = self.shares(normal);
        let angle = across[1].atan2(across[0]) - self.lobe;
        let third = std::f64::consts::TAU / 3.0;
        let cos = (angle - third * (angle / third).round()).cos();
        self.spring_n / (along.max(0.0) + self.lever * across[0].hypot(across[1]) * cos)
    }

    /// Travel of the probe along `normal` from the touch to the signal, mm.
    pub(crate) fn travel_mm(&self, normal: [f64; 3]) -> f64 {
        let (along, across) = self.shares(normal);
        let square = across[0].powi(2) + across[1].powi(2);
        self.force_n(normal) * (square * self.across_mm_per_n + along * along * self.along_mm_per_n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(stylus: Stylus) -> Pretravel {
        Pretravel::new(&ProbeSettings { stylus, ..ProbeSettings::default() })
    }

    #[test]
    fn three_lobes_of_a_factor_two_across_the_stylus() {
        let probe = model(Stylus::AlongZ);
        let force = |deg: f64| {
            let (sin, cos) = deg.to_radians().sin_cos();
            probe.force_n([cos, sin, 0.0])
        };
        // S·r/2L, and twice that where two lobes meet
        let least = 5.5 * 9.0 / (2.0 * 50.0);
        for turn in [0.0, 120.0, 240.0] {
            assert!((force(turn) / least - 1.0).abs() < 1e-12);
            assert!((force(turn + 60.0) / least - 2.0).abs() < 1e-12);
            assert!((force(turn + 17.0) - force(turn - 17.0)).abs() < 1e-12);
            assert!((force(turn + 30.0) / least - 2.0 / 3.0_f64.sqrt()).abs() < 1e-12);
        }
        // a cantilever of carbide: F·L³/3EI
        let bent = least * 50.0_f64.powi(3) * 64.0 / (3.0 * 5.5e5 * std::f64::consts::PI * 4.0_f64.powi(4));
        assert!(
            (probe.travel_mm([1.0, 0.0, 0.0]) / bent - 1.0).abs() < 1e-12 && (1e-3..5e-3).contains(&bent)
        );
        // opposite touches meet the middle of a lobe and the gap between two
        assert!((probe.travel_mm([-1.0, 0.0, 0.0]) / bent - 2.0).abs() < 1e-12);
    }

    #[test]
    fn along_the_stylus_the_spring_is_met_and_hardly_anything_bends() {
        let probe = model(Stylus::AlongX);
        assert!((probe.force_n([1.0, 0.0, 0.0]) - 5.5).abs() < 1e-12);
        assert!(probe.travel_mm([1.0, 0.0, 0.0]) < 1e-4);
        // obliquely the spring is levered: less force
        let (sin, cos) = 0.1_f64.sin_cos();
        assert!(probe.force_n([cos, sin, 0.0]) < 4.0);
    }
}
