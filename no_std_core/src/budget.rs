//! Every capacity of the core, and the memory that follows from them.
//!
//! Nothing else in the crate states a limit. What is larger is refused when a
//! pack is parsed, so that a loop over hulls, points or coefficients is bounded
//! wherever it stands.

/// Rows of a silhouette or template of the default size: Charalambous & Bharath (BMVC 2016).
pub const ROWS: usize = 50;
/// Columns of a silhouette or template of the default size: Charalambous & Bharath (BMVC 2016).
pub const COLUMNS: usize = 30;
/// Pixels of a silhouette or template of the default size.
pub const PIXELS: usize = ROWS * COLUMNS;
/// Most rows of any [`crate::silhouette::Size`].
pub const MAX_ROWS: usize = 64;
/// Most columns of any [`crate::silhouette::Size`]: the bits of a row.
pub const MAX_COLUMNS: usize = 64;
/// Most pixels of any [`crate::silhouette::Size`].
pub const MAX_PIXELS: usize = MAX_ROWS * MAX_COLUMNS;

/// Frequencies of a cycle in the frequency-domain template, from 0: Makihara et al. (ECCV 2006).
pub const FREQUENCIES: usize = 3;
/// Most bytes of any template: as many images as there are frequencies.
pub const MAX_TEMPLATE_BYTES: usize = FREQUENCIES * MAX_PIXELS;

/// Hulls of one avatar. Ours: 24 for a fitted body and 8 for what it wears or carries.
pub const MAX_HULLS: usize = 32;
/// Hulls of one body whose points hang on several joints. Ours: hair, a skirt or a coat that a
/// person wears, and another skirt and coat that a condition puts on; each takes 3 kB of a figure.
pub const MAX_DRAPED_HULLS: usize = 4;
/// Points of one hull. Keeps tiny-skia's edge list within 64 entries.
pub const MAX_HULL_POINTS: usize = 32;
/// Points of one avatar: 24 hulls of 32 points.
pub const MAX_POINTS: usize = 768;
/// Triangles on the surface of one hull: 2 n - 4 for n points (Euler).
pub const MAX_HULL_FACETS: usize = 2 * MAX_HULL_POINTS - 4;
/// Edges of one hull: 3 n - 6 for n points (Euler).
pub const MAX_HULL_EDGES: usize = 3 * MAX_HULL_POINTS - 6;
/// Numbers that are worked on at once: a register of AVX-512, four of NEON or SSE2.
pub const LANES: usize = 16;
/// Facets of one avatar, those of each hull filled up to whole [`LANES`].
pub const MAX_FACETS: usize = 2 * MAX_POINTS + MAX_HULLS * LANES;
/// Corners of a hull's outline after it was clipped to the window, which adds at
/// most one corner for each of the four sides.
pub const MAX_OUTLINE: usize = MAX_HULL_POINTS + 4;

/// Fourier coefficients of one channel: a constant and 31 harmonics.
pub const MAX_COEFFICIENTS: usize = 63;
/// Harmonics of one channel.
pub const MAX_HARMONICS: usize = (MAX_COEFFICIENTS - 1) / 2;

/// Columns of the window in which a figure is measured before those of its silhouette
/// are kept; it has as many rows as the silhouette. The widest figure of the built-in cohort's 260 walks over the 703 viewpoints
/// takes 112.4 columns at 50 rows (F02 walking at 7 km/h, azimuth 65, elevation 90).
pub const WINDOW_COLUMNS: usize = 128;
/// The same of tiny-skia's window, which takes a byte for each pixel: half as many, so that a
/// board has room for it. What is wider is drawn in several.
pub const SKIA_WINDOW_COLUMNS: usize = MAX_COLUMNS;
/// Columns that a figure may take, in as many windows side by side as it needs; wider ones are
/// refused.
pub const MAX_FIGURE_COLUMNS: usize = 2_048;
/// Most pixels from the upper left corner of an image of a fixed scale to a part of a figure
/// that is partly inside: 2^16, where an f32 still resolves 1/128 pixel.
pub const MAX_REACH_PIXELS: f32 = 65_536.0;

