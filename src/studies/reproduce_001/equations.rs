//! The list of errors and eqs 1 to 6 against the first order of the exact chain w-C'-Z'-b-X-t.
//!
//! A printed term is an error with the lever by which it acts along X or Z. It is in the chain
//! where one unit of the error does as much there, up to the sign (the paper prints all with +).

use nalgebra::{Matrix3, Vector3};

use super::inputs::Inputs;
use crate::machine::error_name::Component;
use crate::machine::topology::Topology;
use crate::machine::{ErrorName, Station, first_order};
use crate::studies::reproduction::{Accept, Row};

/// Levers that all differ, and a position, mm: no result below depends on them.
const TOOL_MM: [f64; 3] = [110.0, 90.0, 70.0];
const SLIDE_MM: [f64; 3] = [40.0, 80.0, 120.0];
const AT_MM: [f64; 2] = [30.0, 65.0];
/// An angle and a lever, for figures: what such machines have.
const ANGLE_RAD: f64 = 5e-6;
const LEVER_MM: f64 = 100.0;

fn station([x_mm, z_mm]: [f64; 2]) -> Station {
    Station {
        point_mm: Vector3::new(x_mm, 0.0, z_mm),
        x_mm,
        z_mm,
        x_lever_mm: Some(Vector3::from(TOOL_MM)),
        z_lever_mm: Vector3::from(SLIDE_MM),
    }
}

/// What one unit of an error does along a direction (0: X, 2: Z).
fn acts(name: ErrorName, at: [f64; 2], direction: usize) -> f64 {
    first_order::contribution(Topology::TShaped, &station(at), name).shift_mm[direction]
}

/// The terms of eq. 1: error and lever, as printed.
fn printed_x() -> [(ErrorName, f64); 6] {
    use ErrorName as E;
    let (z, w, t) = (AT_MM[1], SLIDE_MM, TOOL_MM);
    // z and W are one variable: β(z) acts by the distance of the measured point from the reference
    [(E::Exx, 1.0), (E::Exz, 1.0), (E::B0c, z), (E::Ebz, w[2] + z), (E::Ecz, w[1]), (E::Ebx, t[2])]
}

/// The terms of eq. 4.
fn printed_z() -> [(ErrorName, f64); 6] {
    use ErrorName as E;
    let (x, w, t) = (AT_MM[0], SLIDE_MM, TOOL_MM);
    // βxΦ is B0X less B0C: B0X stands for it
    [(E::Ezx, 1.0), (E::B0x, x), (E::Eax, t[1]), (E::Ebx, t[0]), (E::Ebz, w[0] + x), (E::Ezz, 1.0)]
}

fn in_chain(printed: &[(ErrorName, f64)], direction: usize) -> usize {
    let is_there =
        |(name, lever): &&(ErrorName, f64)| (acts(*name, AT_MM, direction).abs() - lever).abs() < 1e-12;
    printed.iter().filter(is_there).count()
}

/// Errors of the slides and orientations that act along a direction and are not printed; B0C stands
/// with B0X in βxΦ.
fn missing(printed: &[(ErrorName, f64)], direction: usize) -> Vec<ErrorName> {
    let is_printed = |name: ErrorName| {
        let with = direction == 2 && name == ErrorName::B0c;
        with || printed.iter().any(|(own, _)| *own == name)
    };
    let of_spindle = |name: ErrorName| (12..18).contains(&(name as usize));
    let acts_there = |name: &ErrorName| acts(*name, AT_MM, direction) != 0.0;
    ErrorName::ALL
        .into_iter()
        .filter(|name| !of_spindle(*name) && !is_printed(*name))
        .filter(acts_there)
        .collect()
}

pub(super) fn rows(inputs: &Inputs) -> Vec<Row> {
    [list(inputs), equation_1(inputs), equation_4(inputs), others()].concat()
}

