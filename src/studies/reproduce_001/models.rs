//! The nets and splines on profiles of the paper's size; the field is assumed, as the paper prints
//! none.
//!
//! Samples have the noise of the paper's probe. Errors are those between the samples.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::inputs::Inputs;
use super::profile::Profile;
use crate::studies::machine::models::{CurveKind, CurveModel};
use crate::studies::reproduction::{Accept, Row};

/// Profiles of a net, and of a model that takes no starts.
const NETS: u64 = 8;
const SPLINES: u64 = 200;
/// Units of the paper's nets: it prints none.
const HIDDEN: usize = 12;

/// Error of a model between the samples of a profile: rms and peak to valley, µm.
fn left(kind: CurveKind, inputs: &Inputs, range_um: f64, seed: u64) -> Option<[f64; 2]> {
    let profile = Profile::drawn(seed, range_um, inputs.side_mm);
    let mut random = Pcg64::seed_from_u64(seed ^ 0x006e_6f69_7365);
    let x: Vec<f64> = (0..inputs.positions()).map(|k| inputs.step_mm * k as f64).collect();
    let mut read = |x: &f64| {
        let noise: f64 = StandardNormal.sample(&mut random);
        profile.um(*x) + inputs.probe_um * noise
    };
    let y: Vec<f64> = x.iter().map(&mut read).collect();
    let model = CurveModel::fitted(kind, &x, &y)?;
    let between = x.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let off: Option<Vec<f64>> = between.map(|p| Some(model.value(p)? - profile.um(p))).collect();
    let off = off?;
    let rms = (off.iter().map(|e| e * e).sum::<f64>() / off.len() as f64).sqrt();
    let fold = |(low, high): (f64, f64), e: &f64| (low.min(*e), high.max(*e));
    let (low, high) = off.iter().fold((f64::INFINITY, f64::NEG_INFINITY), fold);
    Some([rms, high - low])
}

/// What a model leaves over profiles, µm.
struct Over {
    /// Mean rms.
    rms: f64,
    /// Mean peak to valley.
    range: f64,
    /// The rms that 95 % of the profiles stay below.
    rms_of_95: f64,
    /// The largest rms.
    worst: f64,
}

fn over(kind: CurveKind, inputs: &Inputs, range_um: f64, count: u64) -> Over {
    let mut all: Vec<[f64; 2]> = (0..count).filter_map(|seed| left(kind, inputs, range_um, seed)).collect();
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mean = |k: usize| all.iter().map(|e| e[k]).sum::<f64>() / all.len() as f64;
    let of_share = |share: f64| {
        let place = (share * all.len() as f64).ceil() as usize;
        all.get(place.saturating_sub(1)).map_or(f64::NAN, |e| e[0])
    };
    Over { rms: mean(0), range: mean(1), rms_of_95: of_share(0.95), worst: of_share(1.0) }
}

pub(super) fn rows(inputs: &Inputs) -> Vec<Row> {
    let net = CurveKind::Net { hidden: HIDDEN };
    let ([straight, straight_after], [flat, flat_after]) = (inputs.straightness_um, inputs.flatness_um);
    let of_net = [straight, flat].map(|range| over(net, inputs, range, NETS));
    let of_spline = [straight, flat].map(|range| over(CurveKind::PSpline, inputs, range, SPLINES));
    // a reading between the samples has the probe's own noise beside what the model leaves
    let shown = |left: f64| left.hypot(inputs.probe_um * 4.5);
    let factor = |id: &str, of: &str, before: f64, after: f64, left: f64, model: &str| {
        let (id, of) =
            (format!("models.{id}"), format!("{of} over what {model} and the probe's noise leave"));
        let why = "profiles of waves of 25 to 200 mm (8 of a net, 200 of a spline), 51 samples with noise .01; the field is assumed";
        let accept = Accept::Range(before / after, f64::INFINITY);
        Row::in_sample((&id, &of, ""), Some(before / after), before / shown(left), accept, why)
    };
    vec![
        factor("net.straightness", "straightness", straight, straight_after, of_net[0].range, "net A"),
        factor("net.flatness", "flatness", flat, flat_after, of_net[1].range, "net C"),
        Row::ours(
            ("models.net.rms", "error of a net 1-12-1 on profiles of .80, mean rms", "µm"),
            of_net[1].rms,
            format!("eight starts a profile, chosen on samples left out; worst {:.4}", of_net[1].worst),
        ),
        factor(
            "spline.straightness",
            "straightness",
            straight,
            straight_after,
            of_spline[0].range,
            "a penalised spline",
        ),
        factor("spline.flatness", "flatness", flat, flat_after, of_spline[1].range, "a penalised spline"),
        Row::ours(
            ("models.spline.rms", "the same of a penalised spline", "µm"),
            of_spline[1].rms,
            format!("200 profiles, without starts; worst {:.4}", of_spline[1].worst),
        ),
        Row::ours(
            ("models.spline.rms95", "below which 95 % of the 200 profiles stay", "µm"),
            of_spline[1].rms_of_95,
            "rms of a penalised spline on profiles of .80",
        ),
    ]
}
