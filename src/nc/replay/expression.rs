//! Words and expressions of a block: numbers, `#` variables, brackets, the operators and functions
//! of custom macro B and of LinuxCNC.

use std::collections::HashMap;

/// Values of `#` variables; a variable that was never set has none.
pub(super) type Variables = HashMap<u32, f64>;

type Function = (&'static str, fn(f64) -> f64);
type Comparison = (&'static str, fn(f64, f64) -> bool);

/// Reads a block from left to right.
pub(super) struct Reader<'a> {
    rest: &'a str,
    variables: &'a Variables,
}

impl<'a> Reader<'a> {
    pub(super) fn new(text: &'a str, variables: &'a Variables) -> Self {
        Self { rest: text.trim_start(), variables }
    }

    pub(super) fn rest(&self) -> &'a str {
        self.rest
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// Takes `word` where it comes next.
    pub(super) fn takes(&mut self, word: &str) -> bool {
        match self.rest.strip_prefix(word) {
            Some(rest) => {
                self.rest = rest.trim_start();
                true
            }
            None => false,
        }
    }

    /// Takes a letter where one comes next.
    pub(super) fn letter(&mut self) -> Option<char> {
        let letter = self.rest.chars().next().filter(char::is_ascii_alphabetic)?;
        self.rest = self.rest[1..].trim_start();
        Some(letter)
    }

    /// A number, a variable or a bracket, with its sign; and whether it was written as a whole
    /// number.
    pub(super) fn value(&mut self) -> Result<(f64, bool), String> {
        if self.takes("-") {
            return self.value().map(|(v, whole)| (-v, whole));
        }
        if self.takes("+") {
            return self.value();
        }
        if self.takes("[") {
            let value = self.comparison()?;
            return if self.takes("]") { Ok((value, false)) } else { Err("a bracket is not closed".into()) };
        }
        if self.takes("#") {
            let number = self.index()?;
            let value = self.variables.get(&number).copied();
            return value.map(|v| (v, false)).ok_or_else(|| format!("#{number} is read before it is set"));
        }
        if self.rest.starts_with(|c: char| c.is_ascii_alphabetic()) {
            return self.function().map(|v| (v, false));
        }
        let end = self.rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(self.rest.len());
        let (digits, rest) = self.rest.split_at(end);
        let value: f64 = digits.parse().map_err(|_| format!("a number is missing before {:?}", self.rest))?;
        self.rest = rest.trim_start();
        Ok((value, !digits.contains('.')))
    }

    /// The number of a variable after its `#`.
    pub(super) fn index(&mut self) -> Result<u32, String> {
        let (value, _) = self.value()?;
        if value.fract() == 0.0 && (1.0..1e5).contains(&value) {
            Ok(value as u32)
        } else {
            Err(format!("#{value} is no variable"))
        }
    }

    fn function(&mut self) -> Result<f64, String> {
        let functions: [Function; 6] = [
            ("ABS", f64::abs),
            ("SQRT", f64::sqrt),
            ("ROUND", f64::round),
            ("FIX", f64::floor),
            ("FUP", f64::ceil),
            ("EXP", f64::exp),
        ];
        for (name, function) in functions {
            if self.takes(name) {
                return self.value().map(|(v, _)| function(v));
            }
        }
        Err(format!("{:?} is no function that is known here", self.rest))
    }

    /// An expression without its brackets.
    pub(super) fn comparison(&mut self) -> Result<f64, String> {
        let comparisons: [Comparison; 6] = [
            ("EQ", |a, b| a == b),
            ("NE", |a, b| a != b),
            ("GT", |a, b| a > b),
            ("GE", |a, b| a >= b),
            ("LT", |a, b| a < b),
            ("LE", |a, b| a <= b),
        ];
        let mut left = self.sum()?;
        while let Some((_, holds)) = comparisons.iter().find(|(word, _)| self.takes(word)) {
            left = f64::from(u8::from(holds(left, self.sum()?)));
        }
        Ok(left)
    }

    fn sum(&mut self) -> Result<f64, String> {
        let mut left = self.product()?;
        loop {
            if self.takes("+") {
                left += self.product()?;
            } else if self.takes("-") {
                left -= self.product()?;
            } else {
                return Ok(left);
            }
        }
    }

    fn product(&mut self) -> Result<f64, String> {
        let (mut left, _) = self.value()?;
        loop {
            if self.takes("*") {
                left *= self.value()?.0;
            } else if self.takes("/") {
                left /= self.value()?.0;
            } else if self.takes("MOD") {
                left = left.rem_euclid(self.value()?.0);
            } else {
                return if left.is_finite() { Ok(left) } else { Err("a value is not finite".into()) };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evaluate(text: &str) -> Result<f64, String> {
        let variables = Variables::from([(1, 3.0), (3, 4.0)]);
        Reader::new(text, &variables).value().map(|(v, _)| v)
    }

    #[test]
    fn products_come_before_sums_and_sums_before_comparisons() {
        assert_eq!(evaluate("[1.+2.*3.]"), Ok(7.0));
        assert_eq!(evaluate("[#1*1./6.+##1]"), Ok(4.5));
        assert_eq!(evaluate("[#1-#3/2. EQ 1.]"), Ok(1.0));
        assert_eq!(evaluate("-ABS[#1-[#3+0.5]]"), Ok(-1.5));
        assert_eq!(evaluate("[7. MOD 4. GT 3.]"), Ok(0.0));
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        assert!(evaluate("[#7+1.]").unwrap_err().contains("#7 is read before it is set"));
        assert!(evaluate("[1.+2.").unwrap_err().contains("not closed"));
        assert!(evaluate("[1./0.]").unwrap_err().contains("not finite"));
        assert!(evaluate("COS[0.]").unwrap_err().contains("no function"));
    }
}
