//! Stations along z, with what an averager gathers of each.

/// Stations of one length, by their middles, ascending.
#[derive(Clone, Debug)]
pub(super) struct StationRow<T> {
    stations: Vec<Gathered<T>>,
    station_mm: f64,
    /// Pitch of the columns of the last frame, mm.
    pub(super) pitch_mm: f64,
}

/// A station, and what was gathered of it.
#[derive(Clone, Debug)]
pub(super) struct Gathered<T> {
    /// Middle, mm.
    pub(super) z_mm: f64,
    pub(super) sums: T,
}

impl<T: Default> StationRow<T> {
    /// Stations of which nothing is gathered yet: their middles and their common length, mm.
    pub(super) fn new(z_mm: Vec<f64>, station_mm: f64) -> Self {
        let stations = z_mm.into_iter().map(|z_mm| Gathered { z_mm, sums: T::default() }).collect();
        Self { stations, station_mm, pitch_mm: 0.0 }
    }

    /// The station that holds `z_mm`, and the place on it, −1 to 1; `None` between stations.
    pub(super) fn place(&self, z_mm: f64) -> Option<(usize, f64)> {
        let half = 0.5 * self.station_mm;
        let index = self.stations.partition_point(|s| s.z_mm + half <= z_mm);
        let station = self.stations.get(index).filter(|s| z_mm >= s.z_mm - half)?;
        Some((index, (z_mm - station.z_mm) / half))
    }

    /// What was gathered of a station that [`Self::place`] named.
    pub(super) fn sums(&mut self, index: usize) -> &mut T {
        &mut self.stations[index].sums
    }

    /// All stations.
    pub(super) fn iter(&self) -> std::slice::Iter<'_, Gathered<T>> {
        self.stations.iter()
    }

    /// Number of stations.
    pub(super) fn len(&self) -> usize {
        self.stations.len()
    }

    /// Length of a station, mm.
    pub(super) fn station_mm(&self) -> f64 {
        self.station_mm
    }

    /// Columns of a frame that shows a whole station.
    pub(super) fn columns(&self) -> f64 {
        self.station_mm / self.pitch_mm.max(1e-12)
    }
}
