//! Limit deviations of shafts after ISO 286-1:2010: standard tolerances IT01 to IT18 and the
//! fundamental deviations a to zc, up to 500 mm.
//!
//! Figures: ISO 286-1:2010, tables 1, 4 and 5, with Cor. 1:2013 (ef from 18 to 30 mm is −28 µm,
//! printed as −25); IT01 and IT0 after its annex. Up to 10 mm cd, ef and fg are those of ISO
//! 286-1:1988, up to 50 mm those of 2010. The other limit follows from the grade: ei = es − IT for
//! a to h, es = ei + IT for j to zc; js lies at ± IT/2, which the standard of 2010 does not round.

/// Upper ends of the main steps of nominal size, mm; a step includes its upper end, not its lower
/// one.
const MAIN_STEPS_MM: [f64; 13] =
    [3.0, 6.0, 10.0, 18.0, 30.0, 50.0, 80.0, 120.0, 180.0, 250.0, 315.0, 400.0, 500.0];
/// Upper ends of the steps of which the main steps above 10 mm are made, mm.
const STEPS_MM: [f64; 25] = [
    3.0, 6.0, 10.0, 14.0, 18.0, 24.0, 30.0, 40.0, 50.0, 65.0, 80.0, 100.0, 120.0, 140.0, 160.0, 180.0, 200.0,
    225.0, 250.0, 280.0, 315.0, 355.0, 400.0, 450.0, 500.0,
];
/// Names of the grades, as they stand behind the letters.
const GRADES: [&str; 20] = [
    "01", "0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12", "13", "14", "15", "16", "17",
    "18",
];
/// Standard tolerances by main step and grade (IT01, IT0, IT1 … IT18), µm.
const IT_UM: [[f64; 20]; 13] = [
    [
        0.3, 0.5, 0.8, 1.2, 2.0, 3.0, 4.0, 6.0, 10.0, 14.0, 25.0, 40.0, 60.0, 100.0, 140.0, 250.0, 400.0,
        600.0, 1000.0, 1400.0,
    ],
    [
        0.4, 0.6, 1.0, 1.5, 2.5, 4.0, 5.0, 8.0, 12.0, 18.0, 30.0, 48.0, 75.0, 120.0, 180.0, 300.0, 480.0,
        750.0, 1200.0, 1800.0,
    ],
    [
        0.4, 0.6, 1.0, 1.5, 2.5, 4.0, 6.0, 9.0, 15.0, 22.0, 36.0, 58.0, 90.0, 150.0, 220.0, 360.0, 580.0,
        900.0, 1500.0, 2200.0,
    ],
    [
        0.5, 0.8, 1.2, 2.0, 3.0, 5.0, 8.0, 11.0, 18.0, 27.0, 43.0, 70.0, 110.0, 180.0, 270.0, 430.0, 700.0,
        1100.0, 1800.0, 2700.0,
    ],
    [
        0.6, 1.0, 1.5, 2.5, 4.0, 6.0, 9.0, 13.0, 21.0, 33.0, 52.0, 84.0, 130.0, 210.0, 330.0, 520.0, 840.0,
        1300.0, 2100.0, 3300.0,
    ],
    [
        0.6, 1.0, 1.5, 2.5, 4.0, 7.0, 11.0, 16.0, 25.0, 39.0, 62.0, 100.0, 160.0, 250.0, 390.0, 620.0,
        1000.0, 1600.0, 2500.0, 3900.0,
    ],
    [
        0.8, 1.2, 2.0, 3.0, 5.0, 8.0, 13.0, 19.0, 30.0, 46.0, 74.0, 120.0, 190.0, 300.0, 460.0, 740.0,
        1200.0, 1900.0, 3000.0, 4600.0,
    ],
    [
        1.0, 1.5, 2.5, 4.0, 6.0, 10.0, 15.0, 22.0, 35.0, 54.0, 87.0, 140.0, 220.0, 350.0, 540.0, 870.0,
        1400.0, 2200.0, 3500.0, 5400.0,
    ],
    [
        1.2, 2.0, 3.5, 5.0, 8.0, 12.0, 18.0, 25.0, 40.0, 63.0, 100.0, 160.0, 250.0, 400.0, 630.0, 1000.0,
        1600.0, 2500.0, 4000.0, 6300.0,
    ],
    [
        2.0, 3.0, 4.5, 7.0, 10.0, 14.0, 20.0, 29.0, 46.0, 72.0, 115.0, 185.0, 290.0, 460.0, 720.0, 1150.0,
        1850.0, 2900.0, 4600.0, 7200.0,
    ],
    [
        2.5, 4.0, 6.0, 8.0, 12.0, 16.0, 23.0, 32.0, 52.0, 81.0, 130.0, 210.0, 320.0, 520.0, 810.0, 1300.0,
        2100.0, 3200.0, 5200.0, 8100.0,
    ],
    [
        3.0, 5.0, 7.0, 9.0, 13.0, 18.0, 25.0, 36.0, 57.0, 89.0, 140.0, 230.0, 360.0, 570.0, 890.0, 1400.0,
        2300.0, 3600.0, 5700.0, 8900.0,
    ],
    [
        4.0, 6.0, 8.0, 10.0, 15.0, 20.0, 27.0, 40.0, 63.0, 97.0, 155.0, 250.0, 400.0, 630.0, 970.0, 1550.0,
        2500.0, 4000.0, 6300.0, 9700.0,
    ],
];
/// A value that the standard leaves empty.
const NONE: i16 = i16::MIN;

