//! Estimation from windows of grey values: levels, noise, blur, and the position of every edge by
//! maximum likelihood.
//!
//! In: `scan_windows::Windows` of one side. Out: level curves along the shaft (`levels`), the noise
//! (`noise`), the blur and its uncertainty (`blur`, `blur_track`), edges with u and χ²
//! (`column_fit` by the tables of `scoring_table`; `censored_fit` where light is clipped), and what
//! rounding or the systematic residual of the model adds to u. Counts and px throughout.
//!
//! One more estimate is one more file: a function of windows and of the estimates before it, called
//! by `side`. Whether an edge is refused for its position is decided in `rejection`.

pub(crate) mod blur;
pub(crate) mod blur_track;
pub(crate) mod censored;
pub(crate) mod censored_fit;
pub(crate) mod column_fit;
pub(crate) mod grey_ends;
pub(crate) mod level_gradient;
pub(crate) mod levels;
pub(crate) mod light_field;
pub(crate) mod model_bias;
pub(crate) mod noise;
pub(crate) mod rounding;
pub(crate) mod scoring;
pub(crate) mod scoring_table;
pub(crate) mod side_survey;
pub(crate) mod slanted_edge;
pub(crate) mod soft_knee;
