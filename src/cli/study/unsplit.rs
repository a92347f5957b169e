//! Studies that no `--shard` splits, and why.

use std::ffi::OsString;

/// Name and reason of every study that is not of independent scenes.
pub(crate) const REASONS: [(&str, &str); 17] = [
    (
        "controllers",
        "a shaft of it leaves passes of every controller, which no row of a table holds; --shafts and --seed take parts of it",
    ),
    ("correlation", "it reads one table of readings and draws no scenes"),
    ("deflection", "it computes one line of compliance and draws no scenes"),
    ("factor", "it computes size errors from the compliance and draws no scenes"),
    ("flank", "its scenes follow a seed: --seed and --flanks or --tools take parts of them"),
    ("head", "it computes heads from their configs alone and draws no scenes"),
    ("in-process", "it is one job, whose passes follow one another"),
    ("limits", "every threshold is tried on the same scenes, which one process draws and keeps"),
    ("line-camera", "it times one machine's readings, which follow one another"),
    ("machine", "it computes one lathe's errors over its working space and draws no scenes"),
    ("nose", "places, directions and wear of its noses are drawn one after another from one generator"),
    ("optics", "it computes what moves one edge, cause by cause, and draws no random scenes"),
    ("parts", "a part of the batch begins with what was learned from those before it"),
    ("stability", "it computes poles and limits of controllers and draws no scenes"),
    ("tool", "every way to compensate is compared on the same four workpieces"),
    ("uncertainty", "its trials end where the figures of all of them together are stable"),
    ("washers", "it measures the images of a folder and draws no scenes"),
];

/// The refusal of `--shard` for a study that has none, by the program's arguments.
pub(crate) fn refusal(words: &[OsString]) -> Option<String> {
    let words: Vec<&str> = words.iter().map(|word| word.to_str().unwrap_or_default()).collect();
    let study = words.iter().position(|word| *word == "study")? + 1;
    let asks = |word: &&str| *word == "--shard" || word.starts_with("--shard=") || *word == "--shard-dir";
    let name = words.get(study).filter(|_| words[study..].iter().any(asks))?;
    let (_, reason) = REASONS.iter().find(|(own, _)| own == name)?;
    Some(format!(
        "study {name} cannot be split (--shard): {reason}. Studies of independent scenes are split: \
         contamination, coverage and machine-coverage"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_mistakes_keep_their_own_words() {
        let given = |words: &str| words.split(' ').map(OsString::from).collect::<Vec<_>>();
        assert_eq!(refusal(&given("shadowgauge study nose --shards 2")), None);
        assert_eq!(refusal(&given("shadowgauge study coverage --shard 1/2")), None);
        assert!(refusal(&given("shadowgauge -v study nose --shard=1/2")).is_some());
    }
}
