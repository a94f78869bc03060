//! Makes GEIs of several people, speeds and viewpoints from the cohort's pack, hull by hull, and
//! recognizes them, on a Cortex-M with the RAM that `build.rs` gives it.
//!
//! Prints each GEI's hash and answer, instructions by stage, and the high-water mark of the stack.
//! Exits with status 0 if the answers equal the host's and everything is within its limits.
#![no_std]
#![no_main]

#[path = "../../../../tests/golden/study.rs"]
mod study;

use core::fmt::Write;
use cortex_m::{Peripherals, singleton};
use cortex_m_rt::entry;
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::compact::CompactBody;
use edgegait_core::linear::LinearRecognizer;
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::Renderer;
use edgegait_core::silhouette::Size;
use edgegait_core::template::GeiInPlace;
use edgegait_firmware::line::Line;
use edgegait_firmware::memory;
use edgegait_firmware::meter::Meter;
use glam::Vec2;
use semihosting::{println, process};
use study::{BARE, DRESSED, FRAMES, Fnv, RECOGNIZER, Study};

#[cfg(not(feature = "skia"))]
type Window = edgegait_core::compact::CompactRows;
#[cfg(feature = "skia")]
type Window = edgegait_core::raster::Skia;

/// The rasteriser's name in the list of answers.
const RASTERIZER: &str = if cfg!(feature = "skia") {
    "skia"
} else {
    "rows"
};
/// The people: with the feature `dressed`, in clothes.
const STUDY: Study = if IS_DRESSED { DRESSED } else { BARE };
const IS_DRESSED: bool = cfg!(feature = "dressed");
/// Most bytes of RAM: static and stack. Draped clothes take 60 more points.
const RAM_LIMIT: usize = match (cfg!(feature = "skia"), IS_DRESSED) {
    (false, true) => 16 * 1024,
    (false, false) => 15_000,
    (true, _) => 13_500,
};
/// Room for every body of the study; `skia` needs no facets.
type Room = CompactBody<
    { if IS_DRESSED { 548 } else { 488 } },
    { if cfg!(feature = "skia") { 0 } else { 896 } },
>;
/// A person of 19 hulls of 8 points or 7.
const EIGHT: &[u8] = include_bytes!("../../../../tests/golden/eight.egp");
/// Most instructions of one of that person's silhouettes: a requirement for rows with hardware
/// floats, and twice the measured number for the others.
const SILHOUETTE_LIMIT: u64 = match (cfg!(feature = "skia"), cfg!(target_abi = "eabihf")) {
    (false, true) => 60_000,
    (false, false) => 2_600_000,
    (true, true) => 260_000,
    (true, false) => 1_940_000,
};

/// Most instructions of checking the pack, of a pose, and of a silhouette of the study, with
/// hardware floats. Draped hulls are wrapped anew in each pose.
const STAGE_LIMITS: [u64; 3] = if cfg!(target_abi = "eabihf") {
    [
        2_500_000,
        // Walks of populations have more harmonics.
        if IS_DRESSED { 87_000 } else { 45_500 },
        match (cfg!(feature = "skia"), IS_DRESSED) {
            (true, _) => 290_000,
            (false, true) => 440_000,
            (false, false) => 97_000,
        },
    ]
} else {
    [u64::MAX; 3]
};

/// The instructions of a stage.
struct Stage {
    name: &'static str,
    calls: u32,
    sum: u64,
    most: u64,
}

impl Stage {
    const fn new(name: &'static str) -> Self {
        Self {
            name,
            calls: 0,
            sum: 0,
            most: 0,
        }
    }

    /// Runs `work` and adds its instructions.
    fn of<R>(&mut self, meter: &mut Meter, work: impl FnOnce() -> R) -> R {
        let (result, instructions) = meter.count(work);
        self.calls += 1;
        self.sum += instructions;
        self.most = self.most.max(instructions);
        result
    }

    fn print(&self) {
        let mean = self.sum / u64::from(self.calls.max(1));
        println!(
            "{:<28}{:>7}{mean:>12}{:>12}",
            self.name, self.calls, self.most
        );
    }
}

/// The stages of a GEI.
struct Stages {
    facets: Stage,
    pose: Stage,
    silhouette: Stage,
    count: Stage,
    finish: Stage,
    classify: Stage,
}

impl Stages {
    fn print(&self) {
        self.facets.print();
        self.pose.print();
        self.silhouette.print();
        self.count.print();
        self.finish.print();
        self.classify.print();
    }
}

/// The values that are reused from one GEI to the next.
struct Tools {
    body: &'static mut Room,
    renderer: &'static mut Renderer<Window>,
    pixels: &'static mut [u8; 1_500],
    pose: &'static mut ModelPose,
}

impl Tools {
    /// Makes the tools in static memory, once. Separate from `main`, whose stack is never freed.
    #[inline(never)]
    fn take() -> Self {
        let renderer =
            singleton!(: Renderer<Window> = Renderer::with_window(Window::new(Size::S50x30)));
        Self {
            body: singleton!(: Room = CompactBody::EMPTY).expect("taken once"),
            renderer: renderer.expect("taken once"),
            pixels: singleton!(: [u8; 1_500] = [0; 1_500]).expect("taken once"),
            pose: singleton!(: ModelPose = ModelPose::REST).expect("taken once"),
        }
    }
}

