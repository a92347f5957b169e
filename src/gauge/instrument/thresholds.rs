//! Every threshold of the instrument, by name: what `shadowgauge study limits` varies.
//!
//! A group that is not listed here is not varied; `tests/architecture/constants.rs` requires every
//! group of the instrument here, one line each, a function a room.

use crate::gauge::calibration::adjustment::AdjustmentLimits;
use crate::gauge::calibration::error::CalibrationLimits;
use crate::gauge::calibration::file_checks::FileLimits;
use crate::gauge::calibration::finish::FinishLimits;
use crate::gauge::calibration::head_geometry::HeadGeometryLimits;
use crate::gauge::calibration::limb_difference::LimbLimits;
use crate::gauge::calibration::observation::ObservationLimits;
use crate::gauge::calibration::optical_setup::SetupLimits;
use crate::gauge::calibration::unstated::UnstatedLimits;
use crate::gauge::diameter::axis_line::AxisLimits;
use crate::gauge::diameter::bursts::BurstLimits;
use crate::gauge::diameter::field_midline::FieldMidlineLimits;
use crate::gauge::diameter::plausibility::PlausibilityLimits;
use crate::gauge::diameter::reading_scatter::SeriesLimits;
use crate::gauge::diameter::sections::SectionLimits;
use crate::gauge::diameter::station_mean::StationMeanLimits;
use crate::gauge::diameter::stations::StationLimits;
use crate::gauge::diameter::turn_scatter::TurnLimits;
use crate::gauge::edge::acceptance::AcceptanceLimits;
use crate::gauge::edge::estimation::blur::BlurLimits;
use crate::gauge::edge::estimation::blur_track::BlurTrackLimits;
use crate::gauge::edge::estimation::censored_fit::joint::JointLimits;
use crate::gauge::edge::estimation::censored_fit::score::ScoreLimits;
use crate::gauge::edge::estimation::censored_fit::side_fit::SideFitLimits;
use crate::gauge::edge::estimation::column_fit::ColumnFitLimits;
use crate::gauge::edge::estimation::grey_ends::GreyEndLimits;
use crate::gauge::edge::estimation::level_gradient::LevelGradientLimits;
use crate::gauge::edge::estimation::levels::LevelLimits;
use crate::gauge::edge::estimation::light_field::LightFieldLimits;
use crate::gauge::edge::estimation::model_bias::ModelBiasLimits;
use crate::gauge::edge::estimation::noise::NoiseLimits;
use crate::gauge::edge::estimation::rounding::RoundingLimits;
use crate::gauge::edge::estimation::scoring_table::ScoringTableLimits;
use crate::gauge::edge::estimation::side_survey::SideSurveyLimits;
use crate::gauge::edge::estimation::slanted_edge::SlantedEdgeLimits;
use crate::gauge::edge::estimation::soft_knee::SoftKneeLimits;
use crate::gauge::edge::frame_lines::FrameLineLimits;
use crate::gauge::edge::frame_survey::SurveyLimits;
use crate::gauge::edge::frame_windows::FrameWindowLimits;
use crate::gauge::edge::image::grey_step::GreyStepLimits;
use crate::gauge::edge::image::part_localisation::LocalisationLimits;
use crate::gauge::edge::image::repeated::RepeatedLimits;
use crate::gauge::edge::image::scan_windows::WindowLimits;
use crate::gauge::edge::image::shadows::ShadowLimits;
use crate::gauge::edge::image::stuck_rows::StuckRowLimits;
use crate::gauge::edge::image::valleys::ValleyLimits;
use crate::gauge::edge::image::window_layout::LayoutLimits;
use crate::gauge::edge::model::edge_spread::EdgeSpreadLimits;
use crate::gauge::edge::model::edge_table::EdgeTableLimits;
use crate::gauge::edge::model::shape_terms::ShapeTermLimits;
use crate::gauge::edge::model::systematic_residual::SystematicResidualLimits;
use crate::gauge::edge::narrow::NarrowLimits;
use crate::gauge::edge::refusals::explain::ExplainLimits;
use crate::gauge::edge::refusals::other_views::OtherViewLimits;
use crate::gauge::edge::rejection::bent::BentLimits;
use crate::gauge::edge::rejection::bump_extent::BumpExtentLimits;
use crate::gauge::edge::rejection::centreline::CentrelineLimits;
use crate::gauge::edge::rejection::departures::DepartureLimits;
use crate::gauge::edge::rejection::local_bumps::LocalBumpLimits;
use crate::gauge::edge::rejection::neighbour_test::NeighbourLimits;
use crate::gauge::edge::rejection::one_sided::OneSidedLimits;
use crate::gauge::edge::rejection::residual_test::ResidualLimits;
use crate::gauge::edge::rings::RingLimits;
use crate::gauge::edge::side::survey::SideSampleLimits;
use crate::gauge::edge::side::tables::TableLimits;
use crate::gauge::edge::stream::StreamLimits;
use crate::gauge::edge::wire::clipped::WireClipLimits;
use crate::gauge::edge::wire::frame::WireFrameLimits;
use crate::gauge::edge::wire::joint_fit::WireFitLimits;
use crate::gauge::edge::wire::rounding::WireRoundingLimits;
use crate::gauge::flank::limits::{FlankLimits, FlankTrainingLimits};
use crate::gauge::flank::paper::PaperFlankLimits;
use crate::gauge::generatrix::limits::GeneratrixLimits;
use crate::gauge::limit::{Limit, Limits};
use crate::gauge::nose::axes::NoseAxesLimits;
use crate::gauge::nose::limits::NoseLimits;
use crate::gauge::nose::paper::limits::PaperNoseLimits;
use crate::gauge::ring::coarse::CoarseRingLimits;
use crate::gauge::ring::edge_pixels::BandLimits;
use crate::gauge::ring::fit::RingFitLimits;
use crate::gauge::ring::measurement::RingLightLimits;
use crate::gauge::ring::millimetres::RingMillimetreLimits;
use crate::gauge::ring::straight_edge::StraightEdgeLimits;
use crate::gauge::sensor::flat_field::FlatFieldLimits;
use crate::gauge::sensor::photon_transfer::PhotonTransferLimits;
use crate::gauge::sensor::response::ResponseLimits;
use crate::gauge::settings::SettingLimits;
use crate::gauge::uncertainty::coverage::CoverageLimits;
use crate::gauge::uncertainty::form_scatter::FormScatterLimits;
use crate::gauge::uncertainty::stated::StatedLimits;
use crate::gauge::width::axis_slope::AxisSlopeLimits;
use crate::gauge::width::blur_sensitivity::BlurSensitivityLimits;
use crate::gauge::width::curvature_bias::CurvatureLimits;
use crate::gauge::width::largest_caliper::CaliperLimits;
use crate::gauge::width::stretch::crests::CrestLimits;
use crate::gauge::width::stretch::fit::StretchFitLimits;
use crate::gauge::width::stretch::largest_value::LargestValueLimits;

