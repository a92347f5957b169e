//! What moves the edge before one head, as a page that a buyer of a lens reads.

use super::error::ReportError;
use super::html::{Page, Tone};
use super::plot::{Chart, Mark, Series};
use crate::studies::head::limb::{Effect, EffectKind, FocusOfRatio, LimbEffects};

/// The page.
///
/// # Errors
/// Where a chart cannot be drawn.
pub(crate) fn optics_page(found: &LimbEffects) -> Result<String, ReportError> {
    let mut page =
        Page::new(format!("What moves the edge of Ø{} mm before {}", found.diameter_mm, found.name));
    page.verdict(Tone::Good, &found.advice.words);
    page.text(&format!(
        "The light grazes a round part, and its image lies {:.3} µm an edge outside the part before this head (NA {:.4}, S {:.2}, {:.0} nm). \
         Masters of the part's own size, material and finish take that off. What is left is what differs between them and the part, or between \
         the day of the calibration and today: each of the causes below by itself, as the gauge reads it.",
        found.shift_um, found.numerical_aperture, found.coherence_ratio, found.wavelength_nm
    ));
    page.heading("Largest first");
    page.table(&["cause", "within", "diameter / µm"], &ranking(found));
    page.heading("Focus and diameter by the light's aperture");
    page.text(
        "S is the aperture of the light over that of the lens. Depth: how far an edge moves for each millimetre that the part stands nearer to \
         the camera. Diameter: how much farther out a limb of one and a half times the diameter lies than one of half of it.",
    );
    page.figure(
        &by_ratio(found)?,
        "Where both curves are near zero, neither depth nor the masters' size counts.",
    );
    for effect in &found.effects {
        page.heading(effect.kind.words());
        page.text(explanation(effect.kind));
        match effect.configured {
            Some(_) => page.figure(
                &chart(effect)?,
                &format!("Within {}: {:.3} µm of diameter.", effect.tolerance, effect.diameter_um),
            ),
            None => page.table(&["", "shift / µm an edge"], &names(effect)),
        };
    }
    Ok(page.finish())
}

/// Cause, tolerance and change of the diameter.
fn ranking(found: &LimbEffects) -> Vec<Vec<String>> {
    let row =
        |e: &Effect| vec![e.kind.words().to_owned(), e.tolerance.clone(), format!("{:.3}", e.diameter_um)];
    found.effects.iter().map(row).collect()
}

fn names(effect: &Effect) -> Vec<Vec<String>> {
    let named = effect.points.iter().filter_map(|p| Some((p.name?, p.shift_um)));
    named.map(|(name, um)| vec![name.to_owned(), format!("{um:+.3}")]).collect()
}

fn drawn(chart: &Chart) -> Result<String, ReportError> {
    chart.to_svg().map_err(ReportError::Draw)
}

fn chart(effect: &Effect) -> Result<String, ReportError> {
    let points = effect.points.iter().map(|p| (p.value, p.shift_um)).collect();
    let unit = if effect.unit.is_empty() { String::new() } else { format!(" / {}", effect.unit) };
    let mut series = vec![Series::new("shift of the edge", Mark::LineDots, 0, points)];
    if let Some(own) = effect.configured {
        series.push(Series::new("this head", Mark::Dots, 1, vec![(own, 0.0)]));
    }
    drawn(&Chart {
        x_label: format!("{}{unit}", effect.kind.words()),
        y_label: "shift of an edge, outwards / µm".to_owned(),
        series,
        ..Chart::default()
    })
}

fn by_ratio(found: &LimbEffects) -> Result<String, ReportError> {
    let over = |f: fn(&FocusOfRatio) -> f64| {
        found.by_ratio.iter().map(|r| (r.coherence_ratio, f(r))).collect::<Vec<_>>()
    };
    drawn(&Chart {
        x_label: "S, aperture of the light over that of the lens".to_owned(),
        y_label: "shift of an edge / µm".to_owned(),
        series: vec![
            Series::new("by a millimetre of depth", Mark::LineDots, 0, over(|r| r.by_depth_um_per_mm)),
            Series::new(
                "by the diameter, half to one and a half",
                Mark::LineDots,
                1,
                over(|r| r.by_diameter_um),
            ),
        ],
        ..Chart::default()
    })
}

/// What a quantity does, for one who buys a lens.
fn explanation(kind: EffectKind) -> &'static str {
    match kind {
        EffectKind::Focus => {
            "Light that grazed the part diverges from it, so that the sign of the depth counts: nearer to the camera the shadow shrinks under \
             narrow light, farther away it grows. A thin screen, which most simulations take for a part, has none of this. Telecentricity is a matter of its own and not in it."
        }
        EffectKind::NumericalAperture => {
            "A data sheet's f-number sets it: NA = magnification / (2 · working f-number). The aperture of the light goes with it here."
        }
        EffectKind::CoherenceRatio => {
            "Half the angle under which the part sees the illuminator, over the NA of the lens. A collimated backlight has 0.1 to 0.5, a diffuse \
             one more than 1, where mirrored light comes in."
        }
        EffectKind::Wavelength => {
            "The shift goes about with the wavelength. LEDs of one colour scatter by ten nanometres."
        }
        EffectKind::Diameter => {
            "Two masters take off a straight line in the diameter; the curve is what a third diameter keeps. `optics limb` computes the correction."
        }
        EffectKind::Material => {
            "No residual of the fit shows the material. Masters of the part's own material have the same edge."
        }
        EffectKind::Film => {
            "Oil or coolant on the part, its thickness and what it does to the light. The part is larger by the film on either side; below 0.1 µm \
             it may look smaller."
        }
        EffectKind::Finish => {
            "Roughness around the part, along the light. Grooves along the axis are slices of smooth cylinders: the edge follows their mean line, \
             where a micrometer touches their peaks."
        }
        EffectKind::Temperature => {
            "Not optics: for comparison. 11.5 µm/(m·K), the same for masters and part where both have one temperature."
        }
    }
}
