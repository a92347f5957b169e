//! Two windows of rows of every frame, one an edge, in place of the whole: what a camera with two
//! regions reads out.
//!
//! In: a producer of whole frames, and the windows. Out: a producer of frames that hold the upper
//! window's rows and the lower one's beneath them. Both windows stand in the metadata
//! ([`FrameMeta::second_roi`](crate::frame::FrameMeta)), by which a gauge puts the edges apart
//! again.

use std::ops::Range;
use std::str::FromStr;
use std::time::Duration;

use super::producer::{Produced, Producer};
use crate::frame::{Buffer, CameraBinding, Frame, FrameMeta, Pixels, Roi};

/// Rows of two windows of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TwoWindows {
    /// First row of either.
    first: [u32; 2],
    /// Rows of each.
    rows: u32,
}

impl FromStr for TwoWindows {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let right = "the first rows of both windows and their height are needed, for instance 640,1340,64";
        let numbers: Result<Vec<u32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
        let [upper, lower, rows] = numbers.unwrap_or_default()[..] else { return Err(right.to_owned()) };
        match upper.checked_add(rows) {
            _ if rows == 0 => Err(right.to_owned()),
            Some(end) if end <= lower && lower.checked_add(rows).is_some() => {
                Ok(Self { first: [upper, lower], rows })
            }
            _ => Err(format!("the lower window begins within the upper one or above it; {right}")),
        }
    }
}

impl TwoWindows {
    /// Both windows of a frame, in the memory of an earlier one.
    ///
    /// # Errors
    /// A frame that ends within the lower window.
    fn cut(&self, frame: &Frame, reuse: Option<Frame>) -> Result<Frame, String> {
        let (view, rows) = (frame.view(), self.rows as usize);
        let (columns, end) = (view.columns(), self.first[1] as usize + rows);
        if end > view.rows() {
            return Err(format!("the lower window ends at row {end}, and frames have {} rows", view.rows()));
        }
        let spans = self.first.map(|row| row as usize * columns..(row as usize + rows) * columns);
        let buffer = match (view.pixels(), reuse.map(Frame::into_buffer)) {
            (Pixels::U8(p), Some(Buffer::U8(to))) => Buffer::U8(joined(p, &spans, to)),
            (Pixels::U8(p), _) => Buffer::U8(joined(p, &spans, Vec::new())),
            (Pixels::U16(p), Some(Buffer::U16(to))) => Buffer::U16(joined(p, &spans, to)),
            (Pixels::U16(p), _) => Buffer::U16(joined(p, &spans, Vec::new())),
            (Pixels::F32(p), _) => Buffer::F32(joined(p, &spans, Vec::new())),
        };
        let meta = self.meta(&frame.meta, columns);
        let cut =
            Frame::new(buffer, view.format(), 2 * rows, columns, meta).map_err(|why| why.to_string())?;
        let own = view.format().full_scale().map(f32::from);
        Ok(match view.full_scale().filter(|scale| Some(*scale) != own) {
            Some(counts) => cut.with_full_scale(counts),
            None => cut,
        })
    }

    fn meta(&self, of: &FrameMeta, columns: usize) -> FrameMeta {
        let from = of.roi.unwrap_or_default();
        let columns = u32::try_from(columns).unwrap_or(u32::MAX);
        let window = |row: u32| {
            Some(Roi { row: from.row.saturating_add(row), column: from.column, rows: self.rows, columns })
        };
        let [roi, second_roi] = self.first.map(window);
        FrameMeta { roi, second_roi, ..of.clone() }
    }
}

fn joined<T: Copy>(pixels: &[T], spans: &[Range<usize>; 2], mut to: Vec<T>) -> Vec<T> {
    to.clear();
    spans.iter().filter_map(|span| pixels.get(span.clone())).for_each(|rows| to.extend_from_slice(rows));
    to
}

/// A producer whose frames are cut to two windows.
pub(crate) struct Windowed {
    producer: Box<dyn Producer>,
    windows: TwoWindows,
    /// Memory of a whole frame, and of one of windows.
    whole: Option<Frame>,
    cut: Option<Frame>,
}

impl Windowed {
    /// The frames of a producer, cut.
    pub(crate) fn new(producer: Box<dyn Producer>, windows: TwoWindows) -> Self {
        Self { producer, windows, whole: None, cut: None }
    }
}

impl Producer for Windowed {
    fn produce(&mut self, spare: Option<Frame>, wait: Duration) -> Produced {
        self.cut = spare.or(self.cut.take());
        let mut new = match self.producer.produce(self.whole.take(), wait) {
            Produced::Frame(new) => new,
            other => return other,
        };
        match self.windows.cut(&new.frame, self.cut.take()) {
            Ok(cut) => {
                self.whole = Some(std::mem::replace(&mut new.frame, cut));
                Produced::Frame(new)
            }
            Err(why) => Produced::End(Some(why)),
        }
    }

    fn start(&mut self) {
        self.producer.start();
    }

    fn stop(&mut self) {
        self.producer.stop();
    }

    fn camera(&self) -> Option<&CameraBinding> {
        self.producer.camera()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::PixelFormat;

    fn frame(roi: Option<Roi>) -> Frame {
        let buffer = Buffer::U16((0..40).collect());
        let meta = FrameMeta { frame_id: 7, roi, ..FrameMeta::default() };
        Frame::new(buffer, PixelFormat::Mono12, 10, 4, meta).unwrap()
    }

    #[test]
    fn the_rows_of_both_windows_stand_one_beneath_the_other() {
        let windows: TwoWindows = "1,6,2".parse().unwrap();
        let roi = Some(Roi { row: 100, column: 30, rows: 10, columns: 4 });
        for reuse in [None, Some(frame(None))] {
            let cut = windows.cut(&frame(roi), reuse).unwrap();
            let window = |row| Some(Roi { row, column: 30, rows: 2, columns: 4 });
            assert_eq!((cut.meta.frame_id, cut.meta.roi, cut.meta.second_roi), (7, window(101), window(106)));
            assert_eq!(cut.meta.rows_between(), Some(3));
            assert_eq!(cut.view().format(), PixelFormat::Mono12);
            assert_eq!(cut.into_buffer(), Buffer::U16((4..12).chain(24..32).collect()));
        }
        assert_eq!(frame(roi).meta.rows_between(), None);
    }

    #[test]
    fn windows_that_cannot_be_are_refused_with_what_would_be_right() {
        for text in ["", "1,2", "1,6,0", "a,6,2", "1,6,2,3", "-1,6,2", "4294967295,6,2", "5,6,2", "6,1,2"] {
            let why = text.parse::<TwoWindows>().unwrap_err();
            assert!(why.contains("640,1340,64"), "{text}: {why}");
        }
        let why = "1,9,2".parse::<TwoWindows>().unwrap().cut(&frame(None), None).unwrap_err();
        assert!(why.contains("row 11") && why.contains("10 rows"), "{why}");
    }
}
