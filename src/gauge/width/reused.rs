//! Lists whose memory a thread keeps and uses again: scratch of what is computed for every frame,
//! so that a warm stream allocates nothing.

use std::cell::RefCell;
use std::ops::{Deref, DerefMut};
use std::thread::LocalKey;

/// Lists of one type that a thread keeps: more than any computation holds at once; the memory of
/// the others is given back.
const MOST_KEPT: usize = 16;

type Kept<T> = RefCell<Vec<Vec<T>>>;

/// An element whose lists are kept.
pub(crate) trait Element: Copy + 'static {
    /// The lists that this thread keeps.
    fn kept() -> &'static LocalKey<Kept<Self>>;
}

macro_rules! elements {
    ($($type:ty),*) => {$(
        impl Element for $type {
            fn kept() -> &'static LocalKey<Kept<Self>> {
                thread_local! { static KEPT: Kept<$type> = const { RefCell::new(Vec::new()) }; }
                &KEPT
            }
        }
    )*};
}

elements!(usize, f64, (bool, bool), (f64, f64), (f64, f64, f64), (f64, f64, f64, f64));

/// A list in memory that its thread has kept; [`Iterator::collect`] makes one.
#[derive(Debug)]
pub(crate) struct Reused<T: Element>(Vec<T>);

impl<T: Element> Reused<T> {
    /// Adds a value at the end.
    pub(crate) fn push(&mut self, value: T) {
        self.0.push(value);
    }
}

impl<T: Element> FromIterator<T> for Reused<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        // The thread may be ending: then there is nothing to be kept.
        let kept = T::kept().try_with(|kept| kept.borrow_mut().pop()).ok().flatten();
        let mut list = Self(kept.unwrap_or_default());
        list.0.extend(values);
        list
    }
}

impl<T: Element> Clone for Reused<T> {
    fn clone(&self) -> Self {
        self.iter().copied().collect()
    }
}

impl<T: Element> Deref for Reused<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T: Element> DerefMut for Reused<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.0
    }
}

impl<T: Element> Drop for Reused<T> {
    fn drop(&mut self) {
        let mut list = std::mem::take(&mut self.0);
        list.clear();
        let _ = T::kept().try_with(|kept| {
            let mut kept = kept.borrow_mut();
            if kept.len() < MOST_KEPT {
                kept.push(list);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_used_again_and_holds_nothing_of_before() {
        let first: Reused<f64> = (0..100).map(f64::from).collect();
        let place = first.as_ptr();
        let other: Reused<f64> = (0..3).map(f64::from).collect();
        assert_ne!(other.as_ptr(), place);
        drop((other, first));
        let again: Reused<f64> = [7.0, 8.0].into_iter().collect();
        assert_eq!((again.as_ptr(), &again[..]), (place, &[7.0, 8.0][..]));
        let sorted = again.clone();
        assert_eq!(sorted[..], again[..]);
    }
}
