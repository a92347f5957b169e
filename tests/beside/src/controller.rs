//! A controller of this program's own: every station's error is taken off the next pass; a station
//! without a reading keeps its offset.

use shadowgauge::control::{Controller, PassContext};
use shadowgauge::plan::{Decision, DiameterOffset, PassPlan};
use shadowgauge::profile::DiameterProfile;

#[derive(Default)]
pub struct StationByStation {
    notes: Vec<String>,
}

impl Controller for StationByStation {
    fn name(&self) -> &str {
        "station by station"
    }

    fn decide_in(&mut self, plan: &PassPlan, measured: &DiameterProfile, _: &PassContext<'_>) -> Decision {
        let gaps = measured.stations.iter().filter(|s| s.reading.value().is_none()).count();
        self.notes = (gaps > 0).then(|| format!("{gaps} stations keep their offset")).into_iter().collect();
        let stations = plan.offset.o_mm.iter().zip(&measured.stations);
        let next = stations.map(|(o, s)| s.reading.value().map_or(*o, |d| o + d.d_mm - plan.nominal_mm));
        Decision::Offset(DiameterOffset { o_mm: next.collect() })
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }
}
