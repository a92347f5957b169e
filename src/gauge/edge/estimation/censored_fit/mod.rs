//! Edges beside light or shadow that is clipped: censored maximum likelihood of one side of a
//! frame.
//!
//! In: the windows of a side, what its levels and noise showed, the ends of the grey scale. Out:
//! edges with u, levels, blur. `side_fit` runs it; `joint` fits levels, blur and shape over many
//! columns, `score` one column, `level` is a level as they vary it. One more quantity hidden by
//! clipping is one more parameter of `joint`.

pub(crate) mod joint;
pub(crate) mod level;
pub(crate) mod score;
pub(crate) mod side_fit;
