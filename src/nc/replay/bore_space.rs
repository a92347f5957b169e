//! A bore around a boring bar: what the bar must keep off in feed, and the way out.

use super::convex::Convex;
use super::event::Point;

/// Distance below which positions are the same, mm.
const SAME_MM: f64 = 1e-6;

/// The material around a bore as it is left, on both sides of the axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BoreSpace {
    /// Convex parts of it.
    pub finished: Vec<Convex>,
}

impl BoreSpace {
    /// Whether what follows the nose, swept on its way, keeps off the finished bore.
    ///
    /// # Errors
    /// In words, without the way.
    pub(super) fn bar_is_free(&self, swept: &[Convex]) -> Result<(), String> {
        let rubs = |part: &Convex| swept.iter().any(|s| s.meets(part));
        match self.finished.iter().find(|part| rubs(part)) {
            None => Ok(()),
            Some(part) => {
                let ((from, _), (to, _)) = part.bounds();
                Err(format!("in feed the boring bar touches the finished bore at Z {from:.3} to {to:.3}"))
            }
        }
    }
}

/// Whether a move leaves along Z, towards the tailstock.
pub(super) fn is_out_of_bore(from: Point, to: Point) -> bool {
    (from.x - to.x).abs() <= SAME_MM && to.z > from.z
}
