//! A small part before a head with two master pins.
#![allow(dead_code, reason = "not every test uses every job")]

macro_rules! job {
    ($passes:literal, $last:literal) => {
        concat!(
            "name = \"small\"\nseed = 5\n[part]\nlength_mm = 60.0\nstock_diameter_mm = 12.0\n",
            "nominal_diameter_mm = ",
            $passes,
            "\n[part.tolerance]\nnominal_mm = ",
            $last,
            "\nupper_mm = 0.01\nlower_mm = -0.01\n",
            include_str!("small_view.toml")
        )
    };
}

/// Of one pass.
pub const ONE_PASS: &str = job!("[11.5]", "11.5");
/// Of five passes.
pub const FIVE_PASSES: &str = job!("[11.8, 11.6, 11.4, 11.2, 11.0]", "11.0");
/// Of two passes.
pub const TWO_PASSES: &str = job!("[11.5, 11.0]", "11.0");
