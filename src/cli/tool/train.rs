//! `shadowgauge tool train`: a forest from flanks whose land was drawn by hand.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::nose::{frames, scale};
use super::strips;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::files::OutputFile;
use crate::gauge::flank::forest::file;
use crate::gauge::flank::forest::training::Growth;
use crate::gauge::flank::{
    Drawn, FlankSide, Forest, KnownEdge, Labelled, Raster, drawn, errors_um, locate, train,
};
use crate::measurement::flank_labels::{grey_mask, labelme_mask};
use crate::source::{Channel, listing};

/// Images up to which each of them is left out once; more are left out in five groups, which takes
/// five trainings (Hastie, Tibshirani, Friedman 2009, 7.10: five- or tenfold).
const GROUPS: usize = 5;

/// Largest distance of a land's upper border from the edge that is found, µm: masks drawn by hand
/// and edges that are chipped lie within it, another line of the body does not. What is farther off
/// is not learnt from and counts among the errors: the wrong edge is one of the measurement.
const MOST_OFF_UM: f64 = 25.0;

/// Arguments of `tool train`.
#[derive(Debug, clap::Args)]
pub(crate) struct TrainArgs {
    /// Folder of images, each with NAME.json (Labelme) or NAME_land.png (white where the land is).
    dir: PathBuf,
    /// Another folder of labelled images, by which the errors are stated; without one every image
    /// is left out of a training once.
    #[arg(long, value_name = "DIR")]
    test: Option<PathBuf>,
    /// Scale, µm per px in the plane of the flank.
    #[arg(long, value_name = "S", value_parser = scale)]
    um_per_px: f64,
    /// At which side of the cutting edge the flanks lie in all images.
    #[arg(long, value_enum, default_value_t = FlankSide::Any)]
    flank_side: FlankSide,
    /// File of the model, for `tool flank --model`.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Seed of the drawn pixels and features: the same bytes from the same images and seed.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// What the model states that it was trained on, instead of the number of images.
    #[arg(long, value_name = "TEXT")]
    trained_on: Option<String>,
    /// Write the rectified strips and their lands into this folder too: what a network is trained
    /// on that `tool flank --model FILE.onnx` is given.
    #[arg(long, value_name = "DIR")]
    strips: Option<PathBuf>,
    /// Channel of colour images.
    #[arg(long, default_value = "g")]
    channel: Channel,
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for a folder without labelled images, 3 for images and labels that cannot be read.
pub(crate) fn run(args: &TrainArgs) -> CommandResult {
    let paths = pictures(&args.dir)?;
    let test = args.test.as_deref().map(pictures).transpose()?;
    let out = OutputFile::claim(&args.out, paths.iter().chain(test.iter().flatten()).cloned())?;
    let (labelled, aside) = parted(all(args, &paths)?);
    if labelled.len() < 2 {
        return Err(Failure::refuse(format!(
            "{}: {} labelled images, at least 2 are needed: NAME.json of Labelme or NAME_land.png beside each image",
            args.dir.display(),
            labelled.len()
        )));
    }
    let others = test.map(|paths| all(args, &paths)).transpose()?;
    if others.as_ref().is_some_and(Vec::is_empty) {
        // no errors are not errors of 0
        return Err(Failure::refuse(
            "--test: no labelled image in which the edge is found, by which errors could be stated",
        ));
    }
    if let Some(dir) = &args.strips {
        strips::write(dir, &labelled)?;
    }
    let growth = Growth { seed: args.seed, ..Growth::default() };
    let pixels = drawn(&labelled, growth.seed);
    let mut forest = train(&pixels, &growth);
    let of_all = |(_, one): &(PathBuf, Labelled)| error_of(&forest, one);
    let (vb, vb_max) = match &others {
        Some(others) => rms(&others.par_iter().filter_map(of_all).collect::<Vec<_>>()),
        None => {
            let of_aside = aside.par_iter().filter_map(|one| error_of(&forest, one));
            rms(&[left_out(&labelled, &pixels, &growth), of_aside.collect()].concat())
        }
    };
    forest.facts.trained_on =
        args.trained_on.clone().unwrap_or_else(|| format!("{} labelled images", labelled.len()));
    (forest.facts.vb_error_um, forest.facts.vb_max_error_um) = (vb, vb_max);
    let bytes = file::write(&forest).map_err(Failure::fail)?;
    say_line!(
        "{} images; left out of the training their VB is off by {vb:.1} µm rms, VBmax by {vb_max:.1} µm; {} bytes",
        labelled.len(),
        bytes.len()
    );
    out.write(&bytes)?;
    Ok(Outcome::Done)
}

/// The images of a folder that are no masks.
fn pictures(dir: &Path) -> Result<Vec<PathBuf>, Failure> {
    let images = listing(dir).map_err(Failure::fail)?.images;
    let stem = |p: &Path| p.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(images.into_iter().filter(|p| !stem(p).ends_with("_land")).collect())
}

/// Those of the images that have a land and an edge.
fn all(args: &TrainArgs, paths: &[PathBuf]) -> Result<Vec<(PathBuf, Labelled)>, Failure> {
    let named = |path: &PathBuf| Ok(one(args, path)?.map(|labelled| (path.clone(), labelled)));
    let each: Vec<Option<(PathBuf, Labelled)>> =
        paths.par_iter().map(named).collect::<Result<_, Failure>>()?;
    Ok(each.into_iter().flatten().collect())
}

/// Flanks that are learnt from, and those whose edge is not the land's.
fn parted(all: Vec<(PathBuf, Labelled)>) -> (Vec<Labelled>, Vec<Labelled>) {
    let (mut learnt, mut aside) = (Vec::new(), Vec::new());
    for (path, labelled) in all {
        match labelled.off_edge_um().filter(|off| off.abs() > MOST_OFF_UM) {
            Some(off_um) => {
                tracing::warn!(
                    "{} is not learnt from: its land begins {off_um:.0} µm from the edge that is found, {MOST_OFF_UM} µm at most are; its error counts",
                    path.display()
                );
                aside.push(labelled);
            }
            None => learnt.push(labelled),
        }
    }
    (learnt, aside)
}

/// A labelled image; none where neither file stands beside it.
fn one(args: &TrainArgs, path: &Path) -> Result<Option<Labelled>, Failure> {
    let named = |path: &Path, e: &dyn std::fmt::Display| Failure::fail(format!("{}: {e}", path.display()));
    let (labels, mask) = (path.with_extension("json"), {
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        path.with_file_name(format!("{stem}_land.png"))
    });
    let read = |path: &Path| -> Result<(Raster, f32), Failure> {
        let Some(read) = frames(vec![path.to_owned()], args.channel).next() else {
            return Err(named(path, &"holds no image"));
        };
        let frame = read?.1;
        let full = frame.view().full_scale().unwrap_or(1.0);
        Ok((Raster::of(&frame.view()).map_err(|e| named(path, &e))?, full))
    };
    if !labels.is_file() && !mask.is_file() {
        tracing::warn!("{}: no {} and no {}", path.display(), labels.display(), mask.display());
        return Ok(None);
    }
    let (image, _) = read(path)?;
    let land = if labels.is_file() {
        let text = std::fs::read_to_string(&labels).map_err(|e| named(&labels, &e))?;
        labelme_mask(&text, (image.rows, image.columns)).map_err(|e| named(&labels, &e))?
    } else {
        let (grey, full) = read(&mask)?;
        if (grey.rows, grey.columns) != (image.rows, image.columns) {
            let text = format!(
                "{} x {} px, its image has {} x {}",
                grey.rows, grey.columns, image.rows, image.columns
            );
            return Err(named(&mask, &text));
        }
        grey_mask(&grey, full)
    };
    match locate(&image, args.um_per_px, KnownEdge { side: args.flank_side, shape: None }) {
        Ok(flank) => Ok(Some(Labelled::new(flank, &land))),
        Err(e) => {
            // of a flank without an edge nothing is learnt; what remains is counted
            tracing::warn!("{} is left out: {e}", path.display());
            Ok(None)
        }
    }
}

/// Errors of VB and VBmax of images that are left out in turn, µm.
fn left_out(labelled: &[Labelled], pixels: &[Vec<Drawn>], growth: &Growth) -> Vec<(f64, f64)> {
    let groups = labelled.len().min(GROUPS);
    let of = |group: usize| {
        let others = pixels.iter().enumerate().filter(|(k, _)| k % groups != group).map(|(_, l)| l);
        let forest = train(others, growth);
        let own = labelled.iter().enumerate().filter(|(k, _)| k % groups == group);
        own.filter_map(|(_, l)| error_of(&forest, l)).collect::<Vec<_>>()
    };
    (0..groups).into_par_iter().flat_map_iter(of).collect()
}

/// Errors of VB and VBmax, µm; none of a flank that is not measured since another border could be
/// its edge.
fn error_of(forest: &Forest, one: &Labelled) -> Option<(f64, f64)> {
    one.flank.certain().is_ok().then(|| errors_um(forest, one))
}

/// Root mean squares of errors of VB and VBmax, µm.
fn rms(errors: &[(f64, f64)]) -> (f64, f64) {
    let n = errors.len().max(1) as f64;
    let of = |of: fn(&(f64, f64)) -> f64| (errors.iter().map(|e| of(e).powi(2)).sum::<f64>() / n).sqrt();
    (of(|e| e.0), of(|e| e.1))
}
