//! What the judgements in the table of `measure` mean: those that occur.

use crate::conformity::Judgement;
use crate::measurement::Verdict;

/// The judgements of the frames that were printed.
#[derive(Debug, Default)]
pub(super) struct Legend {
    seen: Vec<Verdict>,
}

impl Legend {
    /// Notes the judgement of one more frame.
    pub(super) fn note(&mut self, verdict: Verdict) {
        if !self.seen.contains(&verdict) {
            self.seen.push(verdict);
        }
    }

    /// The lines: a word and its meaning each; none where nothing was judged.
    fn lines(&self, probability: f64) -> Vec<String> {
        let occurs = |verdict: Verdict| self.seen.contains(&verdict);
        let words = Judgement::ALL.into_iter().filter(|judgement| occurs(Verdict::Is(*judgement)));
        let mut lines: Vec<String> =
            words.map(|judgement| format!("{}: {}", judgement.as_str(), judgement.meaning())).collect();
        if occurs(Verdict::NotProven) {
            lines.push("-: not measured, or may be another part's: not proven good".to_owned());
        }
        if !lines.is_empty() {
            let percent = 100.0 * probability;
            lines.push(format!("proven: with a probability of at least {percent} % (ISO 14253-1)"));
        }
        lines
    }

    /// Prints it.
    pub(super) fn print(&self, probability: f64) {
        let lines = self.lines(probability);
        if !lines.is_empty() {
            say_line!("judged by  {}", lines.join("\n           "));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn judgements_that_occur_are_explained() {
        let mut legend = Legend::default();
        legend.note(Verdict::NotJudged);
        assert!(legend.lines(0.95).is_empty());
        let judged = [Verdict::Is(Judgement::GO), Verdict::Is(Judgement::HH), Verdict::NotProven];
        judged.into_iter().chain(judged).for_each(|verdict| legend.note(verdict));
        let text = legend.lines(0.95);
        assert_eq!(text.len(), 4, "{text:?}");
        assert!(text[0].starts_with("HH: proven to lie above") && text[1].starts_with("GO: "), "{text:?}");
        assert!(text[3].contains("95 %"), "{text:?}");
    }
}
