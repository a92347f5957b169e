//! The word that was probably meant. In: a word and those that are known. Out: the one that
//! differs in the unit alone, or in few letters.

/// Fewest letters of a stem that stands for a whole name: shorter ones begin too many.
const LEAST_STEM: usize = 3;

/// Letters that may differ: a slip or two; three in long names.
fn most_letters(word: &str) -> usize {
    match word.chars().count() {
        0..=3 => 1,
        4..=8 => 2,
        _ => 3,
    }
}

/// The candidate that was probably meant.
pub(super) fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase().replace(['-', ' '], "_");
    let stem = word.rsplit_once('_').map_or(word.as_str(), |(stem, _)| stem);
    let distance = |candidate: &&&'a str| edit_distance(candidate, &word);
    let of_stem = candidates.iter().filter(|c| stem.len() >= LEAST_STEM && c.starts_with(stem));
    let by_letters =
        || candidates.iter().min_by_key(distance).filter(|c| edit_distance(c, &word) <= most_letters(&word));
    of_stem.min_by_key(distance).or_else(by_letters).copied()
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_slips_are_found_and_strangers_are_not() {
        let tables = ["part", "optics", "seed", "scan", "name", "masters"];
        assert_eq!(nearest("optik", &tables), Some("optics"));
        assert_eq!(nearest("master", &tables), Some("masters"));
        assert_eq!(nearest("lens", &tables), None);
        assert_eq!(nearest("length_cm", &["length_mm", "station_mm"]), Some("length_mm"));
        assert_eq!(nearest("mono13", &["mono8", "mono12", "mono16"]), Some("mono12"));
        assert_eq!(nearest("Length-mm", &["length_mm", "station_mm"]), Some("length_mm"));
    }
}
