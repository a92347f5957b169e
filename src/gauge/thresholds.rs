//! Every threshold of the instrument, by name: what `shadowgauge study limits` varies.
//!
//! A group that is not listed here is not varied; `tests/architecture.rs` counts the groups.

use super::edge::estimation::blur::BlurLimits;
use super::edge::estimation::blur_track::BlurTrackLimits;
use super::edge::estimation::censored_fit::joint::JointLimits;
use super::edge::estimation::censored_fit::score::ScoreLimits;
use super::edge::estimation::censored_fit::side_fit::SideFitLimits;
use super::edge::estimation::column_fit::ColumnFitLimits;
use super::edge::estimation::grey_ends::GreyEndLimits;
use super::edge::wire::clipped::WireClipLimits;
use super::edge::estimation::level_gradient::LevelGradientLimits;
use super::edge::estimation::levels::LevelLimits;
use super::edge::estimation::light_field::LightFieldLimits;
use super::edge::estimation::model_bias::ModelBiasLimits;
use super::edge::estimation::noise::NoiseLimits;
use super::edge::estimation::rounding::RoundingLimits;
use super::edge::estimation::scoring_table::ScoringTableLimits;
use super::edge::estimation::side_survey::SideSurveyLimits;
use super::edge::estimation::slanted_edge::SlantedEdgeLimits;
use super::edge::estimation::soft_knee::SoftKneeLimits;
use super::edge::model::edge_spread::EdgeSpreadLimits;
use super::edge::model::edge_table::EdgeTableLimits;
use super::edge::model::shape_terms::ShapeTermLimits;
use super::edge::model::systematic_residual::SystematicResidualLimits;
use super::edge::wire::frame::WireFrameLimits;
use super::edge::wire::joint_fit::WireFitLimits;
use super::edge::wire::rounding::WireRoundingLimits;
use super::limit::{Limit, Limits};

/// Every threshold with its default value.
#[must_use]
pub fn every() -> Vec<Limit> {
    [
        GreyEndLimits::list(),
        BlurLimits::list(),
        BlurTrackLimits::list(),
        JointLimits::list(),
        ScoreLimits::list(),
        SideFitLimits::list(),
        ColumnFitLimits::list(),
        LevelGradientLimits::list(),
        LevelLimits::list(),
        LightFieldLimits::list(),
        ModelBiasLimits::list(),
        NoiseLimits::list(),
        RoundingLimits::list(),
        ScoringTableLimits::list(),
        SideSurveyLimits::list(),
        SlantedEdgeLimits::list(),
        SoftKneeLimits::list(),
        EdgeSpreadLimits::list(),
        EdgeTableLimits::list(),
        ShapeTermLimits::list(),
        SystematicResidualLimits::list(),
        WireClipLimits::list(),
        WireFrameLimits::list(),
        WireFitLimits::list(),
        WireRoundingLimits::list(),
    ]
    .concat()
}
