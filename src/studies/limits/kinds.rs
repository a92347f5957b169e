//! The kinds of scenes: chosen so that as many thresholds as possible are reached by one of them.
//!
//! Drawn shadows for what a single frame asks of the gauge (light, sensor, shapes of edges and
//! parts, streams, a line camera, discs, a turn), pieces of shaft with contamination, and setups
//! of the coverage study with masters and budgets. A new kind is a line of a table here.

use super::draw::{Camera, Fall, Shape};
use super::look::{Defect, Look, Part, Series, View};
use crate::frame::PixelFormat;
use crate::studies::coverage::Class;
use crate::studies::dirty_frames::Contaminant;

/// What a scene is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// To be measured: every value has a true one, a gap is a loss.
    Clean,
    /// To be measured rightly or refused: a value off by more than U and the limit is mishandled.
    Contaminated,
}

/// How a scene is made and measured.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source {
    /// Drawn.
    Look(Look),
    /// A sensor with its own response, black levels and defects, its flat fields, and a shaft.
    FlatField,
    /// A piece of shaft, clean or with contamination of one kind.
    Piece(Option<Contaminant>),
    /// The same with a film of so many µm on it.
    Film(f64),
    /// A setup of the coverage study.
    Class(Class),
}

/// A kind of scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kind {
    pub(super) name: &'static str,
    pub(super) role: Role,
    pub(super) source: Source,
}

const fn clean(name: &'static str, look: Look) -> Kind {
    Kind { name, role: Role::Clean, source: Source::Look(look) }
}

const fn harmed(name: &'static str, look: Look) -> Kind {
    Kind { name, role: Role::Contaminated, source: Source::Look(look) }
}

const PLAIN: Look = Look::PLAIN;
const TWELVE: Camera = Camera { format: PixelFormat::Mono12, clip: 4095.0, ..Camera::EIGHT };
const LEFT_ALIGNED: Camera =
    Camera { format: PixelFormat::Mono16, clip: 65_520.0, step: 16.0, ..Camera::EIGHT };
const FLOAT: Camera = Camera { format: PixelFormat::F32, clip: 1.0, step: 0.0, ..Camera::EIGHT };
const QUIET: Camera = Camera { noise: (0.0008, 0.0), ..Camera::EIGHT };
const HOT: Camera = Camera { hot: 0.005, ..Camera::EIGHT };
const KNEE: Camera = Camera { knee: Some(0.9), ..Camera::EIGHT };
const LOUD: Camera = Camera { noise: (0.04, 0.02), ..Camera::EIGHT };
const CLIPPED: Look = Look { light: (1.02, 1.8), ..PLAIN };
const WIRE: Look = Look { part: Part::Wire, ..PLAIN };
const DISC: Look = Look { part: Part::Disc { bore: false, chip: false }, ..PLAIN };
const RING: Look = Look { part: Part::Disc { bore: true, chip: false }, ..PLAIN };

/// Shadows that are drawn.
const DRAWN: [Kind; 50] = [
    clean("plain", PLAIN),
    clean("plain, 12 bits", Look { camera: TWELVE, ..PLAIN }),
    clean("plain, float", Look { camera: FLOAT, ..PLAIN }),
    clean("loud", Look { camera: LOUD, ..PLAIN }),
    clean("faint", Look { light: (0.12, 0.2), dark: (0.05, 0.08), ..PLAIN }),
    clean("quiet", Look { camera: QUIET, ..PLAIN }),
    clean("quiet, level", Look { camera: QUIET, slope: 0.0005, ..PLAIN }),
    clean("sharp", Look { sigma: (0.25, 0.5), ..PLAIN }),
    clean("blurred", Look { sigma: (2.5, 4.5), ..PLAIN }),
    clean("tailed", Look { shape: Shape::Tailed, ..PLAIN }),
    clean("ringing", Look { shape: Shape::Ringing, sigma: (1.0, 1.8), ..PLAIN }),
    clean("widening", Look { shape: Shape::Widening, ..PLAIN }),
    clean("clipped", CLIPPED),
    clean("clipped, half", Look { fall: Fall::Half, ..CLIPPED }),
    clean("clipped, spot", Look { fall: Fall::Spot, ..CLIPPED }),
    clean("clipped, knee", Look { camera: KNEE, ..CLIPPED }),
    clean("clipped, 16 bits", Look { camera: LEFT_ALIGNED, ..CLIPPED }),
    clean("clipped, hot", Look { camera: HOT, ..CLIPPED }),
    clean("clipped, ringing", Look { shape: Shape::Ringing, sigma: (1.0, 1.8), ..CLIPPED }),
    clean("clipped, stream", Look { series: Series::Stream(4), ..CLIPPED }),
    clean("crushed", Look { dark: (-0.03, 0.004), ..PLAIN }),
    clean("hot pixels", Look { camera: HOT, ..PLAIN }),
    clean("hot pixels, quiet", Look { camera: Camera { hot: 0.005, ..QUIET }, ..PLAIN }),
    clean("along", Look { fall: Fall::Along, ..PLAIN }),
    clean("across", Look { fall: Fall::Across, ..PLAIN }),
    clean("spot", Look { fall: Fall::Spot, ..PLAIN }),
    clean("margin", Look { defect: Defect::Margin, ..PLAIN }),
    clean("stuck column", Look { defect: Defect::StuckColumns(1), ..PLAIN }),
    clean("stuck columns", Look { defect: Defect::StuckColumns(2), ..PLAIN }),
    clean("stuck rows", Look { defect: Defect::StuckRows(2), ..PLAIN }),
    clean("tilted", Look { slope: 0.35, ..PLAIN }),
    clean("lit", Look { view: View::Lit, ..PLAIN }),
    clean("upright", Look { view: View::Upright, ..PLAIN }),
    clean("bent", Look { part: Part::Bent, ..PLAIN }),
    clean("stepped", Look { part: Part::Stepped, ..PLAIN }),
    clean("end", Look { part: Part::End, ..PLAIN }),
    clean("tube", Look { part: Part::Tube, ..PLAIN }),
    clean("two shadows", Look { part: Part::Two, ..PLAIN }),
    clean("thread", Look { part: Part::Thread, ..PLAIN }),
    clean("stream", Look { series: Series::Stream(6), ..PLAIN }),
    clean("learnt", Look { series: Series::Stream(4), learnt: true, shape: Shape::Tailed, ..PLAIN }),
    clean("line camera", Look { series: Series::Line(4, 40), ..PLAIN }),
    clean("turn", Look { series: Series::Turn(12), ..PLAIN }),
    clean("wire", WIRE),
    clean("wire, tilted", Look { slope: 0.35, ..WIRE }),
    clean("wire, quiet", Look { camera: QUIET, slope: 0.001, ..WIRE }),
    clean("disc", DISC),
    clean("disc, clipped", Look { light: (1.02, 1.6), ..DISC }),
    clean("ring, spot", Look { fall: Fall::Spot, ..RING }),
    harmed("disc, chip", Look { part: Part::Disc { bore: false, chip: true }, ..PLAIN }),
];

