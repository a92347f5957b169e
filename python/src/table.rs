//! Tables: columns of numbers and texts, for NumPy and by Arrow's PyCapsule interface.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyList};

use crate::arrow_c;
use crate::column::{Column, Values};
use crate::errors::raise;

/// Columns of one length by name.
///
/// polars.DataFrame(table), pyarrow.table(table) and pandas.DataFrame(dict(table)) take it;
/// table["d_mm"] is a NumPy array.
#[pyclass(frozen, module = "shadowgauge")]
pub(crate) struct Table {
    columns: Arc<Vec<Column>>,
}

impl Table {
    pub(crate) fn new(columns: Vec<Column>) -> Self {
        Self { columns: Arc::new(columns) }
    }
}

/// Values as a NumPy array; texts as one of Python's strings.
pub(crate) fn to_numpy<'py>(py: Python<'py>, values: &Values) -> PyResult<Bound<'py, PyAny>> {
    let from_bytes = |dtype: &str, bytes: Vec<u8>| {
        let numpy = py.import("numpy").map_err(|_| {
            raise(
                py,
                "MissingPackage",
                "results come as NumPy arrays, and this Python has no NumPy: pip install numpy",
            )
        })?;
        numpy.call_method1("frombuffer", (PyBytes::new(py, &bytes), dtype))
    };
    match values {
        Values::Double(values) => from_bytes("=f8", values.iter().flat_map(|v| v.to_ne_bytes()).collect()),
        Values::Int(values) => from_bytes("=i8", values.iter().flat_map(|v| v.to_ne_bytes()).collect()),
        Values::Text(values) => {
            let list = PyList::new(py, values)?;
            py.import("numpy")?.call_method1("array", (list, "object"))
        }
    }
}

#[pymethods]
impl Table {
    /// The columns' names, in their order.
    fn keys(&self) -> Vec<&'static str> {
        self.columns.iter().map(|(name, _)| *name).collect()
    }

    /// Rows.
    fn __len__(&self) -> usize {
        self.columns.first().map_or(0, |(_, values)| values.len())
    }

    /// A column as a NumPy array, read-only.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let column = self.columns.iter().find(|(own, _)| *own == name);
        let (_, values) = column.ok_or_else(|| {
            pyo3::exceptions::PyKeyError::new_err(format!(
                "no column {name:?}; there are {}",
                self.keys().join(", ")
            ))
        })?;
        to_numpy(py, values)
    }

    fn __repr__(&self) -> String {
        format!("Table({} rows: {})", self.__len__(), self.keys().join(", "))
    }

    /// Arrow's PyCapsule interface: the schema.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        arrow_c::schema_capsule(py, &self.columns)
    }

    /// Arrow's PyCapsule interface: schema and one batch.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_array__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyCapsule>, Bound<'py, PyCapsule>)> {
        let _ = requested_schema;
        Ok((arrow_c::schema_capsule(py, &self.columns)?, arrow_c::array_capsule(py, &self.columns)?))
    }

    /// Arrow's PyCapsule interface: a stream of one batch.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        arrow_c::stream_capsule(py, &self.columns)
    }
}