#[entry]
fn main() -> ! {
    let mut meter = Meter::new(Peripherals::take().expect("taken once"));
    let mut parse = Stage::new("pack");
    let pack = parse
        .of(&mut meter, || Pack::parse(STUDY.pack))
        .expect("a pack");
    let recognizer = LinearRecognizer::parse(RECOGNIZER).expect("the recognizer");
    let mut stages = Stages {
        facets: Stage::new("body out of the pack"),
        pose: Stage::new("pose"),
        silhouette: Stage::new("silhouette"),
        count: Stage::new("frame into the GEI"),
        finish: Stage::new("GEI"),
        classify: Stage::new("recognition, 26 people"),
    };
    let mut tools = Tools::take();
    let is_ours =
        |line: &&str| line.starts_with(RASTERIZER) && line[RASTERIZER.len()..].starts_with(' ');
    let mut expected = STUDY.answers.lines().filter(is_ours);
    let mut wrong = 0;
    for number in 0..STUDY.jobs() {
        let at = (&pack, number);
        let answer = recognize(at, &recognizer, &mut tools, (&mut meter, &mut stages));
        let is_right = expected.next() == Some(answer.as_str());
        wrong += u32::from(!is_right);
        println!(
            "{} {}",
            answer.as_str(),
            if is_right { "as on the host" } else { "WRONG" }
        );
    }
    let missing = expected.count();
    let small = eight(&mut tools, &mut meter);
    println!(
        "\n{:<28}{:>7}{:>12}{:>12}",
        "instructions", "times", "mean", "most"
    );
    parse.print();
    stages.print();
    small.print();
    let ram = memory_used();
    let most = [&parse, &stages.pose, &stages.silhouette].map(|stage| stage.most);
    let is_fast = most
        .iter()
        .zip(STAGE_LIMITS)
        .all(|(&most, limit)| most <= limit)
        && small.most <= SILHOUETTE_LIMIT;
    let is_well = wrong == 0 && missing == 0 && ram <= RAM_LIMIT && is_fast;
    println!("study: {wrong} answers wrong, {missing} missing, {ram} of {RAM_LIMIT} bytes of RAM");
    process::exit(i32::from(!is_well));
}

/// Prints the memory used, and returns the sum of RAM in bytes.
fn memory_used() -> usize {
    let [code, constants] = memory::flash_bytes();
    let packs = STUDY.pack.len() + EIGHT.len();
    let others = constants.saturating_sub(packs + RECOGNIZER.len());
    println!("\nbytes of flash");
    println!("code{code:>31}");
    println!("constants of the code{others:>14}");
    println!("packs{packs:>30}");
    println!("recognizer{:>25}", RECOGNIZER.len());
    let (fixed, stack) = (memory::static_bytes(), memory::stack_used());
    println!("\nbytes of RAM");
    println!("static{fixed:>29}");
    println!("stack, most used{stack:>19}");
    fixed + stack
}

/// Makes a GEI, and returns its line of the list.
#[inline(never)]
fn recognize(
    (pack, number): (&Pack<'_>, usize),
    recognizer: &LinearRecognizer<'_>,
    tools: &mut Tools,
    (meter, stages): (&mut Meter, &mut Stages),
) -> Line {
    let job = STUDY.job(pack, number);
    let skeleton = job.avatar.skeleton();
    let loaded = stages.facets.of(meter, || tools.body.load(&job.avatar));
    loaded.expect("room");
    let mut gei = GeiInPlace::new(Size::S50x30, tools.pixels).expect("room");
    for frame in 0..FRAMES {
        let phase = f32::from(frame) / f32::from(FRAMES);
        stages.pose.of(meter, || {
            tools.pose.update(&skeleton, &job.cycle.pose(phase));
        });
        let posed = tools.body.posed(tools.pose);
        let drawing = stages.silhouette.of(meter, || {
            tools
                .renderer
                .draw(&posed, &job.camera, recognizer.framing(), Vec2::ZERO)
        });
        let Ok(drawing) = drawing else {
            panic!("a figure without an image");
        };
        let added = stages.count.of(meter, || gei.add(drawing.frame));
        assert!(added.is_ok(), "a frame that the GEI has no room for");
    }
    let pixels = stages.finish.of(meter, || gei.finish());
    let answer = stages.classify.of(meter, || recognizer.classify(pixels));
    let (class, score) = answer.expect("pixels of the recognizer's size");
    let mut hash = Fnv::NEW;
    hash.add(pixels);
    let mut line = Line::EMPTY;
    let [azimuth, elevation] = job.view;
    let written = write!(
        line,
        "{RASTERIZER} {} {} {azimuth} {elevation} {:016x} {} {:08x}",
        job.person,
        job.walk,
        hash.0,
        recognizer.name(class).unwrap_or("nobody"),
        score.to_bits()
    );
    written.expect("a line of at most 96 bytes");
    line
}

/// Draws the silhouettes of a person of 19 hulls of 8 points, a cycle from three viewpoints.
#[inline(never)]
fn eight(tools: &mut Tools, meter: &mut Meter) -> Stage {
    let mut stage = Stage::new("silhouette, hulls of 8");
    let pack = Pack::parse(EIGHT).expect("a pack");
    let avatar = pack.avatar(0).expect("an avatar");
    let clip = pack.clip(0).expect("a clip");
    let cycle = clip.as_loop().expect("a cycle");
    let skeleton = avatar.skeleton();
    tools.body.load(&avatar).expect("room");
    for [azimuth, elevation] in [[90.0, 0.0], [0.0, 0.0], [45.0, 30.0]] {
        let viewpoint = Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint");
        let camera = Camera::orthographic(viewpoint);
        for frame in 0..FRAMES {
            let phase = f32::from(frame) / f32::from(FRAMES);
            tools.pose.update(&skeleton, &cycle.pose(phase));
            let posed = tools.body.posed(tools.pose);
            let is_drawn = stage.of(meter, || {
                let drawing = tools
                    .renderer
                    .draw(&posed, &camera, Framing::Height, Vec2::ZERO);
                drawing.is_ok()
            });
            assert!(is_drawn, "a figure");
        }
    }
    stage
}
