//! What stays the same over all frames of a stream.

use std::sync::Arc;

use crate::gauge::edge::estimation::model_bias::Expected;
use crate::gauge::edge::model::edge_spread::{EdgeSpreadFunction, TabulatedEsf};
use crate::gauge::edge::model::systematic_residual::SystematicResidual;
use crate::gauge::settings::{EsfModel, GaugeSettings, Noise, Polarity};

/// Settings of a stream.
#[derive(Clone, Debug)]
pub(crate) struct StreamSettings {
    pub(crate) gauge: GaugeSettings,
    /// The edge-spread function of the settings.
    pub(crate) shape: EdgeSpreadFunction,
    /// What a calibration's masters left of the edge model, above and below.
    pub(crate) expected: [Option<Expected>; 2],
    pub(crate) columns: ColumnKind,
    /// Whether both sides may be worked on at once.
    pub(crate) splits: bool,
}

/// What neighbouring columns are.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ColumnKind {
    /// Whether neighbouring columns are readings one after the other: where their edges lie states
    /// nothing of a slope.
    pub(crate) level_lines: bool,
    /// Whether columns are copies of one another: their grey values pile up wherever they lie, and
    /// are alike in every row as a stuck row's.
    pub(crate) copies: bool,
}

impl StreamSettings {
    pub(crate) fn new(gauge: GaugeSettings) -> Self {
        let shape = match &gauge.esf {
            EsfModel::Table(samples) => {
                let table = TabulatedEsf::new(samples.reach_px(), |d| samples.at(d));
                EdgeSpreadFunction::Table(Arc::new(table))
            }
            EsfModel::Gaussian {} | EsfModel::Learnt {} | EsfModel::Optics {} => EdgeSpreadFunction::Gaussian,
        };
        Self { gauge, shape, expected: [None, None], columns: ColumnKind::default(), splits: true }
    }

    /// Expects of every edge what a calibration's masters left of the edge model.
    pub(crate) fn expect(&mut self, residual: Option<&SystematicResidual>) {
        self.expected = [0, 1].map(|side| residual.map(|r| Expected::new(r, side)));
    }

    /// −1 for bright parts on dark ground, so that the part is always the darker side.
    pub(crate) fn sign(&self) -> f32 {
        if self.gauge.polarity == Polarity::DarkOnBright { 1.0 } else { -1.0 }
    }

    /// Whether the noise is that of the frame itself.
    pub(crate) fn estimates_noise(&self) -> bool {
        matches!(self.gauge.noise, Noise::Estimated {})
    }
}
