//! Tables by Arrow's C data and C stream interface, in the capsules of its PyCapsule interface
//! (arrow.apache.org/docs/format/CDataInterface.html, CStreamInterface.html).
//!
//! A table is a struct array: a child a column, `g` (f64), `l` (i64) or `u` (UTF-8, offsets of 32
//! bits), none nullable. Each structure owns what it points to by `private_data`, and frees it in
//! its `release`; a consumer that has moved a structure out of its capsule leaves `release` null
//! behind, so that dropping the capsule frees nothing twice.
#![allow(unsafe_code, reason = "structures of C that are freed by whoever consumes them")]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::column::{Column, Values};

/// `struct ArrowSchema`.
#[repr(C)]
struct Schema {
    format: *const c_char,
    name: *const c_char,
    metadata: *const c_char,
    flags: i64,
    n_children: i64,
    children: *mut *mut Schema,
    dictionary: *mut Schema,
    release: Option<unsafe extern "C" fn(*mut Schema)>,
    private_data: *mut c_void,
}

/// `struct ArrowArray`.
#[repr(C)]
struct Array {
    length: i64,
    null_count: i64,
    offset: i64,
    n_buffers: i64,
    n_children: i64,
    buffers: *mut *const c_void,
    children: *mut *mut Array,
    dictionary: *mut Array,
    release: Option<unsafe extern "C" fn(*mut Array)>,
    private_data: *mut c_void,
}

/// `struct ArrowArrayStream`.
#[repr(C)]
struct Stream {
    get_schema: Option<unsafe extern "C" fn(*mut Stream, *mut Schema) -> c_int>,
    get_next: Option<unsafe extern "C" fn(*mut Stream, *mut Array) -> c_int>,
    get_last_error: Option<unsafe extern "C" fn(*mut Stream) -> *const c_char>,
    release: Option<unsafe extern "C" fn(*mut Stream)>,
    private_data: *mut c_void,
}

// SAFETY: what they point to is theirs alone, and frees itself from any thread.
unsafe impl Send for Schema {}
// SAFETY: as above.
unsafe impl Send for Array {}
// SAFETY: as above.
unsafe impl Send for Stream {}

/// What a schema points to.
struct SchemaOwned {
    format: CString,
    name: CString,
    children: Vec<*mut Schema>,
}

/// What an array points to.
struct ArrayOwned {
    _columns: Arc<Vec<Column>>,
    offsets: Vec<i32>,
    bytes: Vec<u8>,
    buffers: Vec<*const c_void>,
    children: Vec<*mut Array>,
}

/// What a stream points to.
struct StreamOwned {
    columns: Arc<Vec<Column>>,
    is_given: bool,
}

unsafe extern "C" fn release_schema(schema: *mut Schema) {
    // SAFETY: a schema of `schema_of`, released once: its owned part came from a box.
    unsafe {
        let owned = Box::from_raw((*schema).private_data.cast::<SchemaOwned>());
        for child in &owned.children {
            drop(Box::from_raw(*child));
        }
        (*schema).release = None;
    }
}

unsafe extern "C" fn release_array(array: *mut Array) {
    // SAFETY: an array of `array_of`, released once: its owned part came from a box.
    unsafe {
        let owned = Box::from_raw((*array).private_data.cast::<ArrayOwned>());
        for child in &owned.children {
            drop(Box::from_raw(*child));
        }
        (*array).release = None;
    }
}

unsafe extern "C" fn release_stream(stream: *mut Stream) {
    // SAFETY: a stream of `stream_of`, released once: its owned part came from a box.
    unsafe {
        drop(Box::from_raw((*stream).private_data.cast::<StreamOwned>()));
        (*stream).release = None;
    }
}

impl Drop for Schema {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            // SAFETY: not released yet.
            unsafe { release(self) }
        }
    }
}

impl Drop for Array {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            // SAFETY: not released yet.
            unsafe { release(self) }
        }
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            // SAFETY: not released yet.
            unsafe { release(self) }
        }
    }
}

fn schema_of(format: &CStr, name: &str, children: Vec<Schema>) -> Schema {
    let children: Vec<*mut Schema> =
        children.into_iter().map(|child| Box::into_raw(Box::new(child))).collect();
    let owned = Box::new(SchemaOwned {
        format: format.to_owned(),
        // Names of columns have no zero byte.
        name: CString::new(name).unwrap_or_default(),
        children,
    });
    Schema {
        format: owned.format.as_ptr(),
        name: owned.name.as_ptr(),
        metadata: null(),
        flags: 0,
        n_children: owned.children.len() as i64,
        children: if owned.children.is_empty() { null_mut() } else { owned.children.as_ptr().cast_mut() },
        dictionary: null_mut(),
        release: Some(release_schema),
        private_data: Box::into_raw(owned).cast(),
    }
}

