//! What a machine's errors amount to at the stations of a pass, for comparison only.

use serde::Serialize;

use super::lathe::{Lathe, part};
use crate::machine::first_order;
use crate::machine::response::{TwoSided, cut_mm};
use crate::plan::PassPlan;
use crate::process::{PathDisplacement as _, PathPlace};

/// A station after a pass, as a row of `truth_machine.csv`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct MachineRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Where the tool stands relative to the part less where it should: radially, µm.
    pub tool_x_um: f64,
    /// The same along Y, µm.
    pub tool_y_um: f64,
    /// The same along the spindle, µm.
    pub tool_z_um: f64,
    /// What the machine adds to the diameter by the exact chain, µm.
    pub cut_um: f64,
    /// The same to first order in the errors, µm.
    pub cut_first_order_um: f64,
    /// What the control's own compensation subtracts, µm; 0 without one.
    pub compensated_um: f64,
    /// What is left of the two, µm.
    pub left_um: f64,
    /// Where a head stands that sees this station in the middle of its field: radially, µm.
    pub head_x_um: f64,
    /// The same along Y, towards the lens, µm.
    pub head_y_um: f64,
    /// The same along the spindle, µm.
    pub head_z_um: f64,
    /// How the head is turned about X, µrad.
    pub head_a_urad: f64,
    /// How it is turned about Y, µrad: minus the slope of the axis in its image.
    pub head_b_urad: f64,
    /// Height of the part's axis in its image by that, µm.
    pub midline_um: f64,
}

impl Lathe {
    /// What the machine does at the stations of a pass. The path is the plan's nominal.
    pub(crate) fn contributions(&self, plan: &PassPlan) -> Vec<MachineRow> {
        let row = |(z_mm, diameter_mm): (&f64, f64)| {
            let place = PathPlace { z_mm: *z_mm, diameter_mm, taper: 0.0 };
            self.contribution(plan.pass, &place)
        };
        plan.station_z_mm.iter().zip(plan.station_nominal_mm()).map(row).collect()
    }

    fn contribution(&self, pass: u32, place: &PathPlace) -> MachineRow {
        let (settings, station) = (self.settings(), self.at_tool(place));
        let (pose, values) = self.tool_pose(&station);
        let linear = first_order::pose(settings.chain, &station, &values);
        let head = self.head_pose(place.z_mm);
        let compensated_mm = self.compensated_mm(place);
        let commanded = PathPlace { diameter_mm: place.diameter_mm - compensated_mm, ..*place };
        MachineRow {
            pass,
            z_mm: place.z_mm,
            tool_x_um: 1e3 * pose.shift_mm.x,
            tool_y_um: 1e3 * pose.shift_mm.y,
            tool_z_um: 1e3 * pose.shift_mm.z,
            cut_um: 1e3 * cut_mm(&part(place), settings.tip_above_axis_mm, &pose),
            cut_first_order_um: 1e3
                * 2.0
                * (linear.shift_mm.x
                    + settings.tip_above_axis_mm * linear.shift_mm.y / (0.5 * place.diameter_mm)),
            compensated_um: 1e3 * compensated_mm,
            left_um: 1e3 * (self.cut_mm(&commanded) - compensated_mm),
            head_x_um: 1e3 * head.shift_mm.x,
            head_y_um: 1e3 * head.shift_mm.y,
            head_z_um: 1e3 * head.shift_mm.z,
            head_a_urad: 1e6 * head.turn_rad.x,
            head_b_urad: 1e6 * head.turn_rad.y,
            midline_um: 1e3 * TwoSided::midline_mm(&head),
        }
    }
}
