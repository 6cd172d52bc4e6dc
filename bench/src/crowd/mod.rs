//! A whole machine of processes: cameras and detectors of the program `tagbus`, and clients that are processes of this program.

mod client;
mod machine;
mod picture;
mod tally;

pub(crate) use client::{Order, Temper, client};
pub(crate) use machine::{Machine, Member, Part};
pub(crate) use picture::PlayedPicture;
pub(crate) use tally::{InForce, Tally};