/// Cameras before which [`crate::raster::Renderer::draw_views`] puts a figure at once. Ours: what is
/// found out about all of them stays in a first-level cache.
pub const VIEWS_AT_ONCE: usize = 8;

/// Elevations that the column rasteriser draws at once: 16 lanes and half as many more.
pub const MAX_ELEVATIONS: usize = LANES + LANES / 2;
/// Binary digits of a count of frames: 4,096 frames of one cycle take 13.
pub const TALLY_DIGITS: usize = 13;

/// Classes of one recognizer: what a byte counts.
pub const MAX_CLASSES: usize = 255;

/// Subjects, walks, avatars or clips of one pack.
pub const MAX_ENTRIES: usize = 65_535;
/// Bytes of a pack: 16 MiB, far above what any board has in flash.
pub const MAX_PACK_BYTES: usize = 1 << 24;

/// Bytes that tiny-skia's rasteriser holds at so many rows: its window from
/// [`crate::raster::Renderer::new`] on, and from the first hull on one path, a point of
/// 8 bytes for each corner and one more, and a verb of 1 byte for each point and the
/// closing. No outline outgrows it.
#[must_use]
pub const fn skia_resident_bytes(rows: usize) -> usize {
    let window = SKIA_WINDOW_COLUMNS * rows;
    let path_points = 8 * (MAX_OUTLINE + 1);
    let path_verbs = MAX_OUTLINE + 2;
    window + path_points + path_verbs
}

/// Most of [`skia_resident_bytes`].
pub const SKIA_RESIDENT_BYTES: usize = skia_resident_bytes(MAX_ROWS);

/// Bytes of tiny-skia's list of edges, which it takes and gives back while one hull is filled:
/// always made for 64 of 80 bytes (tiny-skia 0.12.0's own type). An outline gives at most 42
/// edges (36, four more where it crosses the window's sides, and two sentinels), so that the
/// list never grows, and sorting it takes its 4 kB from the stack (up to 51 edges).
pub const SKIA_EDGES_BYTES: usize = 64 * 80;

/// Most bytes that tiny-skia takes and gives back while one hull is filled: its list of edges,
/// and for anti-aliasing one row of runs (2 bytes) and of coverage (1 byte), both a column
/// wider than the window.
///
/// `tests/memory.rs` reaches the sum exactly with a counting allocator: 9,550 bytes
/// together with the resident ones without anti-aliasing, 9,745 with it.
pub const SKIA_TRANSIENT_BYTES: usize = {
    let runs = (2 + 1) * (SKIA_WINDOW_COLUMNS + 1);
    SKIA_EDGES_BYTES + runs
};

/// Heap bound of drawing with tiny-skia: resident and transient bytes together.
pub const SKIA_HEAP_BYTES: usize = SKIA_RESIDENT_BYTES + SKIA_TRANSIENT_BYTES;

/// Frames a second of a [`crate::cycle::CycleDetector`], least and most. Ours: ten show the fastest
/// steps twice or thrice, and no surveillance camera takes more than 120.
pub const CYCLE_FRAME_RATES_HZ: (f32, f32) = (10.0, 120.0);
/// Steps a minute that it finds, least and most. Ours: slow patients take 80, walkers 90 to 130,
/// runners 150 to 200; `edgegait import` doubts more than 220, too.
pub const CYCLE_STEPS_PER_MINUTE: (f32, f32) = (70.0, 220.0);
/// Samples a second that it keeps at most; frames that come faster are averaged. Ours: eight in the
/// fastest step.
pub const CYCLE_MOST_SAMPLES_HZ: f32 = 32.0;
/// Samples that it keeps: four of the slowest steps, 4 x 60 / 70 x 32 = 109.7.
pub const CYCLE_SAMPLES: usize = 110;
/// Frequencies that it tries, the lowest one and how far they are apart, Hz: from 66 to 228 steps a
/// minute. Ours: in 3.4 seconds Hann's window shows a wave half as strong 0.2 Hz beside its own.
pub const CYCLE_FREQUENCIES: usize = 28;
/// The lowest one.
pub const CYCLE_LOWEST_HZ: f32 = 1.1;
/// How far they are apart.
pub const CYCLE_FREQUENCY_STEP_HZ: f32 = 0.1;
