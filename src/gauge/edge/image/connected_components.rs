//! The dark areas of a grid: four-connected components joined run by run, in memory that a stream
//! keeps.

/// Dark cells of one row side by side, `from..to`, and the component they belong to.
#[derive(Clone, Copy, Debug)]
struct Run {
    row: u32,
    from: u32,
    to: u32,
    /// A run of the same component with a smaller index, or the run itself.
    parent: u32,
    /// Place of the area that begins with this run.
    area: u32,
}

/// The runs of a grid.
#[derive(Clone, Debug, Default)]
pub(crate) struct Components {
    runs: Vec<Run>,
}

/// First and last dark row of a column of the grid.
pub(crate) type Span = Option<(usize, usize)>;

/// A connected dark area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Area {
    /// First run of the component: its name.
    pub(crate) root: u32,
    /// Cells in it.
    pub(crate) cells: u32,
    /// First and last row.
    pub(crate) rows: (u32, u32),
    /// First column and the one after the last.
    pub(crate) columns: (u32, u32),
}

impl Components {
    /// Finds the areas below `threshold`, in the order in which their first runs are met; empty
    /// where nothing is dark.
    pub(crate) fn find(&mut self, values: &[f32], columns: usize, threshold: f32, areas: &mut Vec<Area>) {
        self.find_runs(values, columns, threshold);
        areas.clear();
        for index in 0..self.runs.len() {
            let (run, root) = (self.runs[index], root(&mut self.runs, index as u32));
            // The root is the first run of its component: its area exists before any other run is
            // joined to it.
            if root as usize == index {
                self.runs[index].area = areas.len() as u32;
                let (rows, columns) = ((run.row, run.row), (run.from, run.to));
                areas.push(Area { root, cells: 0, rows, columns });
            }
            let area = &mut areas[self.runs[root as usize].area as usize];
            area.cells += run.to - run.from;
            area.rows.1 = run.row;
            area.columns = (area.columns.0.min(run.from), area.columns.1.max(run.to));
        }
    }

    /// Writes the span of an area in each of the grid's columns.
    pub(crate) fn spans(&mut self, area: &Area, columns: usize, spans: &mut Vec<Span>) {
        spans.clear();
        spans.resize(columns, None);
        for index in 0..self.runs.len() {
            if root(&mut self.runs, index as u32) != area.root {
                continue;
            }
            let run = self.runs[index];
            let row = run.row as usize;
            for span in &mut spans[run.from as usize..run.to as usize] {
                *span = Some((span.map_or(row, |s| s.0), row));
            }
        }
    }

    fn find_runs(&mut self, values: &[f32], columns: usize, threshold: f32) {
        self.runs.clear();
        let mut above = 0..0;
        for (row, line) in values.chunks_exact(columns).enumerate() {
            let first = self.runs.len();
            let mut at = 0;
            while let Some(from) = line[at..].iter().position(|v| *v < threshold).map(|k| at + k) {
                let to = line[from..].iter().position(|v| !(*v < threshold)).map_or(columns, |k| from + k);
                let (row, from, own) = (row as u32, from as u32, self.runs.len() as u32);
                self.runs.push(Run { row, from, to: to as u32, parent: own, area: u32::MAX });
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
                let (a, b) = (root(&mut self.runs, touching as u32), root(&mut self.runs, index as u32));
                self.runs[a.max(b) as usize].parent = a.min(b);
                touching += 1;
            }
        }
    }
}

/// The largest area; of two as large the one met first.
pub(crate) fn largest(areas: &[Area]) -> Option<&Area> {
    areas.iter().rev().max_by_key(|area| area.cells)
}

/// Root of a run, the path to it halved on the way.
fn root(runs: &mut [Run], mut index: u32) -> u32 {
    while runs[index as usize].parent != index {
        let above = runs[runs[index as usize].parent as usize].parent;
        runs[index as usize].parent = above;
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
        assert!(largest_spans(&mut components, &values, 6, 0.5, &mut spans));
        assert_eq!(spans, [Some((0, 3)), Some((3, 3)), Some((3, 3)), Some((0, 3)), None, None]);
        assert!(!largest_spans(&mut components, &[1.0; 12], 6, 0.5, &mut spans));
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
            assert!(largest_spans(&mut Components::default(), &values, columns, 0.55, &mut spans));
            assert_eq!(spans, by_flood(&values, columns, 0.55));
        }
    }

    fn largest_spans(
        components: &mut Components,
        values: &[f32],
        columns: usize,
        threshold: f32,
        spans: &mut Vec<Span>,
    ) -> bool {
        let mut areas = Vec::new();
        components.find(values, columns, threshold, &mut areas);
        assert_eq!(
            areas.iter().map(|a| a.cells as usize).sum::<usize>(),
            values.iter().filter(|v| **v < threshold).count()
        );
        let Some(area) = largest(&areas) else { return false };
        components.spans(area, columns, spans);
        true
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
