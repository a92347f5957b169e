//! The head that stands before the part by its own pose, as the renderer draws it.
//!
//! A head displaced by u and turned by a, b, c about X, Y, Z sees the part displaced by −u and
//! turned the other way: its axis −u_x above the optical axis and −u_y nearer, rising by −b along
//! z in the image and coming nearer by a along z, at the angle φ − c, and the middle of its field
//! at z + u_z while the frame has the commanded z. Error motion of the spindle of order 2 and above
//! moves the axis while it turns. Not drawn: order 1 of that motion (what was cut with it returns
//! to the same place), its change within a field, and turns within an exposure.

use super::lathe::Lathe;
use super::turn_harmonics::undulations;
use crate::machine::Pose;
use crate::process::bending::sum_of_lines;
use crate::shaft::{AxisKnot, Shaft, SpindleHarmonic, SpindleMotion};

/// How a head stands before the part.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HeadView {
    /// The field that it should see, mm.
    field_z_mm: f64,
    pose: Pose,
    /// Error motion of the spindle as the head sees it.
    synchronous: Vec<SpindleHarmonic>,
}

impl Lathe {
    /// The head with Z where it should see the field at `field_z_mm`.
    pub(crate) fn head(&self, field_z_mm: f64) -> HeadView {
        let poses = self.head_poses(field_z_mm);
        let pose = self.head_pose(field_z_mm);
        HeadView { field_z_mm, pose, synchronous: synchronous(&poses) }
    }
}

/// What the head sees of the spindle's error motion over a turn.
fn synchronous(poses: &[Pose]) -> Vec<SpindleHarmonic> {
    let seen = |k: usize| undulations(&poses.iter().map(|pose| -pose.shift_mm[k]).collect::<Vec<_>>());
    let along_x = seen(0).into_iter().map(|u| SpindleHarmonic {
        order: u.order,
        x_um: 1e3 * u.amplitude,
        x_phase_deg: u.phase_deg,
        ..SpindleHarmonic::default()
    });
    let along_y = seen(1).into_iter().map(|u| SpindleHarmonic {
        order: u.order,
        y_um: 1e3 * u.amplitude,
        y_phase_deg: u.phase_deg,
        ..SpindleHarmonic::default()
    });
    along_x.chain(along_y).collect()
}

impl HeadView {
    /// Machine z of the middle of the field that is seen, mm.
    pub(crate) fn z_mm(&self) -> f64 {
        self.field_z_mm + self.pose.shift_mm.z
    }

    /// The spindle angle at which the part is seen, degrees.
    pub(crate) fn angle_deg(&self, angle_deg: f64) -> f64 {
        angle_deg - self.pose.turn_rad.z.to_degrees()
    }

    /// The part as it stands before the head.
    #[must_use]
    pub(crate) fn seen(&self, part: Shaft) -> Shaft {
        let Pose { shift_mm, turn_rad } = self.pose;
        let mut pose = part.pose;
        pose.tilt_mrad -= 1e3 * turn_rad.y;
        pose.tilt_to_camera_mrad += 1e3 * turn_rad.x;
        // the image turns about z = 0: the axis stays where it was in the middle of the field
        let rise = (1e-3 * pose.tilt_mrad).sin() - (1e-3 * part.pose.tilt_mrad).sin();
        pose.x_mm -= shift_mm.x + self.field_z_mm * rise;
        let nearer = [AxisKnot { z_mm: self.field_z_mm, x_mm: 0.0, y_mm: -shift_mm.y }];
        let mut synchronous = part.spindle.synchronous;
        synchronous.extend_from_slice(&self.synchronous);
        Shaft {
            pose,
            deflection: sum_of_lines(&part.deflection, &nearer),
            spindle: SpindleMotion { synchronous, ..part.spindle },
            ..part
        }
    }
}
