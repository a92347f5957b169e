//! Memory of frames that were measured and of files that were decoded, for those that come next.
//!
//! Memory of some megabytes that is allocated anew is mapped page by page as it is written: 2048
//! faults a frame of 8 MiB. Only as much is kept as was lent before, and no more pieces than frames
//! are under way at once.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::frame::Buffer;

/// Memory that is shared by who reads, who decodes and who measures.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spare {
    shelves: Arc<Mutex<Shelves>>,
    /// Most pieces of a kind that are kept.
    most: usize,
}

#[derive(Debug, Default)]
struct Shelves {
    files: Shelf<u8>,
    octets: Shelf<u8>,
    words: Shelf<u16>,
}

#[derive(Debug, Default)]
struct Shelf<T> {
    lent: usize,
    there: Vec<Vec<T>>,
}

impl<T> Shelf<T> {
    fn lend(&mut self) -> Vec<T> {
        self.lent += 1;
        self.there.pop().unwrap_or_default()
    }

    /// What was never lent is not asked for again.
    fn take_back(&mut self, memory: Vec<T>, most: usize) {
        if self.lent > 0 && self.there.len() < most {
            self.lent -= 1;
            self.there.push(memory);
        }
    }
}

impl Spare {
    /// Keeps at most so many pieces of a kind.
    pub(super) fn of(most: usize) -> Self {
        Self { shelves: Arc::default(), most }
    }

    fn shelves(&self) -> MutexGuard<'_, Shelves> {
        self.shelves.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Empty memory for a file.
    pub(super) fn file(&self) -> Vec<u8> {
        let mut memory = self.shelves().files.lend();
        memory.clear();
        memory
    }

    /// So many bytes, to be written over.
    pub(super) fn octets(&self, count: usize) -> Vec<u8> {
        let mut memory = self.shelves().octets.lend();
        memory.resize(count, 0);
        memory
    }

    /// Empty memory for so many words.
    pub(super) fn words(&self, count: usize) -> Vec<u16> {
        let mut memory = self.shelves().words.lend();
        memory.clear();
        memory.reserve_exact(count);
        memory
    }

    /// Takes the memory of a file.
    pub(super) fn take_file(&self, file: Vec<u8>) {
        self.shelves().files.take_back(file, self.most);
    }

    /// Takes the memory of a frame.
    pub(super) fn take_buffer(&self, buffer: Buffer) {
        match buffer {
            Buffer::U8(octets) => self.shelves().octets.take_back(octets, self.most),
            Buffer::U16(words) => self.shelves().words.take_back(words, self.most),
            Buffer::F32(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_comes_back_and_no_more_is_kept_than_was_lent_or_is_allowed() {
        let spare = Spare::of(2);
        // Frames of formats whose readers allocate their own.
        (0..5).for_each(|_| spare.take_buffer(Buffer::U16(vec![0; 10])));
        assert!(spare.shelves().words.there.is_empty());
        let lent: Vec<Vec<u16>> = (0..4).map(|_| spare.words(100)).collect();
        let places: Vec<*const u16> = lent.iter().map(Vec::as_ptr).collect();
        lent.into_iter().for_each(|words| spare.take_buffer(Buffer::U16(words)));
        assert_eq!(spare.shelves().words.there.len(), 2);
        let again = spare.words(50);
        assert!(again.is_empty() && again.capacity() == 100 && again.as_ptr() == places[1]);
        let (mut file, octets) = (spare.file(), spare.octets(3));
        assert_eq!((file.len(), octets.len()), (0, 3));
        file.push(7);
        spare.take_file(file);
        assert!(spare.file().is_empty());
    }
}
