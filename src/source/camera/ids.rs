//! Block ids of a stream to sequence numbers that go on when the camera was away.
//!
//! GigE Vision: ids begin with 1 at a start (GigE Vision 2.0, 24.1). Those of 16 bits wrap to 1;
//! one beyond 65535 shows that the camera counts with 64 bits, as it may have done from the start.
//! USB3 Vision: 64 bits, the first one 0 (USB3 Vision 1.1, 5.2.1).

use crate::source::live::{IdWidth, Unwrapper};

/// Ids of a camera to sequence numbers.
#[derive(Clone, Debug)]
pub(crate) struct Ids {
    ids: Unwrapper,
    is_long: bool,
    /// Added to an id: the first one is 1 here.
    offset: u64,
    /// Number of the first frame after the last restart, and its position then.
    base: u64,
    first: Option<u64>,
    newest: Option<u64>,
}

impl Ids {
    /// The first id of an acquisition is number 0.
    pub(super) fn new() -> Self {
        let ids = Unwrapper::new(IdWidth::GigE16);
        Self { ids, is_long: false, offset: 0, base: 0, first: Some(0), newest: None }
    }

    /// As [`Self::new`], for ids of 64 bits that begin with 0.
    #[cfg(any(feature = "camera-usb", test))]
    pub(super) fn of_64_bits_from_0() -> Self {
        Self { ids: Unwrapper::new(IdWidth::Bits64), is_long: true, offset: 1, ..Self::new() }
    }

    /// The sequence number of a block id; `None` for 0, and for one before the first.
    pub(super) fn number(&mut self, id: u64) -> Option<u64> {
        let id = id.checked_add(self.offset)?;
        if id > u64::from(u16::MAX) && !self.is_long {
            self.is_long = true;
            self.ids = Unwrapper::new(IdWidth::Bits64);
        }
        let position =
            if self.is_long { self.ids.number(id.checked_sub(1)?)? } else { self.ids.number(id)? };
        let first = *self.first.get_or_insert(position);
        let number = self.base + position.checked_sub(first)?;
        self.newest = self.newest.max(Some(number));
        Some(number)
    }

    /// Ids begin anew: the next one, whatever it is, is that after the largest so far.
    pub(super) fn restart(&mut self) {
        let Some(newest) = self.newest else { return };
        let begun = Self { offset: self.offset, ..Self::new() };
        *self = Self { base: newest + 1, first: None, newest: self.newest, ..begun };
        if self.offset > 0 {
            (self.ids, self.is_long) = (Unwrapper::new(IdWidth::Bits64), true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_of_16_bits_wrap_to_1_and_those_of_64_bits_do_not() {
        let mut ids = Ids::new();
        assert_eq!(ids.number(0), None, "reserved for test packets");
        let seen: Vec<u64> = [1, 2, 5, 30_000, 60_000].iter().filter_map(|id| ids.number(*id)).collect();
        assert_eq!(seen, [0, 1, 4, 29_999, 59_999]);
        let mut long = ids.clone();
        assert_eq!([65_535, 1, 2].map(|id| ids.number(id)), [65_534, 65_535, 65_536].map(Some));
        assert_eq!([65_535, 65_536, 70_001].map(|id| long.number(id)), [65_534, 65_535, 70_000].map(Some));
    }

    #[test]
    fn numbers_go_on_after_a_restart_whatever_the_first_id_is() {
        let mut ids = Ids::new();
        ids.restart();
        assert_eq!([1, 2, 3].map(|id| ids.number(id)), [0, 1, 2].map(Some));
        ids.restart();
        assert_eq!([900, 902, 899].map(|id| ids.number(id)), [Some(3), Some(5), None]);
        ids.restart();
        assert_eq!([80_000, 80_001].map(|id| ids.number(id)), [6, 7].map(Some));
    }

    #[test]
    fn ids_from_0_are_numbers_as_they_are_and_go_on_after_a_restart() {
        let mut ids = Ids::of_64_bits_from_0();
        assert_eq!([0, 1, 70_000].map(|id| ids.number(id)), [0, 1, 70_000].map(Some));
        ids.restart();
        assert_eq!([0, 1].map(|id| ids.number(id)), [70_001, 70_002].map(Some));
    }
}
