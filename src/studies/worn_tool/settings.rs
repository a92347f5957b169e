//! Settings of the study.

use super::error::WornToolError;
use super::workpieces::Workpiece;
use crate::render::insert::InsertSettings;
use crate::setting::within;

/// What is studied.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// Insert and camera; its direction is made that of the tool.
    pub insert: InsertSettings,
    /// Half angles of the cones of workpieces 1 and 2, degrees: the paper does not give them.
    pub cone_deg: [f64; 2],
    /// Workpieces of each kind with the lathe's scatter.
    pub pieces: u32,
    /// Which of the paper's workpieces are cut.
    pub workpieces: Vec<Workpiece>,
    /// Seed.
    pub seed: u64,
}

impl Settings {
    /// Checks insert and angles.
    ///
    /// # Errors
    /// The first value out of range.
    pub(crate) fn check(&self) -> Result<(), WornToolError> {
        self.insert.check()?;
        let right = "a half angle of 5 to 80 degrees, from the axis to the cone's side";
        self.cone_deg.iter().try_for_each(|deg| within("--cone-deg", *deg, 5.0, 80.0, right))?;
        within("--pieces", f64::from(self.pieces), 1.0, 1000.0, "1 to 1000 workpieces")?;
        let right = "a corner of 35 to 80 degrees (ISO 1832), which a holder of 93 degrees carries";
        within("nose.epsilon_deg", self.insert.nose.epsilon_deg, 35.0, 80.0, right)?;
        let right = "a nose of .1 to 2 mm: the workpieces have arcs of 5 mm and faces of 5 mm";
        within("nose.radius_mm", self.insert.nose.radius_mm, 0.1, 2.0, right)?;
        Ok(())
    }
}
