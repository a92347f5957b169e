//! The path of least cost through a strip: one row in every column, steps bounded and paid for.
//!
//! Viterbi's recursion: C(k, v) = c(k, v) + min over |v' − v| ≤ step of C(k − 1, v') + λ|v − v'|.
//! The spread of a row about the path is that of the distribution ∝ exp(−C) with the same steps
//! (forward and backward sums), whose costs are log-odds divided by a temperature.

/// Costs of the rows of every column: `costs[column][row]`, and what a step of one row costs.
pub(crate) struct Costs {
    /// A column an entry, of equal lengths.
    pub columns: Vec<Vec<f32>>,
    /// Cost of a row of a step.
    pub step: f32,
    /// Largest step.
    pub most_step: usize,
}

impl Costs {
    /// The row of the path of least cost in every column.
    pub(crate) fn cheapest(&self) -> Vec<usize> {
        let Some(first) = self.columns.first() else { return Vec::new() };
        let rows = first.len();
        let mut cost = first.clone();
        let mut from: Vec<Vec<u16>> = Vec::with_capacity(self.columns.len());
        for column in &self.columns[1..] {
            let mut next = vec![0.0_f32; rows];
            let mut came = vec![0_u16; rows];
            for v in 0..rows {
                let (low, high) = (v.saturating_sub(self.most_step), (v + self.most_step).min(rows - 1));
                let mut best = (f32::INFINITY, v);
                for (w, before) in cost.iter().enumerate().take(high + 1).skip(low) {
                    let through = before + self.step * v.abs_diff(w) as f32;
                    if through < best.0 {
                        best = (through, w);
                    }
                }
                next[v] = best.0 + column[v];
                came[v] = best.1 as u16;
            }
            from.push(came);
            cost = next;
        }
        let mut row = (0..rows).min_by(|a, b| cost[*a].total_cmp(&cost[*b])).unwrap_or(0);
        let mut path = vec![row];
        for came in from.iter().rev() {
            row = usize::from(came[row]);
            path.push(row);
        }
        path.reverse();
        path
    }

    /// Standard deviation of the row in every column about the path, by the distribution
    /// exp(−C/temperature).
    pub(crate) fn spread(&self, path: &[usize], temperature: f32) -> Vec<f64> {
        let forward = self.sums(self.columns.iter(), temperature);
        let mut backward = self.sums(self.columns.iter().rev(), temperature);
        backward.reverse();
        let of_column = |k: usize| {
            let weight = |v: usize| {
                // the column's own cost is in both sums
                f64::from(forward[k][v] + backward[k][v] + self.columns[k][v] / temperature)
            };
            let top = (0..self.columns[k].len()).map(weight).fold(f64::NEG_INFINITY, f64::max);
            let (mut sum, mut square) = (0.0, 0.0);
            for v in 0..self.columns[k].len() {
                let w = (weight(v) - top).exp();
                sum += w;
                square += w * (v as f64 - path[k] as f64).powi(2);
            }
            (square / sum).sqrt()
        };
        (0..self.columns.len()).map(of_column).collect()
    }

    /// Logarithms of the sums over all paths up to a column.
    fn sums<'a>(&self, columns: impl Iterator<Item = &'a Vec<f32>>, temperature: f32) -> Vec<Vec<f32>> {
        let mut all: Vec<Vec<f32>> = Vec::new();
        for column in columns {
            let rows = column.len();
            let sum = |v: usize, before: &[f32]| {
                let (low, high) = (v.saturating_sub(self.most_step), (v + self.most_step).min(rows - 1));
                let of = |w: usize| before[w] - self.step * v.abs_diff(w) as f32 / temperature;
                let top = (low..=high).map(of).fold(f32::NEG_INFINITY, f32::max);
                top + (low..=high).map(|w| (of(w) - top).exp()).sum::<f32>().ln()
            };
            let next: Vec<f32> = (0..rows)
                .map(|v| all.last().map_or(0.0, |before| sum(v, before)) - column[v] / temperature)
                .collect();
            let top = next.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            all.push(next.iter().map(|v| v - top).collect());
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(columns: usize, step: f32) -> Costs {
        let cost = |c: usize, r: usize| ((c * 37 + r * 101 + c * r * 13) % 29) as f32 / 7.0;
        let columns = (0..columns).map(|c| (0..4).map(|r| cost(c, r)).collect()).collect();
        Costs { columns, step, most_step: 1 }
    }

    /// All paths of four rows, and what each costs.
    fn all(costs: &Costs) -> Vec<(Vec<usize>, f32)> {
        let n = costs.columns.len();
        let path = |k: usize| (0..n).map(|c| (k >> (2 * c)) & 3).collect::<Vec<usize>>();
        let allowed = |p: &Vec<usize>| p.windows(2).all(|w| w[0].abs_diff(w[1]) <= costs.most_step);
        let cost = |p: &Vec<usize>| {
            let steps: usize = p.windows(2).map(|w| w[0].abs_diff(w[1])).sum();
            p.iter().enumerate().map(|(c, r)| costs.columns[c][*r]).sum::<f32>() + costs.step * steps as f32
        };
        (0..4_usize.pow(n as u32)).map(path).filter(allowed).map(|p| (p.clone(), cost(&p))).collect()
    }

    #[test]
    fn the_cheapest_path_is_that_of_all_paths() {
        for step in [0.0, 0.4, 3.0] {
            let costs = costs(6, step);
            let best = all(&costs).into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            let found = costs.cheapest();
            let of_found = all(&costs).into_iter().find(|p| p.0 == found).unwrap().1;
            assert!((of_found - best.1).abs() < 1e-5, "{step}: {of_found} {}", best.1);
        }
    }

    /// Forward and backward sums against the sum over all paths.
    #[test]
    fn the_spread_is_that_of_the_distribution_of_paths() {
        let (costs, temperature) = (costs(5, 0.7), 1.7);
        let path = costs.cheapest();
        let spread = costs.spread(&path, temperature);
        for column in 0..5 {
            let (mut sum, mut square) = (0.0, 0.0);
            for (p, cost) in all(&costs) {
                let weight = f64::from(-cost / temperature).exp();
                sum += weight;
                square += weight * (p[column] as f64 - path[column] as f64).powi(2);
            }
            let expected = (square / sum).sqrt();
            assert!((spread[column] - expected).abs() < 1e-4, "{column}: {} {expected}", spread[column]);
        }
    }
}
