//! What a controller in another program is given of a job.

use std::io::{Read, Write};

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::Job;
use crate::control::Controller;
use crate::control::external::{PartFacts, ProgramController};

/// Stream of the programs' seeds, apart from every other random number of a job.
const STREAM: u64 = 0x636f_6e74_726f_6c6c;

impl Job {
    /// A controller at the other end of a stream, by the protocol of `docs/controllers.md`: one
    /// line of JSON each way a pass. It is given what every controller is given, and its offsets
    /// pass the same guards. `name` and `command` stand in errors.
    pub fn program_controller<S: Read + Write + Send + 'static>(
        &self,
        stream: S,
        name: &str,
        command: &str,
    ) -> Box<dyn Controller + Send> {
        let (settings, facts) = (self.loop_job().run_control(), self.part_facts());
        Box::new(ProgramController::new(stream, name, command, &settings, facts))
    }

    /// What a controller in another program is given of the job: the order, nothing of the truth.
    /// Its seed follows from the job's, of which everything random of the simulation is drawn,
    /// and has 32 bits, so that every language reads it exactly.
    pub(crate) fn part_facts(&self) -> PartFacts {
        let order = self.loop_job();
        let (layout, contour) = (order.layout(), order.turned_contour());
        let limits = |z: &f64| contour.as_ref().and_then(|c| c.section_at(*z)).and_then(|s| s.limits_mm);
        let mut random = Pcg64::seed_from_u64(self.seed ^ STREAM);
        PartFacts {
            seed: u64::from(random.next_u32()),
            station_z_mm: layout.z_mm.clone(),
            nominal_mm: (1..=order.passes() as u32).map(|pass| order.part.target_mm(pass)).collect(),
            station_relative_mm: contour.as_ref().map_or_else(Vec::new, |_| layout.relative_mm()),
            station_limits_mm: contour
                .as_ref()
                .map_or_else(Vec::new, |_| layout.z_mm.iter().map(limits).collect()),
            tolerance_mm: order.part.tolerance.map(|t| t.limits_mm()),
            cutting: order.cutting,
        }
    }
}
