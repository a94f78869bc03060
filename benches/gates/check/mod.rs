//! What must hold between benchmarks, and of bytes: a list in TOML, checked against the
//! results that criterion left.

mod figure;
mod gate;
mod heap;
mod need;
mod report;
mod results;

pub use gate::Gates;
pub use need::Need;
pub use results::Results;
