//! Lines of a program that another one does not have at their place.

/// Longest texts, lines, that are compared line by line: a table of 16 MB.
const LONGEST: usize = 2000;

/// Lines of `new`, from 1, that are in no longest common subsequence with `old`; comments count.
/// Of texts with more than 2000 lines that differ, all lines between the first and the last
/// difference.
pub(super) fn changed(old: &str, new: &str) -> Vec<usize> {
    let (old, new): (Vec<&str>, Vec<&str>) = (old.lines().collect(), new.lines().collect());
    let head = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
    let (old, rest) = (&old[head..], &new[head..]);
    let tail = old.iter().rev().zip(rest.iter().rev()).take_while(|(a, b)| a == b).count();
    let (old, new) = (&old[..old.len() - tail], &rest[..rest.len() - tail]);
    if old.len() > LONGEST || new.len() > LONGEST {
        return (head + 1..=head + new.len()).collect();
    }
    // common[i][j]: length of the longest common subsequence of old[i..] and new[j..]
    let columns = new.len() + 1;
    let mut common = vec![0_u16; (old.len() + 1) * columns];
    for i in (0..old.len()).rev() {
        for j in (0..new.len()).rev() {
            common[i * columns + j] = match old[i] == new[j] {
                true => common[(i + 1) * columns + j + 1] + 1,
                false => common[(i + 1) * columns + j].max(common[i * columns + j + 1]),
            };
        }
    }
    let (mut i, mut j, mut lines) = (0, 0, Vec::new());
    while j < new.len() {
        if i < old.len() && old[i] == new[j] {
            (i, j) = (i + 1, j + 1);
        } else if i < old.len() && common[(i + 1) * columns + j] >= common[i * columns + j + 1] {
            i += 1;
        } else {
            lines.push(head + j + 1);
            j += 1;
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::changed;

    #[test]
    fn a_line_that_was_put_in_or_altered_is_named_and_no_other() {
        assert_eq!(changed("a\nb\nc", "a\nb\nc"), [0; 0]);
        assert_eq!(changed("a\nb\nc", "a\nx\nb\nc"), [2]);
        assert_eq!(changed("a\nb\nc", "a\nc"), [0; 0]);
        assert_eq!(changed("a\nb\nc\nd", "a\nx\nc\ny\nd"), [2, 4]);
        assert_eq!(changed("", "a\nb"), [1, 2]);
        assert_eq!(changed("b\nc\na", "a\nb\nc"), [1]);
    }
}
