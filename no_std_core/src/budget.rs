//! Every capacity of the core, and the memory that follows from them.
//!
//! No other module states a capacity on which memory depends. Parsing rejects a pack that exceeds one, so that every loop over
//! hulls, points or coefficients is bounded.

/// Rows of a silhouette or template of the default size: Charalambous & Bharath (BMVC 2016).
pub const ROWS: usize = 50;
/// Columns of a silhouette or template of the default size: Charalambous & Bharath (BMVC 2016).
pub const COLUMNS: usize = 30;
/// Pixels of a silhouette or template of the default size.
pub const PIXELS: usize = ROWS * COLUMNS;
/// The maximum number of rows in any [`crate::silhouette::Size`].
pub const MAX_ROWS: usize = 64;
/// The maximum number of columns in any [`crate::silhouette::Size`]: the bits of a row.
pub const MAX_COLUMNS: usize = 64;
/// The maximum number of pixels in any [`crate::silhouette::Size`].
pub const MAX_PIXELS: usize = MAX_ROWS * MAX_COLUMNS;

/// Frequencies of a cycle in the frequency-domain template, from 0: Makihara et al. (ECCV 2006).
pub const FREQUENCIES: usize = 3;
/// The maximum number of bytes in any template: an image for each frequency.
pub const MAX_TEMPLATE_BYTES: usize = FREQUENCIES * MAX_PIXELS;

/// The maximum number of hulls in one avatar. Our choice: 24 for a fitted body and 8 for what it
/// wears or carries.
pub const MAX_HULLS: usize = 32;
/// The maximum number of draped hulls in one body, whose points are attached to several joints. Our
/// choice: hair, a skirt or a coat that a person wears, and another skirt and coat that a condition
/// adds; each takes 3 kB of a figure.
pub const MAX_DRAPED_HULLS: usize = 4;
/// The maximum number of points in one hull. Keeps tiny-skia's edge list within 64 entries.
pub const MAX_HULL_POINTS: usize = 32;
/// The maximum number of points in one avatar: 24 hulls of 32 points.
pub const MAX_POINTS: usize = 768;
/// The maximum number of triangles on the surface of one hull: 2 n - 4 for n points (Euler).
pub const MAX_HULL_FACETS: usize = 2 * MAX_HULL_POINTS - 4;
/// The maximum number of edges in one hull: 3 n - 6 for n points (Euler).
pub const MAX_HULL_EDGES: usize = 3 * MAX_HULL_POINTS - 6;
/// Numbers that are processed together: one register of AVX-512, four of NEON or SSE2.
pub const LANES: usize = 16;
/// The maximum number of facets in one avatar, with those of each hull padded to a multiple of
/// [`LANES`].
pub const MAX_FACETS: usize = 2 * MAX_POINTS + MAX_HULLS * LANES;
/// The maximum number of corners in a hull's outline after clipping to the window, which adds at
/// most one corner for each of the four sides.
pub const MAX_OUTLINE: usize = MAX_HULL_POINTS + 4;

/// The maximum number of Fourier coefficients of one channel: a constant and 31 harmonics.
pub const MAX_COEFFICIENTS: usize = 63;
/// The maximum number of harmonics of one channel.
pub const MAX_HARMONICS: usize = (MAX_COEFFICIENTS - 1) / 2;

/// Columns of the window in which a figure is measured before it is cut to the columns of its
/// silhouette. The window has as many rows as the silhouette. The widest figure of the built-in
/// cohort's 260 walks over the 703 viewpoints takes 112.4 columns at 50 rows (F02 walking at 7
/// km/h, azimuth 65, elevation 90).
pub const WINDOW_COLUMNS: usize = 128;
/// Columns of the window of `skia` and `skia-aa`: half as many, a machine word. Wider figures are
/// drawn in several windows.
pub const SKIA_WINDOW_COLUMNS: usize = MAX_COLUMNS;
/// The maximum number of columns that a figure may take, in as many windows side by side as it
/// needs; wider figures are rejected.
pub const MAX_FIGURE_COLUMNS: usize = 2_048;
/// The maximum number of pixels from the upper left corner of an image of a fixed scale to any part
/// of a figure that is partly inside: 2^16, where an f32 still resolves 1/128 pixel.
pub const MAX_REACH_PIXELS: f32 = 65_536.0;

