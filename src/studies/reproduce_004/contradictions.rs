//! Thirteen places where the paper's figures, equations and words do not agree, c01 to c13.
//!
//! Every row computes from what is printed; a row that also needs something which the paper lacks
//! names it.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use glam::DVec2;

use super::inputs::{HUNDREDTH_MM, Inputs, MICROMETRE_MM, PrintedPart};
use super::nose_rows::CAMERA_PX;
use super::parts::{MEASURED, RATE_PERCENT};
use super::seat::projected_angle;
use crate::gauge::nose::paper;
use crate::studies::reproduction::{Accept, Row};
use crate::tool::Setting;

/// Inclinations of a holder's seat for negative inserts along X and Z, degrees; not in the paper.
const SEAT_DEG: f64 = 6.0;
/// Radius of the arc on which the edit of part 3 is tried, mm: its part of second order is e/R.
const TRIED_ARC_MM: f64 = 1e3;
/// Accuracy of the radius gauge as the paper has it, mm.
const RADIUS_GAUGE_MM: f64 = 0.01;
/// The ways in which a flank is measured, with their place.
const FLANK_METHODS: [&str; 2] =
    ["morphology, Canny and a fitted edge (section 2)", "a network trained from masks (section 5)"];
/// The frameworks of section 5: name, the end at which the paper puts it, the end that it is for.
const FRAMEWORKS: [(&str, &str, &str); 2] = [("SpringBoot", "front", "back"), ("ReactJS", "back", "front")];

/// The rows; `round` is a round nose of the radius r, set at R1.
pub(super) fn rows(inputs: &Inputs, round: &Setting<'_>) -> Vec<Row> {
    [
        cone_angles(inputs),
        products(inputs),
        large_diameter(inputs),
        arc_sizes(inputs),
        batch(inputs),
        register(inputs, round),
        arc_edit(inputs),
        rates(inputs),
        false_alarms(inputs),
        words(),
        seat(inputs),
        repeatability(inputs),
    ]
    .concat()
}

/// c01: the angle is not given.
fn cone_angles(inputs: &Inputs) -> Vec<Row> {
    let mut rows = Vec::new();
    for (k, &dz) in inputs.dz_mm.iter().enumerate() {
        let id = |name: &str| format!("c01.part{}.{name}", k + 1);
        let angle = |dz: f64| inputs.needed_rad(dz).to_degrees();
        rows.push(
            Row::printed(
                (&id("dz"), "axial compensation dz = d/sin θ", "mm"),
                Some(dz),
                inputs.d_mm() / inputs.cone_rad(k).sin(),
                Accept::Absolute(HUNDREDTH_MM),
                "section 3.1, with d of the printed radii",
            )
            .needs(&[inputs.theta()]),
        );
        let why = "asin(d/dz)";
        rows.push(Row::ours((&id("theta"), "half angle θ that dz would need", "°"), angle(dz), why));
        rows.push(Row::ours(
            (&id("theta.least"), "least θ that rounds to dz", "°"),
            angle(dz + HUNDREDTH_MM),
            "asin(d/(dz + .005))",
        ));
        rows.push(Row::ours(
            (&id("theta.most"), "largest θ that rounds to dz", "°"),
            angle(dz - HUNDREDTH_MM),
            "asin(d/(dz − .005))",
        ));
    }
    rows
}

/// c02: a product in the text.
fn products(inputs: &Inputs) -> Vec<Row> {
    let row = |k: usize| {
        Row::printed(
            (&format!("c02.part{}", k + 1), "largest d·sin θ of all angles, as the text has dz", "mm"),
            Some(inputs.dz_mm[k]),
            inputs.d_mm(),
            Accept::Absolute(HUNDREDTH_MM),
            "the text has \"dz = d sin θ\" without a fraction bar; a product is at most d, so that d/sin θ is meant",
        )
    };
    vec![row(0), row(1)]
}

