//! The model: time, size error, roughness, and the limits that a point violates.

use serde::Serialize;

use super::config::{Limits, OptimizeConfig, TimeModel, ToolLife};
use super::point::Point;
use crate::process::material::Material;
use crate::process::stepped::{Piece, SteppedShaft};
use crate::process::{ForceLaw, Section, ToolSettings, tool_factors};

/// A limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Constraint {
    /// Size error (equation 7).
    SizeError,
    /// Height of the feed marks (equation 8).
    Roughness,
    /// Cutting speed (equation 9).
    Speed,
    /// Feed (equation 9).
    Feed,
    /// Depth of cut (equation 9).
    Depth,
}

/// A point with all results of the model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Solution {
    /// Cutting data.
    #[serde(flatten)]
    pub point: Point,
    /// t, min.
    pub time_min: f64,
    /// T, min.
    pub tool_life_min: f64,
    /// Radial force, N.
    pub force_n: f64,
    /// Size error, mm of diameter.
    pub size_error_mm: f64,
    /// Height of the feed marks, µm.
    pub roughness_um: f64,
    /// Limits that are active at the point (within 1e-6 relative).
    pub active: Vec<Constraint>,
}

/// Why nothing is feasible.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Conflict {
    /// The limits that exclude each other (with the bounds).
    pub(crate) constraints: Vec<Constraint>,
    /// Explanation in words, with the nearest reachable values.
    pub explanation: String,
    /// The point that comes nearest.
    pub nearest: Solution,
}

/// A problem ready to be solved.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    /// Bounds.
    pub limits: Limits,
    /// Size error allowed to the cut (ΔD less the reserve), mm.
    pub size_limit_mm: f64,
    /// Height of the feed marks allowed, µm.
    pub roughness_limit_um: f64,
    /// 2·w: diameter error over radial force, mm/N.
    pub error_per_force_mm_per_n: f64,
    length_mm: f64,
    diameter_mm: f64,
    passes: f64,
    force: ForceLaw,
    tool: ToolSettings,
    material: Material,
    life: ToolLife,
    time: TimeModel,
}

/// Relative slack within which a limit counts as active and rounding does not count as a violation.
const ACTIVE: f64 = 1e-6;

impl Problem {
    /// Sets up a problem.
    ///
    /// # Errors
    /// As [`OptimizeConfig::validate`].
    pub(crate) fn new(config: &OptimizeConfig) -> Result<Self, crate::setting::SettingError> {
        config.validate()?;
        let process = &config.process;
        let material = process.material.resolve()?;
        let section = Section::circular(config.part.diameter_mm, &material);
        let piece = Piece { length_mm: config.part.length_mm, ahead: section, behind: section };
        let shaft = SteppedShaft { pieces: vec![piece], supports: process.support.supports() };
        Ok(Self {
            limits: config.limits,
            size_limit_mm: config.quality.size_error_mm - config.quality.reserve_mm,
            roughness_limit_um: config.quality.roughness_um,
            error_per_force_mm_per_n: 2.0 * shaft.softest().compliance_mm_per_n,
            length_mm: config.part.length_mm,
            diameter_mm: config.part.diameter_mm,
            passes: f64::from(config.part.passes),
            force: process.force.clone(),
            tool: process.tool,
            material,
            life: config.tool_life,
            time: config.time,
        })
    }

    /// The same problem with another limit of the size error.
    #[must_use]
    pub(crate) fn with_size_limit(&self, size_limit_mm: f64) -> Self {
        Self { size_limit_mm, ..self.clone() }
    }

    /// t_j, min (equation 5).
    pub(crate) fn cutting_time_min(&self, p: &Point) -> f64 {
        self.turning_min(p, self.passes)
    }

    /// t_j of pass `pass`, min: equation 5 with n = `pass`.
    pub(crate) fn pass_time_min(&self, p: &Point, pass: u32) -> f64 {
        self.turning_min(p, f64::from(pass))
    }

    fn turning_min(&self, p: &Point, passes: f64) -> f64 {
        let turned = self.diameter_mm - 2.0 * passes * p.depth_mm;
        std::f64::consts::PI * self.length_mm * turned / (1000.0 * p.feed_mm_per_rev * p.speed_m_per_min)
    }

