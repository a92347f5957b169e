//! Every threshold of the instrument, by name: what `shadowgauge study limits` varies.
//!
//! A group that is not listed here is not varied; `tests/architecture/constants.rs` requires every
//! group of the instrument here, one line each, a function a room.

use super::calibration::adjustment::AdjustmentLimits;
use super::calibration::error::CalibrationLimits;
use super::calibration::file_checks::FileLimits;
use super::calibration::finish::FinishLimits;
use super::calibration::head_geometry::HeadGeometryLimits;
use super::calibration::limb_difference::LimbLimits;
use super::calibration::observation::ObservationLimits;
use super::calibration::optical_setup::SetupLimits;
use super::calibration::unstated::UnstatedLimits;
use super::diameter::axis_line::AxisLimits;
use super::diameter::bursts::BurstLimits;
use super::diameter::field_midline::FieldMidlineLimits;
use super::diameter::plausibility::PlausibilityLimits;
use super::diameter::reading_scatter::SeriesLimits;
use super::diameter::sections::SectionLimits;
use super::diameter::station_mean::StationMeanLimits;
use super::diameter::stations::StationLimits;
use super::diameter::turn_scatter::TurnLimits;
use super::edge::acceptance::AcceptanceLimits;
use super::edge::estimation::blur::BlurLimits;
use super::edge::estimation::blur_track::BlurTrackLimits;
use super::edge::estimation::censored_fit::joint::JointLimits;
use super::edge::estimation::censored_fit::score::ScoreLimits;
use super::edge::estimation::censored_fit::side_fit::SideFitLimits;
use super::edge::estimation::column_fit::ColumnFitLimits;
use super::edge::estimation::grey_ends::GreyEndLimits;
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
use super::edge::frame_lines::FrameLineLimits;
use super::edge::frame_survey::SurveyLimits;
use super::edge::frame_windows::FrameWindowLimits;
use super::edge::image::grey_step::GreyStepLimits;
use super::edge::image::part_localisation::LocalisationLimits;
use super::edge::image::repeated::RepeatedLimits;
use super::edge::image::scan_windows::WindowLimits;
use super::edge::image::shadows::ShadowLimits;
use super::edge::image::stuck_rows::StuckRowLimits;
use super::edge::image::valleys::ValleyLimits;
use super::edge::image::window_layout::LayoutLimits;
use super::edge::model::edge_spread::EdgeSpreadLimits;
use super::edge::model::edge_table::EdgeTableLimits;
use super::edge::model::shape_terms::ShapeTermLimits;
use super::edge::model::systematic_residual::SystematicResidualLimits;
use super::edge::narrow::NarrowLimits;
use super::edge::refusals::explain::ExplainLimits;
use super::edge::refusals::other_views::OtherViewLimits;
use super::edge::rejection::bent::BentLimits;
use super::edge::rejection::bump_extent::BumpExtentLimits;
use super::edge::rejection::centreline::CentrelineLimits;
use super::edge::rejection::departures::DepartureLimits;
use super::edge::rejection::local_bumps::LocalBumpLimits;
use super::edge::rejection::neighbour_test::NeighbourLimits;
use super::edge::rejection::one_sided::OneSidedLimits;
use super::edge::rejection::residual_test::ResidualLimits;
use super::edge::rings::RingLimits;
use super::edge::side::survey::SideSampleLimits;
use super::edge::side::tables::TableLimits;
use super::edge::stream::StreamLimits;
use super::edge::wire::clipped::WireClipLimits;
use super::edge::wire::frame::WireFrameLimits;
use super::edge::wire::joint_fit::WireFitLimits;
use super::edge::wire::rounding::WireRoundingLimits;
use super::flank::limits::{FlankLimits, FlankTrainingLimits};
use super::flank::paper::PaperFlankLimits;
use super::generatrix::limits::GeneratrixLimits;
use super::limit::{Limit, Limits};
use super::nose::axes::NoseAxesLimits;
use super::nose::limits::NoseLimits;
use super::nose::paper::limits::PaperNoseLimits;
use super::ring::coarse::CoarseRingLimits;
use super::ring::edge_pixels::BandLimits;
use super::ring::fit::RingFitLimits;
use super::ring::measurement::RingLightLimits;
use super::ring::millimetres::RingMillimetreLimits;
use super::sensor::flat_field::FlatFieldLimits;
use super::sensor::photon_transfer::PhotonTransferLimits;
use super::sensor::response::ResponseLimits;
use super::settings::SettingLimits;
use super::uncertainty::coverage::CoverageLimits;
use super::uncertainty::form_scatter::FormScatterLimits;
use super::uncertainty::stated::StatedLimits;
use super::width::axis_slope::AxisSlopeLimits;
use super::width::blur_sensitivity::BlurSensitivityLimits;
use super::width::curvature_bias::CurvatureLimits;
use super::width::largest_caliper::CaliperLimits;
use super::width::stretch::crests::CrestLimits;
use super::width::stretch::fit::StretchFitLimits;
use super::width::stretch::largest_value::LargestValueLimits;

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
        RingLightLimits::list(),
        RingMillimetreLimits::list(),
    ]
}