/// Fundamental deviations by main step, µm: es of d to g, ei of k to p.
const BY_MAIN_STEP_UM: [(&str, [i16; 13]); 11] = [
    ("cd", [-34, -46, -56, -70, -85, -100, NONE, NONE, NONE, NONE, NONE, NONE, NONE]),
    ("d", [-20, -30, -40, -50, -65, -80, -100, -120, -145, -170, -190, -210, -230]),
    ("e", [-14, -20, -25, -32, -40, -50, -60, -72, -85, -100, -110, -125, -135]),
    ("ef", [-10, -14, -18, -23, -28, -35, NONE, NONE, NONE, NONE, NONE, NONE, NONE]),
    ("f", [-6, -10, -13, -16, -20, -25, -30, -36, -43, -50, -56, -62, -68]),
    ("fg", [-4, -6, -8, -10, -12, -15, NONE, NONE, NONE, NONE, NONE, NONE, NONE]),
    ("g", [-2, -4, -5, -6, -7, -9, -10, -12, -14, -15, -17, -18, -20]),
    ("k", [0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5]),
    ("m", [2, 4, 6, 7, 8, 9, 11, 13, 15, 17, 20, 21, 23]),
    ("n", [4, 8, 10, 12, 15, 17, 20, 23, 27, 31, 34, 37, 40]),
    ("p", [6, 12, 15, 18, 22, 26, 32, 37, 43, 50, 56, 62, 68]),
];
/// Fundamental deviations by the finer steps, µm: es of a to c, ei of r to zc.
const BY_STEP_UM: [(&str, [i16; 25]); 14] = [
    (
        "a",
        [
            -270, -270, -280, -290, -290, -300, -300, -310, -320, -340, -360, -380, -410, -460, -520, -580,
            -660, -740, -820, -920, -1050, -1200, -1350, -1500, -1650,
        ],
    ),
    (
        "b",
        [
            -140, -140, -150, -150, -150, -160, -160, -170, -180, -190, -200, -220, -240, -260, -280, -310,
            -340, -380, -420, -480, -540, -600, -680, -760, -840,
        ],
    ),
    (
        "c",
        [
            -60, -70, -80, -95, -95, -110, -110, -120, -130, -140, -150, -170, -180, -200, -210, -230, -240,
            -260, -280, -300, -330, -360, -400, -440, -480,
        ],
    ),
    (
        "r",
        [
            10, 15, 19, 23, 23, 28, 28, 34, 34, 41, 43, 51, 54, 63, 65, 68, 77, 80, 84, 94, 98, 108, 114,
            126, 132,
        ],
    ),
    (
        "s",
        [
            14, 19, 23, 28, 28, 35, 35, 43, 43, 53, 59, 71, 79, 92, 100, 108, 122, 130, 140, 158, 170, 190,
            208, 232, 252,
        ],
    ),
    (
        "t",
        [
            NONE, NONE, NONE, NONE, NONE, NONE, 41, 48, 54, 66, 75, 91, 104, 122, 134, 146, 166, 180, 196,
            218, 240, 268, 294, 330, 360,
        ],
    ),
    (
        "u",
        [
            18, 23, 28, 33, 33, 41, 48, 60, 70, 87, 102, 124, 144, 170, 190, 210, 236, 258, 284, 315, 350,
            390, 435, 490, 540,
        ],
    ),
    (
        "v",
        [
            NONE, NONE, NONE, NONE, 39, 47, 55, 68, 81, 102, 120, 146, 172, 202, 228, 252, 284, 310, 340,
            385, 425, 475, 530, 595, 660,
        ],
    ),
    (
        "x",
        [
            20, 28, 34, 40, 45, 54, 64, 80, 97, 122, 146, 178, 210, 248, 280, 310, 350, 385, 425, 475, 525,
            590, 660, 740, 820,
        ],
    ),
    (
        "y",
        [
            NONE, NONE, NONE, NONE, NONE, 63, 75, 94, 114, 144, 174, 214, 254, 300, 340, 380, 425, 470, 520,
            580, 650, 730, 820, 920, 1000,
        ],
    ),
    (
        "z",
        [
            26, 35, 42, 50, 60, 73, 88, 112, 136, 172, 210, 258, 310, 365, 415, 465, 520, 575, 640, 710, 790,
            900, 1000, 1100, 1250,
        ],
    ),
    (
        "za",
        [
            32, 42, 52, 64, 77, 98, 118, 148, 180, 226, 274, 335, 400, 470, 535, 600, 670, 740, 820, 920,
            1000, 1150, 1300, 1450, 1600,
        ],
    ),
    (
        "zb",
        [
            40, 50, 67, 90, 108, 136, 160, 200, 242, 300, 360, 445, 525, 620, 700, 780, 880, 960, 1050, 1200,
            1300, 1500, 1650, 1850, 2100,
        ],
    ),
    (
        "zc",
        [
            60, 80, 97, 130, 150, 188, 218, 274, 325, 405, 480, 585, 690, 800, 900, 1000, 1150, 1250, 1350,
            1550, 1700, 1900, 2100, 2400, 2600,
        ],
    ),
];
/// ei of j by main step, µm: grades 5 and 6; grade 7; grade 8 has one, up to 3 mm.
const J_UM: [[i16; 13]; 2] = [
    [-2, -2, -2, -3, -4, -5, -7, -9, -11, -13, -16, -18, -20],
    [-4, -4, -5, -6, -8, -10, -12, -15, -18, -21, -26, -28, -32],
];
const J8_UP_TO_3_MM_UM: i16 = -6;

