//! Inputs that once gave a wrong number without a word, each with the right one, which is analytic
//! or counted by another program.

mod motion;
mod pictures;
mod scores;
