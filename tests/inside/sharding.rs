//! Studies in shards: joined, they print what the unsplit study prints, byte for byte; shards that
//! do not belong together are refused by name.

use std::path::{Path, PathBuf};
use std::process::Output;

use shadowgauge::studies::contamination_plan::ContaminationPlan;
use shadowgauge::studies::coverage::{Class, CoveragePlan};
use shadowgauge::studies::sharding::{SceneStudy, ShardOf, outcomes};

use crate::inside::support::program::{said, shadowgauge, text};

/// A coverage study of few scenes.
const COVERAGE: [&str; 8] = ["coverage", "--scenes", "3", "--class", "noise", "--class", "mixed", "--json"];

fn study(words: &[&str], more: &[&str]) -> Output {
    shadowgauge(["study"].iter().chain(words).chain(more))
}

/// The shards of a study in a folder, by their files.
fn shards(words: &[&str], of: u64, folder: &Path) -> Vec<PathBuf> {
    let folder_text = folder.to_str().unwrap();
    for number in 1..=of {
        let done = study(words, &["--shard", &format!("{number}/{of}"), "--shard-dir", folder_text]);
        assert!(done.status.success(), "{}", said(&done));
    }
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert_eq!(files.len() as u64, of, "{files:?}");
    files
}

fn merge(files: &[PathBuf]) -> Output {
    let files = files.iter().map(|file| file.to_str().unwrap());
    shadowgauge(["study", "merge", "--json"].into_iter().chain(files))
}

#[test]
fn joined_shards_print_what_the_unsplit_study_prints() {
    let whole = study(&COVERAGE, &[]);
    assert!(whole.status.success(), "{}", said(&whole));
    for of in [1, 3, 7] {
        let folder = tempfile::tempdir().unwrap();
        let mut files = shards(&COVERAGE, of, folder.path());
        files.reverse();
        let joined = merge(&files);
        assert!(joined.status.success(), "{of} shards: {}", said(&joined));
        assert_eq!(text(&joined.stdout), text(&whole.stdout), "{of} shards");
    }
}

/// `study machine-coverage` of few machines.
const MACHINES: [&str; 6] =
    ["machine-coverage", "configs/machine_coverage.toml", "--machines", "4", "--json", "--seed=3"];

#[test]
fn machines_joined_print_what_the_unsplit_study_prints() {
    let whole = study(&MACHINES, &[]);
    let folder = tempfile::tempdir().unwrap();
    let joined = merge(&shards(&MACHINES, 3, folder.path()));
    // four machines may lie outside 94 to 96 %: whichever it is, merge says the same
    assert!(matches!(whole.status.code(), Some(0 | 1)), "{}", said(&whole));
    assert_eq!(joined.status.code(), whole.status.code(), "{}", said(&joined));
    assert_eq!(text(&joined.stdout), text(&whole.stdout));
}

#[test]
fn studies_that_cannot_be_split_are_refused_with_the_reason() {
    for (name, reason) in [("nose", "one generator"), ("controllers", "--shafts"), ("washers", "images")] {
        let output = shadowgauge(["study", name, "--shard", "1/2"]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(reason), "{name}: {}", said(&output));
        assert!(said(&output).contains("machine-coverage"), "{name}: {}", said(&output));
    }
}

#[test]
fn a_shard_that_is_there_is_left_and_one_that_was_lost_is_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let files = shards(&COVERAGE, 2, folder.path());
    let (bytes, time) = (std::fs::read(&files[0]).unwrap(), files[0].metadata().unwrap().modified().unwrap());
    std::fs::remove_file(&files[1]).unwrap();
    let again = shards(&COVERAGE, 2, folder.path());
    assert_eq!(again, files);
    assert_eq!(files[0].metadata().unwrap().modified().unwrap(), time, "it was written again");
    assert_eq!(std::fs::read(&files[0]).unwrap(), bytes);
}

