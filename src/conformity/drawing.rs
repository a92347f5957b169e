//! Tolerances as drawings write them: "25h6", "Ø25 ±0,01", "25 +0.0/−0.013", "25 (+0.1/-0.2)",
//! "24.987..25", "25 h6 Ⓔ".
//!
//! No part of the text is ignored: whatever is not part of a tolerance, or of one that silhouettes
//! can verify, is refused with the reason.

use std::str::FromStr;

use super::criterion::{SizeCriterion, is_modifier};
use super::error::ToleranceError;
use super::iso_286::{is_deviation, shaft_deviations_um, standard_tolerance_um};
use super::tolerance::Tolerance;

/// The reason of a refusal, without the text.
enum Refusal {
    Wrong(String),
    Unjudged(String),
}

impl From<String> for Refusal {
    fn from(why: String) -> Self {
        Self::Wrong(why)
    }
}

fn wrong<T>(why: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal::Wrong(why.into()))
}

fn unjudged<T>(why: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal::Unjudged(why.into()))
}

impl FromStr for Tolerance {
    type Err = ToleranceError;

    fn from_str(text: &str) -> Result<Self, ToleranceError> {
        read(text)
    }
}

/// Reads a tolerance.
fn read(text: &str) -> Result<Tolerance, ToleranceError> {
    read_plain(&plain(text)).map_err(|refusal| match refusal {
        Refusal::Wrong(why) => ToleranceError::Wrong { text: text.to_owned(), why },
        Refusal::Unjudged(why) => ToleranceError::Unjudged { text: text.to_owned(), why },
    })
}

/// The text with one sign for each meaning: `-`, `±`, `Ø`, `.` in numbers, `(E)` for a circled
/// letter.
fn plain(text: &str) -> String {
    let text = text.replace("%%c", "Ø").replace("%%C", "Ø").replace("%%p", "±").replace("%%P", "±");
    let characters: Vec<char> = text.chars().collect();
    let digit = |i: Option<usize>| i.and_then(|i| characters.get(i)).is_some_and(char::is_ascii_digit);
    let (mut out, mut circled) = (String::new(), String::new());
    for (i, c) in characters.iter().enumerate() {
        if let Some(letter) = in_circle(*c) {
            circled.push(letter);
            continue;
        }
        close(&mut circled, &mut out);
        match c {
            '\u{2010}'..='\u{2015}' | '\u{2212}' | '\u{fe63}' | '\u{ff0d}' => out.push('-'),
            '\u{ff0b}' => out.push('+'),
            'ø' | '⌀' | '∅' | 'φ' | 'ϕ' | 'Φ' => out.push('Ø'),
            '…' => out.push_str(".."),
            '×' | '✕' => out.push('x'),
            ',' if digit(i.checked_sub(1)) && digit(Some(i + 1)) => out.push('.'),
            c if c.is_whitespace() => out.push(' '),
            c => out.push(*c),
        }
    }
    close(&mut circled, &mut out);
    ["+/-", "+ / -", "+-", "-/+"].iter().fold(out, |text, sign| text.replace(sign, "±"))
}

fn close(circled: &mut String, out: &mut String) {
    if !circled.is_empty() {
        out.push_str(&format!("({circled})"));
        circled.clear();
    }
}

/// The capital letter of a circled one.
fn in_circle(c: char) -> Option<char> {
    let place = match c {
        'Ⓐ'..='Ⓩ' => u32::from(c) - u32::from('Ⓐ'),
        'ⓐ'..='ⓩ' => u32::from(c) - u32::from('ⓐ'),
        _ => return None,
    };
    char::from_u32(u32::from('A') + place)
}

fn read_plain(text: &str) -> Result<Tolerance, Refusal> {
    if text.contains('↔') || text.contains("<->") {
        return unjudged(
            "it is for a part of the length between two marks, and frames do not show the marks",
        );
    }
    let text = without_prefix(text.trim())?;
    let (body, groups, modifiers) = parts(text)?;
    let criterion = SizeCriterion::of(&modifiers).map_err(Refusal::Unjudged)?;
    let (nominal_mm, (lower, upper)) = size_and_deviations(&body, &groups)?;
    if !(lower < upper && nominal_mm + lower > 0.0) {
        return wrong(format!(
            "the limits {} and {} mm leave nothing between them",
            nominal_mm + lower,
            nominal_mm + upper
        ));
    }
    // A picometre is below the last digit of a drawing and above the rounding error of a difference
    // of two sizes.
    let rounded = |mm: f64| (mm * 1e9).round() / 1e9;
    Ok(Tolerance { nominal_mm, upper_mm: rounded(upper), lower_mm: rounded(lower), criterion })
}

