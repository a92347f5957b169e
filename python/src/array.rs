//! Arrays as frames, without a copy.
//!
//! An array states address, shape, strides and type in its `__array_interface__` (version 3), which
//! NumPy defines and others have. The view borrows the array's memory while its owner is held; what
//! other threads write into it meanwhile is theirs to answer for, as with NumPy itself.
#![allow(unsafe_code, reason = "an array's memory is known to Rust by its address alone")]

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use shadowgauge::frame::{FrameView, PixelFormat, Pixels};

use crate::errors::raise;

/// Values of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Container {
    U8,
    U16,
    F32,
}

impl Container {
    const fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::F32 => 4,
        }
    }
}

/// An array that can be viewed as a frame.
pub(crate) struct Array<'py> {
    /// Holds the memory.
    _owner: Bound<'py, PyAny>,
    view: FrameView<'py>,
}

/// What an array states of itself.
struct Interface {
    address: usize,
    shape: (usize, usize),
    /// Bytes from one row to the next, and from one column.
    strides: (isize, isize),
    type_text: String,
}

impl Interface {
    fn in_words(&self) -> String {
        format!(
            "dtype {}, shape ({}, {}), strides ({}, {}) bytes",
            self.type_text, self.shape.0, self.shape.1, self.strides.0, self.strides.1
        )
    }
}

fn item<'py>(of: &Bound<'py, PyDict>, key: &str) -> PyResult<Bound<'py, PyAny>> {
    let missing = || raise(of.py(), "FrameError", format!("__array_interface__ has no {key:?}"));
    of.get_item(key)?.ok_or_else(missing)
}

/// What an array states.
fn interface(array: &Bound<'_, PyAny>) -> PyResult<Interface> {
    let py = array.py();
    let frame_error = |text: String| raise(py, "FrameError", text);
    let Ok(found) = array.getattr("__array_interface__") else {
        let class = array.get_type();
        return Err(frame_error(format!(
            "a frame is a NumPy array of two dimensions (or another with __array_interface__), not a {}",
            class.name()?
        )));
    };
    let found =
        found.cast_into::<PyDict>().map_err(|_| frame_error("__array_interface__ is no dict".to_owned()))?;
    let type_text: String = item(&found, "typestr")?.extract()?;
    let shape: Vec<usize> = item(&found, "shape")?.extract()?;
    let [rows, columns] = shape.as_slice() else {
        return Err(frame_error(format!(
            "a frame has two dimensions, rows and columns; the array has {} (dtype {type_text}, shape {shape:?}): \
             pass one frame, and of a colour image one channel",
            shape.len()
        )));
    };
    let (address, _): (usize, bool) = item(&found, "data")?.extract()?;
    let bytes = type_text.get(2..).and_then(|size| size.parse::<isize>().ok()).unwrap_or(1);
    let strides = match found.get_item("strides")? {
        Some(strides) if !strides.is_none() => {
            let strides = strides.cast_into::<PyTuple>().map_err(PyErr::from)?;
            (strides.get_item(0)?.extract::<isize>()?, strides.get_item(1)?.extract::<isize>()?)
        }
        _ => (bytes * columns.cast_signed(), bytes),
    };
    Ok(Interface { address, shape: (*rows, *columns), strides, type_text })
}

/// The container of a type, or what to do with one that no frame has.
fn container(type_text: &str) -> Result<Container, &'static str> {
    match type_text {
        "|u1" => Ok(Container::U8),
        "<u2" if cfg!(target_endian = "little") => Ok(Container::U16),
        "<f4" if cfg!(target_endian = "little") => Ok(Container::F32),
        ">u2" if cfg!(target_endian = "big") => Ok(Container::U16),
        ">f4" if cfg!(target_endian = "big") => Ok(Container::F32),
        ">u2" | ">f4" | "<u2" | "<f4" => {
            Err("its bytes are in the other order: pass array.astype(array.dtype.newbyteorder('='))")
        }
        "<f2" | ">f2" | "<f8" | ">f8" => Err(
            "frames are uint8, uint16 or float32: pass array.astype(numpy.float32), which a frame of counts survives",
        ),
        _ => Err("frames are uint8, uint16 or float32: pass the camera's own counts"),
    }
}

