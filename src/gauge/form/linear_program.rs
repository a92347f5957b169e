//! Linear programmes in a few variables and many rows, by exchange.
//!
//! Minimise c·x subject to a_i·x ≥ b_i and lower ≤ x ≤ upper. The dual simplex method on K active
//! rows: the vertex of the active rows is optimal for them; the row violated most enters, the one
//! whose multiplier vanishes first leaves; every exchange raises the objective, so that it ends.
//! This is Stiefel's exchange algorithm for Chebyshev approximation when the rows are |residual| ≤
//! t. Costs of zero are replaced by a tiny positive one (1e-9 of the largest), which makes the
//! start strictly dual feasible and prevents cycling; the optimum is then within 1e-9 × (size of
//! the box) of the true one, and callers shrink the box as they converge.

/// One row: a·x ≥ b.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<const K: usize> {
    /// Coefficients.
    pub(crate) a: [f64; K],
    /// Bound.
    pub(crate) b: f64,
}

/// Minimise `cost`·x over the rows and the box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearProgram<const K: usize> {
    /// Cost of each variable, not negative: at the box's lower corner the programme is dual
    /// feasible.
    pub(crate) cost: [f64; K],
    /// Lower bounds.
    pub(crate) lower: [f64; K],
    /// Upper bounds.
    pub(crate) upper: [f64; K],
    /// Violation of a row taken for rounding of its data. Above 0, or ties of many rows (a perfect
    /// circle) never settle.
    pub(crate) tolerance: f64,
}

impl<const K: usize> LinearProgram<K> {
    /// The optimum, or `None` if the rows contradict one another or rounding defeats the exchange.
    pub(crate) fn solve(&self, rows: &[Row<K>]) -> Option<[f64; K]> {
        let largest = self.cost.iter().copied().fold(0.0, f64::max);
        let cost: [f64; K] =
            std::array::from_fn(|k| self.cost[k].max(1e-9 * largest * (1.0 + 0.37 * k as f64)));
        let mut basis: [Row<K>; K] = std::array::from_fn(|k| unit_row(k, 1.0, self.lower[k]));
        for _ in 0..(200 + 20 * K) {
            let x = solve(std::array::from_fn(|k| basis[k].a), std::array::from_fn(|k| basis[k].b))?;
            let Some(enter) = self.most_violated(rows, &x) else { return Some(x) };
            let columns: [[f64; K]; K] = std::array::from_fn(|i| std::array::from_fn(|j| basis[j].a[i]));
            let multipliers = solve(columns, cost)?;
            let shares = solve(columns, enter.a)?;
            let leave = (0..K)
                .filter(|k| shares[*k] > 1e-12)
                .min_by(|p, q| (multipliers[*p] / shares[*p]).total_cmp(&(multipliers[*q] / shares[*q])))?;
            basis[leave] = enter;
        }
        None
    }

    fn most_violated(&self, rows: &[Row<K>], x: &[f64; K]) -> Option<Row<K>> {
        let mut worst = (0.0, None);
        let mut look = |row: Row<K>| {
            let short = row.b - row.a.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
            if short > self.tolerance.max(worst.0) {
                worst = (short, Some(row));
            }
        };
        rows.iter().copied().for_each(&mut look);
        for k in 0..K {
            look(unit_row(k, 1.0, self.lower[k]));
            look(unit_row(k, -1.0, -self.upper[k]));
        }
        worst.1
    }
}

fn unit_row<const K: usize>(k: usize, sign: f64, b: f64) -> Row<K> {
    Row { a: std::array::from_fn(|j| if j == k { sign } else { 0.0 }), b }
}

/// Solves m·x = b by elimination with partial pivoting; `None` if singular.
fn solve<const K: usize>(mut m: [[f64; K]; K], mut b: [f64; K]) -> Option<[f64; K]> {
    for column in 0..K {
        let pivot = (column..K).max_by(|p, q| m[*p][column].abs().total_cmp(&m[*q][column].abs()))?;
        if m[pivot][column].abs() < 1e-14 {
            return None;
        }
        m.swap(column, pivot);
        b.swap(column, pivot);
        for row in column + 1..K {
            let factor = m[row][column] / m[column][column];
            let pivot_row = m[column];
            for (value, above) in m[row].iter_mut().zip(pivot_row).skip(column) {
                *value -= factor * above;
            }
            b[row] -= factor * b[column];
        }
    }
    let mut x = [0.0; K];
    for row in (0..K).rev() {
        let known: f64 = (row + 1..K).map(|k| m[row][k] * x[k]).sum();
        x[row] = (b[row] - known) / m[row][row];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chebyshev_line_through_a_parabola_is_the_textbook_one() {
        // Best uniform line to x² on [0, 1] is x − 1/8 with error 1/8.
        let mut rows = Vec::new();
        for i in 0..=200 {
            let x = f64::from(i) / 200.0;
            rows.push(Row { a: [1.0, x, 1.0], b: x * x });
            rows.push(Row { a: [-1.0, -x, 1.0], b: -x * x });
        }
        let lp = LinearProgram {
            cost: [0.0, 0.0, 1.0],
            lower: [-9.0, -9.0, 0.0],
            upper: [9.0; 3],
            tolerance: 1e-15,
        };
        let [offset, slope, error] = lp.solve(&rows).unwrap();
        assert!(
            (offset + 0.125).abs() < 1e-12 && (slope - 1.0).abs() < 1e-12 && (error - 0.125).abs() < 1e-12
        );
    }

    #[test]
    fn contradicting_rows_have_no_optimum() {
        let rows = [Row { a: [1.0, 0.0], b: 1.0 }, Row { a: [-1.0, 0.0], b: 1.0 }];
        let lp = LinearProgram { cost: [0.0, 1.0], lower: [-9.0; 2], upper: [9.0; 2], tolerance: 1e-15 };
        assert_eq!(lp.solve(&rows), None);
    }
}