/// Cameras that [`crate::raster::Renderer::draw_views`] handles together. Our choice: the data for
/// all of them stays in a first-level cache.
pub const VIEWS_AT_ONCE: usize = 8;

/// The maximum number of elevations that the column rasteriser draws in one pass: 16 lanes and half
/// as many more.
pub const MAX_ELEVATIONS: usize = LANES + LANES / 2;
/// Binary digits of a frame count: 4,096 frames of one cycle take 13.
pub const TALLY_DIGITS: usize = 13;

/// The maximum number of classes of one recognizer: the range of a byte.
pub const MAX_CLASSES: usize = 255;

/// The maximum number of subjects, walks, avatars or clips of one pack.
pub const MAX_ENTRIES: usize = 65_535;
/// The maximum number of bytes in a pack: 16 MiB, far more than any board has in flash.
pub const MAX_PACK_BYTES: usize = 1 << 24;

/// The maximum number of bytes that tiny-skia holds: its window from
/// [`crate::raster::Renderer::new`] on, and from the first hull on one path, which has a point of 8
/// bytes for each corner and one more, and a verb of 1 byte for each point and the closing. No
/// outline exceeds this.
pub const SKIA_RESIDENT_BYTES: usize = {
    let window = SKIA_WINDOW_COLUMNS * MAX_ROWS;
    let path_points = 8 * (MAX_OUTLINE + 1);
    let path_verbs = MAX_OUTLINE + 2;
    window + path_points + path_verbs
};

/// The maximum number of bytes that tiny-skia allocates and frees while it fills one hull: its list
/// of edges, and for anti-aliasing one row of runs (2 bytes) and of coverage (1 byte), both a
/// column wider than the window.
///
/// The list always has 64 edges of 80 bytes (tiny-skia 0.12.0's own type). An outline has at most 42
/// (36, four more where it crosses the window's sides, and two sentinels), so that the list never
/// grows, and sorting it takes 4 kB of stack (for up to 51 edges). `tests/memory.rs` reaches the sum
/// exactly with a counting allocator: 9,550 bytes together with the resident ones without
/// anti-aliasing, 9,745 with it.
pub const SKIA_TRANSIENT_BYTES: usize = {
    let edges = 64 * 80;
    let runs = (2 + 1) * (SKIA_WINDOW_COLUMNS + 1);
    edges + runs
};

/// Heap bound of drawing with tiny-skia: resident and transient bytes together.
pub const SKIA_HEAP_BYTES: usize = SKIA_RESIDENT_BYTES + SKIA_TRANSIENT_BYTES;

/// The minimum and maximum number of frames per second of a [`crate::cycle::CycleDetector`]. Our
/// choice: ten show the fastest steps two or three times, and no surveillance camera takes more
/// than 120.
pub const CYCLE_FRAME_RATES_HZ: (f32, f32) = (10.0, 120.0);
/// The minimum and maximum number of steps per minute that a [`crate::cycle::CycleDetector`] finds.
/// Our choice: slow patients take 80, walkers 90 to 130, runners 150 to 200; `edgegait import` also
/// warns above 220.
pub const CYCLE_STEPS_PER_MINUTE: (f32, f32) = (70.0, 220.0);
/// The maximum number of samples per second that a [`crate::cycle::CycleDetector`] keeps; it
/// averages frames that come faster. Our choice: eight in the fastest step.
pub const CYCLE_MOST_SAMPLES_HZ: f32 = 32.0;
/// Samples that a [`crate::cycle::CycleDetector`] keeps: four of the slowest steps, 4 x 60 / 70 x
/// 32 = 109.7.
pub const CYCLE_SAMPLES: usize = 110;
/// Number of frequencies of cycles that a [`crate::cycle::CycleDetector`] tries, of 24 to 228 steps a
/// minute. Our choice: over 3.4 seconds, Hann's window shows a wave at half its strength 0.2 Hz
/// beside its frequency.
pub const CYCLE_FREQUENCIES: usize = 18;
/// The lowest frequency of cycles that a [`crate::cycle::CycleDetector`] tries, Hz: below the slowest
/// that it finds, so that it does not take a slow walker's steps for cycles.
pub const CYCLE_LOWEST_HZ: f32 = 0.2;
/// The distance between the frequencies that a [`crate::cycle::CycleDetector`] tries, Hz.
pub const CYCLE_FREQUENCY_STEP_HZ: f32 = 0.1;
