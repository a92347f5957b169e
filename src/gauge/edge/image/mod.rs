//! Where in the frame the part is, and the grey values around its edges.
//!
//! In: a frame as a `plane::Plane` of one grey type, shadow dark and shaft level. Out: the part's
//! two contours to a pixel (`part_localisation`), and a window of grey values around each edge of
//! each column (`scan_windows`); what disturbs them, stuck and repeated lines, is found here too.
//! Rows and columns are in px, grey values in counts.
//!
//! One more way to find the part is one more function beside `valleys`; one more fault of frames is
//! one more file with a function that takes a plane and returns its finding.

pub(crate) mod connected_components;
pub(crate) mod grey_step;
pub(crate) mod part_localisation;
pub(crate) mod plane;
pub(crate) mod repeated;
pub(crate) mod scan_windows;
pub(crate) mod shadows;
pub(crate) mod stuck_rows;
pub(crate) mod valleys;
pub(crate) mod window_layout;
