//! What it takes to draw the walks of a pack.

use super::{LeanFigure, Room};
use crate::avatar::Avatar;
use crate::body;
use crate::camera::Camera;
use crate::clip::{Clip, Expanded};
use crate::pack::Pack;
use crate::pose::{ModelPose, Pose};
use crate::raster::{Drawing, Renderer, Window};
use crate::silhouette::Size;
use crate::skeleton::Skeleton;
use crate::template::{GeiBuilder, GeiInPlace};

/// What making the GEI of any walk of a pack takes, for one that is made after another.
///
/// All follows from the pack and from the sizes of types on the target that asks: those that
/// hold references are smaller where pointers have 32 bits. Code, and the stack of functions
/// on their way, are measured with the firmware that has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Bytes of the pack, which is read where it lies: in flash.
    pub pack_bytes: usize,
    /// What is enough for each avatar.
    pub room: Room,
    /// Bytes of RAM that unpack any loop ([`crate::clip::Loop::expand`]), which nothing needs
    /// but poses in a 15th of the time; 0 without loops.
    pub expanded_bytes: usize,
}

/// Bytes of the values that are there at once while a GEI is made, but for what it is drawn
/// from and with.
const WALK_BYTES: usize = size_of::<Pack<'_>>()
    + size_of::<Avatar<'_>>()
    + size_of::<Clip<'_>>()
    + size_of::<Skeleton>()
    + size_of::<Pose>()
    + size_of::<ModelPose>()
    + size_of::<Camera>();

impl Budget {
    /// Bytes of RAM that a GEI takes with [`Renderer`] and the types that it draws,
    /// which have room for every avatar, on a host: tiny-skia's heap comes on top, of
    /// [`crate::budget::SKIA_HEAP_BYTES`].
    pub const UNPACKED_BYTES: usize = WALK_BYTES
        + size_of::<body::UnpackedBody>()
        + size_of::<body::Figure<'_>>()
        + size_of::<Renderer>()
        + size_of::<Drawing<'_>>()
        + size_of::<GeiBuilder>()
        + Size::S64x64.pixels();

    /// That of a pack. Finds the facets of each avatar: about 4 us a hull on a host.
    #[must_use]
    pub fn of(pack: &Pack<'_>) -> Self {
        let avatars = (0..pack.avatar_count()).filter_map(|number| pack.avatar(number));
        let rooms = avatars.map(|avatar| Room::of(&avatar));
        let clips = (0..pack.clip_count()).filter_map(|number| pack.clip(number));
        let loops = clips.filter_map(|clip| clip.as_loop());
        let lengths = loops.map(|cycle| size_of::<f32>() * cycle.expanded_len());
        Self {
            pack_bytes: pack.len_bytes(),
            room: rooms.fold(Room::default(), Room::max),
            expanded_bytes: lengths
                .max()
                .map_or(0, |longest| size_of::<Expanded<'_>>() + longest),
        }
    }

    /// Bytes of RAM of a GEI of this size that a window draws, with a [`super::LeanBody`] of this
    /// room, without facets where none are asked for, be they static or on the stack. The heap
    /// of `raster::Skia` comes on top.
    #[must_use]
    pub const fn ram_bytes<W: for<'a> Window<LeanFigure<'a>>>(&self, size: Size) -> usize {
        let facets = if W::NEEDS_FACETS { self.room.facets } else { 0 };
        let room = Room {
            facets,
            ..self.room
        };
        let builder = if W::IS_GREY {
            size_of::<GeiBuilder>()
        } else {
            size_of::<GeiInPlace<'_>>()
        };
        WALK_BYTES
            + room.bytes()
            + builder
            + size_of::<LeanFigure<'_>>()
            + size_of::<Renderer<W>>()
            + size_of::<Drawing<'_>>()
            + size.pixels()
    }
}
