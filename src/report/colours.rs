//! The colours of pages and charts, light and dark, as CSS; every pair keeps the contrast of WCAG
//! 2.1: 4.5 for text (1.4.3), 3 for lines and marks (1.4.11).
//!
//! In: nothing. Out: the custom properties and classes that a page's style begins with. Elements of
//! a chart carry the light colours as attributes too, so that a picture by itself needs no page.

use std::fmt::Write as _;

/// Colours of one scheme, `#rrggbb`.
pub(super) struct Scheme {
    /// Ground of pages and charts.
    pub paper: &'static str,
    /// Ground of the heads of tables.
    pub shade: &'static str,
    /// Text, axes and their labels.
    pub ink: &'static str,
    /// Text of captions and notes.
    pub muted: &'static str,
    /// Lines of tables and grids.
    pub rule: &'static str,
    /// Text of a verdict that is good, open, bad.
    pub verdicts: [&'static str; 3],
    /// Series of a chart, in order of use.
    pub series: [&'static str; 8],
}

/// By day, on paper, and in files of a picture alone. The series are those of Okabe and Ito, which
/// colour-blind readers can separate, the bright ones darkened, a brown in place of their yellow.
pub(super) const LIGHT: Scheme = Scheme {
    paper: "#ffffff",
    shade: "#f2f2f2",
    ink: "#222222",
    muted: "#555555",
    rule: "#8c8c8c",
    verdicts: ["#00664a", "#7a4a00", "#a02c00"],
    series: ["#0072b2", "#d55e00", "#008a64", "#b8578c", "#9a6b00", "#2b84b8", "#3c3c3c", "#7a3e18"],
};

/// Where the reader's system is dark.
pub(super) const DARK: Scheme = Scheme {
    paper: "#17191c",
    shade: "#26292e",
    ink: "#e4e4e4",
    muted: "#b3b8be",
    rule: "#7a7e84",
    verdicts: ["#4fd6a4", "#f0c060", "#ff9a6b"],
    series: ["#5aa9e6", "#ff8c4b", "#2fc796", "#e39bc4", "#e6b422", "#8fd0f5", "#cfcfcf", "#cf9a70"],
};

/// Colour of a series in the light scheme; indices wrap.
pub(super) fn series(index: usize) -> &'static str {
    LIGHT.series[index % LIGHT.series.len()]
}

impl Scheme {
    /// Its custom properties.
    fn properties(&self) -> String {
        let [good, open, bad] = self.verdicts;
        let mut css = format!(
            "--paper:{};--shade:{};--ink:{};--muted:{};--rule:{};--good:{good};--open:{open};--bad:{bad}",
            self.paper, self.shade, self.ink, self.muted, self.rule
        );
        for (index, colour) in self.series.iter().enumerate() {
            let _ = write!(css, ";--c{index}:{colour}");
        }
        css
    }
}

/// The properties of both schemes, print in the light one, and the classes of a picture's elements:
/// `s0` … strokes and `f0` … fills of a series, `paper`, `rule`, `ink`, `halo`.
pub(super) fn style() -> String {
    let (light, dark) = (LIGHT.properties(), DARK.properties());
    let mut css = format!(
        ":root{{color-scheme:light;{light}}}\
         @media(prefers-color-scheme:dark){{:root{{color-scheme:dark;{dark}}}}}\
         @media print{{:root{{color-scheme:light;{light}}}}}\
         .paper{{fill:var(--paper)}}.rule{{stroke:var(--rule)}}.halo{{stroke:var(--paper)}}\
         svg text,.ink{{fill:var(--ink)}}.chart polyline{{stroke:var(--ink)}}"
    );
    for index in 0..LIGHT.series.len() {
        let _ = write!(css, ".s{index}{{stroke:var(--c{index})}}.f{index}{{fill:var(--c{index})}}");
    }
    css
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance (WCAG 2.1).
    fn luminance(hex: &str) -> f64 {
        let linear = |at: usize| {
            let value = f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap()) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(1) + 0.7152 * linear(3) + 0.0722 * linear(5)
    }

    fn contrast(a: &str, b: &str) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn contrast_is_that_of_the_standard() {
        assert!((contrast("#000000", "#ffffff") - 21.0).abs() < 1e-9);
        assert!((contrast("#777777", "#ffffff") - 4.48).abs() < 0.01);
        assert!(contrast("#bbbbbb", "#ffffff") < 3.0, "a pale line must fail");
    }

    #[test]
    fn text_and_lines_stand_out_in_both_schemes() {
        for (name, scheme) in [("light", LIGHT), ("dark", DARK)] {
            let texts = [scheme.ink, scheme.muted].into_iter().chain(scheme.verdicts);
            for text in texts {
                for ground in [scheme.paper, scheme.shade] {
                    let found = contrast(text, ground);
                    assert!(found >= 4.5, "{name}: text {text} on {ground}: {found:.2}");
                }
            }
            for line in scheme.series.into_iter().chain([scheme.rule, scheme.ink]) {
                let found = contrast(line, scheme.paper);
                assert!(found >= 3.0, "{name}: line {line} on {}: {found:.2}", scheme.paper);
            }
        }
    }

    #[test]
    fn a_page_prints_in_the_light_scheme() {
        let css = style();
        let (dark, print) =
            (css.find("prefers-color-scheme:dark").unwrap(), css.find("@media print").unwrap());
        assert!(dark < print, "the later rule wins");
        assert!(css[print..].contains(&format!("--paper:{}", LIGHT.paper)));
        assert!(css.contains(".s7{stroke:var(--c7)}") && !css.contains("--c8"));
    }
}
