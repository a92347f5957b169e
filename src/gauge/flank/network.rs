//! A network of the user's for the land of a flank: an ONNX file, by `rten`.
//!
//! In: one tensor, float32 `[1, 1, rows, columns]`, the strip along the edge as the forest's
//! features see it: columns 4 µm apart along the edge, rows 2 µm apart at right angles to it,
//! the first 60 above the reference (the air), the other 450 below (the flank); grey values
//! less the air's level over the flank's light, -1 to 3, 0 the air. Columns are as many as the
//! edge is long. With the file's metadata `multiple = N` both sizes are brought to multiples of N
//! by repeating the last row and column.
//!
//! Out: one tensor of that size: the probability that a pixel is worn land, 0 to 1, or with
//! `output = logit` its log-odds. Metadata `vb_error_um` and `vb_max_error_um` are the root mean
//! square errors of VB and VBmax on flanks that the network was not trained on, µm; without them
//! no uncertainty is stated. The network is asked twice, as the strip is and mirrored along the
//! edge; the border follows from the mean, the disagreement goes into u as that of the forest's
//! groups does.

use rten::{DataType, Dimension, Model, Value, ValueType};

use super::error::FlankError;
use super::forest::file::MAGIC;
use super::land::{Land, below, border};
use super::limits::FlankLimits;
use super::model::{LandModel, ModelErrors};
use super::raster::Raster;
use super::strip::{Frame, normalised};

/// A network, read and tried.
#[derive(Debug)]
pub(crate) struct Network {
    model: Model,
    multiple: usize,
    logit: bool,
    errors: ModelErrors,
}

impl Network {
    /// Reads the bytes of an ONNX file and tries the network on an empty strip.
    ///
    /// # Errors
    /// Bytes that are no ONNX file; other inputs, outputs, ranks or sizes than described above;
    /// metadata that make no sense; answers that are no numbers or no probabilities.
    pub(crate) fn read(bytes: Vec<u8>) -> Result<Self, FlankError> {
        if bytes.starts_with(MAGIC.as_bytes()) {
            return refused("a forest of `tool train`, not an ONNX file: give it another ending than .onnx");
        }
        let model = Model::load(bytes)
            .map_err(|e| FlankError::Model(format!("no ONNX file that can be used: {e}")))?;
        let multiple = match model.metadata().get("multiple") {
            None => 1,
            Some(text) => match text.trim().parse() {
                // more than half of the rows would be padding
                Ok(n) if (1..=strip_rows() / 2).contains(&n) => n,
                _ => {
                    return refused(format!(
                        "metadata multiple = {text}: 1 to {} is needed",
                        strip_rows() / 2
                    ));
                }
            },
        };
        let logit = match model.metadata().get("output").map(str::trim) {
            None | Some("probability") => false,
            Some("logit") => true,
            Some(text) => {
                return refused(format!("metadata output = {text}: `probability` or `logit` is needed"));
            }
        };
        let errors = stated_errors(&model)?;
        let network = Self { model, multiple, logit, errors };
        network.takes_strips()?;
        network.probability(&Raster::new(strip_rows(), strip_rows()))?;
        Ok(network)
    }

    /// One input and one output, the input of float32 and rank 4 with free columns.
    fn takes_strips(&self) -> Result<(), FlankError> {
        let counts = [self.model.input_ids().len(), self.model.output_ids().len()];
        if counts != [1, 1] {
            return refused(format!("{} inputs and {} outputs: one of each is needed", counts[0], counts[1]));
        }
        let input = self.model.node_info(self.model.input_ids()[0]);
        if let Some(kind) = input.as_ref().and_then(rten::NodeInfo::dtype)
            && kind != ValueType::Tensor(DataType::Float)
        {
            return refused(format!("an input of {kind:?}: float32 is needed"));
        }
        let Some(shape) = self.model.input_shape(0) else { return Ok(()) };
        let padded = strip_rows().next_multiple_of(self.multiple);
        let free = |at: usize, size: usize| match shape.get(at) {
            Some(Dimension::Fixed(n)) => *n == size,
            _ => true,
        };
        if shape.len() != 4 || !free(0, 1) || !free(1, 1) {
            return refused(format!("an input of shape {}: [1, 1, rows, columns] is needed", named(&shape)));
        }
        if !free(2, padded) || matches!(shape[3], Dimension::Fixed(_)) {
            return refused(format!(
                "an input of shape {}: {padded} rows and free columns are needed, a strip is as long as its edge; export the \
                 network with dynamic rows and columns",
                named(&shape)
            ));
        }
        Ok(())
    }