impl<'py> Array<'py> {
    /// Reads an array as a frame. `bits` is the depth of its grey values; without it 8 for uint8, and
    /// for uint16 what the command line takes for a file that states none: 12 where every value
    /// fits, else 16. `full_scale` is the largest grey value where it is another.
    ///
    /// # Errors
    /// `FrameError`, with dtype and strides: no array of two dimensions, a type or strides that the
    /// gauge cannot read, a depth that does not fit.
    pub(crate) fn read(
        array: &Bound<'py, PyAny>,
        bits: Option<u8>,
        full_scale: Option<f32>,
    ) -> PyResult<Self> {
        let py = array.py();
        let stated = interface(array)?;
        let refuse = |why: &str| raise(py, "FrameError", format!("a frame of {}: {why}", stated.in_words()));
        let container = container(&stated.type_text).map_err(refuse)?;
        let strides = elements(&stated, container).map_err(refuse)?;
        let (rows, columns) = stated.shape;
        if rows == 0 || columns == 0 {
            return Err(refuse("it has no pixel; both dimensions must be at least 1"));
        }
        let length = (rows - 1) * strides.0 + (columns - 1) * strides.1 + 1;
        let pixels = pixels(stated.address, length, container);
        let format = format(&pixels, bits).map_err(|why| refuse(&why))?;
        let view = FrameView::strided((pixels, format), stated.shape, strides);
        let view = view.map_err(|error| refuse(&error.to_string()))?;
        let view = full_scale.map_or(view, |counts| view.with_full_scale(counts));
        Ok(Self { _owner: array.clone(), view })
    }

    /// The frame, while the array is held.
    pub(crate) fn view(&self) -> FrameView<'_> {
        self.view
    }
}

/// Strides in elements.
fn elements(stated: &Interface, container: Container) -> Result<(usize, usize), &'static str> {
    let bytes = container.bytes();
    let (rows, columns) = stated.shape;
    let one = |stride: isize, count: usize| match usize::try_from(stride) {
        // Never stepped by.
        _ if count <= 1 => Ok(1),
        Err(_) => Err("a stride is negative: pass numpy.ascontiguousarray(array)"),
        Ok(0) => Err("a stride is 0 (a broadcast array): pass numpy.ascontiguousarray(array)"),
        Ok(stride) if stride % bytes == 0 => Ok(stride / bytes),
        Ok(_) => Err("a stride is no multiple of the pixel: pass numpy.ascontiguousarray(array)"),
    };
    if !stated.address.is_multiple_of(bytes) {
        return Err("its pixels are not aligned: pass numpy.ascontiguousarray(array)");
    }
    Ok((one(stated.strides.0, rows)?, one(stated.strides.1, columns)?))
}

/// The array's memory from its first to its last pixel.
fn pixels<'a>(address: usize, length: usize, container: Container) -> Pixels<'a> {
    // SAFETY: by its `__array_interface__` the array has pixels of this type at `address` and up to
    // `length` elements on, with strides above 0 between them; alignment was checked, every bit
    // pattern is a value of these types, and `Array` holds the owner as long as the view.
    unsafe {
        match container {
            Container::U8 => Pixels::U8(std::slice::from_raw_parts(address as *const u8, length)),
            Container::U16 => Pixels::U16(std::slice::from_raw_parts(address as *const u16, length)),
            Container::F32 => Pixels::F32(std::slice::from_raw_parts(address as *const f32, length)),
        }
    }
}

fn format(pixels: &Pixels<'_>, bits: Option<u8>) -> Result<PixelFormat, String> {
    match (pixels, bits) {
        (Pixels::U8(_), None | Some(8)) => Ok(PixelFormat::Mono8),
        (Pixels::U16(_), Some(10)) => Ok(PixelFormat::Mono10),
        (Pixels::U16(_), Some(12)) => Ok(PixelFormat::Mono12),
        (Pixels::U16(_), Some(14)) => Ok(PixelFormat::Mono14),
        (Pixels::U16(_), Some(16)) => Ok(PixelFormat::Mono16),
        // As the command line for a file that states no depth.
        (Pixels::U16(values), None) => match values.iter().all(|value| *value <= 4095) {
            true => Ok(PixelFormat::Mono12),
            false => Ok(PixelFormat::Mono16),
        },
        (Pixels::F32(_), None) => Ok(PixelFormat::F32),
        (_, Some(bits)) => Err(format!(
            "bits = {bits} does not fit it: 8 with uint8; 10, 12, 14 or 16 with uint16; none with float32, \
             whose full_scale may be given"
        )),
    }
}
