//! The form tables of a run folder: `form.csv`, one row per section, and `part_form.csv`, one row
//! per pass.

use serde::{Deserialize, Serialize};

use super::folder::{RunFolder, RunFolderError};
use crate::gauge::diameter::sections::{PartForm, SectionForm};
use crate::profile::Station;

/// A row of `form.csv`: sizes and form of a section of the silhouette's hull over the angles of a
/// pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FormRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Number of angles.
    pub angles: usize,
    /// Whether they span half a revolution, with the spindle assumed free of error motion.
    pub half_turn: bool,
    /// Least-squares size GG, mm.
    pub gg_mm: f64,
    /// Its standard uncertainty, mm: `u_gg_random_mm` and `u_gg_common_mm` together. Version 0.1
    /// wrote the random one alone.
    pub u_gg_mm: f64,
    /// Minimum circumscribed size GN, mm.
    pub gn_mm: f64,
    /// Maximum inscribed size GX, mm.
    pub gx_mm: f64,
    /// Mean caliper diameter, mm.
    pub mean_caliper_mm: f64,
    /// Least caliper diameter, mm.
    pub min_caliper_mm: f64,
    /// Greatest caliper diameter, mm.
    pub max_caliper_mm: f64,
    /// Circular run-out against the spindle, mm.
    pub run_out_mm: f64,
    /// Roundness about LSCI, mm.
    pub lsci_mm: f64,
    /// Roundness about MZCI, mm.
    pub mzci_mm: f64,
    /// Roundness about MICI, mm.
    pub mici_mm: f64,
    /// Roundness about MCCI, mm.
    pub mcci_mm: f64,
    /// Amplitude of two lobes (form), mm; empty where the angles do not determine it.
    pub lobes_2_mm: Option<f64>,
    /// Amplitude of three lobes (form + spindle), mm.
    pub lobes_3_form_spindle_mm: Option<f64>,
    /// Amplitude of four lobes (form), mm.
    pub lobes_4_mm: Option<f64>,
    /// Amplitude of five lobes (form + spindle), mm.
    pub lobes_5_form_spindle_mm: Option<f64>,
    /// Common standard uncertainty of GG, mm: that of the station's mean diameter.
    #[serde(default)]
    pub u_gg_common_mm: Option<f64>,
    /// Random standard uncertainty of GG, mm.
    #[serde(default)]
    pub u_gg_random_mm: Option<f64>,
}

impl FormRow {
    /// The row of a section; the common uncertainty at its z is that of `stations`.
    pub(crate) fn new(pass: u32, s: &SectionForm, stations: &[Station]) -> Self {
        let lobes = |k: usize| s.harmonics.section.iter().find(|h| h.lobes == k).map(|h| h.amplitude_mm);
        let station = stations.iter().find(|station| (station.z_mm - s.z_mm).abs() < 1e-6);
        let [lsci_mm, mzci_mm, mici_mm, mcci_mm] = s.roundness_mm;
        let u_gg_common_mm = station.and_then(|s| s.reading.value()).map(|d| d.u_common_mm);
        Self {
            pass,
            z_mm: s.z_mm,
            angles: s.angles,
            half_turn: s.half_turn,
            gg_mm: s.gg_mm,
            u_gg_mm: s.u_gg_random_mm.hypot(u_gg_common_mm.unwrap_or(0.0)),
            gn_mm: s.gn_mm,
            gx_mm: s.gx_mm,
            mean_caliper_mm: s.mean_caliper_mm,
            min_caliper_mm: s.min_caliper_mm,
            max_caliper_mm: s.max_caliper_mm,
            run_out_mm: s.run_out_mm,
            lsci_mm,
            mzci_mm,
            mici_mm,
            mcci_mm,
            lobes_2_mm: lobes(2),
            lobes_3_form_spindle_mm: lobes(3),
            lobes_4_mm: lobes(4),
            lobes_5_form_spindle_mm: lobes(5),
            u_gg_common_mm,
            u_gg_random_mm: Some(s.u_gg_random_mm),
        }
    }
}

/// A row of `part_form.csv`: the form of the whole part after a pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PartFormRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Sections evaluated.
    pub sections: usize,
    /// Total radial run-out, mm.
    pub total_run_out_mm: Option<f64>,
    /// Cylindricity CYLt about the least-squares cylinder, mm.
    pub cylindricity_mm: Option<f64>,
    /// Straightness of the line of centres, mm.
    pub axis_straightness_mm: Option<f64>,
    /// Worst straightness of a flank, mm.
    pub generatrix_straightness_mm: Option<f64>,
    /// Rate of taper dD/dz, mm/mm.
    pub taper: Option<f64>,
}

impl PartFormRow {
    /// The row of a pass.
    pub(crate) fn new(pass: u32, form: &PartForm) -> Self {
        Self {
            pass,
            sections: form.sections.len(),
            total_run_out_mm: form.total_run_out_mm,
            cylindricity_mm: form.cylindricity_mm,
            axis_straightness_mm: form.axis_straightness_mm,
            generatrix_straightness_mm: form.generatrix_straightness_mm,
            taper: form.taper,
        }
    }
}

impl RunFolder {
    /// Writes `form.csv` and `part_form.csv`.
    ///
    /// # Errors
    /// Where they cannot be written.
    pub(crate) fn write_form(
        &self,
        sections: &[FormRow],
        parts: &[PartFormRow],
    ) -> Result<(), RunFolderError> {
        self.write_csv("form.csv", sections).and_then(|()| self.write_csv("part_form.csv", parts))
    }

    /// Reads `form.csv` and `part_form.csv`; empty where there are none.
    ///
    /// # Errors
    /// Where they cannot be read or parsed.
    pub(crate) fn form(&self) -> Result<(Vec<FormRow>, Vec<PartFormRow>), RunFolderError> {
        Ok((self.read_csv("form.csv")?, self.read_csv("part_form.csv")?))
    }
}
