//! placeholder
#![no_std]
pub mod skeleton;
