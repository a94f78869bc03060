//! The memory that drawing a pack takes: the budget of `edgegait inspect`.

use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use edgegait_core::compact::{Budget, CompactFigure, CompactRows};
use edgegait_core::pack::Pack;
use edgegait_core::raster::{Skia, Window};
use edgegait_core::silhouette::Size;
use serde::Serialize;
use std::fmt;

/// The memory that a GEI of any walk takes, by rasteriser, with the type sizes of this machine.
#[derive(Debug, Serialize)]
pub(super) struct BudgetSummary {
    size: &'static str,
    flash_bytes: usize,
    /// The maximum number of hulls in any avatar; `points` and `facets` likewise.
    hulls: usize,
    points: usize,
    facets: usize,
    body_bytes: usize,
    /// The bytes of an unpacked loop, which is optional.
    expanded_bytes: usize,
    rows: MemoryTaken,
    skia: MemoryTaken,
    /// The memory with the core's types for hosts.
    unpacked: MemoryTaken,
}

#[derive(Debug, Serialize)]
struct MemoryTaken {
    /// The bytes of types and buffers, static or on the stack. Only `skia-aa` needs a heap.
    ram_bytes: usize,
}

impl BudgetSummary {
    /// Returns the memory budget of a pack.
    pub(super) fn from_pack(pack: &Pack<'_>) -> Self {
        let (budget, size) = (Budget::from_pack(pack), Size::S50x30);
        Self {
            size: size.name(),
            flash_bytes: budget.pack_bytes,
            hulls: budget.room.hulls,
            points: budget.room.points,
            facets: budget.room.facets,
            body_bytes: budget.room.bytes(),
            expanded_bytes: budget.expanded_bytes,
            rows: MemoryTaken::compact::<CompactRows>(&budget, size),
            skia: MemoryTaken::compact::<Skia>(&budget, size),
            unpacked: MemoryTaken {
                ram_bytes: Budget::UNPACKED_BYTES,
            },
        }
    }
}

impl MemoryTaken {
    fn compact<W: for<'a> Window<CompactFigure<'a>>>(budget: &Budget, size: Size) -> Self {
        Self {
            ram_bytes: budget.ram_bytes::<W>(size),
        }
    }
}

impl fmt::Display for BudgetSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new(&[Left(20), Right(8)]);
        let heading = format!("a GEI of {}", self.size);
        table.row([&heading, "flash", "RAM"]);
        for (name, taken) in [
            ("rows, on a board", &self.rows),
            ("skia, on a board", &self.skia),
            ("unpacked, on a host", &self.unpacked),
        ] {
            let [flash, ram] = [self.flash_bytes, taken.ram_bytes].map(|bytes| bytes.to_string());
            table.row([name, &flash, &ram]);
        }
        write!(f, "\n{table}")?;
        let Self {
            hulls,
            points,
            facets,
            body_bytes,
            expanded_bytes,
            ..
        } = self;
        writeln!(
            f,
            "largest body: {hulls} hulls, compact::CompactBody<{points}, {facets}>, {body_bytes} bytes; an unpacked loop takes {expanded_bytes} more"
        )?;
        writeln!(
            f,
            "bytes of types and buffers with {}-bit pointers, without code and the stack of functions",
            usize::BITS
        )
    }
}