/// Lower and upper limit deviation of a shaft's tolerance class such as `h6`, µm.
///
/// # Errors
/// What the class lacks, or why the standard has no value, in words, without the text itself.
pub(super) fn shaft_deviations_um(nominal_mm: f64, class: &str) -> Result<(f64, f64), String> {
    let (letters, grade) = split_class(class)?;
    let it_um = standard_tolerance_um(nominal_mm, grade)?;
    if letters == "js" {
        return Ok((-0.5 * it_um, 0.5 * it_um));
    }
    let fundamental = f64::from(fundamental_um(nominal_mm, letters, grade)?);
    // the fundamental deviation of a to h is the upper limit, that of j to zc the lower one.
    Ok(if letters <= "h" { (fundamental - it_um, fundamental) } else { (fundamental, fundamental + it_um) })
}

/// Whether letters are a fundamental deviation of shafts.
pub(super) fn is_deviation(letters: &str) -> bool {
    let tabulated = BY_MAIN_STEP_UM.iter().map(|r| r.0).chain(BY_STEP_UM.iter().map(|r| r.0));
    ["h", "j", "js"].into_iter().chain(tabulated).any(|name| name == letters)
}

/// Letters and grade of a class.
fn split_class(class: &str) -> Result<(&str, &str), String> {
    let digits = class.find(|c: char| c.is_ascii_digit()).unwrap_or(class.len());
    let (letters, grade) = class.split_at(digits);
    if !is_deviation(letters) {
        return Err(format!(
            "{letters:?} is no fundamental deviation of ISO 286 (a to h, js, j, k, m, n, p to v, x to zc)"
        ));
    }
    if grade.is_empty() {
        return Err(format!("{class:?} has no grade"));
    }
    if GRADES.contains(&grade) {
        Ok((letters, grade))
    } else {
        Err(format!("{grade:?} is no standard tolerance grade: IT01, IT0, IT1 to IT18"))
    }
}

