//! Names in the order of the numbers in them: `img2` before `img10`.

use std::cmp::Ordering;

/// Compares runs of digits by their value, of any length, and everything else byte by byte; names
/// that differ only in leading zeros are in alphabetical order.
pub(crate) fn natural(a: &str, b: &str) -> Ordering {
    let (mut left, mut right) = (a.as_bytes(), b.as_bytes());
    while let ([x, ..], [y, ..]) = (left, right) {
        if x.is_ascii_digit() && y.is_ascii_digit() {
            let (m, n) = (number(&mut left), number(&mut right));
            match m.len().cmp(&n.len()).then_with(|| m.cmp(n)) {
                Ordering::Equal => {}
                other => return other,
            }
        } else if x == y {
            (left, right) = (&left[1..], &right[1..]);
        } else {
            return x.cmp(y);
        }
    }
    left.len().cmp(&right.len()).then_with(|| a.cmp(b))
}

/// Removes the leading run of digits and returns it without its leading zeros.
fn number<'a>(rest: &mut &'a [u8]) -> &'a [u8] {
    let end = rest.iter().position(|b| !b.is_ascii_digit()).unwrap_or(rest.len());
    let (digits, after) = rest.split_at(end);
    *rest = after;
    let zeros = digits.iter().position(|b| *b != b'0').unwrap_or(digits.len());
    &digits[zeros..]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn numbers_stand_by_their_value() {
        let mut names = ["img10", "img2", "img1", "img002", "img", "a1b10", "a1b9", "img10b", "Img3"];
        names.sort_by(|a, b| natural(a, b));
        let right = ["Img3", "a1b9", "a1b10", "img", "img1", "img002", "img2", "img10", "img10b"];
        assert_eq!(names, right);
        // Longer than any machine number.
        assert_eq!(natural("9".repeat(40).as_str(), &format!("1{}", "0".repeat(40))), Ordering::Less);
    }

    proptest! {
        #[test]
        fn it_is_an_order(a in "[a-c0-3]{0,6}", b in "[a-c0-3]{0,6}", c in "[a-c0-3]{0,6}") {
            prop_assert_eq!(natural(&a, &b), natural(&b, &a).reverse());
            prop_assert_eq!(natural(&a, &b) == Ordering::Equal, a == b);
            if natural(&a, &b).is_le() && natural(&b, &c).is_le() {
                prop_assert!(natural(&a, &c).is_le());
            }
        }

        #[test]
        fn names_padded_with_zeros_keep_their_plain_order(mut n in prop::collection::vec(0_u32..100_000, 2..9)) {
            let mut plain: Vec<String> = n.iter().map(|n| format!("f{n:06}")).collect();
            let mut numbered = plain.clone();
            plain.sort();
            numbered.sort_by(|a, b| natural(a, b));
            prop_assert_eq!(plain, numbered);
            n.sort_unstable();
            let mut bare: Vec<String> = n.iter().rev().map(|n| format!("f{n}")).collect();
            bare.sort_by(|a, b| natural(a, b));
            prop_assert_eq!(bare, n.iter().map(|n| format!("f{n}")).collect::<Vec<_>>());
        }
    }
}