/// c03: d of the cone's diameter.
fn large_diameter(inputs: &Inputs) -> Vec<Row> {
    let part = &inputs.parts[1];
    let measured = PrintedPart::mean_mm(&part.before_mm);
    let row = |names: (&str, &str, &str), ours: f64, why: &str| {
        Row::printed(names, Some(measured), ours, part.accepts(), why)
    };
    let least = inputs.needed_rad(inputs.dz_mm[1] + HUNDREDTH_MM);
    vec![
        row(
            ("c03.least", "part 2: least error 2d/cos θ of the large diameter, at any θ", "mm"),
            2.0 * inputs.d_mm(),
            "an error d along the normal changes the diameter by 2d/cos θ, at least by 2d: more than the mean, but not beyond the \
             scatter of the readings",
        ),
        row(
            ("c03.rounding", "part 2: the same at the least θ that rounds to its dz", "mm"),
            2.0 * inputs.d_mm() / least.cos(),
            "c01.part2.theta.least",
        ),
        row(
            ("c03.theta", "part 2: the same at the θ of its dz, or at the one stated", "mm"),
            2.0 * inputs.d_mm() / inputs.cone_rad(1).cos(),
            "c01.part2.theta",
        )
        .needs(&[inputs.theta()]),
    ]
}

/// c04: e is not d.
fn arc_sizes(inputs: &Inputs) -> Vec<Row> {
    let (d, e) = (inputs.d_mm(), inputs.e_mm);
    let [dx2, dz2] = inputs.dx2_dz2_mm;
    let printed = |names: (&str, &str, &str), paper: f64, ours: f64, reason: &str| {
        Row::printed(names, Some(paper), ours, Accept::Absolute(MICROMETRE_MM), reason)
    };
    let at_45 = "the same nose as part 1: e = R1 − r is d";
    vec![
        printed(
            ("c04.e", "part 3: e = R1 − r", "mm"),
            e,
            d,
            "section 3.1 has e = R1 − r, as d, and section 2.2 employs its R1 and r for the compensation",
        ),
        Row::ours(("c04.ratio", "part 3: e over d", ""), e / d, "1 by the equations"),
        printed(("c04.dx2", "part 3: dx2 = d·cos 45°", "mm"), dx2, d * FRAC_1_SQRT_2, at_45),
        printed(("c04.dz2", "part 3: dz2 = d·sin 45°", "mm"), dz2, d * FRAC_1_SQRT_2, at_45),
        printed(
            ("c04.dx2.e", "part 3: dx2 = e·cos 45° with the e printed", "mm"),
            dx2,
            e * FRAC_1_SQRT_2,
            "eqs 11 and 12 hold among themselves",
        ),
        Row::ours(
            ("c04.gauge", "part 3: accuracy of the radius gauge over e", ""),
            RADIUS_GAUGE_MM / e,
            "the readings have steps of .01 mm, and the text calls them the diameter error of the large cone",
        ),
    ]
}

/// c05: dx radial or of the diameter.
fn batch(inputs: &Inputs) -> Vec<Row> {
    let part = &inputs.parts[3];
    vec![
        Row::printed(
            ("c05.diameter", "part 4: error of the diameter that a radial dx leaves", "mm"),
            Some(PrintedPart::mean_mm(&part.before_mm)),
            2.0 * inputs.dx_mm,
            part.accepts(),
            "dx is called radial; .016 agrees with the mean only as an error of the diameter",
        ),
        Row::printed(
            ("c05.gap", "part 4: radial dx of the nose that is measured", "mm"),
            Some(inputs.dx_mm),
            inputs.gap_mm,
            Accept::Absolute(MICROMETRE_MM),
            "R0 less the distance of the worn nose along X: the mean gap to the tangents",
        )
        .needs(&[("the reading of the nose of part 4, if it is another one", false)]),
    ]
}

/// c06: which radius the control held.
fn register(inputs: &Inputs, round: &Setting<'_>) -> Vec<Row> {
    // the angle in whole degrees, as a drawing would have it
    let a = inputs.cone_deg.map_or(inputs.cone_rad(0).to_degrees().round(), |deg| deg[0]).to_radians();
    let (kept, set) = (round.left_mm(a, inputs.nominal_mm), round.left_mm(a, inputs.set_radius_mm));
    let held = [inputs.theta(), ("the radius in the control's register", false)];
    let (measured, accept) = (PrintedPart::mean_mm(&inputs.parts[0].before_mm), inputs.parts[0].accepts());
    vec![
        Row::ours(
            ("c06.e", "part 1: error along the normal with R0 kept in the register", "mm"),
            kept,
            "(R0 − r) − (R0 − R1)(cos θ + sin θ), by the program's own e(a) of a round nose r set at R1",
        ),
        Row::printed(
            ("c06.dz", "part 1: axial error with R0 kept in the register", "mm"),
            Some(measured),
            kept / a.sin(),
            accept,
            "e/sin θ; d presumes that R1 was entered after setting, which no step of the paper does",
        )
        .needs(&held),
        Row::printed(
            ("c06.dz.R1", "part 1: axial error with R1 in the register", "mm"),
            Some(measured),
            set / a.sin(),
            accept,
            "d/sin θ",
        )
        .needs(&held),
    ]
}