    /// t of a stock turned in `passes` passes at the same cutting data, min: equation 5 gives the
    /// time of the last of them; this is Σ t_j(k) for k = 1 to n with the tool changes of all, and
    /// the auxiliary time once. `None` where no diameter would remain.
    pub(crate) fn total_time_min(&self, p: &Point, passes: u32) -> Option<f64> {
        let left = self.diameter_mm - 2.0 * f64::from(passes) * p.depth_mm;
        let cutting: f64 = (1..=passes).map(|pass| self.pass_time_min(p, pass)).sum();
        (left > 0.0).then(|| self.time_of(cutting, self.wear_per_min(p)))
    }

    /// 1/T, 1/min.
    pub(crate) fn wear_per_min(&self, p: &Point) -> f64 {
        let life = &self.life;
        let relative = p.speed_m_per_min
            * p.feed_mm_per_rev.powf(life.feed_exponent)
            * p.depth_mm.powf(life.depth_exponent)
            / life.constant_m_per_min;
        relative.powf(1.0 / life.life_exponent)
    }

    /// t of parts that may belong to different points, min (equation 4).
    pub(super) fn time_of(&self, cutting_min: f64, wear_per_min: f64) -> f64 {
        cutting_min * (1.0 + self.time.tool_change_min * wear_per_min) + self.time.auxiliary_min
    }

    /// t, min (equation 4).
    pub(crate) fn time_min(&self, p: &Point) -> f64 {
        self.time_of(self.cutting_time_min(p), self.wear_per_min(p))
    }

    /// Radial force, N.
    pub(crate) fn force_n(&self, p: &Point) -> f64 {
        self.force.at(&p.cutting(), &self.tool, &self.material).force_n(p.depth_mm)
    }

    /// Size error, mm of diameter (equation 6 as twice the deflection).
    pub(crate) fn size_error_mm(&self, p: &Point) -> f64 {
        self.error_per_force_mm_per_n * self.force_n(p)
    }

    /// Height of the feed marks, µm: f²/8r, or the height left by the minor cutting edge at feeds
    /// beyond the nose.
    pub(crate) fn roughness_um(&self, feed_mm_per_rev: f64) -> f64 {
        1e3 * tool_factors::feed_mark_mm(feed_mm_per_rev, &self.tool)
    }

    /// Largest feed that bound and roughness allow, mm/r; may lie below the lower bound.
    pub(crate) fn largest_feed_mm_per_rev(&self) -> f64 {
        let most = self.limits.feed_mm_per_rev[1];
        tool_factors::largest_feed_mm_per_rev(1e-3 * self.roughness_limit_um, most, &self.tool)
    }

    /// Excess of size error and roughness over their limits, relative; zero for a feasible point
    /// within the bounds.
    pub(crate) fn violation(&self, p: &Point) -> f64 {
        let size = self.size_error_mm(p) / self.size_limit_mm - 1.0;
        let rough = self.roughness_um(p.feed_mm_per_rev) / self.roughness_limit_um - 1.0;
        size.max(0.0) + rough.max(0.0)
    }

    /// Limits and bounds that a point violates by more than rounding.
    pub(crate) fn violated(&self, p: &Point) -> Vec<Constraint> {
        let outside =
            |value: f64, [low, high]: [f64; 2]| value < low * (1.0 - ACTIVE) || value > high * (1.0 + ACTIVE);
        let checks = [
            (Constraint::SizeError, self.size_error_mm(p) > self.size_limit_mm * (1.0 + ACTIVE)),
            (
                Constraint::Roughness,
                self.roughness_um(p.feed_mm_per_rev) > self.roughness_limit_um * (1.0 + ACTIVE),
            ),
            (Constraint::Speed, outside(p.speed_m_per_min, self.limits.speed_m_per_min)),
            (Constraint::Feed, outside(p.feed_mm_per_rev, self.limits.feed_mm_per_rev)),
            (Constraint::Depth, outside(p.depth_mm, self.limits.depth_mm)),
        ];
        checks.into_iter().filter(|(_, broken)| *broken).map(|(constraint, _)| constraint).collect()
    }