/// The text behind the number of features ("4x") and the sign of a diameter.
fn without_prefix(text: &str) -> Result<&str, Refusal> {
    let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let times = text[digits..].trim_start().strip_prefix(['x', 'X']).filter(|_| digits > 0);
    let text = times.unwrap_or(text).trim_start();
    let text = ["Ø", "DIA.", "Dia.", "dia.", "DIA", "Dia", "dia"]
        .iter()
        .find_map(|sign| text.strip_prefix(sign))
        .unwrap_or(text)
        .trim_start();
    match text.chars().next() {
        Some(c) if c.is_ascii_digit() || c == '.' => Ok(text),
        None => wrong("nothing stands there"),
        Some('R') => unjudged("R is a radius: a silhouette gives diameters"),
        Some('M') => unjudged("M is a thread, whose sizes have classes of their own (ISO 965)"),
        Some('S') => unjudged("S is a sphere: a shaft's silhouette is judged"),
        Some(_) => wrong("a size begins with its number"),
    }
}

/// The text outside parentheses without modifiers, the deviations or limits inside, the modifiers.
fn parts(text: &str) -> Result<(String, Vec<String>, Vec<String>), Refusal> {
    let (mut body, mut groups, mut modifiers) = (String::new(), Vec::new(), Vec::new());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('(') {
        let Some((inside, behind)) = after.split_once(')') else {
            return wrong("a parenthesis is not closed");
        };
        body.push_str(before);
        body.push(' ');
        let inside = inside.trim();
        if inside.starts_with(|c: char| c.is_ascii_digit() || "+-±.".contains(c)) {
            groups.push(inside.to_owned());
        } else {
            // Letters in any case: "(e)" and "(Lp)", too.
            modifiers.push(known_modifier(&inside.to_uppercase())?);
        }
        rest = behind;
    }
    body.push_str(rest);
    if body.contains(')') {
        return wrong("a parenthesis is not opened");
    }
    let mut words: Vec<&str> = body.split_whitespace().filter(|word| *word != "mm").collect();
    while let Some(word) = words.last().copied().filter(|w| *w == "E" || (w.len() > 1 && is_modifier(w))) {
        modifiers.push(word.to_owned());
        words.pop();
    }
    Ok((words.join(" "), groups, modifiers))
}

fn known_modifier(word: &str) -> Result<String, Refusal> {
    let joined: String = word.split(|c: char| c.is_whitespace()).collect();
    if is_modifier(&joined) { Ok(joined) } else { wrong(format!("({word}) is no modifier of ISO 14405-1")) }
}

/// Lower and upper deviation from the nominal size, mm.
type Deviations = (f64, f64);

/// The most by which a drawing's deviations differ from those of the class they stand beside, mm:
/// half a micrometre of rounding.
const SAME_MM: f64 = 0.51e-3;

fn differ(a: Deviations, b: Deviations) -> bool {
    (a.0 - b.0).abs().max((a.1 - b.1).abs()) > SAME_MM
}

/// The nominal size, mm, and the deviations from it.
fn size_and_deviations(body: &str, groups: &[String]) -> Result<(f64, Deviations), Refusal> {
    if let Some((lower, upper)) = body.split_once("..") {
        let (a, b) = (size(lower)?, size(upper.trim_start_matches('.').trim_start_matches(['Ø', ' ']))?);
        return if groups.is_empty() { Ok((b, (a - b, 0.0))) } else { wrong("limits stand there twice") };
    }
    let end = body.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(body.len());
    let (nominal, rest) = (size(&body[..end])?, body[end..].trim());
    let rest = rest.strip_prefix("mm").unwrap_or(rest).trim();
    let mut stated = Vec::new();
    if !rest.is_empty() {
        stated.push(behind_size(nominal, rest)?);
    }
    for group in groups {
        stated.push(in_parentheses(nominal, group)?);
    }
    let Some(first) = stated.first().copied() else {
        return wrong(format!("{nominal} is a bare size, without what it may deviate by"));
    };
    match stated.iter().find(|s| differ(**s, first)) {
        Some(other) => wrong(format!(
            "two tolerances stand there, {:+.4}/{:+.4} mm and {:+.4}/{:+.4} mm",
            first.1, first.0, other.1, other.0
        )),
        None => Ok((nominal, first)),
    }
}