    /// The network's probabilities of a strip, of the strip's size.
    fn probability(&self, strip: &Raster) -> Result<Raster, FlankError> {
        let [rows, columns] = [strip.rows, strip.columns].map(|n| n.next_multiple_of(self.multiple));
        let padded = sized(strip, rows, columns);
        let failed = |e: &dyn std::fmt::Display| FlankError::Model(format!("the network fails: {e}"));
        let input = Value::from_shape([1, 1, rows, columns], padded.values).map_err(|e| failed(&e))?;
        let output = self.model.run_one(input.into(), None).map_err(|e| failed(&e))?;
        let kind = output.dtype();
        let (shape, values) = output.into_shape_vec::<f32, 4>().map_err(|e| {
            FlankError::Model(format!("an output of {kind:?}, {e}: float32 [1, 1, rows, columns] is needed"))
        })?;
        if shape != [1, 1, rows, columns] {
            return refused(format!(
                "an output of shape {shape:?} for an input of [1, 1, {rows}, {columns}]: the same is needed"
            ));
        }
        let found = sized(&Raster { rows, columns, values }, strip.rows, strip.columns);
        self.checked(&found)
    }

    /// Probabilities, checked.
    fn checked(&self, found: &Raster) -> Result<Raster, FlankError> {
        let place =
            |k: usize| format!("row {}, column {} of the strip", k / found.columns, k % found.columns);
        if let Some(k) = found.values.iter().position(|v| !v.is_finite()) {
            return refused(format!("the network gives {} at {}", found.values[k], place(k)));
        }
        if self.logit {
            return Ok(found.map(|v| (1.0 + (-v).exp()).recip()));
        }
        // a sigmoid in float32 rounds
        let within = -1e-4..=1.0 + 1e-4;
        match found.values.iter().position(|v| !within.contains(v)) {
            None => Ok(found.map(|v| v.clamp(0.0, 1.0))),
            Some(k) => refused(format!(
                "the network gives {} at {}, which is no probability; where it gives log-odds, state `output = logit` in the \
                 file's metadata",
                found.values[k],
                place(k)
            )),
        }
    }
}

impl LandModel for Network {
    fn land(&self, strip: &Raster, frame: &Frame, inside: &[usize]) -> Result<Land, FlankError> {
        let strip = normalised(strip, frame);
        let both = [self.probability(&strip)?, mirrored(&self.probability(&mirrored(&strip))?)];
        Ok(border(&below(&both, frame), frame, inside))
    }

    fn errors(&self) -> ModelErrors {
        self.errors
    }
}

/// The errors in the file's metadata: both, or none.
fn stated_errors(model: &Model) -> Result<ModelErrors, FlankError> {
    let of = |key: &str| {
        let Some(text) = model.metadata().get(key) else { return Ok(None) };
        match text.trim().parse::<f64>() {
            Ok(um) if um.is_finite() && um > 0.0 => Ok(Some(um)),
            _ => refused(format!("metadata {key} = {text}: a root mean square above 0 µm is needed")),
        }
    };
    match (of("vb_error_um")?, of("vb_max_error_um")?) {
        (Some(vb_um), Some(vb_max_um)) => Ok(ModelErrors { vb_um, vb_max_um }),
        (None, None) => Ok(ModelErrors { vb_um: f64::NAN, vb_max_um: f64::NAN }),
        _ => refused("metadata hold only one of vb_error_um and vb_max_error_um: give both, or none"),
    }
}

fn refused<T>(text: impl Into<String>) -> Result<T, FlankError> {
    Err(FlankError::Model(text.into()))
}

/// Rows of every strip.
fn strip_rows() -> usize {
    let limits = FlankLimits::get();
    [limits.above_um, limits.depth_um].iter().map(|um| (um / limits.pitch_um) as usize).sum()
}

