//! An independent plant: a slender shaft that shares nothing with `process` or with the
//! controllers' models.
//!
//! Beam clamped in a chuck that yields sideways (1/k_c), tailstock of stiffness k_t at L, radial
//! load F at a. The tailstock's reaction R follows from its own deflection R/k_t; Euler-Bernoulli,
//! one diameter along the shaft.

use shadowgauge::plan::{CuttingData, DiameterOffset, PassPlan, PlannedForm};
use shadowgauge::profile::{Diameter, DiameterProfile, Reading, Station};

pub const LENGTH_MM: f64 = 500.0;
const E_N_PER_MM2: f64 = 2.1e5;
const CHUCK_N_PER_MM: f64 = 50e3;
const TAILSTOCK_N_PER_MM: f64 = 20e3;

pub const CUTTING: CuttingData = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };

pub struct Plant {
    pub z_mm: Vec<f64>,
    pub diameter_mm: Vec<f64>,
    /// Factor on the force coefficient.
    pub force: f64,
    /// Added to the tool's position at a station of the pass, mm of radius.
    pub shift: Box<dyn FnMut(u32, f64) -> f64>,
}

impl Plant {
    pub fn new(stations: usize) -> Self {
        let pitch = LENGTH_MM / stations as f64;
        let z_mm = (0..stations).map(|i| (i as f64 + 0.5) * pitch).collect();
        Self { z_mm, diameter_mm: vec![27.0; stations], force: 1.0, shift: Box::new(|_, _| 0.0) }
    }

    /// Cuts a pass; returns e = D - r.
    pub fn cut(&mut self, plan: &PassPlan) -> Vec<f64> {
        let shift = &mut self.shift;
        let commanded: Vec<f64> =
            plan.commanded_mm().zip(&self.z_mm).map(|(b, z)| b + 2.0 * shift(plan.pass, *z)).collect();
        for (i, b) in commanded.iter().enumerate() {
            let before = self.diameter_mm[i];
            let w = compliance(self.z_mm[i], 0.5 * (before + b));
            let after = |d: f64| b + 2.0 * w * self.force * force_n((before - d) / 2.0);
            let (mut low, mut high) = (*b - 1.0, before);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if after(middle) > middle { low = middle } else { high = middle }
            }
            self.diameter_mm[i] = 0.5 * (low + high);
        }
        self.diameter_mm.iter().map(|d| d - plan.nominal_mm).collect()
    }

    pub fn plan(&self, pass: u32, nominal_mm: f64, offset: DiameterOffset) -> PassPlan {
        PassPlan {
            pass,
            nominal_mm,
            cutting: CUTTING,
            station_z_mm: self.z_mm.clone(),
            offset,
            form: PlannedForm::PLAIN,
        }
    }

    pub fn measured(&self, pass: u32) -> DiameterProfile {
        profile(pass, &self.z_mm, &self.diameter_mm)
    }
}

pub fn force_n(depth_mm: f64) -> f64 {
    4764.2
        * depth_mm.max(0.0).powf(0.901)
        * CUTTING.feed_mm_per_rev.powf(0.6)
        * CUTTING.speed_m_per_min.powf(-0.3)
}

fn compliance(a: f64, d: f64) -> f64 {
    let ei = E_N_PER_MM2 * std::f64::consts::PI * d.powi(4) / 64.0;
    let l = LENGTH_MM;
    let at_tailstock = a * a * (3.0 * l - a) / (6.0 * ei) + 1.0 / CHUCK_N_PER_MM;
    let reaction = at_tailstock / (l.powi(3) / (3.0 * ei) + 1.0 / CHUCK_N_PER_MM + 1.0 / TAILSTOCK_N_PER_MM);
    a.powi(3) / (3.0 * ei) + 1.0 / CHUCK_N_PER_MM - reaction * at_tailstock
}

pub fn profile(pass: u32, z_mm: &[f64], d_mm: &[f64]) -> DiameterProfile {
    let station = |(z, d): (&f64, &f64)| Station {
        z_mm: *z,
        reading: Reading::Value(Diameter { d_mm: *d, u_random_mm: 2e-4, u_common_mm: 1e-4 }),
        freedom: None,
    };
    DiameterProfile { pass, stations: z_mm.iter().zip(d_mm).map(station).collect() }
}

pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, v| most.max(v.abs()))
}