/// Deviations from the text behind the nominal size.
fn behind_size(nominal: f64, rest: &str) -> Result<Deviations, Refusal> {
    if rest.starts_with(|c: char| c.is_ascii_alphabetic()) {
        return by_class(nominal, rest);
    }
    if let Some(other) = rest.strip_prefix('/') {
        let other = size(other)?;
        return if near(other, nominal) {
            Ok(((other - nominal).min(0.0), (other - nominal).max(0.0)))
        } else {
            wrong(format!("{nominal}/{other} are no two limits of one size; a deviation carries its sign"))
        };
    }
    deviations(nominal, rest)
}

/// Whether two numbers can be limits of one size: a deviation is never half of its size.
fn near(a: f64, b: f64) -> bool {
    a > 0.5 * b && b > 0.5 * a
}

/// Deviations in parentheses, or limits.
fn in_parentheses(nominal: f64, group: &str) -> Result<Deviations, Refusal> {
    let sizes: Vec<f64> = group.split(['/', ' ', ';']).filter_map(|t| t.trim().parse().ok()).collect();
    match sizes[..] {
        [a, b] if near(a, nominal) && near(b, nominal) => Ok((a.min(b) - nominal, a.max(b) - nominal)),
        _ => deviations(nominal, group),
    }
}

/// Deviations of a class, with or without explicit ones behind it.
fn by_class(nominal: f64, rest: &str) -> Result<Deviations, Refusal> {
    let letters_end = rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len());
    let letters = &rest[..letters_end];
    let behind = rest[letters_end..].trim_start();
    let grade_end = behind.find(|c: char| !c.is_ascii_digit()).unwrap_or(behind.len());
    let (class, behind) = (format!("{letters}{}", &behind[..grade_end]), behind[grade_end..].trim());
    let small = letters.to_lowercase();
    if ["max", "min", "MAX", "MIN"].contains(&letters) {
        return unjudged("it states one limit; conformity is judged to both");
    }
    if let Some(other) = behind.strip_prefix('/') {
        return if other.trim_start().starts_with(|c: char| c.is_ascii_alphabetic()) {
            unjudged(format!("{class}{behind} is a fit, of a hole and a shaft: give the shaft's class alone"))
        } else {
            unjudged(format!("/{} restricts it to a length anywhere on the feature", other.trim()))
        };
    }
    // Textbooks write "Js" for JS.
    if letters.starts_with(|c: char| c.is_ascii_uppercase()) && is_deviation(&small) {
        return unjudged(format!(
            "{class} is the class of a hole, and a shaft's outside diameter is judged (a bore is measured by --shape ring, and not judged); a \
             shaft's letters are small"
        ));
    }
    let (lower_um, upper_um) = shaft_deviations_um(nominal, &class)?;
    let found = (1e-3 * lower_um, 1e-3 * upper_um);
    if !behind.is_empty() && differ(found, deviations(nominal, behind)?) {
        return wrong(format!("{class} is {upper_um:+}/{lower_um:+} µm, and {behind:?} stands beside it"));
    }
    Ok(found)
}

/// Deviations in numbers.
fn deviations(nominal: f64, text: &str) -> Result<Deviations, Refusal> {
    let found = match text.strip_prefix('±') {
        Some(both) => size(both).map(|deviation| (-deviation, deviation))?,
        None => two_deviations(text)?,
    };
    // Whole numbers, and a zone that no grade has: "25 0/-13".
    match standard_tolerance_um(nominal, "18") {
        Ok(widest) if !text.contains('.') && found.1 - found.0 > 1e-3 * widest => wrong(format!(
            "the limits lie {} mm apart, more than IT18 ({:.1} mm here): deviations are in millimetres, not micrometres; with a decimal point \
             they are taken as they stand",
            found.1 - found.0,
            1e-3 * widest
        )),
        _ => Ok(found),
    }
}

