//! Workpiece materials: elastic constants, thermal growth and specific cutting force, each with its
//! source.
//!
//! kc1.1 and mc are Kienzle's main values as collected by H. Victor (Zerspankennwerte,
//! Industrie-Anzeiger 98, 1976, and the handbooks that reprint him): turning with carbide, v about
//! 100 m/min, rake angle 6°, sharp tool, uncertain by 10-20 %. Where a second, independent table
//! was found they are compared with it in a test (chuck maker Röhm, RN-1391, Table 2: k_c over the
//! feed at a lead angle of 45°, for 42CrMo4, 16MnCr5 and EN-GJL-250: within 5 %). Elastic constants
//! and expansion are those of the standards named in each row. A material without `kienzle` has
//! none because no value with a source was found.

/// Main values of the specific cutting force k_c = kc1.1·h^(-mc), h in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KienzleData {
    /// kc1.1, N/mm² at a chip 1 mm thick and 1 mm wide.
    pub kc11_n_per_mm2: f64,
    /// mc, dimensionless.
    pub mc: f64,
}

/// A workpiece material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Material {
    /// Name as in the config.
    pub name: &'static str,
    /// Young's modulus E, N/mm².
    pub youngs_modulus_n_per_mm2: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Linear thermal expansion, µm/(m·K).
    pub expansion_um_per_m_k: f64,
    /// Density, kg/m³.
    pub density_kg_per_m3: f64,
    /// Specific cutting force, where there is a value with a source.
    pub kienzle: Option<KienzleData>,
    /// Where the cutting values come from.
    pub source: &'static str,
    /// Where elastic constants and expansion come from.
    pub elastic_source: &'static str,
}

const VICTOR: &str = "H. Victor, Industrie-Anzeiger 98 (1976)";
const NONE: &str = "elastic constants only";
/// Density 7850 kg/m³ is EN 1991-1-1's upper value (Table A.4, 77.0-78.5 kN/m³); E = 210 000 N/mm²
/// and ν = .3 are the standard's; α = 11.5 µm/(m·K) is the usual value about 20 °C (the standard
/// rounds to 12).
const STEEL: &str = "EN 1993-1-1, 3.2.6; α as used for gauging steel (11.5 ± 1, ISO 1 practice)";

/// A steel: E, ν and α are common to all of them within a few percent.
const fn steel(name: &'static str, kc11: f64, mc: f64) -> Material {
    Material {
        name,
        youngs_modulus_n_per_mm2: 2.1e5,
        poisson_ratio: 0.3,
        expansion_um_per_m_k: 11.5,
        density_kg_per_m3: 7850.0,
        kienzle: Some(KienzleData { kc11_n_per_mm2: kc11, mc }),
        source: VICTOR,
        elastic_source: STEEL,
    }
}

/// All materials.
pub(crate) const MATERIALS: [Material; 9] = [
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
        density_kg_per_m3: 7200.0,
        kienzle: Some(KienzleData { kc11_n_per_mm2: 1160.0, mc: 0.26 }),
        source: VICTOR,
        elastic_source: "EN 1561, Annex A: E 103-118 kN/mm², ν .26, α 10 (below 20 °C) to 11.7 (20-200 °C), density 7.20 g/cm³",
    },
    Material {
        name: "X5CrNi18-10",
        youngs_modulus_n_per_mm2: 2.0e5,
        poisson_ratio: 0.3,
        expansion_um_per_m_k: 16.0,
        density_kg_per_m3: 7900.0,
        kienzle: None,
        source: NONE,
        elastic_source: "EN 10088-1, Annex E: E 200 kN/mm², α 16.0 (20-100 °C), density 7.9 kg/dm³",
    },
    Material {
        name: "EN AW-6082",
        youngs_modulus_n_per_mm2: 7.0e4,
        poisson_ratio: 0.3,
        expansion_um_per_m_k: 23.0,
        density_kg_per_m3: 2700.0,
        kienzle: None,
        source: NONE,
        elastic_source: "EN 1999-1-1, 3.2.5: E 70 000 N/mm², ν .3, α 23, density 2700 kg/m³",
    },
];

/// The material of that name.
pub(crate) fn find(name: &str) -> Option<&'static Material> {
    MATERIALS.iter().find(|material| material.name.eq_ignore_ascii_case(name))
}

/// All names, for an error message.
pub(crate) fn names() -> String {
    MATERIALS.map(|material| material.name).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// k_c in kN/mm² at feeds .16, .25, .4, .63, 1.0, 1.6 mm and a lead angle of 45° (Röhm,
    /// RN-1391, Table 2): h = f·sin 45°.
    const ROEHM: [(&str, [f64; 6]); 3] = [
        ("42CrMo4", [4.35, 3.90, 3.45, 3.10, 2.75, 2.45]),
        ("16MnCr5", [3.75, 3.30, 2.95, 2.60, 2.30, 2.05]),
        ("EN-GJL-250", [2.05, 1.80, 1.60, 1.45, 1.30, 1.15]),
    ];

    #[test]
    fn specific_cutting_forces_agree_with_a_second_table() {
        for (name, table) in ROEHM {
            let Some(kienzle) = find(name).and_then(|m| m.kienzle) else { panic!("{name} has no value") };
            for (feed, kc) in [0.16_f64, 0.25, 0.4, 0.63, 1.0, 1.6].into_iter().zip(table) {
                let ours = kienzle.kc11_n_per_mm2 * (feed * 0.5_f64.sqrt()).powf(-kienzle.mc);
                let off = ours / (1e3 * kc) - 1.0;
                assert!(off.abs() < 0.05, "{name} at {feed} mm: {ours:.0} against {:.0}", 1e3 * kc);
            }
        }
    }

    #[test]
    fn every_row_names_its_sources() {
        for material in &MATERIALS {
            assert!(!material.elastic_source.is_empty(), "{}", material.name);
            assert_eq!(material.kienzle.is_none(), material.source == NONE, "{}", material.name);
        }
    }
}
