//! Classes of scenes: their distributions and their declarations.

use serde::{Deserialize, Serialize};

use super::{illumination, limb};

/// The class of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Class {
    /// Certificates of the masters dominate.
    Certificates,
    /// Noise dominates.
    Noise,
    /// Temperatures of masters and part dominate.
    Temperature,
    /// The part's place along the line of sight dominates.
    Focus,
    /// Edges unlike the masters' dominate.
    Finish,
    /// Distortion and a camera not square to the object dominate.
    Lens,
    /// Texture of the part dominates; ten angles, one station.
    Form,
    /// All sources contribute.
    Mixed,
    /// Partially coherent light under a blur of the sensor, fitted with Gaussian edges.
    Diffraction,
    /// Partially coherent light with visible rings; the gauge is given the edge-spread function of
    /// a neighbouring light.
    GivenEsf,
    /// Light that falls across and along the field.
    Gradient,
    /// Axes tilted by up to 20 mrad.
    Tilt,
    /// Axes up to 2 mm out of the plane.
    Defocus,
    /// Lobes of up to 3 µm.
    Lobes,
    /// Half the contrast, ten times the noise of a good frame.
    LowContrast,
    /// The part jumps by 3 px during the exposure.
    Vibration,
    /// The axis 6 to 10 mm out of the plane.
    LossOfFocus,
    /// Light three times too bright: clipped.
    Overexposed,
    /// The part 8 K warmer than stated.
    WarmPart,
    /// Edges 1 µm off by their finish, beyond the limit stated.
    OtherFinish,
    /// Masters under Gaussian blur, the part in partially coherent light.
    OtherLight,
    /// Light on the part from 0.9 to 1.5 times the end of the grey scale, masters below it;
    /// measured under `clipped`.
    Clipped,
    /// Round parts of unknown material under a film, out of focus, in light half as wide as the
    /// lens: drawn from the rows of a limb's difference.
    LimbNarrow,
    /// The same in light 0.85 as wide as the lens, in which focus moves the edge least.
    LimbWide,
}

impl Class {
    /// Drawn from the budget's own distributions.
    pub(crate) const DRAWN: [Self; 8] = [
        Self::Certificates,
        Self::Noise,
        Self::Temperature,
        Self::Focus,
        Self::Finish,
        Self::Lens,
        Self::Form,
        Self::Mixed,
    ];
    /// Deviating inside the declared limits.
    pub(crate) const DEVIATING: [Self; 7] = [
        Self::Diffraction,
        Self::GivenEsf,
        Self::Gradient,
        Self::Tilt,
        Self::Defocus,
        Self::Lobes,
        Self::LowContrast,
    ];
    /// Drawn from the rows of a limb's difference.
    pub(crate) const LIMBS: [Self; 2] = [Self::LimbNarrow, Self::LimbWide];
    /// Outside the limits, and detectable by a residual, a blur or a clipped level.
    pub(crate) const DETECTABLE: [Self; 4] =
        [Self::Vibration, Self::LossOfFocus, Self::Overexposed, Self::OtherLight];
    /// Outside the limits, and not detectable in any frame.
    pub(crate) const UNDETECTABLE: [Self; 2] = [Self::WarmPart, Self::OtherFinish];

    /// NA of the light over that of the lens before round parts: that of a collimator that half
    /// fills the pupil, and the widest of [`Self::LIMBS`], in which focus moves the edge least.
    pub(super) const fn coherence_of_limbs(self) -> f64 {
        if matches!(self, Self::LimbNarrow) { 0.5 } else { 0.85 }
    }

    /// The declaration of the class and its scenes, as far as they differ from the others.
    pub(crate) fn declared(self) -> String {
        let text = match self {
            Self::Certificates => "certificates U = 2 um",
            Self::Noise => "340-500 counts, read noise 12 e, blur 1.4-2.6 px",
            Self::Temperature => "part 26 +- 3 C, expansion +- 2 um/(m K), masters +- 2 K",
            Self::Focus => "axis +- 3 mm from the masters' plane, chief rays +- 0.02 degrees",
            Self::Finish => "edges +- 1 um unlike the masters'",
            Self::Lens => "distortion +- 0.1 %, keystone +- 0.1 %",
            Self::Form => "texture 0.5 um rms, ten angles",
            Self::Mixed => {
                "certificates 0.4 um, +- 1.5 K, axis +- 1 mm, edges +- 0.15 um, distortion 0.02 %, keystone 0.01 %"
            }
            Self::Diffraction => return illumination::light(false) + "; Gaussian edge fitted",
            Self::GivenEsf => {
                return illumination::light(true) + "; given to the gauge as it is at the middle ratio";
            }
            Self::Gradient => "light falls by up to 5 % down and 10 % along the field",
            Self::Tilt => "axis tilted by up to 20 mrad",
            Self::Defocus => "axis up to 2 mm out of the masters' plane",
            Self::Lobes => "lobes 2 and 3 up to 3 um, 5 up to 1 um, texture 0.3 um rms",
            Self::LowContrast => "as noise",
            Self::Vibration => "two places 3 px apart in one exposure",
            Self::LossOfFocus => "axis 6-10 mm out of the masters' plane",
            Self::Overexposed => "grey values three times too large",
            Self::OtherLight => {
                return "masters under Gaussian blur; ".to_owned() + &illumination::other_light();
            }
            Self::WarmPart => "part 8 K warmer than stated",
            Self::OtherFinish => "edges 1 um unlike the masters', 0.05 um stated",
            Self::LimbNarrow | Self::LimbWide => return limb::in_words(self.coherence_of_limbs()),
            Self::Clipped => "light of 0.9-1.5 times the end of the grey scale on the part",
        };
        text.to_owned()
    }

    /// All of them, in the order of the tables.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let inside = Self::DRAWN.into_iter().chain(Self::DEVIATING);
        inside.chain(Self::LIMBS).chain(Self::DETECTABLE).chain(Self::UNDETECTABLE)
    }
}
