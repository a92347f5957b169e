//! `shadowgauge nc`: the offsets of a run, or of the next part, as an NC program.
//!
//! In: a run folder, a job with the state of its offsets (`from_state`), or a model of a part
//! (`model`). Out: a program that has passed its replay, an air cut of it, or the list of a dry
//! run.

mod args;
mod bar_args;
mod from_state;
mod machine_data;
mod model;
mod pass;

pub(crate) use self::args::NcArgs;

use std::path::{Path, PathBuf};

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::ConfigText;
use crate::cli::run::model::is_model;
use crate::config;
use crate::files::OutputFile;
use crate::job::Job;
use crate::nc::{
    self, AirCut, MacroProgram, NcError, NcSettings, ProbingProgram, Qualification, ScanProgram,
    TurningProgram, Written,
};
use crate::run_folder::RunFolder;

use self::args::Form;
use self::machine_data::in_file;
use self::pass::Pass;

/// Largest residual of the offsets from a line, mm of diameter: half a micrometre.
const LINE_TOLERANCE_MM: f64 = 0.0005;

/// Writes the program or lists the dry run.
///
/// # Errors
/// Exit 2 for a pass, a machine file or offsets that are refused, 3 for a run folder that cannot be
/// read.
pub(crate) fn run(args: &NcArgs) -> CommandResult {
    if is_model(&args.run) {
        let (text, inputs) = model::program(args)?;
        return put(args, &text, inputs);
    }
    args.model.only_for_models(&args.run)?;
    args.bar.only_for_models(&args.run)?;
    let source = match &args.state {
        Some(state) => of_state(args, state)?,
        None => of_run(args)?,
    };
    let Source { job, settings, pass, inputs } = source;
    let text = match args.form {
        _ if args.scan => scan(args, &job, &settings, &pass?)?,
        _ if args.air && (args.form != Form::Knots || args.dry_run) => {
            return Err(Failure::refuse(
                "--air raises the program of --form knots: leave --form and --dry-run out",
            ));
        }
        Form::Knots => knots(args, &settings, &pass?)?,
        Form::Macro => line(args, &job, &settings, &pass?)?,
        Form::Probing => probing(args, &job, &settings, &pass?)?,
        Form::Qualify => qualify(args, &settings)?,
    };
    put(args, &text, inputs)
}

/// The program into its file, or to stdout.
fn put(args: &NcArgs, text: &str, inputs: Vec<PathBuf>) -> CommandResult {
    match &args.out {
        Some(path) => {
            OutputFile::claim(path, inputs)?.write(text.as_bytes())?;
        }
        None => say!("{text}"),
    }
    Ok(Outcome::Done)
}

/// What a program is made from.
struct Source {
    job: Job,
    settings: NcSettings,
    /// The pass, where there is one: a qualification needs none.
    pass: Result<Pass, Failure>,
    /// Files that the output may not replace.
    inputs: Vec<PathBuf>,
}

fn of_run(args: &NcArgs) -> Result<Source, Failure> {
    let folder = RunFolder::open(&args.run).map_err(Failure::fail)?;
    let text = folder.config_text().map_err(Failure::fail)?;
    let name = folder.path().join("run.toml").display().to_string();
    let job = config::parse(&text, &name).map_err(Failure::refused)?;
    let settings = settings(args, &job, None)?;
    let rows = folder.offsets().map_err(Failure::fail);
    let pass = rows.and_then(|rows| Pass::of(&job, &rows, args.pass));
    let inputs = folder.files().into_iter().chain(args.machine.clone()).collect();
    Ok(Source { job, settings, pass, inputs })
}

fn of_state(args: &NcArgs, state: &Path) -> Result<Source, Failure> {
    if matches!(args.form, Form::Probing | Form::Qualify) {
        return Err(Failure::refuse(
            "--state has offsets: --form probing makes its own at the machine, --form qualify uses none",
        ));
    }
    let job = config::load(&args.run).map_err(Failure::refused)?;
    let (pass, part_number) = from_state::next_part(&job, state, args.pass)?;
    let settings = settings(args, &job, Some(part_number))?;
    let inputs = [args.run.clone(), state.to_owned()].into_iter().chain(args.machine.clone()).collect();
    Ok(Source { job, settings, pass: Ok(pass), inputs })
}

/// The settings of the machine file, otherwise the run's own where they are for this control.
/// `next` is the number of the part where neither is given on the command line.
fn settings(args: &NcArgs, job: &Job, next: Option<u32>) -> Result<NcSettings, Failure> {
    let own = job.nc.as_ref().filter(|nc| nc.dialect == args.dialect);
    let part_number = |settings: NcSettings| NcSettings {
        part_number: args.part.or(next).unwrap_or(settings.part_number),
        ..settings
    };
    let Some(path) = &args.machine else {
        let settings = part_number(own.map_or_else(NcSettings::default, |nc| nc.machine.clone()));
        settings.validate().map_err(Failure::refuse)?;
        return Ok(settings);
    };
    let file = ConfigText::read(path)?;
    let settings = part_number(file.parse()?);
    settings.validate().map_err(|error| in_file(&file, error.into()))?;
    Ok(settings)
}

