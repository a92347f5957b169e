//! Frames of a part on a lathe with errors: at every field the head stands before the part by its
//! own pose, and the frame has the commanded z.

use std::sync::Arc;

use crate::job::{HeadView, Lathe};
use crate::render::{OpticalSetup, RenderError, Scene};
use crate::shaft::Shaft;

/// What frames are taken of.
pub(super) enum Shown {
    /// One scene for all stops, or one a stop.
    Scenes(Vec<Scene>),
    /// A part before a head that the machine displaces.
    Moved(Box<MovedHead>),
}

/// A part before a head that the machine displaces.
pub(super) struct MovedHead {
    lathe: Arc<Lathe>,
    setup: OpticalSetup,
    part: Shaft,
    /// The last field, mm, with its view and scene: the angles of a field have them in common.
    field: Option<(f64, HeadView, Scene)>,
}

/// The scene of a stop, and where the head stands in it.
pub(super) struct Stop<'a> {
    pub(super) scene: &'a Scene,
    /// z of the middle of its field, mm.
    pub(super) z_mm: f64,
    /// The spindle angle that it sees, degrees.
    pub(super) angle_deg: f64,
}

impl Shown {
    /// A part before the head of a lathe, at rest.
    pub(super) fn moved(lathe: Arc<Lathe>, setup: OpticalSetup, part: Shaft) -> Self {
        Self::Moved(Box::new(MovedHead { lathe, setup, part, field: None }))
    }

    /// Stop `index` (from 0) at a commanded z and angle.
    ///
    /// # Errors
    /// Where the part cannot be drawn there.
    pub(super) fn stop(
        &mut self,
        index: usize,
        (z_mm, angle_deg): (f64, f64),
    ) -> Result<Stop<'_>, RenderError> {
        match self {
            Self::Scenes(scenes) => {
                let scene = &scenes[index.min(scenes.len() - 1)];
                Ok(Stop { scene, z_mm, angle_deg })
            }
            Self::Moved(head) => head.stop(z_mm, angle_deg),
        }
    }
}

impl MovedHead {
    fn stop(&mut self, z_mm: f64, angle_deg: f64) -> Result<Stop<'_>, RenderError> {
        let last = self.field.take().filter(|(at, ..)| *at == z_mm);
        let (at, view, scene) = match last {
            Some(field) => field,
            None => {
                let view = self.lathe.head(z_mm);
                let scene = Scene::new(&self.setup, view.seen(self.part.clone()))?;
                (z_mm, view, scene)
            }
        };
        let (seen_z_mm, seen_deg) = (view.z_mm(), view.angle_deg(angle_deg));
        let (_, _, scene) = self.field.insert((at, view, scene));
        Ok(Stop { scene, z_mm: seen_z_mm, angle_deg: seen_deg })
    }
}
