//! The memory that drawing the walks of a pack takes.

use super::{CompactFigure, Room};
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

/// The memory that making the GEIs of a pack's walks takes, one at a time.
///
/// All numbers follow from the pack and from the sizes of types on the current target: types that
/// hold references are smaller with 32-bit pointers. Code and the stack of functions have to be
/// measured in the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Bytes of the pack, which is read in place, in flash.
    pub pack_bytes: usize,
    /// The room that is enough for each avatar.
    pub room: Room,
    /// Bytes of RAM in which any loop can be unpacked ([`crate::clip::Loop::expand`]). They are
    /// optional, for poses in a 15th of the time; 0 without loops.
    pub expanded_bytes: usize,
}

/// Bytes of the values that are alive together while a GEI is made, except those of drawing: body,
/// figure, renderer, drawing and GEI.
const WALK_BYTES: usize = size_of::<Pack<'_>>()
    + size_of::<Avatar<'_>>()
    + size_of::<Clip<'_>>()
    + size_of::<Skeleton>()
    + size_of::<Pose>()
    + size_of::<ModelPose>()
    + size_of::<Camera>();

impl Budget {
    /// Bytes of RAM that a GEI takes on a host, with [`Renderer`] and the types that it draws,
    /// which have room for every avatar. The heap of `skia-aa`, [`crate::budget::SKIA_HEAP_BYTES`],
    /// comes on top.
    pub const UNPACKED_BYTES: usize = WALK_BYTES
        + size_of::<body::UnpackedBody>()
        + size_of::<body::Figure<'_>>()
        + size_of::<Renderer>()
        + size_of::<Drawing<'_>>()
        + size_of::<GeiBuilder>()
        + Size::S64x64.pixels();

    /// Returns the budget of a pack. Finds the facets of each avatar: about 4 us a hull on a host.
    #[must_use]
    pub fn from_pack(pack: &Pack<'_>) -> Self {
        let avatars = (0..pack.avatar_count()).filter_map(|number| pack.avatar(number));
        let rooms = avatars.map(|avatar| Room::for_avatar(&avatar));
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

    /// Returns the bytes of RAM, static or on the stack, that a GEI of this size takes with the
    /// window `W` and a [`super::CompactBody`] of this room, without facets if `W` needs none. The
    /// heap of `raster::Skia` comes on top.
    #[must_use]
    pub const fn ram_bytes<W: for<'a> Window<CompactFigure<'a>>>(&self, size: Size) -> usize {
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
            + size_of::<CompactFigure<'_>>()
            + size_of::<Renderer<W>>()
            + size_of::<Drawing<'_>>()
            + size.pixels()
    }
}
