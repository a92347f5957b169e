//! What the judgements in the table of `measure` mean: those that occur.

use crate::conformity::Judgement;
use crate::measurement::{Measurement, Verdict};

/// The lines: a word and its meaning each; none where nothing was judged.
fn lines(frames: &[Measurement], probability: f64) -> Vec<String> {
    let occurs = |verdict: Verdict| frames.iter().any(|frame| frame.judgement == verdict);
    let words = Judgement::ALL.into_iter().filter(|judgement| occurs(Verdict::Is(*judgement)));
    let mut lines: Vec<String> =
        words.map(|judgement| format!("{}: {}", judgement.as_str(), judgement.meaning())).collect();
    if occurs(Verdict::NotProven) {
        lines.push("-: not measured, or may be another part's: not proven good".to_owned());
    }
    if !lines.is_empty() {
        lines.push(format!("proven: with a probability of at least {} % (ISO 14253-1)", 100.0 * probability));
    }
    lines
}

/// Prints the legend.
pub(super) fn print_legend(frames: &[Measurement], probability: f64) {
    let lines = lines(frames, probability);
    if !lines.is_empty() {
        say_line!("judged by  {}", lines.join("\n           "));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn judgements_that_occur_are_explained() {
        let frame = |judgement| Measurement { judgement, ..Measurement::default() };
        assert!(lines(&[frame(Verdict::NotJudged)], 0.95).is_empty());
        let judged = [Verdict::Is(Judgement::GO), Verdict::Is(Judgement::HH), Verdict::NotProven].map(frame);
        let text = lines(&judged, 0.95);
        assert_eq!(text.len(), 4, "{text:?}");
        assert!(text[0].starts_with("HH: proven to lie above") && text[1].starts_with("GO: "), "{text:?}");
        assert!(text[3].contains("95 %"), "{text:?}");
    }
}
