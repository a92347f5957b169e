//! Values with their uncertainty as printed: u or U with two significant digits, the value rounded
//! to the same place (GUM 7.2.6). Files and JSON keep every digit.
use crate::gauge::limit::limits;

limits! {
    /// Digits that are printed.
    StatedLimits = "stated";
    /// Significant digits of an uncertainty (GUM 7.2.6: at most two suffice).
    digits: i32 = 2;
    /// Decimals printed where no uncertainty determines how many are significant: of mm, hundredths
    /// of a µm.
    without_u: i32 = 5;
}

/// Decimals to which an uncertainty has two significant digits: those of the rounded value, 0.0996
/// is 0.10. Negative from 100 on.
pub(crate) fn decimals(u: f64) -> i32 {
    let limits = StatedLimits::get();
    if !(u > 0.0 && u.is_finite()) {
        return limits.without_u;
    }
    let decimals = limits.digits - 1 - u.log10().floor() as i32;
    let rounded = (u * 10f64.powi(decimals)).round();
    if rounded >= 10f64.powi(limits.digits) { decimals - 1 } else { decimals }
}

/// A number rounded to so many decimals; to tens, hundreds, … where they are negative.
pub(crate) fn rounded(value: f64, decimals: i32) -> String {
    match usize::try_from(decimals) {
        Ok(decimals) => format!("{value:.decimals$}"),
        Err(_) => {
            let unit = 10f64.powi(-decimals);
            format!("{:.0}", (value / unit).round() * unit)
        }
    }
}

/// A value and its uncertainty (standard or expanded), both to the place where the uncertainty has
/// two significant digits.
///
/// ```
/// use shadowgauge::gauge::stated::stated;
///
/// assert_eq!(stated(24.986_537, 0.001_23), ["24.9865", "0.0012"].map(String::from));
/// assert_eq!(stated(24.986_537, 0.000_0996), ["24.98654", "0.00010"].map(String::from));
/// assert_eq!(stated(10_278.0, 134.0), ["10280", "130"].map(String::from));
/// ```
pub fn stated(value: f64, u: f64) -> [String; 2] {
    let decimals = decimals(u);
    [value, u].map(|number| if number.is_finite() { rounded(number, decimals) } else { "-".to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_of_u_are_the_values_place_whatever_their_size() {
        for exponent in -9..4 {
            for mantissa in [1.0, 1.04, 2.5, 9.94, 9.96, 9.999] {
                let u = mantissa * 10f64.powi(exponent);
                let [value, text] = stated(24.123_456_789_012_3, u);
                let digits = text.trim_start_matches(['0', '.']).replace('.', "");
                let read: f64 = text.parse().unwrap();
                assert!((read / u - 1.0).abs() < 0.051, "{u} {text}");
                assert!(decimals(u) < 0 || digits.len() == 2, "{u} {text}");
                let place = |t: &str| t.split_once('.').map_or(0, |(_, d)| d.len());
                assert_eq!(place(&value), place(&text), "{value} {text}");
            }
        }
        assert_eq!(stated(25.0, 0.0), ["25.00000", "0.00000"].map(String::from));
        assert_eq!(stated(25.0, f64::NAN)[1], "-");
    }
}
