//! The scale stated in a file: `pHYs`, TIFF and JFIF resolutions, `frames.csv`.

/// Resolutions of screens, dots per inch, as written by programs without a scale of the object.
const SCREEN_DPI: [f64; 2] = [72.0, 96.0];
/// Resolutions of printers and scanners, dots per inch: a scale of the object only where stated to
/// be one.
const PRINT_DPI: [f64; 19] = [
    75.0, 90.0, 100.0, 120.0, 144.0, 150.0, 180.0, 200.0, 240.0, 300.0, 350.0, 360.0, 400.0, 600.0, 720.0,
    1200.0, 1440.0, 2400.0, 4800.0,
];
/// An inch, µm.
const INCH_UM: f64 = 25_400.0;
/// Relative difference above which two scales disagree. The diameter has the same relative error as
/// the scale: 0.1 % of 20 mm is 20 µm, and the rounding of writers (whole pixels per metre,
/// hundredths of a dot per inch) is smaller.
pub(crate) const SAME_SCALE: f64 = 1e-3;

/// Meaning of a file's scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trust {
    /// A scale of the object.
    Object,
    /// Possibly a printer's or scanner's: used on request, not compared with another scale.
    Print,
    /// A screen's, which is not a scale of the object.
    Screen,
}

/// A scale and its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct FileScale {
    /// Along columns and along rows, µm/px.
    pub um_per_px: [f64; 2],
    /// The tag or table with its value.
    pub origin: String,
    /// Its meaning.
    pub trust: Trust,
    /// Half a unit in the last written place, relative.
    pub rounding: f64,
}

impl FileScale {
    /// The scale of a density in dots per `unit_um` µm, across and down, in `whole` numbers or not;
    /// `None` where the density is not positive.
    pub(super) fn of_density(density: [f64; 2], whole: bool, unit_um: f64, origin: String) -> Option<Self> {
        let um_per_px = density.map(|d| unit_um / d);
        if um_per_px.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
            return None;
        }
        let dpi = INCH_UM / um_per_px[0];
        // Whole dots per metre or per centimetre: 2835 px/m means 72 dpi.
        let near = |all: &[f64]| all.iter().any(|d| (dpi / d - 1.0).abs() < 5e-3);
        let trust = if near(&SCREEN_DPI) {
            Trust::Screen
        } else if near(&PRINT_DPI) {
            Trust::Print
        } else {
            Trust::Object
        };
        let rounding = if whole { 0.5 / density[0].min(density[1]) } else { 0.0 };
        Some(Self { um_per_px, origin, trust, rounding })
    }

    /// From a table's column.
    pub(super) fn stated(um_per_px: f64, origin: String) -> Self {
        Self { um_per_px: [um_per_px; 2], origin, trust: Trust::Object, rounding: 0.0 }
    }

    /// The one scale of both directions.
    ///
    /// # Errors
    /// Why there is none: a screen's resolution, or pixels that are not square.
    pub(crate) fn of_object(&self) -> Result<f64, String> {
        let [x, y] = self.um_per_px;
        if self.trust == Trust::Screen {
            return Err(format!(
                "{}: a screen's resolution, not a scale of the object; give the scale in µm (--um-per-px S)",
                self.origin
            ));
        }
        if !agree(x, y, self.rounding) {
            return Err(format!(
                "{}: {x:.6} µm/px across and {y:.6} down differ by more than .1 %; pixels must be square",
                self.origin
            ));
        }
        Ok(x)
    }

    /// Refuses a scale in use that differs from this one by more than 0.1 %; a printer's or a
    /// screen's is not compared.
    ///
    /// # Errors
    /// Names both.
    pub(crate) fn check(&self, used_um_per_px: f64, used: &str) -> Result<(), String> {
        let [x, y] = self.um_per_px;
        let is_used = |own: f64| agree(own, used_um_per_px, self.rounding);
        if self.trust != Trust::Object || (is_used(x) && is_used(y)) {
            return Ok(());
        }
        let shown = if agree(x, y, self.rounding) { format!("{x:.6}") } else { format!("{x:.6} x {y:.6}") };
        Err(format!(
            "{}: a scale of {shown} µm/px, but {used} is {used_um_per_px:.6} µm/px; they differ by more than .1 %",
            self.origin
        ))
    }

    /// Relative difference of a scale in use.
    pub(crate) fn departure(&self, used_um_per_px: f64) -> f64 {
        self.um_per_px.map(|own| (own / used_um_per_px - 1.0).abs()).into_iter().fold(0.0, f64::max)
    }

    /// With rows and columns exchanged.
    pub(super) fn transposed(self) -> Self {
        let [x, y] = self.um_per_px;
        Self { um_per_px: [y, x], ..self }
    }
}

fn agree(a: f64, b: f64, rounding: f64) -> bool {
    (a / b - 1.0).abs() <= SAME_SCALE + rounding
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_scales_a_per_mille_apart_are_two() {
        let metre = |x: f64| FileScale::of_density([x, x], true, 1e6, "pHYs".to_owned()).unwrap();
        let scale = metre(57_471.0);
        assert!(scale.check(17.4, "--um-per-px").is_ok());
        assert!(scale.check(17.4 * 1.0009, "--um-per-px").is_ok());
        let words = scale.check(17.4 * 1.0011, "--um-per-px").unwrap_err();
        assert!(
            words.contains("pHYs: a scale of 17.40") && words.contains("--um-per-px is 17.41914"),
            "{words}"
        );
        // 10 px/m means anything from 9.5 to 10.5.
        assert!(metre(10.0).check(97_000.0, "--um-per-px").is_ok());
        assert_eq!(scale.of_object().map(|s| (s * 1e3).round()), Ok(17_400.0));
    }

    #[test]
    fn what_programs_write_that_know_no_scale_is_none() {
        for (dpi, trust) in
            [(72.0, Trust::Screen), (96.0, Trust::Screen), (300.0, Trust::Print), (1234.0, Trust::Object)]
        {
            let scale = FileScale::of_density([dpi, dpi], true, 25_400.0, "JFIF".to_owned()).unwrap();
            assert_eq!(scale.trust, trust, "{dpi}");
            assert_eq!(scale.check(3.0, "the calibration").is_ok(), trust != Trust::Object, "{dpi}");
            assert_eq!(scale.of_object().is_ok(), trust != Trust::Screen, "{dpi}");
        }
        // 72 and 96 dpi in whole pixels per metre.
        for metre in [2834.0, 2835.0, 3779.0, 3780.0] {
            let scale = FileScale::of_density([metre, metre], true, 1e6, "pHYs".to_owned()).unwrap();
            assert_eq!(scale.trust, Trust::Screen, "{metre}");
        }
        assert!(FileScale::of_density([0.0, 5.0], true, 1e6, String::new()).is_none());
        let oblong = FileScale::of_density([5000.0, 5100.0], true, 1e6, "pHYs".to_owned()).unwrap();
        assert!(oblong.of_object().unwrap_err().contains("square"));
    }
}