/// Radius by which an arc between fixed tangents at right angles is smaller where its middle lies
/// `b` further out, mm: the middle is (√2 − 1)R from the corner of the tangents.
fn between_tangents(b: f64) -> f64 {
    b / (SQRT_2 - 1.0)
}

/// What the edit of part 3 moves the middle of a quarter arc of radius `r` by, mm outwards: the
/// point on the face is moved by e·cos 45° to the axis, the point on the cylinder by e·sin 45°
/// along it, and the radius becomes r + e.
fn edited_middle(r: f64, e: f64) -> f64 {
    let (face, cylinder) = (DVec2::new(-e * FRAC_1_SQRT_2, r), DVec2::new(r, -e * FRAC_1_SQRT_2));
    let (chord, radius) = (face.distance(cylinder), r + e);
    let sagitta = radius - (radius * radius - 0.25 * chord * chord).sqrt();
    0.5 * (face + cylinder).length() + sagitta - r
}

/// c07: what wear in the middle of a nose does to an arc, and what the edit does.
fn arc_edit(inputs: &Inputs) -> Vec<Row> {
    let (d, e) = (inputs.d_mm(), inputs.e_mm);
    vec![
        Row::printed(
            ("c07.radius", "part 3: change of the arc's radius by material d at 45°", "mm"),
            Some(e),
            between_tangents(d),
            Accept::Absolute(MICROMETRE_MM),
            "cylinder and face stay where setting puts them: an arc tangent to both is smaller by (1 + √2)·d, not by d",
        ),
        Row::printed(
            ("c07.edit", "part 3: what the edit moves the arc by at 45°, over e", ""),
            Some(-1.0),
            edited_middle(TRIED_ARC_MM, e) / e,
            Accept::Absolute(0.01),
            "to return to the drawing it must move by −e; the ends moved by e·cos 45° and e·sin 45° and the radius r + e take it \
             by −.414 e",
        ),
        Row::ours(
            ("c07.left", "part 3: error left at 45° after the edit, over e", ""),
            1.0 + edited_middle(TRIED_ARC_MM, e) / e,
            "the printed rate is 37.5 %",
        ),
    ]
}

/// c08: two ways to compute a rate.
fn rates(inputs: &Inputs) -> Vec<Row> {
    let agrees = |percent: f64, part: &PrintedPart| (percent - part.rate_percent).abs() <= RATE_PERCENT;
    let raw = inputs.parts.iter().filter(|p| agrees(p.raw_percent(), p)).count();
    let means = inputs.parts.iter().filter(|p| agrees(p.printed_means_percent(), p)).count();
    let mut rows = vec![Row::printed(
        ("c08.parts", "parts whose printed rate is that of the raw readings", ""),
        Some(inputs.parts.len() as f64),
        raw as f64,
        Accept::Absolute(0.0),
        format!(
            "{means} of the rates are those of the printed means: the columns are not computed in one way"
        ),
    )];
    for k in [0, 1] {
        let part = &inputs.parts[k];
        rows.push(Row::printed(
            (&format!("c08.part{}", k + 1), "reduction of the mean of the raw readings", "%"),
            Some(part.rate_percent),
            part.raw_percent(),
            Accept::Absolute(RATE_PERCENT),
            format!("of the printed means it is {:.2} %", part.printed_means_percent()),
        ));
    }
    rows
}