/// Standard tolerance of a grade such as `6` or `01`, µm.
///
/// # Errors
/// Why there is none.
pub(super) fn standard_tolerance_um(nominal_mm: f64, grade: &str) -> Result<f64, String> {
    if !(nominal_mm > 0.0 && nominal_mm <= 500.0) {
        return Err(format!(
            "ISO 286 is known here for nominal sizes above 0 up to 500 mm, not for {nominal_mm} mm"
        ));
    }
    let row = MAIN_STEPS_MM.iter().position(|end| nominal_mm <= *end);
    let column = GRADES.iter().position(|g| *g == grade);
    if nominal_mm <= 1.0 && column >= GRADES.iter().position(|g| *g == "14") {
        return Err(format!("IT{grade} is not used for nominal sizes up to 1 mm"));
    }
    row.zip(column).map(|(row, column)| IT_UM[row][column]).ok_or_else(|| format!("IT{grade} has no value"))
}

/// es of a to h, ei of j to zc, µm.
fn fundamental_um(nominal_mm: f64, letters: &str, grade: &str) -> Result<i16, String> {
    let main = MAIN_STEPS_MM.iter().position(|end| nominal_mm <= *end).unwrap_or(0);
    let step = STEPS_MM.iter().position(|end| nominal_mm <= *end).unwrap_or(0);
    if (letters == "a" || letters == "b") && nominal_mm <= 1.0 {
        return Err(format!("{letters} is not used for nominal sizes up to 1 mm"));
    }
    let value = match letters {
        "h" => 0,
        "j" => match grade {
            "5" | "6" => J_UM[0][main],
            "7" => J_UM[1][main],
            "8" if main == 0 => J8_UP_TO_3_MM_UM,
            "8" => return Err("j8 ends at 3 mm; js8 exists".to_owned()),
            _ => return Err(format!("j exists in grades 5 to 8, not {grade}; js{grade} exists")),
        },
        "k" if !["4", "5", "6", "7"].contains(&grade) => 0,
        _ => tabulated_um(letters, main, step).ok_or_else(|| format!("{letters} has no grade {grade}"))?,
    };
    if value != NONE {
        return Ok(value);
    }
    Err(match letters {
        "cd" | "ef" | "fg" => format!("{letters} ends at 50 mm"),
        "t" => "t begins above 24 mm; up to there u is used".to_owned(),
        "v" => "v begins above 14 mm; up to there x is used".to_owned(),
        "y" => "y begins above 18 mm; up to there z is used".to_owned(),
        _ => format!("{letters} has no value at {nominal_mm} mm"),
    })
}

