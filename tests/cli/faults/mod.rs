//! Inputs that once broke the program or gave a wrong number without a word, each with the right one, which is analytic
//! or counted by another program.

mod hostile;
mod inputs;
mod masks;
mod motion;
mod pictures;
mod scores;
