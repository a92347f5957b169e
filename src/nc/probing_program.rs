//! The whole program of paper 000: it probes the semi-finished part, fits the line, cuts its
//! inverse, probes again and raises an alarm.
//!
//! ```text
//! Σε, Σxε over the places                    #830, #831
//! ε = probed − diameter before the pass      (3)
//! b = (nΣxε − ΣxΣε)/(nΣx² − (Σx)²)           (5)  #802
//! a = (Σε − bΣx)/n                           (6)  #803
//! ```
//!
//! x from the free end as a share of the length (the paper's positions); then equations 9, 10, 7, 8
//! as in [`MacroProgram`]. It needs no run: the offsets are computed on the machine. Every result
//! goes into a variable of its own (the paper's `#800 = #800 − #804` would compensate again at
//! every run), and `#820` ensures that the program cuts a part's pass only once. The results before
//! the cut are in #841-#852, those after it in #861-#872. As in the paper, the pass before must
//! have had the speed, feed and depth of this one.

use super::dialect::{Dialect, number};
use super::error::NcError;
use super::line::{LineFit, fit_line};
use super::macro_program::MacroProgram;
use super::probe::{AFTER, BEFORE, Cycle};
use super::probe_settings::NcProbe;
use super::replay::{self, Surface, WorkingSpace};
use super::route::Workpiece;
use super::settings::NcSettings;
use super::skeleton::{self, Skeleton};
use super::turning::Written;
use crate::plan::CuttingData;

/// Decimals of the places' shares and sums in a program.
const SHARE_DECIMALS: usize = 9;

/// A finishing pass that measures its own correction.
#[derive(Clone, Debug)]
pub(crate) struct ProbingProgram<'a> {
    /// Diameter to be cut, mm.
    pub nominal_mm: f64,
    /// The part before the pass; its free end lies at Z = length.
    pub piece: Workpiece,
    /// Number of the pass.
    pub pass: u32,
    /// Feed and speed.
    pub cutting: CuttingData,
    /// Lower and upper limit of the finished part, mm.
    pub limits_mm: Option<(f64, f64)>,
    /// Machine, with its probe.
    pub settings: &'a NcSettings,
}

/// Errors of the part before the pass in the replays, as shares of `nc.correction_limit_mm`: at the
/// free end, in the middle, at the chuck. Constant, tapered both ways, bowed.
const ERRORS: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [0.5, 0.5, 0.5], [-0.5, -0.1, 0.3], [0.4, 0.0, -0.4], [0.0, 0.3, 0.1]];