/// Every threshold with its default value.
#[must_use]
pub(crate) fn every() -> Vec<Limit> {
    let rooms = [
        of_sensor(),
        of_model(),
        of_image(),
        of_estimation(),
        of_wires(),
        of_rejection(),
        of_edges(),
        of_width(),
        of_calibration(),
        of_diameter(),
        of_uncertainty(),
        of_ring(),
        of_nose(),
        of_flank(),
    ];
    rooms.concat().concat()
}

/// Thresholds of the sensor and the settings, a group an entry.
fn of_sensor() -> Vec<Vec<Limit>> {
    vec![FlatFieldLimits::list(), PhotonTransferLimits::list(), ResponseLimits::list(), SettingLimits::list()]
}

/// Thresholds of the edges' image, a group an entry.
fn of_image() -> Vec<Vec<Limit>> {
    vec![
        GreyStepLimits::list(),
        LocalisationLimits::list(),
        RepeatedLimits::list(),
        WindowLimits::list(),
        ShadowLimits::list(),
        StuckRowLimits::list(),
        ValleyLimits::list(),
        LayoutLimits::list(),
    ]
}

/// Thresholds of the estimation, a group an entry.
fn of_estimation() -> Vec<Vec<Limit>> {
    vec![
        BlurLimits::list(),
        BlurTrackLimits::list(),
        JointLimits::list(),
        ScoreLimits::list(),
        SideFitLimits::list(),
        ColumnFitLimits::list(),
        GreyEndLimits::list(),
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
    ]
}

