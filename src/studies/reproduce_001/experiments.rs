//! Straightness, cylindricity and flatness: what the figures imply, and what a probe on the machine
//! sees of the part that it cut.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::inputs::Inputs;
use super::profile::Profile;
use crate::numerics::distributions::phi_cdf;
use crate::studies::reproduction::{Accept, Row};

/// Profiles of a mean: its scatter is then below a thousandth of a micrometre.
const PROFILES: u64 = 200;
/// Stream of the probe's noise.
const STREAM: u64 = 0x7374_7261_6967_6874;
/// Expansion of aluminium, µm/(m·K).
const ALUMINIUM: f64 = 23.1;

pub(super) fn rows(inputs: &Inputs) -> Vec<Row> {
    [factors(inputs), own_part(inputs), scatter(inputs)].concat()
}

/// Expected range of n normal values of standard deviation 1: ∫ 1 − Φⁿ − (1 − Φ)ⁿ.
fn expected_range(n: usize) -> f64 {
    // beyond ±8 the integrand is below n·1e-15
    const STEPS: usize = 1600;
    let width = 16.0 / STEPS as f64;
    let at = |k: usize| {
        let p = phi_cdf(-8.0 + width * k as f64);
        1.0 - p.powi(n as i32) - (1.0 - p).powi(n as i32)
    };
    let inner: f64 = (1..STEPS).map(at).sum();
    width * (inner + 0.5 * (at(0) + at(STEPS)))
}

fn factors(inputs: &Inputs) -> Vec<Row> {
    let factor = |[before, after]: [f64; 2]| before / after;
    let off = |um: f64| (um - inputs.cylindrimeter_um).abs();
    let [before, after] = inputs.cylindricity_um;
    vec![
        Row::ours(
            ("straightness.factor", "straightness before over after compensation", ""),
            factor(inputs.straightness_um),
            ".26/.10",
        ),
        Row::ours(
            ("cylindricity.factor", "cylindricity before over after compensation", ""),
            factor(inputs.cylindricity_um),
            ".38/.21",
        ),
        Row::ours(
            ("flatness.factor", "flatness before over after compensation", ""),
            factor(inputs.flatness_um),
            ".80/.12",
        ),
        Row::printed(
            ("cylindricity.off", "deviation from the cylindrimeter after compensation, over that before", ""),
            None,
            off(after) / off(before),
            Accept::Range(0.0, 1.0),
            "the cylindrimeter reads .40: .38 is off by .02 and .21 by .19. A smaller indication is no smaller error",
        ),
    ]
}

/// Mean peak to valley of profiles of the paper's straightness, a number of times over, with the
/// probe's noise, µm.
fn indicated(inputs: &Inputs, times: f64) -> f64 {
    let range = |seed: u64| {
        let profile = Profile::drawn(seed, inputs.straightness_um[0], inputs.generatrix_mm);
        let mut random = Pcg64::seed_from_u64(seed ^ STREAM);
        let fold = |(low, high): (f64, f64), k: usize| {
            let noise: f64 = StandardNormal.sample(&mut random);
            let um = times * profile.um(inputs.step_mm * k as f64) + inputs.probe_um * noise;
            (low.min(um), high.max(um))
        };
        let points = 0..inputs.generatrix_points();
        let (low, high) = points.fold((f64::INFINITY, f64::NEG_INFINITY), fold);
        high - low
    };
    (0..PROFILES).map(range).sum::<f64>() / PROFILES as f64
}

/// What a probe on the machine indicates of the part that the machine cut. The tool's error is in
/// the part and, on the same slide and side, in the reading with the opposite sign; on the other
/// side with the same.
fn own_part(inputs: &Inputs) -> Vec<Row> {
    let noise_um = inputs.probe_um * expected_range(inputs.generatrix_points());
    let [before, after] = inputs.straightness_um;
    vec![
        Row::printed(
            (
                "self.same_side",
                "straightness that a probe on the tool's side indicates of the part it cut",
                "µm",
            ),
            Some(before),
            noise_um,
            Accept::Relative(0.5),
            "the errors that cut the generatrix carry the probe along it: what is left is the probe's noise of .01 over 51 points",
        ),
        Row::ours(
            ("self.same_side.after", "the same after the exact error is subtracted", "µm"),
            indicated(inputs, 1.0),
            "compensation makes the true straightness of .26 appear: the indication grows",
        ),
        Row::ours(
            ("self.opposite", "what a probe on the opposite side indicates", "µm"),
            indicated(inputs, 2.0),
            "twice the true straightness, and the true one after compensation",
        ),
        Row::ours(
            ("self.two_sided", "what a head that sees both edges indicates", "µm"),
            indicated(inputs, 1.0),
            "the true straightness without any compensation",
        ),
        Row::in_sample(
            (
                "self.elsewhere",
                "what is left of a straight part that was made elsewhere, after compensation",
                "µm",
            ),
            Some(after),
            noise_um,
            Accept::Range(0.0, after),
            "before, the machine's .26 shows: of the four cases only this one resembles .26 → .10",
        ),
    ]
}

fn scatter(inputs: &Inputs) -> Vec<Row> {
    let ([_, straight], [_, flat]) = (inputs.straightness_um, inputs.flatness_um);
    let (points, spiral) = (inputs.generatrix_points(), inputs.spiral_points);
    let [line, plane] = [straight / expected_range(points), flat / expected_range(spiral)];
    vec![
        Row::ours(
            ("scatter.straightness", "scatter of model and probe that .10 over 51 points implies", "µm"),
            line,
            ".10 over the expected range of 51 normal values",
        ),
        Row::in_sample(
            ("scatter.flatness", "the same of .12 over 481 points", "µm"),
            Some(line),
            plane,
            Accept::Relative(0.25),
            "compared with that of the straightness: both leave the same scatter",
        ),
        Row::ours(
            ("scatter.probe", "flatness that the probe's noise of .01 alone shows over 481 points", "µm"),
            inputs.probe_um * expected_range(spiral),
            "half of what is left after compensation",
        ),
        Row::ours(
            ("temperature.um", "what ±.1 K does to 100 mm of aluminium", "µm"),
            1e-3 * ALUMINIUM * inputs.side_mm * inputs.limit_k,
            "23.1 µm/(m·K); the paper names no material: twice the flatness after compensation",
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::expected_range;

    /// Harter's table (1960): 1.128, 3.078, 4.498, 5.015.
    #[test]
    fn the_expected_range_is_that_of_the_tables() {
        for (n, range) in [(2, 1.128), (10, 3.078), (50, 4.498), (100, 5.015)] {
            assert!((expected_range(n) - range).abs() < 6e-4, "{n}: {}", expected_range(n));
        }
    }
}
