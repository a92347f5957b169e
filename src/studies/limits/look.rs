//! Shadows drawn for the study: a part, light, camera and defects to frames with their true sizes.

use super::draw::{Camera, Fall, Random, Shape, outside};
use crate::frame::{Frame, FrameError, PixelsMut};
use crate::gauge::{EsfModel, GaugeSettings, Polarity};

/// Columns of a station in these frames.
pub(super) const STATION: usize = 40;
/// Pitch and height of the crests of a thread, px.
const THREAD_PX: (f64, f64) = (32.0, 8.0);
/// Height of the chip on a disc, px, and the half angle that it covers, rad.
const CHIP: (f64, f64) = (3.0, 0.15);

/// What stands before the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    /// A shaft of 40 to 70 px.
    Shaft,
    /// A wire of 6 to 22 px.
    Wire,
    /// A shaft whose axis bends by 3 px within the field.
    Bent,
    /// A shaft with a shoulder of 8 px.
    Stepped,
    /// A shaft with a chamfered end in the field.
    End,
    /// A tube: a bright line along its middle.
    Tube,
    /// A second, thinner shadow beside the shaft.
    Two,
    /// A shaft with crests at even distances.
    Thread,
    /// A disc of 50 to 90 px, with or without a bore of 25 to 40 px.
    Disc { bore: bool, chip: bool },
    /// A shadow that leaves the field.
    Cut,
    /// No part.
    Nothing,
}

/// What else the frame has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Defect {
    None,
    /// Black margins, as a round vignette leaves them.
    Margin,
    /// One stuck column, or more side by side.
    StuckColumns(usize),
    /// Stuck rows in the light or in the shadow.
    StuckRows(usize),
}

/// How the frames of a scene follow each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Series {
    /// One by itself.
    Single,
    /// A stream in which place, light and blur drift.
    Stream(usize),
    /// Readings of a line camera of so many columns.
    Line(usize, usize),
    /// Frames over so many angles in two turns of an eccentric, lobed shaft.
    Turn(usize),
}

/// How the part is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum View {
    /// As a shadow before light.
    Shadow,
    /// Lit before a dark ground.
    Lit,
    /// As an upright shadow: rows and columns exchanged by the view.
    Upright,
}

/// Everything that a drawn scene is drawn from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub(super) part: Part,
    pub(super) camera: Camera,
    /// Light as a multiple of the clip: the range drawn from.
    pub(super) light: (f64, f64),
    /// Shadow as a share of the clip.
    pub(super) dark: (f64, f64),
    pub(super) fall: Fall,
    pub(super) sigma: (f64, f64),
    pub(super) shape: Shape,
    /// Most slope of the axis.
    pub(super) slope: f64,
    pub(super) defect: Defect,
    pub(super) view: View,
    pub(super) series: Series,
    /// Whether the edge-spread function is learnt.
    pub(super) learnt: bool,
}

impl Look {
    /// A shaft in good light.
    pub(super) const PLAIN: Self = Self {
        part: Part::Shaft,
        camera: Camera::EIGHT,
        light: (0.55, 0.9),
        dark: (0.03, 0.1),
        fall: Fall::Even,
        sigma: (0.6, 1.8),
        shape: Shape::Gaussian,
        slope: 0.02,
        defect: Defect::None,
        view: View::Shadow,
        series: Series::Single,
        learnt: false,
    };

    /// The gauge's settings for it.
    pub(super) fn settings(&self) -> GaugeSettings {
        let settings = GaugeSettings {
            polarity: if self.view == View::Lit { Polarity::BrightOnDark } else { Polarity::DarkOnBright },
            min_diameter_px: if self.part == Part::Wire { 4.0 } else { 24.0 },
            esf: if self.learnt { EsfModel::Learnt {} } else { EsfModel::Gaussian {} },
            ..GaugeSettings::default()
        };
        if self.part == Part::Thread { settings.for_crests() } else { settings }
    }

    fn size(&self) -> (usize, usize) {
        match (self.part, self.series) {
            (_, Series::Line(columns, _)) => (140, columns),
            (Part::Disc { .. }, _) => (130, 140),
            (Part::Thread, _) => (140, 320),
            _ => (140, 160),
        }
    }

    fn frames(&self) -> usize {
        match self.series {
            Series::Single => 1,
            Series::Stream(frames) | Series::Line(_, frames) => frames,
            Series::Turn(angles) => 2 * angles,
        }
    }