/// Thresholds of the edge model, a group an entry.
fn of_model() -> Vec<Vec<Limit>> {
    vec![
        EdgeSpreadLimits::list(),
        EdgeTableLimits::list(),
        ShapeTermLimits::list(),
        SystematicResidualLimits::list(),
    ]
}

/// Thresholds of wires, a group an entry.
fn of_wires() -> Vec<Vec<Limit>> {
    vec![WireClipLimits::list(), WireFrameLimits::list(), WireFitLimits::list(), WireRoundingLimits::list()]
}

/// Thresholds of the rejection and the refusals, a group an entry.
fn of_rejection() -> Vec<Vec<Limit>> {
    vec![
        BentLimits::list(),
        BumpExtentLimits::list(),
        CentrelineLimits::list(),
        DepartureLimits::list(),
        LocalBumpLimits::list(),
        NeighbourLimits::list(),
        OneSidedLimits::list(),
        ResidualLimits::list(),
        ExplainLimits::list(),
        OtherViewLimits::list(),
    ]
}

/// Thresholds of a frame, a side and a stream, a group an entry.
fn of_edges() -> Vec<Vec<Limit>> {
    vec![
        AcceptanceLimits::list(),
        SurveyLimits::list(),
        NarrowLimits::list(),
        RingLimits::list(),
        FrameWindowLimits::list(),
        FrameLineLimits::list(),
        SideSampleLimits::list(),
        TableLimits::list(),
        StreamLimits::list(),
    ]
}

/// Thresholds of widths, a group an entry.
fn of_width() -> Vec<Vec<Limit>> {
    vec![
        AxisSlopeLimits::list(),
        BlurSensitivityLimits::list(),
        CurvatureLimits::list(),
        CaliperLimits::list(),
        CrestLimits::list(),
        StretchFitLimits::list(),
        LargestValueLimits::list(),
    ]
}

/// Thresholds of the calibration, a group an entry.
fn of_calibration() -> Vec<Vec<Limit>> {
    vec![
        AdjustmentLimits::list(),
        CalibrationLimits::list(),
        FileLimits::list(),
        FinishLimits::list(),
        HeadGeometryLimits::list(),
        LimbLimits::list(),
        ObservationLimits::list(),
        SetupLimits::list(),
        UnstatedLimits::list(),
    ]
}

/// Thresholds of diameters, a group an entry.
fn of_diameter() -> Vec<Vec<Limit>> {
    vec![
        AxisLimits::list(),
        BurstLimits::list(),
        FieldMidlineLimits::list(),
        PlausibilityLimits::list(),
        SeriesLimits::list(),
        SectionLimits::list(),
        StationMeanLimits::list(),
        StationLimits::list(),
        TurnLimits::list(),
    ]
}

/// Thresholds of the uncertainty, a group an entry.
fn of_uncertainty() -> Vec<Vec<Limit>> {
    vec![CoverageLimits::list(), FormScatterLimits::list(), StatedLimits::list()]
}

/// Thresholds of noses, a group an entry.
fn of_nose() -> Vec<Vec<Limit>> {
    vec![NoseLimits::list(), NoseAxesLimits::list(), PaperNoseLimits::list(), GeneratrixLimits::list()]
}

/// Thresholds of flanks, a group an entry.
fn of_flank() -> Vec<Vec<Limit>> {
    vec![FlankLimits::list(), FlankTrainingLimits::list(), PaperFlankLimits::list()]
}

/// Thresholds of rings, a group an entry.
fn of_ring() -> Vec<Vec<Limit>> {
    vec![
        CoarseRingLimits::list(),
        BandLimits::list(),
        RingFitLimits::list(),
        StraightEdgeLimits::list(),
        RingLightLimits::list(),
        RingMillimetreLimits::list(),
    ]
}
