//! Limits on ratios of benchmarks and on sizes: a list in TOML, checked against criterion's
//! results.

mod figure;
mod gate;
mod heap;
mod need;
mod report;
mod results;

pub use gate::Gates;
pub use need::Need;
pub use results::Results;
