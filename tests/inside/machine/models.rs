//! Models of the errors side by side: what no sum of curves holds, the errors through the chain,
//! and what is refused.

use super::study;
use crate::studies::machine::ModelsAsked;
use crate::studies::machine::models::{CurveKind, CurveModel, FieldRow};

/// EBZ of ±5 µrad: 5 µrad · 100 mm of e_Z that grow with x.
const YAW: &str = "[machine.errors.ebz]\npolynomial = { coefficients_urad = [0.0, 5.0, 2.0] }\n[machine.errors.exz]\nfourier = [{ wavelength_mm = 80.0, amplitude_um = 0.3 }]\n[machine.errors.ezx]\nfourier = [{ wavelength_mm = 120.0, amplitude_um = 0.3 }]\n";

fn asked() -> ModelsAsked {
    ModelsAsked { nets: false, ..ModelsAsked::default() }
}

#[test]
fn the_errors_through_the_chain_hold_what_no_sum_does() {
    let models = study(&[], YAW).models(&asked()).unwrap();
    let of =
        |name: &str| -> &FieldRow { models.fields.iter().find(|row| row.model.starts_with(name)).unwrap() };
    let [sum, separable, structured] = [of("sum of penalised"), of("f(x)"), of("structured")];
    assert!(sum.e_z_um > 0.08 && separable.e_z_um > 0.08, "{sum:?} {separable:?}");
    assert!(structured.e_z_um < 0.012 && structured.e_x_um < 0.012, "{structured:?}");
    // along X nothing grows with both: every model has it
    assert!(sum.e_x_um < 0.02 && separable.e_x_um < 0.02, "{sum:?} {separable:?}");
    assert!(structured.z_factor > 5.0 * sum.z_factor);
}

#[test]
fn a_curve_is_held_to_the_noise_and_chosen_by_what_it_was_not_given() {
    let models = study(&[], YAW).models(&asked()).unwrap();
    for curve in models.curves.chunk_by(|a, b| a.curve == b.curve) {
        assert_eq!(curve.iter().filter(|row| row.is_least).count(), 1, "{curve:?}");
        let spline = curve.iter().find(|row| row.model == "penalised spline").unwrap();
        assert!(spline.held_out_um.unwrap() < 0.008, "{spline:?}");
        // the samples left out have their own noise of .01
        assert!(spline.left_out_um.unwrap() > 0.004, "{spline:?}");
    }
    assert_eq!(models, study(&[], YAW).models(&asked()).unwrap(), "the same seed, the same samples");
}

#[test]
fn no_model_has_a_value_outside_its_samples() {
    let x: Vec<f64> = (0..20).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| (0.3 * x).sin()).collect();
    for kind in [
        CurveKind::Net { hidden: 3 },
        CurveKind::PSpline,
        CurveKind::CubicSpline,
        CurveKind::Chebyshev { degree: 6 },
    ] {
        let model = CurveModel::fitted(kind, &x, &y).unwrap();
        assert!((model.value(9.5).unwrap() - 2.85_f64.sin()).abs() < 0.05, "{kind:?}");
        assert_eq!((model.value(-0.01), model.value(19.01)), (None, None), "{kind:?}");
    }
}

#[test]
fn values_out_of_range_are_refused_by_their_option() {
    let refused = |asked: ModelsAsked| study(&[], YAW).models(&asked).unwrap_err().to_string();
    assert!(refused(ModelsAsked { noise_um: -1.0, ..asked() }).contains("--noise-um"));
    assert!(refused(ModelsAsked { positions: 3, ..asked() }).contains("--positions"));
    assert!(refused(ModelsAsked { hidden: 0, ..asked() }).contains("--hidden"));
}
