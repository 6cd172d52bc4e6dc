//! The binary as its users run it: real processes, real pictures, real signals.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed, also in what tests share")]

mod support;

mod bad_input;
mod command_line;
mod controlling;
mod deadlines;
mod families_of_others;
mod generating;
mod killing;
mod machine;
mod own_families;
mod pictures;
mod printing;
mod real_data;
mod terminal;
mod together;
mod top;
mod wiped;