    /// Draws a scene: its frames and what is true of each, px (the mean width of every station;
    /// outer diameter and bore of a disc), NaN where nothing is.
    ///
    /// # Errors
    /// A frame without pixels.
    pub(super) fn draw(&self, seed: u64) -> Result<(Vec<Frame>, Vec<Vec<f64>>), FrameError> {
        let mut random = Random::new(seed);
        let base = Picture::draw(self, &mut random);
        let (mut frames, mut truth) = (Vec::new(), Vec::new());
        for index in 0..self.frames() {
            let picture = base.at(index, &mut random);
            let mut frame = picture.frame(&mut random)?;
            frame.meta.frame_id = index as u64;
            if let Series::Turn(angles) = self.series {
                frame.meta.angle_deg = 360.0 * index as f64 / angles as f64;
            }
            frames.push(frame);
            truth.push(picture.truth());
        }
        Ok((frames, truth))
    }
}

/// One frame to be drawn.
struct Picture<'a> {
    look: &'a Look,
    size: (usize, usize),
    sigma: f64,
    dark: f64,
    light: f64,
    field: std::rc::Rc<dyn Fn(f64, f64) -> f64>,
    /// Width or diameter, bore, px; row and column of the middle; slope of the axis.
    width: f64,
    bore: f64,
    middle: (f64, f64),
    slope: f64,
    /// Where a stuck line stands, as a share of the frame, and its grey value as a share of the
    /// clip.
    stuck: (f64, f64),
}

impl<'a> Picture<'a> {
    fn draw(look: &'a Look, random: &mut Random) -> Self {
        let size = look.size();
        let sigma = random.within(look.sigma);
        let width = random.within(match look.part {
            Part::Wire => (6.0_f64.max(4.0 * sigma), 22.0),
            Part::Disc { bore: false, .. } => (50.0, 80.0),
            Part::Disc { .. } => (65.0, 90.0),
            _ => (40.0, 70.0),
        });
        let off = (random.within((-3.0, 3.0)), random.within((-3.0, 3.0)));
        let middle = (0.5 * size.0 as f64 + off.0, 0.5 * size.1 as f64 + off.1);
        Self {
            look,
            size,
            sigma,
            dark: random.within(look.dark),
            light: random.within(look.light),
            field: look.fall.field(random).into(),
            width,
            bore: random.within((25.0, 40.0)),
            middle: if look.part == Part::Cut { (0.1 * width, middle.1) } else { middle },
            slope: random.within((-look.slope, look.slope)),
            stuck: (random.within((0.1, 0.9)), random.within((0.0, 1.0)).round()),
        }
    }

    /// The same scene at a later frame.
    fn at(&self, index: usize, random: &mut Random) -> Self {
        let later = Self { field: self.field.clone(), ..*self };
        let (row, column) = self.middle;
        match self.look.series {
            Series::Single => later,
            Series::Stream(_) | Series::Line(..) => Self {
                sigma: self.sigma * (1.0 + 0.03 * index as f64).min(1.6),
                light: self.light * (1.0 + 0.02 * random.normal().clamp(-2.0, 2.0)),
                middle: (row + 1.5 * random.normal().clamp(-3.0, 3.0), column),
                ..later
            },
            Series::Turn(angles) => {
                let rotation = std::f64::consts::TAU * index as f64 / angles as f64;
                let lobes = 0.1 * (2.0 * rotation).cos();
                let middle = (row + 1.2 * rotation.cos(), column);
                Self { middle, width: self.width + lobes, ..later }
            }
        }
    }

    /// Rows of the upper and lower edge in a column; none where no part is.
    fn edges(&self, column: f64) -> Option<(f64, f64)> {
        let x = column - self.middle.1;
        let share = column / self.size.1 as f64;
        let middle = self.middle.0 + self.slope * x;
        let (middle, half) = match self.look.part {
            Part::Nothing | Part::Disc { .. } => return None,
            Part::Bent => (middle + 3.0 * (std::f64::consts::PI * share).sin(), 0.5 * self.width),
            Part::Stepped => (middle, 0.5 * self.width - if x > 20.5 { 4.0 } else { 0.0 }),
            Part::End if x > 50.0 => return None,
            Part::End => (middle, 0.5 * self.width - (x - 42.0).max(0.0)),
            Part::Thread => {
                let turns = column / THREAD_PX.0;
                let root = 0.5 - 0.5 * (std::f64::consts::TAU * turns).cos();
                (middle, 0.5 * self.width - THREAD_PX.1 * root)
            }
            _ => (middle, 0.5 * self.width),
        };
        Some((middle - half, middle + half))
    }

