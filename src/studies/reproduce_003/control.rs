//! Equations 11 to 18 and Fig. 11 on the error-transfer plant.

use super::inputs::PidInput;
use crate::control::stability::{Plant, pid_transfer, stable_gains};
use crate::control::{FirstPass, OffsetForm, Pid, PidAlgorithm, PidSettings};
use crate::studies::reproduction::{Accept, Row};

/// Agreement required of the errors of Fig. 11, as a share of the first.
pub(super) const READING: f64 = 0.15;

pub(super) fn rows(input: &PidInput) -> Vec<Row> {
    let mut rows = equations(input);
    rows.extend(equation_18(input));
    rows.extend(transfer_plant(input));
    rows.extend(stability(input));
    rows
}

fn settings(input: &PidInput) -> PidSettings {
    PidSettings {
        kp: input.kp,
        ki: input.ki,
        kd: input.kd,
        first_pass: FirstPass::Proportional,
        ..PidSettings::default()
    }
}

/// A plant e(k+1) = α·e(k) - g·u(k) + w.
#[derive(Clone, Copy)]
struct ErrorPlant {
    alpha: f64,
    gain: f64,
    w: f64,
}

/// Errors of a plant under a controller.
fn sequence(settings: &PidSettings, first: f64, plant: ErrorPlant, passes: usize) -> Vec<f64> {
    let ErrorPlant { alpha, gain, w } = plant;
    let mut pid = Pid::new(settings, 1);
    let mut errors = vec![first];
    while errors.len() < passes {
        let e = errors[errors.len() - 1];
        let u = pid.step(&[e])[0];
        errors.push(alpha * e - gain * u + w);
    }
    errors
}

fn equations(input: &PidInput) -> Vec<Row> {
    let PidInput { kp, ki, kd, .. } = *input;
    let (ti, td) = (kp / ki, kd / kp);
    // eq. 11 on a ramp e = t, exactly: the integral is t²/2, the derivative 1.
    let t = 3.0;
    let eleven = kp * (t + t * t / 2.0 / ti + td);
    let thirteen = kp * t + ki * t * t / 2.0 + kd;
    let incremental =
        PidSettings { algorithm: PidAlgorithm::Incremental, first_pass: FirstPass::Full, ..settings(input) };
    let positional = PidSettings { algorithm: PidAlgorithm::Positional, ..incremental.clone() };
    let (mut a, mut b) = (Pid::new(&positional, 1), Pid::new(&incremental, 1));
    let apart = input
        .uncompensated_mm
        .iter()
        .chain(&input.compensated_mm)
        .map(|e| (a.step(&[*e])[0] - b.step(&[*e])[0]).abs())
        .fold(0.0, f64::max);
    let fifteen = (kp * ti + kp) / ti - (kp + ki);
    vec![
        Row::identity(
            ("eq11", "eq. 11 less eq. 13 on a ramp", ""),
            eleven - thirteen,
            1e-12,
            "equal with K_i = K_p/T_i, K_d = K_p·T_d",
        ),
        Row::ours(("eq13.Ti", "integration time T_i = K_p/K_i", "passes"), ti, "from the printed gains"),
        Row::identity(
            ("eq15", "eq. 15 less eq. 13 with T_d = 0, at s = 1", ""),
            fifteen,
            1e-12,
            "equal; the text calls this PI regulator PID",
        ),
        Row::identity(
            ("eq16-17", "largest difference of eq. 16 and the summed eq. 17 over Fig. 11's errors", "mm"),
            apart,
            1e-12,
            "positional and incremental form are the same",
        ),
    ]
}

