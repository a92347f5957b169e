//! The largest dark area of a grid: four-connected components joined run by run, in memory that a stream keeps.

/// Dark cells of one row side by side: `from..to`.
#[derive(Clone, Copy, Debug)]
struct Run {
    row: u32,
    from: u32,
    to: u32,
}

/// Runs and the components they belong to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Components {
    runs: Vec<Run>,
    /// A run of the same component with a smaller index, or the run itself.
    parent: Vec<u32>,
    cells: Vec<u32>,
}

/// First and last dark row of a column of the grid.
pub(crate) type Span = Option<(usize, usize)>;

impl Components {
    /// Writes the span of the largest component below `threshold` in each of the grid's columns; of two as large the one met first.
    /// False where nothing is dark.
    pub(crate) fn largest(
        &mut self,
        values: &[f32],
        columns: usize,
        threshold: f32,
        spans: &mut Vec<Span>,
    ) -> bool {
        self.find_runs(values, columns, threshold);
        let Some(largest) = self.largest_root() else { return false };
        spans.clear();
        spans.resize(columns, None);
        for (index, run) in self.runs.iter().enumerate() {
            if root(&mut self.parent, index as u32) != largest {
                continue;
            }
            let row = run.row as usize;
            for span in &mut spans[run.from as usize..run.to as usize] {
                *span = Some((span.map_or(row, |s| s.0), row));
            }
        }
        true
    }

    fn find_runs(&mut self, values: &[f32], columns: usize, threshold: f32) {
        self.runs.clear();
        self.parent.clear();
        let mut above = 0..0;
        for (row, line) in values.chunks_exact(columns).enumerate() {
            let first = self.runs.len();
            let mut at = 0;
            while let Some(from) = line[at..].iter().position(|v| *v < threshold).map(|k| at + k) {
                let to = line[from..].iter().position(|v| !(*v < threshold)).map_or(columns, |k| from + k);
                self.parent.push(self.runs.len() as u32);
                self.runs.push(Run { row: row as u32, from: from as u32, to: to as u32 });
                at = to;
            }
            self.join(above, first);
            above = first..self.runs.len();
        }
    }

    /// Joins the runs from `first` on with those of the row above that they touch.
    fn join(&mut self, above: std::ops::Range<usize>, first: usize) {
        let mut other = above.start;
        for index in first..self.runs.len() {
            let run = self.runs[index];
            while other < above.end && self.runs[other].to <= run.from {
                other += 1;
            }
            let mut touching = other;
            while touching < above.end && self.runs[touching].from < run.to {
                let (a, b) = (root(&mut self.parent, touching as u32), root(&mut self.parent, index as u32));
                self.parent[a.max(b) as usize] = a.min(b);
                touching += 1;
            }
        }
    }

    fn largest_root(&mut self) -> Option<u32> {
        self.cells.clear();
        self.cells.resize(self.runs.len(), 0);
        for (index, run) in self.runs.iter().enumerate() {
            self.cells[root(&mut self.parent, index as u32) as usize] += run.to - run.from;
        }
        let most = self.cells.iter().max()?;
        self.cells.iter().position(|cells| cells == most).map(|index| index as u32)
    }
}

/// Root of a run, the path to it halved on the way.
fn root(parent: &mut [u32], mut index: u32) -> u32 {
    while parent[index as usize] != index {
        let above = parent[parent[index as usize] as usize];
        parent[index as usize] = above;
        index = above;
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arms_that_meet_below_are_one_and_corners_do_not_join() {
        // A U of 10 cells, a block of 4 that touches it by a corner, and a speck.
        let grid = ["#..#..", "#..#.#", "#..#..", "####..", "....##", "....##"];
        let values: Vec<f32> =
            grid.iter().flat_map(|row| row.chars().map(|c| if c == '#' { 0.0 } else { 1.0 })).collect();
        let (mut components, mut spans) = (Components::default(), Vec::new());
        assert!(components.largest(&values, 6, 0.5, &mut spans));
        assert_eq!(spans, [Some((0, 3)), Some((3, 3)), Some((3, 3)), Some((0, 3)), None, None]);
        assert!(!components.largest(&[1.0; 12], 6, 0.5, &mut spans));
    }

    #[test]
    fn the_largest_is_that_of_a_flood_fill() {
        let (rows, columns) = (40, 37);
        let mut state = 5_u32;
        for _ in 0..50 {
            let values: Vec<f32> = (0..rows * columns)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 8) as f32 / (1 << 24) as f32
                })
                .collect();
            let mut spans = Vec::new();
            assert!(Components::default().largest(&values, columns, 0.55, &mut spans));
            assert_eq!(spans, by_flood(&values, columns, 0.55));
        }
    }

    fn by_flood(values: &[f32], columns: usize, threshold: f32) -> Vec<Span> {
        let mut seen = vec![false; values.len()];
        let mut best: Vec<usize> = Vec::new();
        for seed in 0..values.len() {
            let (mut stack, mut area) = (vec![seed], Vec::new());
            while let Some(cell) = stack.pop() {
                if seen[cell] || !(values[cell] < threshold) {
                    continue;
                }
                seen[cell] = true;
                area.push(cell);
                let column = cell % columns;
                stack.extend((column > 0).then(|| cell - 1));
                stack.extend((column + 1 < columns).then_some(cell + 1));
                stack.extend(cell.checked_sub(columns));
                stack.extend(Some(cell + columns).filter(|c| *c < values.len()));
            }
            if area.len() > best.len() {
                best = area;
            }
        }
        let rows = |c: usize| best.iter().filter(move |b| **b % columns == c).map(|b| b / columns);
        (0..columns).map(|c| Some((rows(c).min()?, rows(c).max()?))).collect()
    }
}