/// The list of errors.
fn list(inputs: &Inputs) -> Vec<Row> {
    let of_motion =
        ErrorName::ALL.iter().filter(|name| !matches!(name.component(), Component::Orientation(_)));
    // B0C, B0X − B0C and B0X over A0C, B0C, B0X
    let named = Matrix3::new(0.0, 1.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 1.0);
    let rank = named.svd(false, false).rank(1e-12);
    // α is the rotation about X in rows 16 to 18, γ that about Z: in rows 10 and 12 α is the roll
    // of Z and γ its pitch
    let about = |meaning: &str| {
        let name = ErrorName::ALL.into_iter().find(|name| name.meaning() == meaning);
        name.map(ErrorName::component)
    };
    let agree = [("roll of Z", 0), ("pitch of Z", 2)]
        .iter()
        .filter(|(meaning, axis)| about(meaning) == Some(Component::About(*axis)))
        .count();
    vec![
        Row::predicted(
            ("list.errors", "geometric errors of a lathe", ""),
            Some(inputs.errors as f64),
            ErrorName::ALL.len() as f64,
            Accept::Absolute(0.0),
            "six of X, Z and C each and three orientations (ISO 230-1)",
        ),
        Row::predicted(
            ("list.motion", "errors of motion among them", ""),
            Some(inputs.errors_of_motion as f64),
            of_motion.count() as f64,
            Accept::Absolute(0.0),
            "δx, δy, δz, α, β, γ of each axis",
        ),
        Row::printed(
            ("list.rank", "independent orientations among αzΦ, βxΦ, βxz", ""),
            Some(3.0),
            rank as f64,
            Accept::Absolute(0.0),
            "all three turn about Y: the angle of X to the spindle is that of X to Z less that of the spindle to Z; the third one, \
             A0C, the spindle's lean about X, is not in the list",
        ),
        Row::printed(
            (
                "list.letters",
                "letters of rows 10 and 12 that name the axis turned about, as in rows 16 to 18",
                "",
            ),
            Some(2.0),
            agree as f64,
            Accept::Absolute(0.0),
            "α(z) is the roll, about Z, and γ(z) the pitch, about X: letters follow roll, yaw and pitch, else α(z)·Wh in eq. 1 \
             would act along Z",
        ),
    ]
}

fn equation_1(inputs: &Inputs) -> Vec<Row> {
    let printed = printed_x();
    let left = missing(&printed, 0);
    let column = |z: f64| {
        let names = [ErrorName::Exz, ErrorName::B0c, ErrorName::Ebz, ErrorName::Ecz];
        names.iter().map(|name| acts(*name, [AT_MM[0], z], 0)).sum::<f64>()
    };
    // eq. 3 with errors of one unit each: what is left of all of them but δX(x)
    let all = |x: f64, z: f64| {
        let others = printed.iter().filter(|(name, _)| *name != ErrorName::Exx);
        others.map(|(name, _)| acts(*name, [x, z], 0)).sum::<f64>()
    };
    let places = [0.0, 25.0, 50.0, 100.0];
    let off = places.iter().flat_map(|x| places.iter().map(move |z| (*x, *z)));
    let off = off.map(|(x, z)| (all(x, z) - column(z) - acts(ErrorName::Ebx, [x, z], 0)).abs());
    vec![
        Row::predicted(
            ("eq1.terms", "terms of eq. 1 that the exact chain has to first order, but for their signs", ""),
            Some(inputs.terms_x as f64),
            in_chain(&printed, 0) as f64,
            Accept::Absolute(0.0),
            "δX(z), αzΦ·z, β(z)·W, α(z)·Wh and their like act on the part and count negative; all are printed with +; W as measured \
             from the Z slide's reference, not from the chuck",
        ),
        Row::printed(
            ("eq1.missing", "errors of slides that act along X and are not in eq. 1", ""),
            Some(0.0),
            left.len() as f64,
            Accept::Absolute(0.0),
            format!("{}: γ(x)·T, the pitch of X by the height of the tool", codes(&left)),
        ),
        Row::ours(
            ("eq1.missing.um", "what it amounts to at 5 µrad and 100 mm", "µm"),
            1e3 * ANGLE_RAD * LEVER_MM,
            "twice the straightness that the paper measures",
        ),
        Row::predicted(
            ("eq3.off", "eq. 3 less eq. 1 without δX(x), for errors of one unit", "mm"),
            Some(0.0),
            off.fold(0.0, f64::max),
            Accept::Absolute(1e-12),
            "column and β(x)·T hold the rest of eq. 1",
        ),
    ]
}