fn tabulated_um(letters: &str, main: usize, step: usize) -> Option<i16> {
    let coarse = BY_MAIN_STEP_UM.iter().find(|r| r.0 == letters).map(|r| r.1[main]);
    coarse.or_else(|| BY_STEP_UM.iter().find(|r| r.0 == letters).map(|r| r.1[step]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published limits (ISO 286-2:2010 as in Machinery's Handbook, Narayana's Machine Drawing and
    /// makers' tables), es and ei in µm.
    #[test]
    fn limits_are_those_of_published_tables() {
        for (nominal, class, es, ei) in [
            (25.0, "h6", 0.0, -13.0),
            (50.0, "g6", -9.0, -25.0),
            (10.0, "e7", -25.0, -40.0),
            (30.0, "k6", 15.0, 2.0),
            (40.0, "p6", 42.0, 26.0),
            (60.0, "s6", 72.0, 53.0),
            (60.0, "r6", 60.0, 41.0),
            (70.0, "r6", 62.0, 43.0),
            (100.0, "u7", 159.0, 124.0),
            (6.0, "a11", -270.0, -345.0),
            (30.0, "b11", -160.0, -290.0),
            (45.0, "c11", -130.0, -290.0),
            (20.0, "d9", -65.0, -117.0),
            (18.0, "f7", -16.0, -34.0),
            (2.0, "j6", 4.0, -2.0),
            (25.0, "j6", 9.0, -4.0),
            (25.0, "j7", 13.0, -8.0),
            (3.0, "j8", 8.0, -6.0),
            (50.0, "js9", 31.0, -31.0),
            (25.0, "js7", 10.5, -10.5),
            (25.0, "k5", 11.0, 2.0),
            (25.0, "k8", 33.0, 0.0),
            (25.0, "k3", 4.0, 0.0),
            (25.0, "m6", 21.0, 8.0),
            (25.0, "n6", 28.0, 15.0),
            (24.0, "t6", f64::NAN, f64::NAN),
            (24.5, "t6", 54.0, 41.0),
            (16.0, "v6", 50.0, 39.0),
            (16.0, "x6", 56.0, 45.0),
            (20.0, "y6", 76.0, 63.0),
            (25.0, "z8", 121.0, 88.0),
            (120.0, "za8", 454.0, 400.0),
            (400.0, "zb9", 1790.0, 1650.0),
            (500.0, "zc11", 3000.0, 2600.0),
            (500.0, "h18", 0.0, -9700.0),
            (2.0, "h01", 0.0, -0.3),
            (2.0, "h0", 0.0, -0.5),
            (12.0, "cd8", -70.0, -97.0),
            (20.0, "ef7", -28.0, -49.0),
            (8.0, "fg6", -8.0, -17.0),
        ] {
            match shaft_deviations_um(nominal, class) {
                Ok(found) => assert_eq!(found, (ei, es), "{nominal} {class}"),
                Err(why) => assert!(es.is_nan(), "{nominal} {class}: {why}"),
            }
        }
    }

    /// Geometric mean of a step's ends; the first begins at 3 mm.
    fn mean(ends: &[f64], i: usize) -> f64 {
        if i == 0 { 3.0_f64.sqrt() } else { (ends[i - 1] * ends[i]).sqrt() }
    }

    /// The standard's own derivation: IT6 to IT18 are 10, 16, 25, 40, 64, 100 … times i = 0.45·∛D +
    /// 0.001·D, fundamental deviations geometric means and powers of D; its rounding moves them by
    /// a tenth at most (a twentieth above 50 µm).
    #[test]
    fn tolerance_grades_follow_the_formula_of_the_standard() {
        for (row, it) in IT_UM.iter().enumerate() {
            let d = mean(&MAIN_STEPS_MM, row);
            let unit = 0.45 * d.cbrt() + 0.001 * d;
            for (grade, value) in it.iter().enumerate().skip(7) {
                let factor =
                    [10.0, 16.0, 25.0, 40.0, 64.0, 100.0, 160.0, 250.0, 400.0, 640.0, 1000.0, 1600.0, 2500.0]
                        [grade - 7];
                let slack = if row == 0 { 0.16 } else { 0.1 };
                assert!(
                    (value / (factor * unit) - 1.0).abs() < slack,
                    "{} {row} {value} {}",
                    GRADES[grade],
                    factor * unit
                );
            }
        }
    }

    /// Fundamental deviations, likewise.
    #[test]
    fn deviations_follow_the_formulae_of_the_standard() {
        let near = |letters: &str, of: &dyn Fn(f64, usize) -> f64, least_step: usize| {
            for (step, end_mm) in STEPS_MM.iter().enumerate().skip(least_step) {
                let main = MAIN_STEPS_MM.iter().position(|end| end_mm <= end).unwrap();
                let Some(value) = tabulated_um(letters, main, step).filter(|v| *v != NONE) else { continue };
                let d = if BY_STEP_UM.iter().any(|r| r.0 == letters) {
                    mean(&STEPS_MM, step)
                } else {
                    mean(&MAIN_STEPS_MM, main)
                };
                let expected = of(d, main);
                let slack = (0.05 * expected.abs()).max(2.0);
                assert!(
                    (f64::from(value) - expected).abs() <= slack,
                    "{letters} to {} mm: {value} {expected}",
                    STEPS_MM[step]
                );
            }
        };
        let it = |grade: usize, main: usize| IT_UM[main][grade + 1];
        near("a", &|d, _| if d <= 120.0 { -(265.0 + 1.3 * d) } else { -3.5 * d }, 0);
        near("b", &|d, _| if d <= 160.0 { -(140.0 + 0.85 * d) } else { -1.8 * d }, 0);
        near("c", &|d, _| if d <= 40.0 { -52.0 * d.powf(0.2) } else { -(95.0 + 0.8 * d) }, 8);
        near("d", &|d, _| -16.0 * d.powf(0.44), 0);
        near("e", &|d, _| -11.0 * d.powf(0.41), 0);
        near("f", &|d, _| -5.5 * d.powf(0.41), 0);
        near("g", &|d, _| -2.5 * d.powf(0.34), 0);
        near("m", &|_, m| it(7, m) - it(6, m), 3);
        near("n", &|d, _| 5.0 * d.powf(0.34), 1);
        near("t", &|d, m| it(7, m) + 0.63 * d, 7);
        near("u", &|d, m| it(7, m) + d, 4);
        near("v", &|d, m| it(7, m) + 1.25 * d, 0);
        near("x", &|d, m| it(7, m) + 1.6 * d, 4);
        near("y", &|d, m| it(7, m) + 2.0 * d, 0);
        near("z", &|d, m| it(7, m) + 2.5 * d, 4);
        near("za", &|d, m| it(8, m) + 3.15 * d, 3);
        near("zb", &|d, m| it(9, m) + 4.0 * d, 2);
        near("zc", &|d, m| it(10, m) + 5.0 * d, 2);
    }

    #[test]
    fn deviations_between_two_letters_are_their_geometric_mean() {
        let between = |letters: &str, below: &str, above: &str| {
            for (step, end_mm) in STEPS_MM.iter().enumerate().take(9) {
                let main = MAIN_STEPS_MM.iter().position(|end| end_mm <= end).unwrap();
                let of = |l: &str| f64::from(tabulated_um(l, main, step).unwrap());
                let expected = -(of(below) * of(above)).sqrt();
                assert!(
                    (of(letters) - expected).abs() <= 1.1 + 0.02 * expected.abs(),
                    "{letters} {}: {expected}",
                    STEPS_MM[step]
                );
            }
        };
        between("cd", "c", "d");
        between("ef", "e", "f");
        between("fg", "f", "g");
    }

    #[test]
    fn what_does_not_exist_is_refused_with_the_reason() {
        for (nominal, class, reason) in [
            (0.8, "h14", "up to 1 mm"),
            (1.0, "a11", "up to 1 mm"),
            (1.0, "b9", "up to 1 mm"),
            (51.0, "cd8", "ends at 50"),
            (14.0, "v6", "above 14"),
            (18.0, "y6", "above 18"),
            (5.0, "j8", "ends at 3"),
            (25.0, "j9", "grades 5 to 8"),
            (25.0, "j01", "grades 5 to 8"),
            (501.0, "h6", "500 mm"),
            (25.0, "h19", "IT18"),
            (25.0, "h02", "IT18"),
            (25.0, "h", "no grade"),
            (25.0, "i6", "no fundamental deviation"),
            (25.0, "l6", "no fundamental deviation"),
        ] {
            let why = shaft_deviations_um(nominal, class).expect_err(class);
            assert!(why.contains(reason), "{nominal} {class}: {why}");
        }
        assert!(shaft_deviations_um(1.01, "h14").is_ok() && shaft_deviations_um(1.0, "h13").is_ok());
    }
}