/// The text of a program, with a note on the uncut length. A dry run lists the offsets even where
/// machine data are missing; the note then states that the program itself would be refused.
fn written<P>(args: &NcArgs, program: Result<Written<P>, NcError>) -> Result<String, Failure> {
    match program {
        Ok(written) => {
            tracing::warn!("{}", written.uncut);
            Ok(written.text)
        }
        Err(open @ NcError::Unstated { .. }) if args.dry_run => {
            tracing::warn!("the program itself would be refused: {open}");
            Ok(String::new())
        }
        Err(other) => Err(Failure::refuse(other)),
    }
}

fn knots(args: &NcArgs, settings: &NcSettings, pass: &Pass) -> Result<String, Failure> {
    let program = TurningProgram {
        plan: &pass.plan,
        settings,
        piece: &pass.piece,
        limits_mm: pass.limits_mm,
        reason: &pass.reason,
    };
    if args.air {
        return written(args, AirCut { of: program }.write(args.dialect));
    }
    let written = written(args, program.write(args.dialect))?;
    if args.dry_run {
        let path = nc::Path::new(&pass.plan, settings, args.dialect).map_err(Failure::refuse)?;
        return Ok(nc::dry_run(&pass.old, &pass.plan, &path, &pass.reason));
    }
    Ok(written)
}

/// Refuses a form of program that cuts a cylinder alone.
fn one_diameter(pass: &Pass, form: &str) -> Result<(), Failure> {
    match pass.plan.form.contour() {
        None => Ok(()),
        Some(contour) => Err(Failure::refuse(format!(
            "--form {form} cuts one diameter, and the run's [shaft] contour has {} sections: use --form knots",
            contour.sections.len()
        ))),
    }
}

fn line(args: &NcArgs, job: &Job, settings: &NcSettings, pass: &Pass) -> Result<String, Failure> {
    one_diameter(pass, "macro")?;
    // x from the free end, as a share of the length: the paper's positions
    let length_mm = job.part.length_mm;
    let x: Vec<f64> = pass.plan.station_z_mm.iter().map(|z| (length_mm - z) / length_mm).collect();
    let fitted = nc::fit_line(&x, &pass.plan.offset.o_mm)
        .ok_or_else(|| Failure::refuse("a line needs offsets at two stations or more"))?;
    if fitted.largest_residual > LINE_TOLERANCE_MM {
        return Err(Failure::refuse(format!(
            "a line leaves {:.4} mm of the offsets of pass {} (limit {LINE_TOLERANCE_MM} mm): use --form knots, or run \
             with --controller lsq and its line",
            fitted.largest_residual, pass.plan.pass
        )));
    }
    let program = MacroProgram {
        line: fitted,
        unit_mm: 1.0,
        diameter_mm: (pass.plan.nominal_mm, pass.plan.nominal_mm),
        piece: pass.piece.clone(),
        pass: pass.plan.pass,
        cutting: job.cutting,
        limits_mm: pass.limits_mm,
        settings,
    };
    let written = written(args, program.write(args.dialect))?;
    if args.dry_run {
        let v = program.values();
        return Ok(format!(
            "pass {}: #802 = {:.6}, #803 = {:.6}, #804 = {:.6}, #805 = {:.6} mm; X {:.5} at x = 1/6, {:.5} at x = 1\n\
             reason: {}\n",
            pass.plan.pass, fitted.b, fitted.a, v.v804, v.v805, v.v810, v.v811, pass.reason
        ));
    }
    Ok(written)
}

/// The scan of the run's plan, or the table of its stops.
fn scan(args: &NcArgs, job: &Job, settings: &NcSettings, pass: &Pass) -> Result<String, Failure> {
    if args.air || args.form != Form::Knots {
        return Err(Failure::refuse("--scan cuts nothing and probes nothing: leave --form and --air out"));
    }
    let plan = job.loop_job().scan_plan();
    let program = ScanProgram { plan: &plan, settings, piece: &pass.piece, pass: pass.plan.pass };
    if args.dry_run {
        return program.stops().map(|stops| nc::stop_list(&stops)).map_err(Failure::refuse);
    }
    written(args, program.write(args.dialect))
}

fn qualify(args: &NcArgs, settings: &NcSettings) -> Result<String, Failure> {
    if args.dry_run || args.pass.is_some() {
        return Err(Failure::refuse(
            "--form qualify touches a reference, no part: --pass and --dry-run do not apply",
        ));
    }
    let qualification = Qualification::new(settings).map_err(Failure::refuse)?;
    qualification.write(args.dialect).map(|written| written.text).map_err(Failure::refuse)
}

fn probing(args: &NcArgs, job: &Job, settings: &NcSettings, pass: &Pass) -> Result<String, Failure> {
    one_diameter(pass, "probing")?;
    if pass.plan.pass < 2 {
        return Err(Failure::refuse(
            "pass 1 cuts the blank: a program that probes corrects what the pass before left; give --pass 2 or later",
        ));
    }
    let program = ProbingProgram {
        nominal_mm: pass.plan.nominal_mm,
        piece: pass.piece.clone(),
        pass: pass.plan.pass,
        cutting: job.cutting,
        limits_mm: pass.limits_mm,
        settings,
    };
    if args.dry_run {
        return Err(Failure::refuse(
            "--form probing makes its offsets at the machine: there is none to list",
        ));
    }
    written(args, program.write(args.dialect))
}
