//! Workpiece materials: elastic constants, thermal growth and specific cutting force, each with its source.
//!
//! kc1.1 and mc are Kienzle's main values as collected by H. Victor (Zerspankennwerte, Industrie-Anzeiger 98,
//! 1976, and the handbooks that reprint him): turning with carbide, v about 100 m/min, rake angle 6°, sharp tool,
//! uncertain by 10-20 %. Elastic constants and expansion are handbook values for room temperature. A material
//! without `kienzle` has no value here that we could trace.

/// Main values of the specific cutting force k_c = kc1.1·h^(-mc), h in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KienzleData {
    /// kc1.1, N/mm² at a chip 1 mm thick and 1 mm wide.
    pub kc11_n_per_mm2: f64,
    /// mc, dimensionless.
    pub mc: f64,
}

/// A workpiece material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Name as in the config.
    pub name: &'static str,
    /// Young's modulus E, N/mm².
    pub youngs_modulus_n_per_mm2: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Linear thermal expansion, µm/(m·K).
    pub expansion_um_per_m_k: f64,
    /// Specific cutting force, where there is a value with a source.
    pub kienzle: Option<KienzleData>,
    /// Where the cutting values come from.
    pub source: &'static str,
}

const VICTOR: &str = "H. Victor, Industrie-Anzeiger 98 (1976)";
const NONE: &str = "elastic constants only";

/// A steel: E, ν and α are common to all of them within a few percent.
const fn steel(name: &'static str, kc11: f64, mc: f64) -> Material {
    Material {
        name,
        youngs_modulus_n_per_mm2: 2.1e5,
        poisson_ratio: 0.3,
        expansion_um_per_m_k: 11.5,
        kienzle: Some(KienzleData { kc11_n_per_mm2: kc11, mc }),
        source: VICTOR,
    }
}

/// The materials known.
pub const MATERIALS: [Material; 9] = [
    steel("C45", 2220.0, 0.14),
    steel("C60", 2130.0, 0.18),
    steel("E295", 1990.0, 0.26),
    steel("E360", 2260.0, 0.30),
    steel("16MnCr5", 2100.0, 0.26),
    steel("42CrMo4", 2500.0, 0.26),
    Material {
        name: "EN-GJL-250",
        youngs_modulus_n_per_mm2: 1.1e5,
        poisson_ratio: 0.26,
        expansion_um_per_m_k: 10.0,
        kienzle: Some(KienzleData { kc11_n_per_mm2: 1160.0, mc: 0.26 }),
        source: VICTOR,
    },
    Material {
        name: "X5CrNi18-10",
        youngs_modulus_n_per_mm2: 2.0e5,
        poisson_ratio: 0.3,
        expansion_um_per_m_k: 16.0,
        kienzle: None,
        source: NONE,
    },
    Material {
        name: "EN AW-6082",
        youngs_modulus_n_per_mm2: 7.0e4,
        poisson_ratio: 0.33,
        expansion_um_per_m_k: 23.4,
        kienzle: None,
        source: NONE,
    },
];

/// The material of that name.
pub fn find(name: &str) -> Option<&'static Material> {
    MATERIALS.iter().find(|material| material.name.eq_ignore_ascii_case(name))
}

/// All names, for an error message.
pub fn names() -> String {
    MATERIALS.map(|material| material.name).join(", ")
}