/// Frames that show no part, each of which is to be refused.
const WITHOUT_PART: [Kind; 2] = [
    harmed("cut", Look { part: Part::Cut, ..PLAIN }),
    harmed("no part", Look { part: Part::Nothing, ..PLAIN }),
];

const fn piece(name: &'static str, contaminant: Option<Contaminant>) -> Kind {
    let role = if contaminant.is_some() { Role::Contaminated } else { Role::Clean };
    Kind { name, role, source: Source::Piece(contaminant) }
}

const fn film(name: &'static str, height_um: f64) -> Kind {
    Kind { name, role: Role::Contaminated, source: Source::Film(height_um) }
}

/// Pieces of shaft of the contamination study.
const PIECES: [Kind; 12] = [
    piece("clean piece", None),
    piece("window droplets", Some(Contaminant::WindowDroplets)),
    piece("air droplets", Some(Contaminant::AirDroplets)),
    piece("chips", Some(Contaminant::Chips)),
    piece("mist", Some(Contaminant::Mist)),
    piece("specks", Some(Contaminant::Dirt)),
    piece("scratches", Some(Contaminant::Scratches)),
    piece("films", Some(Contaminant::Films)),
    piece("a little of everything", Some(Contaminant::All)),
    film("film of 2 µm", 2.0),
    film("film of 5 µm", 5.0),
    film("film of 10 µm", 10.0),
];

const fn class(name: &'static str, class: Class, role: Role) -> Kind {
    Kind { name, role, source: Source::Class(class) }
}

/// Setups of the coverage study. Without [`Class::GivenEsf`], whose table takes longer than all
/// else, [`Class::Lobes`], which is measured as [`Class::Form`] is, and the classes whose frames
/// show nothing.
const CLASSES: [Kind; 16] = [
    class("certificates", Class::Certificates, Role::Clean),
    class("noise", Class::Noise, Role::Clean),
    class("temperature", Class::Temperature, Role::Clean),
    class("focus", Class::Focus, Role::Clean),
    class("finish", Class::Finish, Role::Clean),
    class("lens", Class::Lens, Role::Clean),
    class("form", Class::Form, Role::Clean),
    class("mixed", Class::Mixed, Role::Clean),
    class("diffraction", Class::Diffraction, Role::Clean),
    class("gradient", Class::Gradient, Role::Clean),
    class("tilt", Class::Tilt, Role::Clean),
    class("defocus", Class::Defocus, Role::Clean),
    class("clipped part", Class::Clipped, Role::Clean),
    class("vibration", Class::Vibration, Role::Contaminated),
    class("overexposed", Class::Overexposed, Role::Contaminated),
    class("other light", Class::OtherLight, Role::Contaminated),
];

/// All kinds, in a fixed order: a stored scene names its kind by the place in it.
pub(super) fn all() -> Vec<Kind> {
    let flat_field = Kind { name: "flat field", role: Role::Clean, source: Source::FlatField };
    [DRAWN.as_slice(), &WITHOUT_PART, &PIECES, &CLASSES, &[flat_field]].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_kinds_have_one_name() {
        let mut names: Vec<&str> = all().iter().map(|kind| kind.name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