fn equation_4(inputs: &Inputs) -> Vec<Row> {
    let printed = printed_z();
    let left = missing(&printed, 2);
    let slope = |x: [f64; 2]| {
        (acts(ErrorName::Ebz, [x[1], AT_MM[1]], 2) - acts(ErrorName::Ebz, [x[0], AT_MM[1]], 2))
            / (x[1] - x[0])
    };
    let grows = slope([0.0, LEVER_MM]).abs();
    vec![
        Row::predicted(
            ("eq4.terms", "terms of eq. 4 that the exact chain has to first order, but for their signs", ""),
            Some(inputs.terms_z as f64),
            in_chain(&printed, 2) as f64,
            Accept::Absolute(0.0),
            "βxΦ is the angle of X to the spindle, B0X − B0C",
        ),
        Row::printed(
            ("eq4.missing", "errors of slides that act along Z and are not in eq. 4", ""),
            Some(0.0),
            left.len() as f64,
            Accept::Absolute(0.0),
            format!("{}: γ(z)·Wh, the pitch of Z by the height of the part", codes(&left)),
        ),
        Row::printed(
            ("eq6.slope", "growth with x of what β(z) does along Z, over β(z), by eq. 6", ""),
            Some(0.0),
            grows,
            Accept::Absolute(0.0),
            "eq. 6 has β(z)·TX for eq. 4's β(z)·WX with WX = x + const: bilinear, no f(x) + g(z) holds it",
        ),
        Row::ours(
            ("eq6.um", "what is left of it over 100 mm at 5 µrad", "µm"),
            1e3 * ANGLE_RAD * LEVER_MM * grows,
            "more than four times the flatness after compensation",
        ),
    ]
}

/// Names of ISO 230-1.
fn codes(names: &[ErrorName]) -> String {
    names.iter().map(|name| name.code()).collect::<Vec<_>>().join(", ")
}

/// Eq. 5 and the nets.
fn others() -> Vec<Row> {
    // printed in eq. 5: Δ "plane X" and δ(x), where eq. 4 has a displacement along Z and δz(x)
    const WRONG_SYMBOLS: usize = 2;
    // β(z)·TZ does not change with x, the input of net B; β(x)·TZ does
    let changes =
        (acts(ErrorName::Ebz, [LEVER_MM, AT_MM[1]], 0) - acts(ErrorName::Ebz, [0.0, AT_MM[1]], 0)).abs();
    vec![
        Row::printed(
            ("eq5.symbols", "symbols of eq. 5 that differ from those of eq. 4 for the same quantity", ""),
            Some(0.0),
            WRONG_SYMBOLS as f64,
            Accept::Absolute(0.0),
            "an error along Z of a face is called plane X, δz(x) is printed δ(x)",
        ),
        Row::printed(
            ("netB.input", "inputs of net B on which its printed output, β(z)·TZ = f(x), depends", ""),
            Some(1.0),
            f64::from(u8::from(changes > 0.0)),
            Accept::Absolute(0.0),
            "β(z) does not change with x; eq. 3 and the samples have β(x)·TZ",
        ),
        Row::printed(
            ("samples.netD", "times that the output of net D enters the table of Z", ""),
            Some(1.0),
            0.0,
            Accept::Absolute(0.0),
            "printed is δ1Z(xi) + δ1Z(zj), the curve of the face twice, once over z; δ2Z(zj) is meant",
        ),
    ]
}
