//! Refractive indices of materials by name.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::airy::C;

/// A material of parts, by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Material {
    /// Ground steel: 2.9 + 3.1i, as for a glancing reflection; 400 to 700 nm.
    #[default]
    Steel,
    /// Iron (Johnson, Christy, Phys. Rev. B 9 (1974) 5056), 431 to 704 nm.
    Iron,
    /// Chromium (Johnson, Christy 1974), 431 to 704 nm.
    Chromium,
    /// Aluminium (Rakić, Appl. Opt. 34 (1995) 4755), 413 to 689 nm.
    Aluminium,
    /// Ceramic that scatters what enters it: 1.77 (alumina; sapphire's ordinary ray, Dodge,
    /// Handbook of Laser Science and Technology IV (1986) 30); 400 to 700 nm.
    Ceramic,
}

/// Wavelength, nm, n and κ.
type Row = (f64, f64, f64);

const STEEL: [Row; 2] = [(400.0, 2.9, 3.1), (700.0, 2.9, 3.1)];

const CERAMIC: [Row; 2] = [(400.0, 1.77, 0.0), (700.0, 1.77, 0.0)];

const IRON: [Row; 10] = [
    (431.0, 2.48, 2.71),
    (451.0, 2.59, 2.77),
    (471.0, 2.67, 2.82),
    (496.0, 2.74, 2.88),
    (521.0, 2.86, 2.91),
    (549.0, 2.95, 2.93),
    (582.0, 2.94, 2.99),
    (617.0, 2.88, 3.05),
    (659.0, 2.92, 3.10),
    (704.0, 2.86, 3.19),
];

#[allow(clippy::approx_constant, reason = "an extinction coefficient that is near π by chance")]
const CHROMIUM: [Row; 10] = [
    (431.0, 2.19, 3.04),
    (451.0, 2.33, 3.14),
    (471.0, 2.51, 3.24),
    (496.0, 2.75, 3.30),
    (521.0, 2.94, 3.33),
    (549.0, 3.18, 3.33),
    (582.0, 3.22, 3.30),
    (617.0, 3.17, 3.30),
    (659.0, 3.09, 3.34),
    (704.0, 3.05, 3.39),
];

const ALUMINIUM: [Row; 8] = [
    (413.28, 0.521_35, 5.0008),
    (442.80, 0.607_90, 5.3676),
    (476.87, 0.727_80, 5.7781),
    (516.60, 0.873_40, 6.2418),
    (563.57, 1.0728, 6.7839),
    (619.93, 1.3660, 7.4052),
    (652.25, 1.5724, 7.7354),
    (688.81, 1.8301, 8.0601),
];

impl Material {
    fn rows(self) -> &'static [Row] {
        match self {
            Self::Steel => &STEEL,
            Self::Iron => &IRON,
            Self::Chromium => &CHROMIUM,
            Self::Aluminium => &ALUMINIUM,
            Self::Ceramic => &CERAMIC,
        }
    }

    /// Name in a config.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Steel => "steel",
            Self::Iron => "iron",
            Self::Chromium => "chromium",
            Self::Aluminium => "aluminium",
            Self::Ceramic => "ceramic",
        }
    }

    /// Wavelengths of the table, nm.
    pub(super) fn range_nm(self) -> (f64, f64) {
        let rows = self.rows();
        (rows[0].0, rows[rows.len() - 1].0)
    }

    /// n + iκ at a wavelength, linear between two rows; `None` outside the table.
    pub(super) fn index(self, wavelength_nm: f64) -> Option<C> {
        self.rows().windows(2).find(|r| (r[0].0..=r[1].0).contains(&wavelength_nm)).map(|r| {
            let t = (wavelength_nm - r[0].0) / (r[1].0 - r[0].0);
            C::new(r[0].1 + t * (r[1].1 - r[0].1), r[0].2 + t * (r[1].2 - r[0].2))
        })
    }
}