/// A shape in words.
fn named(shape: &[Dimension]) -> String {
    let one = |d: &Dimension| match d {
        Dimension::Fixed(n) => n.to_string(),
        Dimension::Symbolic(name) => name.clone(),
    };
    format!("[{}]", shape.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// Cut, or extended by the last row and column, to a size.
fn sized(of: &Raster, rows: usize, columns: usize) -> Raster {
    let value = |k: usize| of.at((k / columns).min(of.rows - 1), (k % columns).min(of.columns - 1));
    Raster { rows, columns, values: (0..rows * columns).map(value).collect() }
}

/// The other way round along the edge.
fn mirrored(of: &Raster) -> Raster {
    let mut out = of.clone();
    out.values.chunks_exact_mut(of.columns).for_each(<[f32]>::reverse);
    out
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::reference::EdgeLine;
    use super::*;

    /// A network of the tests (`tests/data/onnx/make.py`) by its name.
    macro_rules! network {
        ($name:literal) => {
            ($name, include_bytes!(concat!("../../../tests/data/onnx/", $name, ".onnx")).as_slice())
        };
    }

    const FILES: [(&str, &[u8]); 15] = [
        network!("threshold"),
        network!("bare"),
        network!("logit"),
        network!("lopsided"),
        network!("unet"),
        network!("log_odds_unstated"),
        network!("one_error"),
        network!("multiple_0"),
        network!("fixed_size"),
        network!("three_channels"),
        network!("rank_2"),
        network!("two_inputs"),
        network!("two_outputs"),
        network!("half_size"),
        network!("not_a_number"),
    ];

    fn file(name: &str) -> Vec<u8> {
        FILES.iter().find(|file| file.0 == name).unwrap_or_else(|| panic!("no {name}")).1.to_vec()
    }

    fn read(name: &str) -> Network {
        Network::read(file(name)).unwrap()
    }

    /// A strip of 2 µm a row without a curve.
    fn frame(columns: usize) -> Frame {
        let limits = FlankLimits::get();
        let length_px = (columns - 1) as f64 * limits.column_pitches + 0.5;
        let line = EdgeLine { from: DVec2::ZERO, along: DVec2::X, normal: DVec2::Y, length_px };
        Frame::about(line, limits.pitch_um, (limits.above_um, limits.depth_um))
    }

    /// Rows of land in a column: a step of 10 rows and a slope.
    fn land_rows(column: usize) -> usize {
        30 + column / 20 + if column >= 100 { 10 } else { 0 }
    }

    /// Air of 20, a land of 220 counts, a flank of 40: 1 and 0.1 after the strip is normalised.
    fn strip(frame: &Frame) -> Raster {
        let (rows, columns) = (frame.above + frame.below, frame.columns());
        let value = |k: usize| match (k / columns).checked_sub(frame.above) {
            None => 20.0,
            Some(depth) if depth < land_rows(k % columns) => 220.0,
            Some(_) => 40.0,
        };
        Raster { rows, columns, values: (0..rows * columns).map(value).collect() }
    }

    fn found(network: &Network, columns: usize) -> Land {
        let frame = frame(columns);
        assert_eq!(frame.columns(), columns);
        network.land(&strip(&frame), &frame, &vec![frame.above + frame.below; columns]).unwrap()
    }

    /// sigmoid(8 (1 − 0.5)) and sigmoid(8 (0.1 − 0.5)) are the probabilities on land and flank, so
    /// that the border lies where the grey value falls.
    #[test]
    fn a_threshold_finds_the_border_where_the_grey_value_falls() {
        let network = read("threshold");
        let strip = strip(&frame(203));
        let seen = network.probability(&normalised(&strip, &frame(203))).unwrap();
        for (row, odds) in [(0, -4.0f32), (60, 4.0), (509, -3.2)] {
            let by_hand = (1.0 + (-odds).exp()).recip();
            assert!((seen.at(row, 7) - by_hand).abs() < 1e-5, "{row}: {} {by_hand}", seen.at(row, 7));
        }
        for name in ["threshold", "logit", "bare"] {
            let land = found(&read(name), 203);
            for (column, depth_um) in land.depth_um.iter().enumerate() {
                let off = depth_um - 2.0 * land_rows(column) as f64;
                // at the step of 10 rows the path takes two columns
                let least = if (98..103).contains(&column) { 20.0 } else { 1e-9 };
                assert!(off.abs() <= least, "{name}, column {column}: {depth_um}");
            }
            assert_eq!(land.by_group_um.len(), 2);
            assert_eq!(land.by_group_um[0], land.by_group_um[1], "{name} is the same mirrored");
        }
    }

    /// The operators of a small U-Net against ONNX's own reference evaluator (`make.py`).
    #[test]
    fn the_operators_of_a_u_net_are_those_of_the_standard() {
        let (rows, columns) = (32, 48);
        let value = |k: usize| (0.3 * (k / columns) as f32).sin() * (0.2 * (k % columns) as f32).cos();
        let strip = Raster { rows, columns, values: (0..rows * columns).map(value).collect() };
        let seen = read("unet").probability(&strip).unwrap();
        let text = include_str!("../../../tests/data/onnx/unet.csv");
        let mut least_and_most = (1.0f32, 0.0f32);
        for line in text.lines().skip(1) {
            let [row, column, right] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
            let right: f32 = right.parse().unwrap();
            let ours = seen.at(row.parse().unwrap(), column.parse().unwrap());
            assert!((ours - right).abs() < 1e-5, "{line}: {ours}");
            least_and_most = (least_and_most.0.min(right), least_and_most.1.max(right));
        }
        assert!(least_and_most.1 - least_and_most.0 > 0.1, "a constant would pass: {least_and_most:?}");
    }

    /// A network that shifts everything by half a column disagrees with its mirror image where the
    /// border falls, and nowhere else.
    #[test]
    fn the_disagreement_with_the_mirror_image_is_kept() {
        let land = found(&read("lopsided"), 203);
        let apart: Vec<usize> =
            (0..203).filter(|c| land.by_group_um[0][*c] != land.by_group_um[1][*c]).collect();
        assert!(
            apart.iter().all(|c| land_rows(c.saturating_sub(3)) != land_rows((c + 3).min(202))),
            "{apart:?}"
        );
        assert!(!apart.is_empty());
    }

    #[test]
    fn errors_are_those_of_the_metadata_or_none() {
        assert_eq!(read("threshold").errors(), ModelErrors { vb_um: 5.0, vb_max_um: 12.0 });
        let none = read("bare").errors();
        assert!(none.vb_um.is_nan() && none.vb_max_um.is_nan());
    }

    /// Every file is wrong in one way; the refusal names it and what would be right.
    #[test]
    fn networks_of_another_kind_are_refused_in_words() {
        for (name, words) in [
            ("two_inputs", ["2 inputs and 1 outputs", "one of each"]),
            ("two_outputs", ["1 inputs and 2 outputs", "one of each"]),
            ("rank_2", ["[rows, columns]", "[1, 1, rows, columns] is needed"]),
            ("three_channels", ["[1, 3, rows, columns]", "[1, 1, rows, columns] is needed"]),
            ("fixed_size", ["[1, 1, 256, 256]", "dynamic rows and columns"]),
            ("half_size", ["[1, 1, 255, 255]", "[1, 1, 510, 510]"]),
            ("not_a_number", ["NaN at row 0, column 0", "network gives"]),
            ("log_odds_unstated", ["-4 at row 0, column 0", "output = logit"]),
            ("one_error", ["only one of", "give both, or none"]),
            ("multiple_0", ["multiple = 0", "1 to 255"]),
        ] {
            let error = Network::read(file(name)).map(|_| ()).unwrap_err().to_string();
            assert!(words.iter().all(|w| error.contains(w)), "{name}: {error}");
        }
    }

    /// Bytes that are no network are refused; a damaged one is refused or read, never a panic.
    #[test]
    fn what_is_no_onnx_file_is_refused() {
        for (bytes, word) in [
            (&b""[..], "no ONNX file"),
            (b"P5 640 480 255 of a picture", "no ONNX file"),
            (b"SGFLANK2{}\n", "a forest of `tool train`"),
        ] {
            let error = Network::read(bytes.to_vec()).map(|_| ()).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
        let good = file("threshold");
        for end in (0..good.len()).step_by(5) {
            let _ = Network::read(good[..end].to_vec());
        }
    }
}