    fn active(&self, p: &Point) -> Vec<Constraint> {
        let near = |value: f64, limit: f64| (value / limit - 1.0).abs() <= ACTIVE;
        let at_end = |value: f64, [low, high]: [f64; 2]| near(value, low) || near(value, high);
        let checks = [
            (Constraint::SizeError, near(self.size_error_mm(p), self.size_limit_mm)),
            (Constraint::Roughness, near(self.roughness_um(p.feed_mm_per_rev), self.roughness_limit_um)),
            (Constraint::Speed, at_end(p.speed_m_per_min, self.limits.speed_m_per_min)),
            (Constraint::Feed, at_end(p.feed_mm_per_rev, self.limits.feed_mm_per_rev)),
            (Constraint::Depth, at_end(p.depth_mm, self.limits.depth_mm)),
        ];
        checks.into_iter().filter(|(_, active)| *active).map(|(constraint, _)| constraint).collect()
    }

    /// A point with all results of the model.
    pub(crate) fn solution(&self, point: Point) -> Solution {
        Solution {
            time_min: self.time_min(&point),
            tool_life_min: 1.0 / self.wear_per_min(&point),
            force_n: self.force_n(&point),
            size_error_mm: self.size_error_mm(&point),
            roughness_um: self.roughness_um(point.feed_mm_per_rev),
            active: self.active(&point),
            point,
        }
    }

    /// The eight corners of a box of cutting data.
    pub(super) fn corners(limits: &Limits) -> impl Iterator<Item = Point> + '_ {
        (0..8).map(|corner| Point {
            speed_m_per_min: limits.speed_m_per_min[corner & 1],
            feed_mm_per_rev: limits.feed_mm_per_rev[(corner >> 1) & 1],
            depth_mm: limits.depth_mm[(corner >> 2) & 1],
        })
    }

    /// The point of smallest size error among the corners: the force is monotone in each variable,
    /// so no point of the box has a smaller one.
    pub(crate) fn smallest_error(&self, limits: &Limits) -> Point {
        let first = Point {
            speed_m_per_min: limits.speed_m_per_min[1],
            feed_mm_per_rev: limits.feed_mm_per_rev[0],
            depth_mm: limits.depth_mm[0],
        };
        Self::corners(limits).min_by(|a, b| self.force_n(a).total_cmp(&self.force_n(b))).unwrap_or(first)
    }

    /// Why nothing is feasible: the smallest set of limits that excludes every point.
    pub(crate) fn conflict(&self) -> Conflict {
        let least_feed = self.limits.feed_mm_per_rev[0];
        if self.largest_feed_mm_per_rev() < least_feed {
            let nearest = Point { feed_mm_per_rev: least_feed, ..self.smallest_error(&self.limits) };
            return Conflict {
                constraints: vec![Constraint::Roughness, Constraint::Feed],
                explanation: format!(
                    "even at the smallest feed of {least_feed} mm/r the feed marks are {:.3} µm high, above {} µm; a feed \
                     below {:.4} mm/r or a larger nose radius would do",
                    self.roughness_um(least_feed),
                    self.roughness_limit_um,
                    self.largest_feed_mm_per_rev()
                ),
                nearest: self.solution(nearest),
            };
        }
        let alone = self.smallest_error(&self.limits);
        let smooth = Limits {
            feed_mm_per_rev: [self.limits.feed_mm_per_rev[0], self.largest_feed_mm_per_rev()],
            ..self.limits
        };
        let with_roughness = self.size_error_mm(&alone) <= self.size_limit_mm;
        let nearest = if with_roughness { self.smallest_error(&smooth) } else { alone };
        let constraints = if with_roughness {
            vec![Constraint::SizeError, Constraint::Roughness]
        } else {
            vec![Constraint::SizeError]
        };
        Conflict {
            constraints,
            explanation: format!(
                "even at v = {} m/min, f = {:.4} mm/r, a_p = {} mm{} the size error is {:.4} mm, above {:.4} mm: the radial \
                 force is {:.1} N where {:.1} N are allowed; a smaller depth bound, a stiffer support or a larger \
                 tolerance would do",
                nearest.speed_m_per_min,
                nearest.feed_mm_per_rev,
                nearest.depth_mm,
                if with_roughness { " (roughness forbids more feed)" } else { "" },
                self.size_error_mm(&nearest),
                self.size_limit_mm,
                self.force_n(&nearest),
                self.size_limit_mm / self.error_per_force_mm_per_n
            ),
            nearest: self.solution(nearest),
        }
    }

    /// Where the force law is used outside its data at a point.
    pub(crate) fn notes(&self, p: &Point) -> Vec<String> {
        self.force.extrapolation(&p.cutting(), [p.depth_mm; 2], &self.tool)
    }
}
