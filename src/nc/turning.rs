//! A turning pass with its correction as a program.

use super::contour_path;
use super::dialect::{Dialect, number};
use super::error::NcError;
use super::machine::Direction;
use super::path::Path;
use super::path::interpolate;
use super::replay;
use super::route::Workpiece;
use super::settings::NcSettings;
use super::skeleton::{self, Skeleton};
use crate::plan::PassPlan;

/// Distance below which points of a path coincide, mm: the increment of Z.
const SAME_Z_MM: f64 = 1e-3;

/// A pass to be written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TurningProgram<'a> {
    /// The pass with the offsets asked for.
    pub plan: &'a PassPlan,
    /// Machine and path.
    pub settings: &'a NcSettings,
    /// The part before the pass.
    pub piece: &'a Workpiece,
    /// Lower and upper limit for the re-measurement, mm, where the part is finished by this pass.
    pub limits_mm: Option<(f64, f64)>,
    /// Reason for these offsets, written into the header.
    pub reason: &'a str,
}

/// A program that has passed its replay.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Written<P> {
    /// Its text.
    pub text: String,
    /// The cut.
    pub cut: P,
    /// What stays uncut, in a sentence.
    pub uncut: String,
}

impl<'a> TurningProgram<'a> {
    /// The program's text and the path it cuts, replayed from every start position.
    ///
    /// # Errors
    /// As [`Path::new`]; a part that does not fit the plan; machine data that are missing; a block
    /// that collides.
    pub(crate) fn write(&self, dialect: Dialect) -> Result<Written<Path>, NcError> {
        let (path, skeleton) = self.prepare(dialect, self.plan.nominal_mm)?;
        let mut lines = self.head(&skeleton, &path);
        lines.extend(skeleton.once("PASS WAS CUT ALREADY"));
        lines.extend(skeleton.approach());
        let points = match self.plan.form.contour() {
            Some(_) => contour_points(&skeleton, &path),
            None => points(&skeleton, &path),
        };
        lines.extend(skeleton.cut(&points));
        lines.extend(skeleton.after(self.plan.nominal_mm)?);
        let text = lines.join("\n") + "\n";
        replay::check(&text, &self.working_space_of(&skeleton))?;
        Ok(Written { text, cut: path, uncut: skeleton.uncut() })
    }

    /// The working space for a replay of this pass.
    ///
    /// # Errors
    /// As [`Self::write`], but for the replay.
    #[cfg(test)]
    pub(crate) fn working_space(&self, dialect: Dialect) -> Result<replay::WorkingSpace<'a>, NcError> {
        self.prepare(dialect, self.plan.nominal_mm).map(|(_, skeleton)| self.working_space_of(&skeleton))
    }

    pub(super) fn working_space_of(&self, skeleton: &Skeleton<'a>) -> replay::WorkingSpace<'a> {
        let mut working_space = skeleton.working_space(self.commanded());
        working_space.surface = skeleton.surface(self.plan.nominal_mm);
        if let Some(contour) = self.plan.form.contour() {
            let nose_mm = skeleton.route.nose_mm;
            working_space.cut.between = (skeleton.route.full_from_mm, self.piece.length_mm);
            working_space.cut.solid = Some(replay::FinishedSolid {
                surface: contour_path::commanded_surface(self.plan, contour),
                nose_mm,
                centre_z_mm: contour_path::lead(contour) * nose_mm,
            });
        }
        working_space
    }

    fn commanded(&self) -> Vec<(f64, f64)> {
        self.plan.station_z_mm.iter().copied().zip(self.plan.commanded_mm()).collect()
    }

    /// The path and what is around it; `nominal_mm` is the diameter that is left at the least.
    pub(super) fn prepare(&self, dialect: Dialect, nominal_mm: f64) -> Result<(Path, Skeleton<'a>), NcError> {
        let (plan, s) = (self.plan, self.settings);
        let path = Path::new(plan, s, dialect)?;
        let route = skeleton::check(s, self.piece, nominal_mm, dialect)?;
        let last = plan.station_z_mm[plan.station_z_mm.len() - 1];
        if last > self.piece.length_mm {
            return Err(NcError::Plan(format!(
                "a station at Z {last} mm lies beyond the end of the part at {} mm",
                self.piece.length_mm
            )));
        }
        let skeleton = Skeleton {
            dialect,
            settings: s,
            piece: self.piece,
            route,
            cutting: plan.cutting,
            pass: plan.pass,
            wear_mm: path.wear_mm,
            limits_mm: self.limits_mm,
            measures_first: false,
        };
        Ok((path, skeleton))
    }

    fn head(&self, skeleton: &Skeleton<'_>, path: &Path) -> Vec<String> {
        let (plan, s) = (self.plan, self.settings);
        let register = s.uses_wear_register(skeleton.dialect);
        let where_mean = if register { "in the wear register" } else { "in the path" };
        let mut about = vec![
            format!("shadowgauge {} for {}", env!("CARGO_PKG_VERSION"), skeleton.dialect.as_str()),
            format!(
                "aim {} mm from {} mm, v {} m/min, f {} mm/rev",
                number(plan.nominal_mm, 4),
                number(self.piece.before_mm, 4),
                plan.cutting.speed_m_per_min,
                plan.cutting.feed_mm_per_rev
            ),
            format!("{} knots, mean correction {where_mean}", path.knots.len()),
            format!("reason: {}", self.reason),
        ];
        if let Some(contour) = plan.form.contour() {
            about.push(format!(
                "contour of {} sections, diameters of the largest; the nose radius of {} mm is in the path: no G41, no G42",
                contour.sections.len(),
                number(skeleton.route.nose_mm, 3)
            ));
        }
        let smallest = plan.commanded_mm().fold(f64::INFINITY, f64::min);
        skeleton.head(&format!("PART {} PASS {}", s.part_number, plan.pass), &about, smallest)
    }
}

/// The path's knots in the order of cutting, level from the outer ones to the ends of the cut.
pub(super) fn points(skeleton: &Skeleton<'_>, path: &Path) -> Vec<(String, f64)> {
    let (route, decimals) = (&skeleton.route, skeleton.dialect.x_decimals());
    let (z, x): (Vec<f64>, Vec<f64>) = path.knots.iter().rev().copied().unzip();
    let (low, high) = (route.z_first.min(route.z_last), route.z_first.max(route.z_last));
    let mut places: Vec<f64> =
        z.iter().copied().filter(|z| *z > low + SAME_Z_MM && *z < high - SAME_Z_MM).collect();
    places.insert(0, low);
    places.push(high);
    if skeleton.piece.direction == Direction::TowardsChuck {
        places.reverse();
    }
    places.into_iter().map(|at| (number(interpolate(&z, &x, at), decimals), at)).collect()
}

/// The path along a contour in the order of cutting, level to the ends of the cut; X and Z of a
/// shoulder both stand in it.
fn contour_points(skeleton: &Skeleton<'_>, path: &Path) -> Vec<(String, f64)> {
    let (route, decimals) = (&skeleton.route, skeleton.dialect.x_decimals());
    let ascending: Vec<(f64, f64)> = path.knots.iter().rev().copied().collect();
    let ends = (route.z_first.min(route.z_last), route.z_first.max(route.z_last));
    let mut places = contour_path::between(&ascending, ends);
    if skeleton.piece.direction == Direction::TowardsChuck {
        places.reverse();
    }
    places.into_iter().map(|(z, x)| (number(x, decimals), z)).collect()
}
