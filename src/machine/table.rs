//! A tabulated error between its points.

/// Values at ascending positions, piecewise linear: what a control's compensation table does
/// between its points. Two columns where the values of both directions were measured.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    /// Ascending positions, mm or rad.
    pub position: Vec<f64>,
    /// Values where the position grew, mm or rad.
    pub forward: Vec<f64>,
    /// Values where it fell; the same where they were not measured apart.
    pub backward: Vec<f64>,
    /// Whether the last point is the first one a turn later.
    pub is_periodic: bool,
}

impl Table {
    /// The value at a position; beyond the ends the last one (a periodic table has none).
    pub(crate) fn value(&self, position: f64, is_backward: bool) -> f64 {
        let values = if is_backward { &self.backward } else { &self.forward };
        let first = self.position.first().copied().unwrap_or(0.0);
        let turn = std::f64::consts::TAU;
        // The remainder takes longer than the rest of the interpolation: only where it changes
        // anything.
        let is_beyond = self.is_periodic && !(0.0..turn).contains(&(position - first));
        let at = if self.is_periodic {
            first + if is_beyond { (position - first).rem_euclid(turn) } else { position - first }
        } else {
            position
        };
        let after = self.after(at);
        if after == 0 {
            return values.first().copied().unwrap_or(0.0);
        }
        let (from, start) = (self.position[after - 1], values[after - 1]);
        let (to, end) = match self.position.get(after) {
            Some(to) => (*to, values[after]),
            None if self.is_periodic => (first + turn, values[0]),
            None => return start,
        };
        start + (end - start) * (at - from) / (to - from)
    }

    /// Index of the first point beyond a position. Even steps, which most tables have, are tried
    /// before the search: its branches cost more than the rest of the interpolation.
    fn after(&self, at: f64) -> usize {
        let count = self.position.len();
        if let (Some(first), Some(last)) = (self.position.first(), self.position.last()) {
            let step = (at - first) / (last - first) * (count - 1) as f64;
            let even = step.clamp(0.0, count as f64) as usize + 1;
            let is_it = self.position.get(even - 1).is_some_and(|p| *p <= at);
            if is_it && self.position.get(even).is_some_and(|p| at < *p) {
                return even;
            }
        }
        self.position.partition_point(|p| *p <= at)
    }
}
