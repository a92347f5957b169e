//! Both edges of every column of a frame.

use pyo3::prelude::*;
use shadowgauge::gauge::{Edge, FrameEdges};

use crate::column::Values;
use crate::table::{Table, to_numpy};

/// Rows of both edges of every column, px (pixel centres at integers), with their standard
/// uncertainties; NaN in a gap, whose reason `flag` has. Arrays have one value a column.
#[pyclass(frozen, module = "shadowgauge")]
pub(crate) struct Edges {
    pub(crate) inner: FrameEdges,
}

impl Edges {
    fn numbers<'py>(&self, py: Python<'py>, of: impl Fn(&Edge, &Edge) -> f64) -> PyResult<Bound<'py, PyAny>> {
        let pairs = self.inner.top.iter().zip(&self.inner.bottom);
        to_numpy(py, &Values::Double(pairs.map(|(top, bottom)| of(top, bottom)).collect()))
    }

    /// Why columns are gaps or impaired; empty for good ones.
    pub(crate) fn flags(&self) -> Vec<String> {
        let reason = |(top, bottom)| Edge::reason_of_both(top, bottom);
        let pairs = self.inner.top.iter().zip(&self.inner.bottom);
        pairs.map(|pair| reason(pair).map_or_else(String::new, |reason| reason.to_string())).collect()
    }

    fn values(&self, of: impl Fn(&Edge, &Edge) -> f64) -> Values {
        let pairs = self.inner.top.iter().zip(&self.inner.bottom);
        Values::Double(pairs.map(|(top, bottom)| of(top, bottom)).collect())
    }
}

#[pymethods]
impl Edges {
    /// Row of the upper edge, px.
    #[getter]
    fn top_px<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |top, _| top.row_px)
    }

    /// Row of the lower edge, px.
    #[getter]
    fn bottom_px<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |_, bottom| bottom.row_px)
    }

    /// Standard uncertainty of the upper edge, px (k = 1).
    #[getter]
    fn u_top_px<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |top, _| top.u_px())
    }

    /// Standard uncertainty of the lower edge, px (k = 1).
    #[getter]
    fn u_bottom_px<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |_, bottom| bottom.u_px())
    }

    /// Width between the edges, px.
    #[getter]
    fn width_px<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let widths = (0..self.inner.columns()).map(|column| self.inner.width_px(column).unwrap_or(f64::NAN));
        to_numpy(py, &Values::Double(widths.collect()))
    }

    /// Why a column is a gap or impaired; empty for a good one.
    #[getter]
    fn flag(&self) -> Vec<String> {
        self.flags()
    }

    /// Columns with both edges.
    #[getter]
    fn valid(&self) -> usize {
        self.inner.valid()
    }

    fn __len__(&self) -> usize {
        self.inner.columns()
    }

    fn __repr__(&self) -> String {
        format!("Edges({} of {} columns)", self.inner.valid(), self.inner.columns())
    }

    /// The columns of `measure --edges` as a table.
    fn table(&self) -> Table {
        Table::new(vec![
            ("column", Values::Int((0..self.inner.columns() as i64).collect())),
            ("top_px", self.values(|top, _| top.row_px)),
            ("bottom_px", self.values(|_, bottom| bottom.row_px)),
            ("u_top_px", self.values(|top, _| top.u_px())),
            ("u_bottom_px", self.values(|_, bottom| bottom.u_px())),
            ("flag", Values::Text(self.flags())),
        ])
    }
}
