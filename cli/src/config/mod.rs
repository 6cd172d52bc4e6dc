//! What is in force: defaults, below the configuration file, below the flags.
//!
//! A command's flags are one struct that is read from the command line and from the file. That a key and a flag never
//! differ in name, meaning or type follows from that.

mod file;
mod layers;
pub(crate) mod text;

pub(crate) use file::File;
pub(crate) use layers::{arguments, as_toml, in_force, overlay, print, values};