fn two_deviations(text: &str) -> Result<Deviations, Refusal> {
    let mut found = Vec::new();
    let mut number = String::new();
    for c in text.chars().chain([' ']) {
        let sign = c == '+' || c == '-';
        let ends = sign || "/;:^ ".contains(c);
        // A blank between a sign and its number is none between two numbers.
        if c == ' ' && (number == "+" || number == "-") {
            continue;
        }
        if ends && !number.is_empty() {
            found.push(deviation(&std::mem::take(&mut number))?);
        }
        if sign || !ends {
            number.push(c);
        }
    }
    match found[..] {
        [a, b] => Ok((a.min(b), a.max(b))),
        [one] => wrong(format!(
            "one deviation stands there, {one:+}: both are needed, 0 where the size itself is a limit"
        )),
        _ => wrong(format!("{text:?} are no two deviations")),
    }
}

fn deviation(text: &str) -> Result<f64, Refusal> {
    let value = number(text)?;
    if value != 0.0 && !text.starts_with(['+', '-']) {
        return wrong(format!("the deviation {text} has no sign"));
    }
    Ok(value)
}

/// A number without a sign.
fn size(text: &str) -> Result<f64, Refusal> {
    let text = text.trim();
    let text = text.strip_suffix("mm").unwrap_or(text).trim_end();
    if text.starts_with(['+', '-']) {
        return wrong(format!("{text:?} has a sign where a size stands"));
    }
    number(text)
}

