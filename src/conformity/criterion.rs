//! The size that a tolerance applies to: the modifiers of ISO 14405-1:2016, as far as silhouettes
//! can verify them.
//!
//! A silhouette shows the convex hull of every section. Sizes that depend on the hull alone are
//! judged: two-point (caliper) sizes, the least circumscribed circle and cylinder, and with them
//! the envelope requirement. Sizes that also depend on hollows, or that have no limits of their own
//! here, are refused with that reason.

/// Which size must lie within the limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SizeCriterion {
    /// Every two-point size (LP), the default where nothing is stated.
    #[default]
    TwoPoint,
    /// Envelope requirement Ⓔ: every two-point size at least the lower limit, the least
    /// circumscribed cylinder over the length at most the upper one (the maximum-material limit of
    /// a shaft).
    Envelope,
    /// (GN): diameter of the least circumscribed cylinder over the length.
    CircumscribedCylinder,
    /// (GN) ACS: diameter of the least circumscribed circle of any cross-section.
    CircumscribedCircle,
}

impl SizeCriterion {
    /// Its modifiers as written on a drawing.
    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::TwoPoint => "(LP)",
            Self::Envelope => "(E)",
            Self::CircumscribedCylinder => "(GN)",
            Self::CircumscribedCircle => "(GN) ACS",
        }
    }

    /// The sizes that it is about, in words.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::TwoPoint => "every two-point size",
            Self::Envelope => "the envelope (E): two-point sizes below, the circumscribed cylinder above",
            Self::CircumscribedCylinder => "the least circumscribed cylinder (GN)",
            Self::CircumscribedCircle => "the least circumscribed circle of every section (GN) ACS",
        }
    }

    /// Whether it needs the sections of a whole turn, over the length.
    pub(crate) fn needs_turn(self) -> bool {
        self != Self::TwoPoint
    }

    /// The criterion of a tolerance's modifiers, capital letters without circles or parentheses.
    ///
    /// # Errors
    /// Why it is not judged, for people.
    pub(super) fn of(modifiers: &[String]) -> Result<Self, String> {
        let words: Vec<&str> = modifiers.iter().map(String::as_str).collect();
        if let Some(why) = words.iter().find_map(|word| refusal(word)) {
            return Err(why);
        }
        let section = words.contains(&"ACS");
        let sizes: Vec<&str> = words.iter().copied().filter(|w| *w != "ACS").collect();
        match (sizes.as_slice(), section) {
            // A two-point size is one of a cross-section anyway.
            ([] | ["LP"], _) => Ok(Self::TwoPoint),
            // Its lower limit applies to two-point sizes anyway.
            (["E"] | ["LP", "E"] | ["E", "LP"], false) => Ok(Self::Envelope),
            (["E"], true) => {
                Err("(E) is a requirement over the length, ACS is one for any cross-section".to_owned())
            }
            (["GN"], false) => Ok(Self::CircumscribedCylinder),
            (["GN"], true) => Ok(Self::CircumscribedCircle),
            (several, _) => Err(format!(
                "({}) stand together: one of (LP), (E), (GN), (GN) ACS is judged at a time",
                several.join("), (")
            )),
        }
    }
}

/// Whether a word is a modifier of ISO 14405-1 (or of ISO 2692, ISO 1101 and ISO 10579, which
/// drawings mix with them).
pub(super) fn is_modifier(word: &str) -> bool {
    ["E", "LP", "GN", "ACS"].contains(&word) || refusal(word).is_some()
}

/// Why a modifier is not judged; `None` for those that are, and for words that are none.
fn refusal(word: &str) -> Option<String> {
    let hull =
        "hollows that no tangent reaches make it smaller than a silhouette shows, which sees the convex hull";
    let why = match word {
        "LS" => "the local size of an inscribed sphere needs points of the surface".to_owned(),
        "GG" => format!("the least-squares size is that of the surface: {hull} (measure --turn gives GG of the hull, unjudged)"),
        "GX" => format!("the largest inscribed size is that of the surface: {hull} (measure --turn gives GX of the hull, unjudged)"),
        "GC" => format!("the Chebyshev size is that of the surface: {hull}"),
        "CC" => format!("the circumference diameter is that of the surface: {hull}"),
        "CA" => format!("the area diameter is that of the surface: {hull}"),
        "CV" => format!("the volume diameter is that of the surface: {hull}"),
        "SX" | "SN" | "SA" | "SM" | "SD" | "SR" | "SQ" => {
            "a rank-order size needs all two-point sizes of the feature, and frames show some of its angles and places".to_owned()
        }
        "ALS" => "longitudinal sections through the axis have sizes of their own".to_owned(),
        "SCS" => "frames do not state which cross-section the drawing fixes".to_owned(),
        "CT" => "a common tolerance is one of several features taken as one, and one feature is measured".to_owned(),
        "UF" => "a united feature is made of several, and one feature is measured".to_owned(),
        "M" | "L" | "R" => "it relates the size to a geometrical tolerance (ISO 2692), which is not measured".to_owned(),
        "F" => "the free state (ISO 10579) is not that of a part held between chuck and centre".to_owned(),
        "P" | "U" | "T" | "SZ" | "CZ" => "it belongs to a geometrical tolerance (ISO 1101)".to_owned(),
        _ => return None,
    };
    Some(format!("({word}) is not judged: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modifiers_are_judged_or_refused_never_dropped() {
        let of =
            |words: &[&str]| SizeCriterion::of(&words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>());
        assert_eq!(of(&[]), Ok(SizeCriterion::TwoPoint));
        assert_eq!(of(&["LP", "ACS"]), Ok(SizeCriterion::TwoPoint));
        assert_eq!(of(&["E"]), Ok(SizeCriterion::Envelope));
        assert_eq!(of(&["LP", "E"]), Ok(SizeCriterion::Envelope));
        assert_eq!(of(&["GN"]), Ok(SizeCriterion::CircumscribedCylinder));
        assert_eq!(of(&["ACS", "GN"]), Ok(SizeCriterion::CircumscribedCircle));
        for word in [
            "LS", "GG", "GX", "GC", "CC", "CA", "CV", "SX", "SN", "SA", "SM", "SD", "SR", "SQ", "ALS", "SCS",
            "CT", "UF", "M", "L", "F",
        ] {
            assert!(is_modifier(word) && of(&[word]).is_err_and(|why| why.contains(word)), "{word}");
        }
        assert!(of(&["E", "GN"]).is_err() && of(&["E", "ACS"]).is_err());
        assert!(!is_modifier("H"));
    }
}
