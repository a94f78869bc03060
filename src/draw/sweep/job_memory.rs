//! What a thread keeps from one job for the next: bodies, and memory for frames.

use super::posed_walker::PosedWalker;
use crate::error::Result;
use crate::people::clothes::Outfit;
use edgegait_core::body::UnpackedBody;
use std::collections::VecDeque;
use std::sync::Arc;

/// The number of bodies that a thread keeps, 6 MB: enough for the 26 built-in people, bare and
/// dressed. Unpacking a body takes about 40 us, most of it for facets.
const KEPT: usize = 64;

/// What a thread keeps from one job for the next.
#[derive(Default)]
pub(super) struct JobMemory {
    /// The bodies that were used last, of which the last is the latest.
    bodies: VecDeque<UnpackedOutfit>,
    /// The memory of posed frames, 1.2 MB for 60, and of their points by axis.
    pub(super) frames: Vec<PosedWalker<'static>>,
    pub(super) points: [Vec<f32>; 3],
}

/// An outfit, and its body.
struct UnpackedOutfit {
    outfit: Outfit,
    /// Whether it is a pack's own body, in which hulls of one joint can be draped.
    is_stored: bool,
    body: Arc<UnpackedBody>,
}

impl JobMemory {
    /// Returns the body of an outfit: the pack's own if it `is_stored`, dressed otherwise. `unpack`
    /// adds the hulls to an empty body, unless the body was kept.
    ///
    /// # Errors
    /// The errors of `unpack`.
    pub(super) fn body(
        &mut self,
        outfit: &Outfit,
        is_stored: bool,
        unpack: impl FnOnce(&mut UnpackedBody) -> Result<()>,
    ) -> Result<Arc<UnpackedBody>> {
        let is_it = |kept: &UnpackedOutfit| kept.is_stored == is_stored && kept.outfit == *outfit;
        let known = self.bodies.iter().rposition(is_it);
        let kept = match known.and_then(|at| self.bodies.remove(at)) {
            Some(kept) => kept,
            None => UnpackedOutfit {
                body: self.unpacked(unpack)?,
                outfit: outfit.clone(),
                is_stored,
            },
        };
        let body = kept.body.clone();
        self.bodies.push_back(kept);
        Ok(body)
    }

    /// Returns a new body, in the memory of the oldest one if there are enough.
    fn unpacked(
        &mut self,
        unpack: impl FnOnce(&mut UnpackedBody) -> Result<()>,
    ) -> Result<Arc<UnpackedBody>> {
        let oldest = (self.bodies.len() >= KEPT).then(|| self.bodies.pop_front());
        let mut shared = oldest.flatten().map_or_else(Arc::default, |kept| kept.body);
        // Nobody else has it: jobs are drawn one after another.
        let body = Arc::make_mut(&mut shared);
        *body = UnpackedBody::default();
        unpack(body)?;
        Ok(shared)
    }
}
