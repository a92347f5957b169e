//! Which head has the smaller U in use.

use serde::Serialize;

use super::figures::HeadFigures;

/// Heads whose U differ by less are taken as equal: U is given to two digits, of which the second
/// is worth 1 to 10 %, and no budget is known better.
const EQUAL: f64 = 0.05;

/// The comparison of heads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct HeadVerdict {
    /// The head with the smallest U in use; none where no head measures.
    pub best: Option<String>,
    /// Heads whose U is the same within 5 %.
    pub equal: Vec<String>,
    /// Why, in words.
    pub words: String,
}

impl HeadVerdict {
    /// Of heads before the same part.
    pub(super) fn of(heads: &[HeadFigures]) -> Self {
        let u_um = |head: &HeadFigures| head.in_use.as_ref().map(|budget| budget.expanded_u_um);
        let measuring = || heads.iter().filter_map(|head| Some((head, u_um(head)?)));
        let Some((best, least_um)) = measuring().min_by(|a, b| a.1.total_cmp(&b.1)) else {
            let words = format!("No head measures this part in use: {}.", refusals(heads).join("; "));
            return Self { best: None, equal: Vec::new(), words };
        };
        let others = || measuring().filter(|(head, _)| head.name != best.name);
        let equal: Vec<String> = others()
            .filter(|(_, um)| *um <= (1.0 + EQUAL) * least_um)
            .map(|(head, _)| head.name.clone())
            .collect();
        let mut words = format!(
            "{}: U = {least_um:.3} µm at {} mm, {} µs and {} rev/min",
            best.name,
            best.diameter_mm,
            short(best.optics.exposure_us),
            short(best.motion.rpm)
        );
        if !equal.is_empty() {
            words += &format!("; no different within 5 %: {}", equal.join(", "));
        }
        let worse = others().filter(|(head, _)| !equal.contains(&head.name));
        for (head, um) in worse {
            words += &format!("; {}: {um:.3} µm, {:.2} times as much", head.name, um / least_um);
        }
        for refusal in refusals(heads) {
            words += &format!("; {refusal}");
        }
        Self { best: Some(best.name.clone()), equal, words: words + "." }
    }
}

/// Heads that measure nothing in use, and why.
fn refusals(heads: &[HeadFigures]) -> Vec<String> {
    let why = |head: &HeadFigures| {
        let refused = head.motion.refused.as_ref()?;
        Some(format!("{} measures nothing at {} rev/min: {refused}", head.name, short(head.motion.rpm)))
    };
    heads.iter().filter_map(why).collect()
}

/// A number without needless decimals.
fn short(value: f64) -> String {
    if value.fract().abs() < 1e-9 { format!("{value:.0}") } else { format!("{value:.1}") }
}
