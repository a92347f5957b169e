//! Arguments of the results beyond edges: tolerance, stations, averages, revolutions.

use crate::conformity::Tolerance;
use crate::gauge::diameter::reading_series::{Average, Averaging};
use crate::measurement::MeasureSettings;

/// What is stated of diameters.
#[derive(Debug, clap::Args)]
pub(crate) struct JudgeArgs {
    /// Tolerance of the part as on its drawing: "25 h6", "Ø25 ±0.01", "25 0/-0.013", "24.987..25",
    /// with (E) or (GN) where --turn is given; exit code 1 unless every value is proven good: each
    /// frame's largest diameter, its local sizes (means over about 65 columns, or over the stations
    /// of --station-mm) and its mean. Judged HH or LL: proven to lie above or below the limits; HI
    /// or LO: proven neither good nor bad, above or below the middle; GO: proven good.
    #[arg(long, value_name = "T")]
    tolerance: Option<Tolerance>,
    /// Probability of conformity to both limits behind GO (ISO 14253-1).
    #[arg(long, value_name = "P", default_value_t = 0.95)]
    conformance_probability: f64,
    /// Length of the stations that are given and judged, mm; without it 65 columns, as the largest
    /// diameter is found.
    #[arg(long, value_name = "MM", value_parser = length)]
    station_mm: Option<f64>,
    /// Least width of a stretch that counts for the largest diameter, columns; without it 5, as far
    /// as noise lets a narrow one be distinguished.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    stretch_columns: Option<u16>,
    /// Least width of a stretch that counts for the largest diameter, mm along the axis.
    #[arg(long, value_name = "MM", value_parser = length, conflicts_with = "stretch_columns")]
    stretch_mm: Option<f64>,
    /// Averages the means of successive frames: moving:N, median:N or recursive:W; in the table and
    /// the files it stands beside the frame's own mean, and it is judged in its place.
    #[arg(long, value_name = "HOW", value_parser = averaging)]
    average: Option<Averaging>,
    /// Coverage factor k of the expanded uncertainties; without it that of 95.45 % at the effective
    /// degrees of freedom: 2 where there are many.
    #[arg(long, value_name = "K", value_parser = length)]
    coverage_factor: Option<f64>,
    /// Uncertainty budget of every frame's largest diameter.
    #[arg(long)]
    budget: bool,
    /// Takes the frames as one turn (angles from frames.csv) and adds sizes, roundness, run-out and
    /// harmonics.
    #[arg(long)]
    turn: bool,
    /// Spindle angles of the frames of a turn in their order, degrees from one to the next.
    #[arg(long, value_name = "DEG", value_parser = length, requires = "turn")]
    angle_step: Option<f64>,
    /// Largest change of a diameter from one turn to the next that is accepted, µm; more (and more
    /// than noise explains) is a gap with the flag `implausible`.
    #[arg(long, value_name = "UM", default_value_t = 5.0, value_parser = length, requires = "turn")]
    turn_limit_um: f64,
    /// Takes every frame as another part: the statistics are those of a batch, and have Cp and Cpk.
    #[arg(long, conflicts_with_all = ["turn", "average"])]
    parts: bool,
    /// Seconds over which readings must agree before a diameter is good: until then, and while it
    /// changes (coolant that runs off, a part that cools), nothing is proven; what a test at 1 %
    /// false alarm cannot see is in U. With --turn the readings are means of whole turns.
    #[arg(long, value_name = "S", value_parser = length, conflicts_with = "parts")]
    settle_s: Option<f64>,
    /// Gives diameters of frames, too, that are blurred otherwise than the masters were (out of
    /// focus, moving), with a warning.
    #[arg(long)]
    accept_blur: bool,
    /// Gaussian filter of roundness, undulations per revolution (15, 50, 150).
    #[arg(long, value_name = "UPR", default_value_t = 50.0, value_parser = length)]
    cutoff_upr: f64,
}

fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a number above 0 is needed".to_owned()),
    }
}

fn averaging(text: &str) -> Result<Averaging, String> {
    let right = || "right would be moving:8, median:5 or recursive:0.2".to_owned();
    let (how, number) = text.split_once(':').ok_or_else(right)?;
    let averaging = match how {
        "moving" => Averaging::Moving { readings: number.parse().map_err(|_| right())? },
        "median" => Averaging::Median { readings: number.parse().map_err(|_| right())? },
        "recursive" => Averaging::Recursive { weight: number.parse().map_err(|_| right())? },
        _ => return Err(right()),
    };
    Average::new(averaging).map(|_| averaging).map_err(|e| e.to_string())
}

impl JudgeArgs {
    /// Whether anything here needs millimetres.
    pub(crate) fn needs_scale(&self) -> Option<&'static str> {
        [
            (self.tolerance.is_some(), "--tolerance"),
            (self.station_mm.is_some(), "--station-mm"),
            (self.stretch_mm.is_some(), "--stretch-mm"),
            (self.average.is_some(), "--average"),
            (self.budget, "--budget"),
            (self.turn, "--turn"),
            (self.settle_s.is_some(), "--settle-s"),
        ]
        .into_iter()
        .find_map(|(given, name)| given.then_some(name))
    }

    /// Whether the budgets are printed.
    pub(crate) fn shows_budgets(&self) -> bool {
        self.budget
    }

    /// The settings stated here.
    pub(crate) fn settings(&self) -> MeasureSettings {
        MeasureSettings {
            stretch_columns: self.stretch_columns,
            stretch_mm: self.stretch_mm,
            tolerance: self.tolerance,
            conformance_probability: self.conformance_probability,
            station_mm: self.station_mm,
            average: self.average.unwrap_or_default(),
            coverage_factor: self.coverage_factor,
            budget: self.budget,
            turn: self.turn,
            angle_step_deg: self.angle_step,
            turn_limit_um: self.turn_limit_um,
            parts: self.parts,
            accept_blur: self.accept_blur,
            settle_s: self.settle_s,
            cutoff_upr: self.cutoff_upr,
            ..MeasureSettings::default()
        }
    }
}