fn table_schema(columns: &[Column]) -> Schema {
    let child = |(name, values): &Column| {
        let format = match values {
            Values::Double(_) => c"g",
            Values::Int(_) => c"l",
            Values::Text(_) => c"u",
        };
        schema_of(format, name, Vec::new())
    };
    schema_of(c"+s", "", columns.iter().map(child).collect())
}

/// An array over buffers of `owned`; validity, which all lack, first.
fn array_of(length: usize, mut owned: ArrayOwned, data: &[*const c_void]) -> Array {
    owned.buffers = std::iter::once(null()).chain(data.iter().copied()).collect();
    let owned = Box::new(owned);
    Array {
        length: length as i64,
        null_count: 0,
        offset: 0,
        n_buffers: owned.buffers.len() as i64,
        n_children: owned.children.len() as i64,
        buffers: owned.buffers.as_ptr().cast_mut(),
        children: if owned.children.is_empty() { null_mut() } else { owned.children.as_ptr().cast_mut() },
        dictionary: null_mut(),
        release: Some(release_array),
        private_data: Box::into_raw(owned).cast(),
    }
}

/// A column; numbers are the table's own memory, which the array holds.
fn column_array(columns: &Arc<Vec<Column>>, values: &Values) -> Array {
    let owned = |offsets: Vec<i32>, bytes: Vec<u8>| ArrayOwned {
        _columns: Arc::clone(columns),
        offsets: offsets,
        bytes: bytes,
        buffers: Vec::new(),
        children: Vec::new(),
    };
    match values {
        Values::Double(numbers) => {
            array_of(numbers.len(), owned(Vec::new(), Vec::new()), &[numbers.as_ptr().cast()])
        }
        Values::Int(numbers) => {
            array_of(numbers.len(), owned(Vec::new(), Vec::new()), &[numbers.as_ptr().cast()])
        }
        Values::Text(texts) => {
            let mut offsets = vec![0_i32];
            let mut bytes = Vec::new();
            for text in texts {
                bytes.extend_from_slice(text.as_bytes());
                offsets.push(i32::try_from(bytes.len()).unwrap_or(i32::MAX));
            }
            let owned = owned(offsets, bytes);
            let data = [owned.offsets.as_ptr().cast(), owned.bytes.as_ptr().cast()];
            array_of(texts.len(), owned, &data)
        }
    }
}

fn table_array(columns: &Arc<Vec<Column>>) -> Array {
    let child = |(_, values): &Column| Box::into_raw(Box::new(column_array(columns, values)));
    let owned = ArrayOwned {
        _columns: Arc::clone(columns),
        offsets: Vec::new(),
        bytes: Vec::new(),
        buffers: Vec::new(),
        children: columns.iter().map(child).collect(),
    };
    array_of(columns.first().map_or(0, |(_, values)| values.len()), owned, &[])
}

unsafe extern "C" fn get_schema(stream: *mut Stream, out: *mut Schema) -> c_int {
    // SAFETY: a stream that is not released, and room for a schema, which is not read.
    unsafe {
        let owned = &*(*stream).private_data.cast::<StreamOwned>();
        out.write(table_schema(&owned.columns));
    }
    0
}

unsafe extern "C" fn get_next(stream: *mut Stream, out: *mut Array) -> c_int {
    // SAFETY: a stream that is not released, and room for an array, which is not read.
    unsafe {
        let owned = &mut *(*stream).private_data.cast::<StreamOwned>();
        if owned.is_given {
            // The end of a stream is an array that is released already.
            (&raw mut (*out).release).write(None);
        } else {
            owned.is_given = true;
            out.write(table_array(&owned.columns));
        }
    }
    0
}

unsafe extern "C" fn get_last_error(_: *mut Stream) -> *const c_char {
    null()
}

/// The schema of a table.
pub(crate) fn schema_capsule<'py>(py: Python<'py>, columns: &[Column]) -> PyResult<Bound<'py, PyCapsule>> {
    PyCapsule::new_with_value(py, table_schema(columns), c"arrow_schema")
}

/// A table as one batch.
pub(crate) fn array_capsule<'py>(
    py: Python<'py>,
    columns: &Arc<Vec<Column>>,
) -> PyResult<Bound<'py, PyCapsule>> {
    PyCapsule::new_with_value(py, table_array(columns), c"arrow_array")
}

/// A table as a stream of one batch.
pub(crate) fn stream_capsule<'py>(
    py: Python<'py>,
    columns: &Arc<Vec<Column>>,
) -> PyResult<Bound<'py, PyCapsule>> {
    let owned = Box::new(StreamOwned { columns: Arc::clone(columns), is_given: false });
    let stream = Stream {
        get_schema: Some(get_schema),
        get_next: Some(get_next),
        get_last_error: Some(get_last_error),
        release: Some(release_stream),
        private_data: Box::into_raw(owned).cast(),
    };
    PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
}
