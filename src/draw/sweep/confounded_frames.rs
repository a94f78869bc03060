//! Frames under confounders of the image: rendered finely, confounded, and framed again.

use super::posed_frames::{FramedView, PosedFrames};
use super::recording;
use crate::draw::confounders::image::{
    self, BitPicture, Crossing, Fine, FineRenderer, Framed, Light, Pillar,
};
use crate::draw::confounders::{ConfounderKind, Dose};
use crate::error::Result;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{self, DrawError};

impl PosedFrames<'_> {
    /// Draws one of the posed frames under confounders of the image. Returns `None` if nothing of
    /// the figure is left.
    ///
    /// # Errors
    /// If the frame cannot be drawn.
    pub(super) fn segmented(
        &self,
        index: usize,
        framed_view: &FramedView<'_>,
        renderer: &mut FineRenderer,
    ) -> Result<Option<Framed>> {
        let render_view = self.render_view(index, framed_view)?;
        let framed = self.confounded(index, framed_view, render_view, renderer);
        framed.map_err(|error| self.refusal(framed_view.requested(), error))
    }

    fn confounded(
        &self,
        index: usize,
        framed_view: &FramedView<'_>,
        render_view: raster::RenderView,
        renderer: &mut FineRenderer,
    ) -> std::result::Result<Option<Framed>, DrawError> {
        let (posed, extras, plan) = (&self.frames[index], &self.extras[index], self.plan);
        let requested = framed_view.requested();
        let view = (requested.azimuth_deg, requested.elevation_deg);
        let frame = self.sources[index];
        let shadow = extras.shadow();
        let others: Vec<&Figure<'_>> = shadow.iter().collect();
        let size = self.settings.size;
        let fine = match Fine::lay_out(&posed.figure, &others, render_view, size) {
            Err(DrawError::TooNear(_) | DrawError::TooWide(_)) => {
                Fine::lay_out(&posed.figure, &[], render_view, size)?
            }
            fine => fine?,
        };
        let (mut picture, before) = match extras.exposures.as_slice() {
            [] => fine.draw_figure(renderer, &posed.figure)?,
            moments => fine.draw_exposed(renderer, &posed.figure, moments)?,
        };
        if let Some(shadow) = &shadow {
            picture.join(&in_sight(&fine, renderer, shadow)?);
        }
        for other in self.in_front(index, framed_view) {
            let other = other.figure(self.walker.crossing());
            picture.remove(&in_sight(&fine, renderer, &other)?);
        }
        let cell = recording::coarseness(plan, self.settings.framing);
        if let Some(cell) = cell {
            let mut rng = plan.of_view(ConfounderKind::FocalLength, view);
            image::to_cells(&mut picture, &fine, cell, &mut rng);
        }
        for &Dose { kind, strength } in plan.doses().list() {
            // Random numbers of the whole cycle, and random numbers of this frame.
            let lasting = || plan.of_view(kind, view);
            let passing = || plan.of_picture(kind, view, frame);
            let picture = &mut picture;
            match kind {
                ConfounderKind::RadialDistortion => image::distort(picture, &fine, strength),
                ConfounderKind::Resolution => {
                    image::coarsen(picture, &fine, strength, &mut lasting());
                }
                ConfounderKind::Light => {
                    Light::new(strength, &mut lasting()).segment(picture, &fine, &mut passing());
                }
                ConfounderKind::Holes => {
                    image::holes(picture, &fine, &posed.figure, strength, &mut lasting());
                }
                ConfounderKind::MissingParts => {
                    let (figure, rng) = (&posed.figure, &mut lasting());
                    image::missing_part(picture, &fine, renderer, figure, strength, rng)?;
                }
                ConfounderKind::MergedBackground => {
                    image::merged_background(picture, &fine, strength, &mut lasting());
                }
                ConfounderKind::Erosion => image::erode(picture, &fine, strength, &mut passing()),
                ConfounderKind::Dilation => image::dilate(picture, &fine, strength, &mut passing()),
                ConfounderKind::Waver => {
                    image::waver(picture, &fine, extras.strides, strength, &mut lasting());
                }
                ConfounderKind::FilteredNoise => {
                    image::filtered_noise(picture, strength, &mut passing());
                }
                ConfounderKind::SaltAndPepper => {
                    image::salt_and_pepper(picture, strength, &mut passing());
                }
                _ => {}
            }
        }
        Ok(fine.frame(&picture, before))
    }

    /// Returns the occluders between the camera and the walker.
    pub(super) fn in_front(&self, index: usize, framed_view: &FramedView<'_>) -> Vec<InFront> {
        let (posed, extras, plan) = (&self.frames[index], &self.extras[index], self.plan);
        let (stride_m, _) = self.walker.stride();
        let mut all = Vec::new();
        if let Some(strength) = plan.strength(ConfounderKind::StaticOccluder) {
            let mut rng = plan.of_cycle(ConfounderKind::StaticOccluder);
            let pillar = Pillar::new(strength, &mut rng);
            all.push(InFront::Pillar(pillar.body(
                extras.strides,
                stride_m,
                framed_view.viewpoint(),
            )));
        }
        if let Some(strength) = plan.strength(ConfounderKind::MovingOccluder) {
            let mut rng = plan.of_cycle(ConfounderKind::MovingOccluder);
            let crossing = Crossing::new(strength, &mut rng);
            let pose = crossing.pose(
                &posed.model,
                extras.strides,
                stride_m,
                framed_view.viewpoint(),
            );
            all.push(InFront::Walker(Box::new(pose)));
        }
        all
    }
}

/// Draws a figure other than the walker. The picture is blank if the figure is not wholly in front
/// of the camera, or larger than a picture can be.
fn in_sight(
    fine: &Fine,
    renderer: &mut FineRenderer,
    figure: &Figure<'_>,
) -> std::result::Result<BitPicture, DrawError> {
    match fine.draw(renderer, figure) {
        Err(DrawError::TooNear(_) | DrawError::TooWide(_)) => Ok(fine.blank()),
        drawn => drawn,
    }
}

/// An occluder between the camera and the walker.
pub(super) enum InFront {
    /// A static pillar.
    Pillar(Box<UnpackedBody>),
    /// A person who crosses.
    Walker(Box<ModelPose>),
}

impl InFront {
    /// Returns the occluder's figure; `body` is the body of the person who crosses.
    pub(super) fn figure<'f>(&'f self, body: &'f UnpackedBody) -> Figure<'f> {
        match self {
            Self::Pillar(own) => Figure::at_rest(own),
            Self::Walker(pose) => Figure::new(body, pose),
        }
    }
}
