//! The EdgeGait host crate: everything around `edgegait-core` that needs an operating system.
//!
//! People and their walks are synthetic ([`people::cohort`]) or recorded ([`people::recorded`]).
//! They are encoded into a [`Pack`], drawn from viewpoints under conditions ([`sweep()`]), and
//! shown to recognizers ([`Contest`]). The [`guide`] has a page for each topic of the command.
//!
//! # GEIs of a pack, as an array
//!
//! ```
//! use edgegait::people::cohort;
//! use edgegait::{CohortOptions, MAX_ERROR_MM, Pack, Settings, Views, encode_subjects, jobs, sweep};
//! use ndarray::Array3;
//!
//! # fn main() -> edgegait::Result<()> {
//! let options = CohortOptions { people: 2, speeds_kmh: vec![5.0], ..CohortOptions::default() };
//! let bytes = encode_subjects(&cohort::subjects(&options)?, MAX_ERROR_MM, &|| Ok(()))?;
//! let pack = Pack::parse(&bytes)?;
//!
//! // The cycle of each of the two walks, from the front and from the left.
//! let cycles = jobs(&pack, &[0, 1], 0..1)?;
//! let views = Views::grid("front and left", [0.0, 90.0], [0.0])?;
//! let mut pixels = Vec::new();
//! sweep(
//!     &pack,
//!     &cycles,
//!     &views.list,
//!     Settings::default(),
//!     |_, swept| Ok(swept.templates.concat()),
//!     |_, geis| {
//!         pixels.extend(geis);
//!         Ok(())
//!     },
//! )?;
//! let geis = Array3::from_shape_vec((2 * 2, 50, 30), pixels).expect("four GEIs of 50x30");
//! assert_eq!(geis.iter().max(), Some(&255));
//! # Ok(())
//! # }
//! ```
//!
//! # Score an ONNX model
//!
//! ```
//! # use edgegait::people::cohort;
//! # use edgegait::{CohortOptions, MAX_ERROR_MM, Pack, Settings, Views, encode_subjects};
//! use edgegait::{DrawnContest, Entrant, Model, Runtime, ContestOptions};
//!
//! # fn main() -> edgegait::Result<()> {
//! # let options = CohortOptions { people: 2, speeds_kmh: vec![5.0], ..CohortOptions::default() };
//! # let bytes = encode_subjects(&cohort::subjects(&options)?, MAX_ERROR_MM, &|| Ok(()))?;
//! # let pack = Pack::parse(&bytes)?;
//! // Trained on these people from the left; GEIs of 50x30 framed by height, as by default.
//! let model = Model::open("models/side.onnx")?;
//! let entrants = [Entrant::drawn(&model, &Runtime::rten(), Settings::default())?];
//! let options = ContestOptions { views: Some(Views::side()?), ..ContestOptions::default() };
//! let drawn = DrawnContest::new(&pack, &[0, 1], &entrants, options)?;
//! let outcome = drawn.contest.run(&entrants, 1, &mut |_| Ok(()), &mut |_| Ok(()))?;
//! assert_eq!(outcome.results[0].rank1, 1.0);
//! # Ok(())
//! # }
//! ```
//!
//! # Measure the effect of a confounder on rank-1
//!
//! ```
//! # use edgegait::people::cohort;
//! # use edgegait::{CohortOptions, MAX_ERROR_MM, Pack, Settings, Views, encode_subjects};
//! # use edgegait::{DrawnContest, Entrant, Model, Runtime, ContestOptions};
//! use edgegait::{Condition, Doses, dose};
//!
//! # fn main() -> edgegait::Result<()> {
//! # let options = CohortOptions { people: 8, speeds_kmh: vec![5.0], ..CohortOptions::default() };
//! # let bytes = encode_subjects(&cohort::subjects(&options)?, MAX_ERROR_MM, &|| Ok(()))?;
//! # let pack = Pack::parse(&bytes)?;
//! # let model = Model::open("models/side.onnx")?;
//! # let entrants = [Entrant::drawn(&model, &Runtime::rten(), Settings::default())?];
//! // A camera rolled by 1 and by 20 degrees.
//! let rolled = ["roll=1deg", "roll=20deg"]
//!     .map(|text| Condition::from_doses(Doses::new(dose(text).ok())));
//! let options = ContestOptions { views: Some(Views::side()?), conditions: &rolled, ..ContestOptions::default() };
//! let walks: Vec<usize> = (0..8).collect();
//! let drawn = DrawnContest::new(&pack, &walks, &entrants, options)?;
//! let outcome = drawn.contest.run(&entrants, 1, &mut |_| Ok(()), &mut |_| Ok(()))?;
//! let [level, askew] = &outcome.results[0].probe_sets[..] else {
//!     panic!("a set of probes for each condition");
//! };
//! assert!(level.rank1 > 0.9 && askew.rank1 < 0.5);
//! # Ok(())
//! # }
//! ```
//!
//! # Modules
//!
//! A module uses only the modules that stand before it in this table:
//!
//! | module | contents |
//! |---|---|
//! | [`mod@error`] | what goes wrong |
//! | [`files`] | safe reading and writing of files, the cache, the header of results |
//! | `import` | motions and meshes as their files state them |
//! | [`people`] | bodies and walks, made or recorded, and their audit |
//! | [`draw`] | confounders, sweeps and templates |
//! | [`encode`] | the bytes of packs, their inspection, and choices within an error |
//! | [`dataset`] | designs, datasets, sequences and gait cycles |
//! | [`segment`] | silhouettes from video |
//! | [`inference`] | models that answer |
//! | `train` | models that learn |
//! | [`evaluate`] | contests, protocols, parity, literature and study |
//! | `report` | tables, charts and pages |
//! | `bench` | cost, speed against error, and limits on results |
//! | [`cli`] | the command |

#![warn(unreachable_pub)]

mod bench;
pub mod cli;
pub mod dataset;
pub mod draw;
pub mod encode;
pub mod error;
pub mod evaluate;
pub mod files;
pub mod guide;
#[cfg(feature = "import")]
pub mod import;
pub mod inference;
pub mod people;
mod report;
pub mod segment;
#[cfg(feature = "train")]
pub mod train;

pub use dataset::gait_cycles::{CycleFinder, FoundCycles};
pub use dataset::sequences::{PackSource, Selection};
pub use dataset::{Dataset, Tree};
pub use draw::confounders::{Condition, Conditions, Doses, dose};
pub use draw::sweep::{FramingMode, Jitter, Job, Lens, Raster, Settings, View, Views, jobs, sweep};
pub use draw::template::Template;
pub use edgegait_core::pack::Pack;
pub use encode::{Effort, MAX_ERROR_MM, encode_population, encode_subjects};
pub use error::{Error, Result};
pub use evaluate::contest::{
    Contest, ContestOptions, ContestOutcome, ContestWarning, DrawnContest, Entrant,
};
pub use evaluate::protocol::Protocol;
#[cfg(feature = "import")]
pub use import::Motion;
pub use inference::{Contract, Model, Runtime};
pub use people::Subject;
pub use people::cohort::CohortOptions;
#[cfg(feature = "import")]
pub use people::recorded::{ReadOptions, Recording};
#[cfg(feature = "train")]
pub use train::{LinearModel, Samples};