#[test]
fn shards_that_do_not_belong_together_are_refused_by_name() {
    let [folder, other, more] = std::array::from_fn(|_| tempfile::tempdir().unwrap());
    let files = shards(&COVERAGE, 2, folder.path());
    let seeded = [&COVERAGE[..], &["--seed", "8"][..]].concat();
    let of_another_seed = shards(&seeded, 2, other.path());
    let larger = ["coverage", "--scenes", "4", "--class", "noise", "--class", "mixed"];
    let of_another_config = shards(&larger, 2, more.path());
    let refused = |files: &[PathBuf], words: &[&str]| {
        let output = merge(files);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(output.stdout.is_empty());
        for word in words {
            assert!(
                said(&output).replace(' ', "").contains(&word.replace(' ', "")),
                "{word}: {}",
                said(&output)
            );
        }
    };
    let name = |file: &PathBuf| file.file_name().unwrap().to_str().unwrap().to_owned();
    refused(
        &[files[0].clone(), of_another_seed[1].clone()],
        &[&name(&of_another_seed[1]), "its seed is 8, not 1"],
    );
    refused(&[files[0].clone(), of_another_config[1].clone()], &["the number of its scenes is 8, not 6"]);
    refused(&[files[0].clone(), files[0].clone()], &["are both shard 1 of 2"]);
    refused(&files[1..], &["of 2 shards these are missing: 1"]);
    let damaged = folder.path().join("damaged.parquet");
    std::fs::write(&damaged, &std::fs::read(&files[1]).unwrap()[..200]).unwrap();
    refused(&[files[0].clone(), damaged], &["damaged.parquet is no shard"]);
    // The same name in place of another study's shard.
    let taken = study(&seeded, &["--shard", "1/2", "--shard-dir", folder.path().to_str().unwrap()]);
    assert_eq!(taken.status.code(), Some(2), "{}", said(&taken));
    assert!(said(&taken).contains("its seed is 1, not 8"), "{}", said(&taken));
}

/// Outcomes of a study by itself, and put together from the rows of its shards.
fn by_shards<S: SceneStudy>(plan: &S, of: u64) -> (Vec<S::Outcome>, Vec<S::Outcome>)
where
    S::Error: std::fmt::Debug,
{
    let bench = plan.bench().unwrap();
    let whole = outcomes(plan, &bench, 0..plan.scenes(), &|| {}).unwrap();
    let mut rows = Vec::new();
    for number in 1..=of {
        let scenes = ShardOf { number, of }.scenes(plan.scenes());
        let found = outcomes(plan, &bench, scenes.clone(), &|| {}).unwrap();
        rows.extend(scenes.zip(found.iter().map(S::row)));
    }
    rows.sort_by_key(|(number, _)| *number);
    (whole, rows.iter().map(|(_, row)| S::outcome(row).unwrap()).collect())
}

#[test]
fn every_scene_follows_from_its_number_alone() {
    let coverage = CoveragePlan { scenes: 6, seed: 5, only: vec![Class::Certificates, Class::Overexposed] };
    let (whole, split) = by_shards(&coverage, 5);
    // an outcome without a value is no number, and equals none
    assert_eq!(format!("{whole:?}"), format!("{split:?}"));
    let contamination = ContaminationPlan { frames: 1, clean: 2, seed: 5 };
    let (whole, split) = by_shards(&contamination, 3);
    assert_eq!(whole, split);
    let [whole, split] = [whole, split].map(|o| serde_json::to_string(&contamination.result(&o)).unwrap());
    assert_eq!(whole, split);
}

#[test]
fn the_whole_study_has_as_many_scenes_as_its_classes() {
    let plan = CoveragePlan { scenes: 40, seed: 1, only: Vec::new() };
    let class_scenes = 8 * 5 + 7 * 2 + 2 * 10 + 4 * 2 + 2 * 2;
    assert_eq!(plan.scenes(), class_scenes);
}
