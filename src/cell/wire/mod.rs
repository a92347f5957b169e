//! The cell behind a wire: a head with its process in another program, commanded by its features.
//!
//! In: a head under control (`CommandedHead`) and the loop's half of a job. Out: the cell of a
//! closed loop. `fits` holds the head against the job before anything is cut, `wire_cell` gives it
//! pass plans and what stands before the camera, `placed` has a head without a part put fields and
//! pins there for a calibration, `wire_frames` takes frames, each bound to its
//! trigger by the head's clock and to its place by its chunks. A head of its own is an
//! implementation of `CommandedHead`; one more condition on it is a function of `fits`.

mod fits;
mod placed;
mod wire_cell;
mod wire_frames;

pub(crate) use self::fits::{Unfit, check};
pub(crate) use self::placed::{Placed, PlacedHead, places};
pub(crate) use self::wire_cell::WireCell;