/// Eq. 18 as printed, without Ki, and with Ki, on a plant of unit gain under a constant
/// disturbance. The paper does not print its machine's gain; where the inputs contain one, it is
/// used.
fn equation_18(input: &PidInput) -> Vec<Row> {
    let first = input.uncompensated_mm[0];
    let gain = input.plant_gain.unwrap_or(1.0);
    let printed = PidSettings { ki: 1.0, ..settings(input) };
    let restored = settings(input);
    let accumulated = |settings: &PidSettings| {
        let mut pid = Pid::new(settings, 1);
        let (mut offset, mut errors) = (0.0, vec![first]);
        while errors.len() < 4 {
            offset += pid.step(&[errors[errors.len() - 1]])[0];
            errors.push(first - gain * offset);
        }
        errors
    };
    let absolute =
        |settings: &PidSettings| sequence(settings, first, ErrorPlant { alpha: 0.0, gain, w: first }, 4);
    let row = |id: &str, reading: &str, errors: &[f64]| {
        let apart = errors.iter().zip(&input.compensated_mm).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let quantity = format!("largest distance from Fig. 11b on a plant of gain {gain}, {reading}");
        let text: Vec<String> = errors.iter().map(|e| format!("{e:.4}")).collect();
        let reason = format!("gives {} mm", text.join(", "));
        // Figures are printed to 0.001 mm.
        Row::predicted((id, &quantity, "mm"), Some(0.0), apart, Accept::Absolute(5e-4), reason)
            .needs(&[("the machine's answer to an offset", input.plant_gain.is_some())])
    };
    vec![
        row("eq18.printed", "sum without K_i", &absolute(&printed)),
        row("eq18.restored", "K_i restored", &absolute(&restored)),
        row("eq18.printed.accumulated", "sum without K_i, offsets accumulated", &accumulated(&printed)),
        row("eq18.restored.accumulated", "K_i restored, offsets accumulated", &accumulated(&restored)),
    ]
}

/// Fig. 11 on e(k+1) = α·e(k) - g·u(k).
fn transfer_plant(input: &PidInput) -> Vec<Row> {
    let (alpha, gain) = (input.transfer_alpha, input.transfer_gain);
    let first = input.uncompensated_mm[0];
    let nothing = PidSettings { kp: 0.0, ki: 0.0, kd: 0.0, ..settings(input) };
    let without = sequence(&nothing, first, ErrorPlant { alpha, gain: 0.0, w: 0.0 }, 4);
    let with = sequence(&settings(input), first, ErrorPlant { alpha, gain, w: 0.0 }, 9);
    let assumption = format!(
        "error-transfer plant e(k+1) = {alpha}·e(k) - {gain}·u(k) identified from Fig. 11, K_i restored in eq. 18"
    );
    let mut rows = Vec::new();
    for (name, paper, ours) in
        [("uncompensated", &input.uncompensated_mm, &without), ("compensated", &input.compensated_mm, &with)]
    {
        for (k, (paper, ours)) in paper.iter().zip(ours).enumerate() {
            let id = format!("fig11.{name}.pass{}", k + 1);
            let quantity = format!("error after pass {}, {name}", k + 1);
            let accept = Accept::Absolute(READING * first);
            rows.push(Row::in_sample((&id, &quantity, "mm"), Some(*paper), *ours, accept, &*assumption));
        }
    }
    let falls = with[..4].windows(2).all(|pair| pair[1] < pair[0] && pair[1] > 0.0);
    rows.push(Row::in_sample(
        ("fig11.monotone", "four compensated passes fall monotonically (1: yes)", ""),
        Some(1.0),
        f64::from(u8::from(falls)),
        Accept::Absolute(0.5),
        "on the error-transfer plant",
    ));
    rows.push(Row::ours(
        ("fig11.pass9", "error after pass 9, compensated", "mm"),
        with[8],
        "beyond the paper's four passes the loop overshoots before it settles",
    ));
    rows
}

fn stability(input: &PidInput) -> Vec<Row> {
    let absolute = PidSettings { form: OffsetForm::Absolute, first_pass: FirstPass::Full, ..settings(input) };
    let accumulated = PidSettings { form: OffsetForm::Accumulated, ..absolute.clone() };
    let transfer = Plant::Transfer { alpha: input.transfer_alpha };
    let limits = |settings: &PidSettings, plant: Plant| {
        stable_gains(&pid_transfer(settings), plant).first().copied().unwrap_or((f64::NAN, f64::NAN))
    };
    let row = |id: &str, quantity: &str, ours: f64, reason: &str| Row::ours((id, quantity, ""), ours, reason);
    let (low, high) = limits(&absolute, transfer);
    vec![
        row(
            "stability.transfer.low",
            "smallest stable gain of the error-transfer plant",
            low,
            "below it errors grow as without control",
        ),
        row(
            "stability.transfer.high",
            "largest stable gain of the error-transfer plant",
            high,
            "the paper's plant lies inside",
        ),
        row(
            "stability.absolute",
            "largest stable plant gain, offsets absolute as printed",
            limits(&absolute, Plant::Constant).1,
            "the physical plant's gain (fig11.physical.gain) lies above it: eq. 18 as printed oscillates there",
        ),
        row(
            "stability.accumulated",
            "largest stable plant gain, offsets accumulated",
            limits(&accumulated, Plant::Constant).1,
            "the form that the loop here uses",
        ),
    ]
}
