//! The paper's method: a genetic algorithm, real-coded.
//!
//! Binary tournaments, simulated binary crossover and polynomial mutation (K. Deb and R. B.
//! Agrawal, 1995), and survival of the best of parents and children. Limits by Deb's rules (2000):
//! a feasible individual beats an infeasible one, a shorter time beats a longer one, a smaller
//! violation a larger one. There is no penalty factor to tune, and the result is feasible as soon
//! as one individual is.

use rand::RngExt;
use rand_pcg::Pcg64;
use serde::Serialize;

use super::config::{GeneticSettings, Limits};
use super::point::Point;
use super::problem::{Problem, Solution};

/// The best individual.
#[derive(Clone, Debug)]
pub(crate) struct Best {
    /// The point.
    pub solution: Solution,
    /// Evaluations of the model.
    pub evaluations: usize,
    /// The best of every generation, the initial one first.
    pub generations: Vec<Generation>,
}

/// The best individual of a generation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Generation {
    /// Number of the generation; 0 is the population drawn at random.
    pub generation: usize,
    /// Evaluations of the model so far.
    pub evaluations: usize,
    /// Its time, min.
    pub time_min: f64,
    /// Violation of the limits, relative; 0 for a feasible one.
    pub violation: f64,
}

/// Speed, feed and depth, each as its share of its range.
type Genes = [f64; 3];

#[derive(Clone, Copy)]
struct Individual {
    genes: Genes,
    violation: f64,
    time_min: f64,
}

impl Individual {
    fn better_than(&self, other: &Self) -> bool {
        if self.violation > 0.0 || other.violation > 0.0 {
            return self.violation < other.violation;
        }
        self.time_min < other.time_min
    }
}

/// Evolves a population; `None` where it found nothing feasible.
pub(crate) fn minimise(problem: &Problem, settings: &GeneticSettings, seed: u64) -> Option<Best> {
    let mut evolution =
        Evolution { problem, settings, random: Pcg64::new(u128::from(seed), 0x6761), evaluations: 0 };
    let mut population: Vec<Individual> = (0..settings.population).map(|_| evolution.newborn()).collect();
    let newborn = population.iter().min_by(|a, b| in_order(a, b));
    let mut generations: Vec<Generation> =
        newborn.map(|best| generation(0, evolution.evaluations, best)).into_iter().collect();
    while evolution.evaluations + settings.population <= settings.evaluations {
        let children: Vec<Individual> =
            (0..settings.population).map(|_| evolution.child(&population)).collect();
        population.extend(children);
        population.sort_by(in_order);
        population.truncate(settings.population);
        generations.push(generation(generations.len(), evolution.evaluations, &population[0]));
    }
    let best = population.first().filter(|best| best.violation == 0.0)?;
    let solution = problem.solution(point(&problem.limits, &best.genes));
    Some(Best { solution, evaluations: evolution.evaluations, generations })
}

/// Deb's order: smaller violations first, shorter times among the feasible.
fn in_order(a: &Individual, b: &Individual) -> std::cmp::Ordering {
    a.violation.total_cmp(&b.violation).then_with(|| a.time_min.total_cmp(&b.time_min))
}

fn generation(generation: usize, evaluations: usize, best: &Individual) -> Generation {
    Generation { generation, evaluations, time_min: best.time_min, violation: best.violation }
}

fn point(limits: &Limits, genes: &Genes) -> Point {
    let at = |[low, high]: [f64; 2], share: f64| (low + share * (high - low)).clamp(low, high);
    Point {
        speed_m_per_min: at(limits.speed_m_per_min, genes[0]),
        feed_mm_per_rev: at(limits.feed_mm_per_rev, genes[1]),
        depth_mm: at(limits.depth_mm, genes[2]),
    }
}

struct Evolution<'a> {
    problem: &'a Problem,
    settings: &'a GeneticSettings,
    random: Pcg64,
    evaluations: usize,
}

impl Evolution<'_> {
    fn uniform(&mut self) -> f64 {
        self.random.random::<f64>()
    }

    fn evaluated(&mut self, genes: Genes) -> Individual {
        self.evaluations += 1;
        let point = point(&self.problem.limits, &genes);
        Individual {
            genes,
            violation: self.problem.violation(&point),
            time_min: self.problem.time_min(&point),
        }
    }

    fn newborn(&mut self) -> Individual {
        let genes = [self.uniform(), self.uniform(), self.uniform()];
        self.evaluated(genes)
    }

    fn parent(&mut self, population: &[Individual]) -> Individual {
        let mut pick = || population[self.random.random_range(0..population.len())];
        let (a, b) = (pick(), pick());
        if a.better_than(&b) { a } else { b }
    }

    fn child(&mut self, population: &[Individual]) -> Individual {
        let (mother, father) = (self.parent(population), self.parent(population));
        let mut genes = mother.genes;
        for (gene, other) in genes.iter_mut().zip(father.genes) {
            let crossed = self.crossed(*gene, other);
            *gene = self.mutated(crossed);
        }
        self.evaluated(genes)
    }

    /// Simulated binary crossover: one of the two children, spread around the parents.
    fn crossed(&mut self, a: f64, b: f64) -> f64 {
        let (u, power) = (self.uniform(), 1.0 / (self.settings.crossover_index + 1.0));
        let spread = if u <= 0.5 { (2.0 * u).powf(power) } else { (0.5 / (1.0 - u)).powf(power) };
        let side = if self.uniform() < 0.5 { 1.0 } else { -1.0 };
        (0.5 * ((a + b) + side * spread * (b - a))).clamp(0.0, 1.0)
    }

    /// Polynomial mutation.
    fn mutated(&mut self, gene: f64) -> f64 {
        if self.uniform() >= self.settings.mutation_rate {
            return gene;
        }
        let (u, power) = (self.uniform(), 1.0 / (self.settings.mutation_index + 1.0));
        let step = if u < 0.5 { (2.0 * u).powf(power) - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).powf(power) };
        (gene + step).clamp(0.0, 1.0)
    }
}
