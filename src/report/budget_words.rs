//! An uncertainty budget as rows of a table and in words.

use crate::gauge::budget::Budget;
use crate::gauge::stated::stated;

/// Columns of [`budget_rows`].
pub(crate) const BUDGET_HEADER: [&str; 6] = ["source", "input", "distribution", "share", "u / µm", "% of u²"];

/// The rows of a budget, largest first.
pub(crate) fn budget_rows(budget: &Budget) -> Vec<Vec<String>> {
    let total = budget.u_mm().powi(2);
    let mut rows: Vec<_> = budget.contributions.iter().collect();
    rows.sort_by(|a, b| b.u_mm.total_cmp(&a.u_mm));
    rows.into_iter()
        .map(|c| {
            vec![
                c.source.clone(),
                c.input.clone(),
                c.shape.as_str().to_owned(),
                format!("{:?}", c.share).to_lowercase(),
                format!("{:.4}", 1e3 * c.u_mm),
                format!("{:.2}", 1e2 * c.u_mm * c.u_mm / total),
            ]
        })
        .collect()
}

/// The result of a budget in words, U and value to the place of U's second significant digit (GUM
/// 7.2.6); U is k·u.
pub(super) fn budget_words(budget: &Budget, k: f64) -> String {
    let expanded_mm = k * budget.u_mm();
    let um = |u_mm: f64| stated(0.0, 1e3 * u_mm)[1].clone();
    format!(
        "D = {} mm, u = {} µm (random {}, common {}), U = {} µm at k = {k:.2}.",
        stated(budget.diameter_mm, expanded_mm)[0],
        um(budget.u_mm()),
        um(budget.u_random_mm()),
        um(budget.u_common_mm()),
        um(expanded_mm)
    )
}
