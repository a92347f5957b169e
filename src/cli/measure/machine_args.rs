//! Arguments of the machine that carries the head.

use std::path::PathBuf;

use crate::cli::failure::Failure;
use crate::gauge::calibration::HeadGeometry;
use crate::identification::head_geometry::{of_identified, temperature_consequence, unread};
use crate::identification::{IdentifiedMachine, MachineIdentity};

/// The machine that carries the head, as it was identified.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct MachineArgs {
    /// machine.json of `calibrate machine`: corrects every frame, at its z_mm (frames.csv; 0
    /// without one), by where the machine carries the head. A frame outside the identified range
    /// has no diameter.
    #[arg(long, value_name = "FILE.json", requires = "calibration")]
    machine: Option<PathBuf>,
    /// Name of the head, which that of the file must equal.
    #[arg(long, value_name = "NAME", requires = "machine")]
    head: Option<String>,
    /// Temperature of the machine, °C; warns of what the file's does not hold for.
    #[arg(long, value_name = "C", requires = "machine", allow_negative_numbers = true)]
    machine_temperature: Option<f64>,
}

impl MachineArgs {
    /// The argument, where it is given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        self.machine.as_ref().map(|_| "--machine")
    }

    /// The file named here.
    pub(crate) fn file(&self) -> Option<PathBuf> {
        self.machine.clone()
    }

    /// Where the machine carries the head, over z.
    ///
    /// # Errors
    /// A file that cannot be read, is no machine.json, or is of another head; a temperature that is
    /// none.
    pub(crate) fn geometry(&self) -> Result<Option<HeadGeometry>, Failure> {
        let Some(path) = &self.machine else { return Ok(None) };
        let shown = path.display();
        let text = std::fs::read_to_string(path).map_err(|e| Failure::fail(format!("{shown}: {e}")))?;
        let refuse = |why: String| Failure::refuse(format!("{shown}: {why}"));
        let found = IdentifiedMachine::read(&text).map_err(refuse)?;
        let identity = MachineIdentity { machine: None, head: self.head.clone() };
        found.fits(&identity, &found.machine).map_err(refuse)?;
        let unread = unread(&found);
        if !unread.is_empty() {
            tracing::warn!(
                "{shown}: {} move the head along Y and count as zero there: what they add to the readings is corrected by nothing and in \
                 no uncertainty",
                unread.join(", ")
            );
        }
        if let Some(now) = self.machine_temperature {
            if !(-20.0..=80.0).contains(&now) {
                return Err(Failure::refuse(format!(
                    "--machine-temperature {now}: must be between -20 and 80 °C"
                )));
            }
            if let Some(words) = temperature_consequence(&found.machine, found.temperature_c, now) {
                tracing::warn!("{shown}: {words}");
            }
        }
        of_identified(&found).map(Some).map_err(|e| refuse(e.to_string()))
    }
}
