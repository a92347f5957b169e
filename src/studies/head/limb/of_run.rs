//! How far the limbs of a run's part stand from its masters': what `run` corrects by where its
//! optics image limbs.
//!
//! Part and masters of a job have the one surface that its optics state, so that only the diameter
//! sets them apart; what else is known stands in `[scan.limb]`.

use super::comparison::{Surfaces, Texture, compare};
use super::shift::{FittedEdge, LimbHead};
use crate::gauge::calibration::{Finish, LimbDifference};
use crate::gauge::{EdgeRoom, EsfModel};
use crate::job::Job;
use crate::render::settings::Esf;
use crate::studies::head::error::HeadError;

/// The difference of the part's limbs of any pass from the masters'; none for optics that image no
/// limbs, where the config states it, without a camera, and before masters of one size.
///
/// # Errors
/// Limbs that cannot be computed or fitted.
pub(crate) fn limb_of_run(job: &Job) -> Result<Option<LimbDifference>, HeadError> {
    let Esf::Cylinder(optics) = &job.optics.esf else { return Ok(None) };
    let masters_mm: Vec<f64> = job.masters.pins.iter().map(|pin| pin.diameter_mm).collect();
    let (least, most) = bounds(&masters_mm);
    if job.scan.limb.is_some() || job.probe.is_some() || least >= most {
        return Ok(None);
    }
    let gauge = job.gauge_settings()?;
    let half_px = EdgeRoom::of(&gauge, 1.0).beside_px as usize;
    let fitted = match job.gauge.esf {
        EsfModel::Gaussian {} => FittedEdge::Gaussian,
        _ => FittedEdge::Optics,
    };
    let part_mm = job.part.nominal_diameter_mm.iter().chain([&job.part.stock_diameter_mm]);
    let all: Vec<f64> = part_mm.chain(&masters_mm).copied().collect();
    let surfaces = Surfaces {
        masters_mm,
        masters_material: optics.material,
        part_material: Some(optics.material),
        masters_finish: Finish::Lapped,
        certified_by_contact: false,
        part_texture: Texture::Roughness(0.0),
        film_um: (0.0, 0.0),
        range_mm: bounds(&all),
        masters_y_mm: 0.0,
    };
    let head = LimbHead::before(&job.setup_settings(), job.part.drawn_diameter_mm(), half_px, fitted)?;
    Ok(Some(compare(&head, &surfaces)?.limb))
}

fn bounds(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), d| (least.min(*d), most.max(*d)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::calibration::KnownMaterial;
    use crate::render::optics::edge_spread::CylinderEdge;

    #[test]
    fn a_run_before_limbs_is_corrected_by_diameter_and_others_are_not() {
        let mut job = Job::default();
        assert_eq!(limb_of_run(&job).unwrap(), None);
        job.optics.esf = Esf::Cylinder(CylinderEdge { extra_sigma_um: 5.0, ..CylinderEdge::default() });
        let limb = limb_of_run(&job).unwrap().unwrap();
        assert_eq!((limb.from_mm, limb.to_mm, limb.material), (24.0, 28.0, KnownMaterial::LikeMasters));
        // Masters of 24 and 28 mm lie on their own line; between them the limb lies outside it.
        for mm in [24.0, 28.0] {
            assert!(limb.by_diameter_um(mm).abs() < 1e-3, "{mm}: {}", limb.by_diameter_um(mm));
        }
        assert!((0.0..0.01).contains(&limb.by_diameter_um(26.0)), "{}", limb.by_diameter_um(26.0));
        job.scan.limb = Some(limb);
        assert_eq!(limb_of_run(&job).unwrap(), None);
    }
}
