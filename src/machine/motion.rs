//! The errors of a machine as functions: 18 of motion and three orientations.

use super::conditions::{Conditions, Direction};
use super::error_function::ErrorFunction;
use super::error_name::{Axis, COUNT, ErrorName, ErrorValues};

/// All errors of a machine.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// The functions of X, Z and C, in the order of [`ErrorName::ALL`].
    pub functions: [ErrorFunction; 18],
    /// B0X, A0C, B0C, rad.
    pub orientations_rad: [f64; 3],
}

impl Motion {
    /// The values with the slides at a position (mm), in a state.
    pub(crate) fn values(&self, x_mm: f64, z_mm: f64, state: &Conditions) -> ErrorValues {
        let mut values = [0.0; COUNT];
        let c = state.c_deg.to_radians();
        let axes = [(x_mm, state.x_direction), (z_mm, state.z_direction), (c, Direction::Forward)];
        // six of each axis, in the order of the names
        let of_motion = values.chunks_mut(6).zip(self.functions.chunks(6)).zip(axes);
        for ((values, functions), (position, direction)) in of_motion {
            for (value, function) in values.iter_mut().zip(functions) {
                *value = function.value(position, direction, state);
            }
        }
        values[self.functions.len()..].copy_from_slice(&self.orientations_rad);
        ErrorValues(values)
    }

    /// The value of one error, with the slides at [x, z], mm.
    pub(crate) fn value(&self, name: ErrorName, [x_mm, z_mm]: [f64; 2], state: &Conditions) -> f64 {
        let Some(function) = self.functions.get(name as usize) else {
            return self.orientations_rad[name as usize - self.functions.len()];
        };
        let (position, direction) = match name.axis() {
            Axis::X => (x_mm, state.x_direction),
            Axis::Z => (z_mm, state.z_direction),
            Axis::C => (state.c_deg.to_radians(), Direction::Forward),
        };
        function.value(position, direction, state)
    }

    /// The function of an error; an orientation has none.
    pub(crate) fn function(&self, name: ErrorName) -> Option<&ErrorFunction> {
        self.functions.get(name as usize)
    }
}