fn number(text: &str) -> Result<f64, Refusal> {
    let text = text.trim();
    let digits = text.trim_start_matches(['+', '-']);
    let plain = !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit() || c == '.');
    match text.parse::<f64>() {
        Ok(value) if plain => Ok(value),
        _ if text.ends_with("µm") || text.ends_with("um") => {
            wrong(format!("{text:?}: millimetres are needed"))
        }
        _ => wrong(format!("{text:?} is no number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(text: &str) -> (f64, f64) {
        read(text).unwrap_or_else(|e| panic!("{e}")).limits_mm()
    }

    #[test]
    fn drawings_are_understood() {
        for (text, lower, upper) in [
            ("25 h6", 24.987, 25.0),
            ("25h6", 24.987, 25.0),
            ("25,0 h6", 24.987, 25.0),
            ("Ø25h6", 24.987, 25.0),
            ("⌀25 h 6", 24.987, 25.0),
            ("∅ 25.000 h6", 24.987, 25.0),
            ("%%c25 %%p0.01", 24.99, 25.01),
            ("Ø25 ±0.01", 24.99, 25.01),
            ("25±0,01", 24.99, 25.01),
            ("25 +/-0.01 mm", 24.99, 25.01),
            ("25 mm ± 0.01 mm", 24.99, 25.01),
            ("25 +0.0/−0.013", 24.987, 25.0),
            ("25 -0.013/0", 24.987, 25.0),
            ("25 0/-0.013", 24.987, 25.0),
            ("25 0 -0.013", 24.987, 25.0),
            ("25-0.013+0", 24.987, 25.0),
            ("25 (+0.1/-0.2)", 24.8, 25.1),
            ("25 +0,1 -0,2", 24.8, 25.1),
            ("25 +0,1 / – 0,2", 24.8, 25.1),
            ("25 +0.05/+0.02", 25.02, 25.05),
            ("25 h6 (0/-0.013)", 24.987, 25.0),
            ("25 h6 0/-0.013", 24.987, 25.0),
            ("25 h6 (25/24.987)", 24.987, 25.0),
            ("25 h6 (25,000/24,987)", 24.987, 25.0),
            ("25.000/24.987", 24.987, 25.0),
            ("24.987..25", 24.987, 25.0),
            ("24,987 … 25,000", 24.987, 25.0),
            ("4x Ø25 h6", 24.987, 25.0),
            ("2×25h6", 24.987, 25.0),
            ("18 f7", 17.966, 17.984),
            ("50 js9", 49.969, 50.031),
            ("25 ±5.0", 20.0, 30.0),
        ] {
            let (l, u) = limits(text);
            assert!((l - lower).abs() < 1e-9 && (u - upper).abs() < 1e-9, "{text}: {l} {u}");
        }
        let tolerance = read("24.987..25").unwrap();
        assert_eq!((tolerance.nominal_mm, tolerance.upper_mm, tolerance.lower_mm), (25.0, 0.0, -0.013));
    }

    #[test]
    fn modifiers_are_kept_in_every_spelling() {
        for (text, criterion) in [
            ("25h6 Ⓔ", SizeCriterion::Envelope),
            ("25h6(E)", SizeCriterion::Envelope),
            ("25 h6 E", SizeCriterion::Envelope),
            ("25 ±0.01 (e)", SizeCriterion::Envelope),
            ("24.987..25 Ⓔ", SizeCriterion::Envelope),
            ("25 (+0.1/-0.2) Ⓔ", SizeCriterion::Envelope),
            ("25 h6 Ⓛⓟ", SizeCriterion::TwoPoint),
            ("25 h6 (LP) ACS", SizeCriterion::TwoPoint),
            ("25 h6 ⒼⓃ", SizeCriterion::CircumscribedCylinder),
            ("25 h6 (GN) ACS", SizeCriterion::CircumscribedCircle),
        ] {
            assert_eq!(read(text).map(|t| t.criterion), Ok(criterion), "{text}");
        }
    }

    #[test]
    fn what_is_no_tolerance_is_refused_with_the_reason() {
        for (text, reason) in [
            ("25", "bare size"),
            ("25 mm", "bare size"),
            ("Ø25", "bare size"),
            ("25 (E)", "bare size"),
            ("", "nothing"),
            ("h6", "begins with its number"),
            ("x h6", "begins with its number"),
            ("NaN h6", "begins with its number"),
            ("25..24", "nothing between"),
            ("25 0/0", "nothing between"),
            ("0 h6", "500 mm"),
            ("25 h", "no grade"),
            ("25 h19", "IT18"),
            ("600 h6", "500 mm"),
            ("25 -0.013", "one deviation"),
            ("24.987-25", "one deviation"),
            ("25 0.1/0.2", "no sign"),
            ("25 0/-13", "micrometres"),
            ("25 ±5", "micrometres"),
            ("25 h6 (0/-0.021)", "two tolerances"),
            ("25 h7 0/-0.013", "stands beside it"),
            ("25 h6 (XY)", "no modifier"),
            ("25 h6 (E", "not closed"),
            ("25 h6 )", "not opened"),
            ("25/0.013", "carries its sign"),
            ("1.234.5 h6", "no number"),
            ("25 0/-13µm", "millimetres"),
            ("25 +0.1 0 -0.1", "no two deviations"),
        ] {
            let error = read(text).expect_err(text);
            let told = error.to_string();
            assert!(matches!(error, ToleranceError::Wrong { .. }) && told.contains(reason), "{text}: {told}");
            assert!(told.contains("25 h6"), "{told}");
        }
    }

    #[test]
    fn what_this_gauge_does_not_judge_is_refused_with_the_reason() {
        for (text, reason) in [
            ("25 H7", "class of a hole"),
            ("25 JS6", "class of a hole"),
            ("25 Js7", "class of a hole"),
            ("25 H7/h6", "fit"),
            ("25 h6/H7", "fit"),
            ("25 h6 (GG)", "hollows"),
            ("25 h6 (LP)/10", "length"),
            ("25 h6 Ⓜ", "ISO 2692"),
            ("2x 25 h6 CT", "several features"),
            ("25 h6 SCS", "cross-section"),
            ("25 h6 ⓈⓍ", "rank-order"),
            ("25 h6 A↔B", "between two marks"),
            ("25 h6 (E) (GN)", "stand together"),
            ("R12.5 ±0.01", "radius"),
            ("M10 6g", "thread"),
            ("SØ25 h6", "sphere"),
            ("25 max", "one limit"),
        ] {
            let error = read(text).expect_err(text);
            let told = error.to_string();
            assert!(
                matches!(error, ToleranceError::Unjudged { .. }) && told.contains(reason),
                "{text}: {told}"
            );
        }
    }
}
