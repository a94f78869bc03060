//! Silhouettes of a recording in the form that a recognizer takes.

use crate::dataset::sequences::{Form, mean};
use crate::draw::template::{Builder, Template};
use crate::error::Result;
use edgegait_core::silhouette::{AnySilhouette, Coverage, Size};

/// Converts the silhouettes of a recording or a gait cycle to a recognizer's input. Silhouettes
/// are bytes of 0 to 255, at least one frame.
///
/// # Errors
/// For more frames than [`Builder::MAX_FRAMES`], except for GEIs and silhouettes.
pub(crate) fn in_form(silhouettes: Vec<u8>, form: &Form) -> Result<Vec<u8>> {
    let size = form.settings.size;
    let frames = silhouettes.len() / size.pixels();
    match (form.settings.template, form.frames) {
        (Template::Gei, _) => Ok(mean(&silhouettes, size)),
        (Template::Silhouettes, None) => Ok(silhouettes),
        (Template::Silhouettes, Some(wanted)) => Ok((0..wanted)
            .flat_map(|at| {
                // Evenly spaced frames, or a repetition from the start if there are too few.
                let from = if frames > wanted {
                    at * frames / wanted
                } else {
                    at % frames
                };
                silhouettes[from * size.pixels()..][..size.pixels()].to_vec()
            })
            .collect()),
        (template, _) => whole(template, &silhouettes, size),
    }
}

/// Makes a template from silhouettes, which count as one cycle.
fn whole(template: Template, bytes: &[u8], size: Size) -> Result<Vec<u8>> {
    let frames = silhouettes(bytes, size);
    let mut builder = Builder::new(template, size, frames.len() as u32);
    for frame in frames {
        builder.add(&frame)?;
    }
    Ok(builder.finish())
}

/// Splits the bytes of silhouettes.
pub(crate) fn silhouettes(
    bytes: &[u8],
    size: Size,
) -> impl ExactSizeIterator<Item = AnySilhouette> {
    bytes.chunks_exact(size.pixels()).map(move |bytes| {
        let mut coverage = Coverage::empty(size);
        coverage.pixels_mut().copy_from_slice(bytes);
        AnySilhouette::Grey(coverage)
    })
}