    /// True values of the frame.
    fn truth(&self) -> Vec<f64> {
        match self.look.part {
            Part::Disc { bore: false, .. } => return vec![self.width],
            Part::Disc { .. } => return vec![self.width, self.bore],
            Part::Nothing | Part::Cut => return Vec::new(),
            // The distance of the crests that face each other.
            Part::Thread => return vec![self.width * (1.0 + self.slope * self.slope).sqrt().recip()],
            _ => {}
        }
        let station = STATION.min(self.size.1);
        let mean = |first: usize| {
            let widths =
                (first..first + station).map(|c| self.edges(c as f64).map(|(top, bottom)| bottom - top));
            let all: Option<Vec<f64>> = widths.collect();
            // No one value is true of a station with a shoulder or an end in it.
            let flat = all.filter(|w| w.iter().all(|width| (width - w[0]).abs() < 0.5));
            flat.map_or(f64::NAN, |w| w.iter().sum::<f64>() / w.len() as f64)
        };
        (0..self.size.1 / station).map(|s| mean(s * station)).collect()
    }

    /// Light at a pixel as a share of the bright field.
    fn lit(&self, row: f64, column: f64) -> f64 {
        let Look { part, shape, .. } = self.look;
        if let Part::Disc { bore, chip } = part {
            let (dy, dx) = (row - self.middle.0, column - self.middle.1);
            let near = (1.0 - (dy.atan2(dx) / CHIP.1).powi(2)).max(0.0);
            let radius = 0.5 * self.width + if *chip { CHIP.0 * near } else { 0.0 };
            let hole = if *bore { 1.0 - outside(dy, dx, 0.5 * self.bore, self.sigma) } else { 0.0 };
            return outside(dy, dx, radius, self.sigma) + hole;
        }
        let Some((top, bottom)) = self.edges(column) else { return 1.0 };
        // Across a tilted edge distances are shorter than along a column.
        let across = 1.0_f64.hypot(self.slope);
        let along = column / self.size.1 as f64;
        let from = |d: f64| shape.light(d / across, self.sigma, along);
        let shadow = 1.0 - from(top - row) - from(row - bottom);
        let inside = match part {
            // A line of light of 3 px along the middle.
            Part::Tube => from(1.5 - (row - 0.5 * (top + bottom)).abs()),
            // A second shadow of 10 px, clear of the first.
            Part::Two => {
                let d = (row - bottom - 17.0).abs() - 5.0;
                return (1.0 - shadow).min(from(d));
            }
            _ => 0.0,
        };
        1.0 - shadow + 0.4 * inside
    }

    fn frame(&self, random: &mut Random) -> Result<Frame, FrameError> {
        let (rows, columns) = self.size;
        let margin = |r: f64, c: f64| self.look.defect == Defect::Margin && (r - 0.5).hypot(c - 0.5) > 0.6;
        let share = |row: usize, column: usize| {
            let (r, c) = (row as f64 / rows as f64, column as f64 / columns as f64);
            if margin(r, c) {
                return 0.008;
            }
            let lit = self.lit(row as f64, column as f64);
            let lit = if self.look.view == View::Lit { 1.0 - lit } else { lit };
            self.dark + (self.light * (self.field)(r, c) - self.dark) * lit
        };
        let place = |row: usize, column: usize| {
            if self.look.view == View::Upright { (column, row) } else { (row, column) }
        };
        let size = place(rows, columns);
        let mut frame = self.look.camera.expose(size, random, |row, column| {
            let (row, column) = place(row, column);
            share(row, column)
        })?;
        self.stick(&mut frame);
        Ok(frame)
    }

    /// Sets stuck lines, in frames of eight bits.
    fn stick(&self, frame: &mut Frame) {
        let (rows, columns) = self.size;
        let PixelsMut::U8(pixels) = frame.pixels_mut() else { return };
        let grey = (255.0 * self.stuck.1) as u8;
        match self.look.defect {
            Defect::StuckColumns(count) => {
                let first = (self.stuck.0 * columns as f64) as usize;
                for column in first..(first + count).min(columns) {
                    (0..rows).for_each(|row| pixels[row * columns + column] = grey);
                }
            }
            Defect::StuckRows(count) => {
                // In the middle of the part, or far out in the light.
                let middle = if self.stuck.0 > 0.5 { self.middle.0 as usize } else { 4 };
                pixels[middle * columns..(middle + count) * columns].fill(grey);
            }
            Defect::None | Defect::Margin => {}
        }
    }
}