impl ProbingProgram<'_> {
    /// The program's text and the places it probes (Z, mm), replayed from every start position and
    /// with every error of a set; it must raise its alarms where a touch is missing or out of range
    /// and where the part is out of tolerance.
    ///
    /// # Errors
    /// No probe in the settings, machine data that are missing, places that cannot be touched, a
    /// block that collides.
    pub(crate) fn write(&self, dialect: Dialect) -> Result<Written<Vec<f64>>, NcError> {
        let (skeleton, probe) = self.prepare(dialect)?;
        let places = skeleton.places(&probe)?;
        let text = self.text(&skeleton, &probe, &places)?;
        self.replay(&text, &skeleton, &probe, &places)?;
        Ok(Written { text, cut: places, uncut: skeleton.uncut() })
    }

    /// The working space for a replay of this pass, where the part before it has the diameters
    /// `before`, (Z, mm), Z ascending, and afterwards its target diameter.
    ///
    /// # Errors
    /// As [`Self::write`], but for the replay.
    #[cfg(test)]
    pub(crate) fn working_space(
        &self,
        dialect: Dialect,
        before: Vec<(f64, f64)>,
    ) -> Result<WorkingSpace<'_>, NcError> {
        let (skeleton, probe) = self.prepare(dialect)?;
        let places = skeleton.places(&probe)?;
        self.working_space_of(&skeleton, &places, before)
    }

    fn prepare(&self, dialect: Dialect) -> Result<(Skeleton<'_>, NcProbe), NcError> {
        let Some(probe) = self.settings.probe else {
            return Err(NcError::Plan(
                "a program that probes needs the probe's data: nc.probe (tool, correction_mm, expanded_u_mm)"
                    .into(),
            ));
        };
        let route = skeleton::check(self.settings, &self.piece, self.nominal_mm, dialect)?;
        let skeleton = Skeleton {
            dialect,
            settings: self.settings,
            piece: &self.piece,
            route,
            cutting: self.cutting,
            pass: self.pass,
            wear_mm: 0.0,
            limits_mm: self.limits_mm,
            measures_first: true,
        };
        Ok((skeleton, probe))
    }

    /// The cut for a fitted line, which sets the variables at its start.
    fn cone(&self, line: LineFit) -> MacroProgram<'_> {
        MacroProgram {
            line,
            unit_mm: 1.0,
            diameter_mm: (self.nominal_mm, self.nominal_mm),
            piece: self.piece.clone(),
            pass: self.pass,
            cutting: self.cutting,
            limits_mm: self.limits_mm,
            settings: self.settings,
        }
    }

    fn share(&self, z: f64) -> f64 {
        (self.piece.length_mm - z) / self.piece.length_mm
    }

    fn text(&self, skeleton: &Skeleton<'_>, probe: &NcProbe, places: &[f64]) -> Result<String, NcError> {
        let cone = self.cone(LineFit { b: 0.0, a: 0.0, largest_residual: 0.0 });
        cone.check(skeleton)?;
        let d = skeleton.dialect;
        let mut lines = self.head(skeleton, places);
        lines.extend(skeleton.once("PASS WAS CUT ALREADY"));
        let before = Cycle { places, expected_mm: self.piece.before_mm, variable: BEFORE };
        lines.extend(skeleton.cycle(probe, before));
        lines.extend(self.fit(d, places));
        lines.extend(cone.diameters());
        lines.extend(cone.equations(d));
        lines.extend(cone.limits(d));
        lines.extend(cone.far_end(skeleton));
        lines.extend(skeleton.approach());
        lines.extend(skeleton.cut(&cone.points(skeleton)));
        lines.extend(skeleton.after_cut());
        lines.extend(skeleton.probe_again(probe, self.nominal_mm, self.limits_mm)?);
        lines.extend(d.end());
        Ok(lines.join("\n") + "\n")
    }

    fn head(&self, skeleton: &Skeleton<'_>, places: &[f64]) -> Vec<String> {
        let cutting = self.cutting;
        let listed: Vec<String> = places.iter().map(|z| number(*z, 3)).collect();
        let about = [
            format!("shadowgauge {} for {}", env!("CARGO_PKG_VERSION"), skeleton.dialect.as_str()),
            format!(
                "aim {} mm from {} mm, v {} m/min, f {} mm/rev",
                number(self.nominal_mm, 4),
                number(self.piece.before_mm, 4),
                cutting.speed_m_per_min,
                cutting.feed_mm_per_rev
            ),
            "probes, fits the line B X + A, cuts its inverse, probes again".to_owned(),
            "the pass before must have had the speed, feed and depth of this one".to_owned(),
            format!("probed at Z {}", listed.join(" ")),
            format!("one touch a place: found in {BEFORE} on before the cut, in {AFTER} on after it"),
        ];
        let title = format!("PART {} PASS {} PROBED", self.settings.part_number, self.pass);
        skeleton.head(&title, &about, self.nominal_mm - self.settings.correction_limit_mm)
    }

    /// Sums over the places, and equations 5 and 6.
    fn fit(&self, dialect: Dialect, places: &[f64]) -> Vec<String> {
        let share = |z: &f64| number(self.share(*z), SHARE_DECIMALS);
        let before = number(self.piece.before_mm, 4);
        let mut lines = vec![
            dialect.comment("sums of the errors, and of x times them"),
            "#830=0.".to_owned(),
            "#831=0.".to_owned(),
        ];
        for (z, variable) in places.iter().zip(BEFORE..) {
            lines.push(format!("#830=[#830+#{variable}-{before}]"));
            lines.push(format!("#831=[#831+{}*[#{variable}-{before}]]", share(z)));
        }
        let n = places.len() as f64;
        let sum: f64 = places.iter().map(|z| self.share(*z)).sum();
        let squares: f64 = places.iter().map(|z| self.share(*z).powi(2)).sum();
        let [n_text, sum_text, spread] =
            [n, sum, n * squares - sum * sum].map(|value| number(value, SHARE_DECIMALS));
        lines.push(dialect.comment("the line: B and A by least squares"));
        lines.push(format!("#802=[[{n_text}*#831-{sum_text}*#830]/{spread}]"));
        lines.push(format!("#803=[[#830-{sum_text}*#802]/{n_text}]"));
        lines
    }

    fn working_space_of<'s>(
        &self,
        skeleton: &Skeleton<'s>,
        places: &[f64],
        before: Vec<(f64, f64)>,
    ) -> Result<WorkingSpace<'s>, NcError> {
        let surface = Surface { before, ..Surface::default() };
        let aimed = skeleton.surface(self.nominal_mm).unwrap_or_default();
        let x: Vec<f64> = places.iter().map(|z| self.share(*z)).collect();
        let errors: Vec<f64> = places.iter().map(|z| surface.before_at(*z) - self.piece.before_mm).collect();
        let line =
            fit_line(&x, &errors).ok_or_else(|| NcError::Plan("two places or more are needed".into()))?;
        let cone = self.cone(line);
        let ends = [0.0, self.piece.length_mm].map(|z| (z, cone.cone_mm(z)));
        let mut working_space = skeleton.working_space(ends.to_vec());
        working_space.surface = Some(Surface { after: aimed.after, ..surface });
        Ok(working_space)
    }

    fn replay(
        &self,
        text: &str,
        skeleton: &Skeleton<'_>,
        probe: &NcProbe,
        places: &[f64],
    ) -> Result<(), NcError> {
        let (length, limit) = (self.piece.length_mm, self.settings.correction_limit_mm);
        let part = |[free, middle, chuck]: [f64; 3], scale: f64| {
            let at = |z: f64, share: f64| (z, self.piece.before_mm + scale * share);
            self.working_space_of(
                skeleton,
                places,
                vec![at(0.0, chuck), at(0.5 * length, middle), at(length, free)],
            )
        };
        replay::check(text, &part(ERRORS[0], limit)?)?;
        for errors in &ERRORS[1..] {
            replay::check_once(text, &part(*errors, limit)?)?;
        }
        let alarm = |working_space: &WorkingSpace<'_>| replay::must_alarm(text, working_space);
        if probe.stored_correction {
            alarm(&part(ERRORS[0], limit)?.unqualified())?;
        }
        alarm(&part([2.0; 3], limit)?)?;
        alarm(&part([-(2.0 * probe.reach_mm + 1.0); 3], 1.0)?)?;
        if let Some((low, high)) = self.limits_mm {
            for wrong in [low - 0.1 * limit, high + 0.1 * limit] {
                let mut working_space = part(ERRORS[0], limit)?;
                if let Some(surface) = &mut working_space.surface {
                    surface.after = vec![(0.0, wrong)];
                }
                alarm(&working_space)?;
            }
        }
        Ok(())
    }
}
