//! Block and frame ids of 16 to 64 bits to sequence numbers of 64 bits.
//!
//! GigE Vision 1.x counts blocks from 1 to 65535 and leaves 0 out (GigE Vision 2.0, 24.1: block_id
//! 0 is reserved for test packets), so that its period is 65535. An id is taken for the nearest
//! number to the last one: half a period may be lost in a row.

/// How ids count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum IdWidth {
    /// 16 bits from 1 to 65535; 0 is left out.
    GigE16,
    /// 16 bits from 0 to 65535.
    #[cfg_attr(not(test), allow(dead_code, reason = "ids of other transports than GigE Vision"))]
    Bits16,
    /// 32 bits from 0.
    #[cfg_attr(not(test), allow(dead_code, reason = "ids of other transports than GigE Vision"))]
    Bits32,
    /// 64 bits: numbers as they are.
    Bits64,
}

impl IdWidth {
    /// Ids after which they repeat; 2⁶⁴ for 64 bits.
    fn period(self) -> i128 {
        match self {
            Self::GigE16 => 65_535,
            Self::Bits16 => 1 << 16,
            Self::Bits32 => 1 << 32,
            Self::Bits64 => 1 << 64,
        }
    }

    /// The first id after a start.
    fn first(self) -> u64 {
        u64::from(self == Self::GigE16)
    }
}

/// Ids of one stream to sequence numbers.
#[derive(Clone, Debug)]
pub(crate) struct Unwrapper {
    width: IdWidth,
    /// Largest number so far with its position in the period.
    newest: Option<(u64, i128)>,
    /// Number of the first frame after a restart.
    restarted_at: u64,
}

impl Unwrapper {
    /// Ids of this width; an acquisition's first id is number 0.
    pub(crate) fn new(width: IdWidth) -> Self {
        Self { width, newest: None, restarted_at: 0 }
    }

    /// The sequence number of an id: below that of an earlier one for a frame that comes late or
    /// again. `None` for an id that the width does not have (0 in GigE Vision 1.x), and for one
    /// before number 0.
    pub(crate) fn number(&mut self, id: u64) -> Option<u64> {
        let period = self.width.period();
        let position = i128::from(id) - i128::from(self.width.first());
        if !(0..period).contains(&position) {
            return None;
        }
        let number = match self.newest {
            None => i128::from(self.restarted_at) + if self.restarted_at == 0 { position } else { 0 },
            Some((newest, at)) => {
                let ahead = (position - at).rem_euclid(period);
                let nearest = if ahead <= period / 2 { ahead } else { ahead - period };
                i128::from(newest) + nearest
            }
        };
        let number = u64::try_from(number).ok()?;
        if self.newest.is_none_or(|(newest, _)| number > newest) {
            self.newest = Some((number, position));
        }
        Some(number)
    }

    /// The ids begin anew (a camera that was away): the next one, whatever it is, is that after the
    /// largest so far.
    #[cfg_attr(not(test), allow(dead_code, reason = "a camera's ids may change their width, too"))]
    pub(crate) fn restart(&mut self) {
        if let Some((newest, _)) = self.newest.take() {
            self.restarted_at = newest + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_of_every_width_wrap_without_a_gap() {
        for (width, period, first) in
            [(IdWidth::GigE16, 65_535, 1), (IdWidth::Bits16, 65_536, 0), (IdWidth::Bits32, 1_u64 << 32, 0)]
        {
            let mut unwrapper = Unwrapper::new(width);
            // Steps of up to half a period: the id by its definition, counted in 128 bits.
            let steps = [0, 1, 1, period / 2, period / 2, 1, 2, period / 3, period / 3, period / 3, 1];
            let mut number = 0;
            for step in steps {
                number += step;
                assert_eq!(unwrapper.number(number % period + first), Some(number), "{width:?}");
            }
        }
    }

    #[test]
    fn gige_ids_leave_zero_out() {
        let mut unwrapper = Unwrapper::new(IdWidth::GigE16);
        for number in 0..200_000_u64 {
            assert_eq!(unwrapper.number(number % 65_535 + 1), Some(number));
        }
        assert_eq!(unwrapper.number(0), None);
        assert_eq!(unwrapper.number(65_536), None);
    }

    #[test]
    fn a_late_frame_has_its_own_number_and_moves_nothing() {
        let mut unwrapper = Unwrapper::new(IdWidth::GigE16);
        for id in [65_533, 65_534, 65_535] {
            unwrapper.number(id);
        }
        assert_eq!(unwrapper.number(1), Some(65_535));
        assert_eq!(unwrapper.number(65_534), Some(65_533));
        assert_eq!(unwrapper.number(2), Some(65_536));
        // Before number 0 there is none.
        let mut unwrapper = Unwrapper::new(IdWidth::Bits16);
        assert_eq!((unwrapper.number(0), unwrapper.number(65_535)), (Some(0), None));
    }

    #[test]
    fn after_a_restart_numbers_go_on() {
        let mut unwrapper = Unwrapper::new(IdWidth::GigE16);
        assert_eq!([1, 2, 5].map(|id| unwrapper.number(id)), [Some(0), Some(1), Some(4)]);
        unwrapper.restart();
        assert_eq!([1, 2].map(|id| unwrapper.number(id)), [Some(5), Some(6)]);
        unwrapper.restart();
        // The first frame after the return was the camera's 40th.
        assert_eq!([40, 41].map(|id| unwrapper.number(id)), [Some(7), Some(8)]);
    }

    #[test]
    fn numbers_of_64_bits_are_taken_as_they_are() {
        let mut unwrapper = Unwrapper::new(IdWidth::Bits64);
        for number in [0, 7, u64::from(u32::MAX) + 9, 1 << 62] {
            assert_eq!(unwrapper.number(number), Some(number));
        }
    }
}