/// c09: the exponent of the number of tests.
fn false_alarms(inputs: &Inputs) -> Vec<Row> {
    let tests = |exponent: f64| paper::tests(CAMERA_PX, exponent, 1.0);
    vec![
        Row::printed(
            ("c09.exponent", "exponent of NM in the number of regions (eq. 5)", ""),
            Some(inputs.exponent),
            2.0 + 0.5,
            Accept::Absolute(0.0),
            "either end of a region may be any of NM pixels, its width any up to √(NM)",
        ),
        Row::ours(
            ("c09.tests", "regions of an image of 3072 × 2048 pixels, exponent 5/2", ""),
            tests(2.5),
            "the camera's pixels by its data sheet",
        ),
        Row::ours(
            ("c09.tests.printed", "the same with the printed exponent 2/5", ""),
            tests(inputs.exponent),
            "fewer than the image has rows",
        ),
    ]
}

/// c10 and c11: statements in words.
fn words() -> Vec<Row> {
    let right = FRAMEWORKS.iter().filter(|(_, stated, is)| stated == is).count();
    vec![
        Row::printed(
            ("c10.flank", "ways in which the wear of the flank is measured", ""),
            Some(1.0),
            FLANK_METHODS.len() as f64,
            Accept::Absolute(0.0),
            FLANK_METHODS.join("; "),
        )
        .needs(&[("which of them Table 1 is from", false)]),
        Row::printed(
            ("c11.frameworks", "frameworks of section 5 named at the end that they are for", ""),
            Some(FRAMEWORKS.len() as f64),
            right as f64,
            Accept::Absolute(0.0),
            "SpringBoot, which serves, is called the front end and ReactJS, which runs in the browser, the back end; the \
             language is given as Python",
        ),
    ]
}

/// c12: the angle that the image shows.
fn seat(inputs: &Inputs) -> Vec<Row> {
    let slope = -SEAT_DEG.to_radians().tan();
    // the leading edge lies at κ_r to the feed, in X-Z as seen
    let leading = (inputs.kappa_r_deg - 90.0).to_radians();
    let seen = projected_angle(inputs.epsilon_r_deg.to_radians(), leading, DVec2::splat(slope));
    let row = Row::printed(
        ("c12.angle", "angle of the cutting edges in the reference plane on a seat of −6° and −6°", "°"),
        Some(inputs.epsilon_r_deg),
        seen.to_degrees(),
        Accept::Absolute(0.05),
        "60° is the angle in the rake's own plane; forcing the lines to it turns them by half a degree where the holder tilts \
         the insert towards the lens",
    );
    vec![row.needs(&[("the inclinations of the seat", false)])]
}

/// c13: what is left beside what the lathe repeats.
fn repeatability(inputs: &Inputs) -> Vec<Row> {
    let [x, z] = inputs.repeatability_mm;
    let limits = [z, 2.0 * x, RADIUS_GAUGE_MM, 2.0 * x];
    let why = [
        "the repeatability along Z",
        "twice the repeatability along X",
        "the accuracy of the radius gauge",
        "twice the repeatability along X",
    ];
    let row = |k: usize| {
        let ours = PrintedPart::mean_mm(&inputs.parts[k].after_mm) / limits[k];
        Row::ours(
            (
                &format!("c13.part{}", k + 1),
                &format!("mean error left of the {}, over {}", MEASURED[k], why[k]),
                "",
            ),
            ours,
            "Tables 3 and 4: about 1, on four parts, so that what the method itself leaves cannot be seen",
        )
    };
    (0..4).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_between_two_tangents_is_found_by_bisection_too() {
        // quarter arc of 5 mm, its middle 12.2 µm further out
        let out = 5.0 + 0.0122;
        let (mut low, mut high) = (4.5f64, 5.0f64);
        for _ in 0..60 {
            let r = 0.5 * (low + high);
            // centre at (5 − r)(1, 1)
            if (5.0 - r) * SQRT_2 + r > out { low = r } else { high = r }
        }
        assert!((5.0 - low - between_tangents(0.0122)).abs() < 1e-9);
        assert!((between_tangents(0.0122) - 0.029_45).abs() < 5e-6);
    }

    #[test]
    fn the_edit_moves_the_ends_not_at_all_and_the_middle_by_less_than_half() {
        let (r, e) = (1e3, 0.015);
        assert!((edited_middle(r, e) / e + (SQRT_2 - 1.0)).abs() < 1e-4);
        // by nothing where there is no e
        assert!((edited_middle(r, 0.0)).abs() < 1e-9);
    }
}
