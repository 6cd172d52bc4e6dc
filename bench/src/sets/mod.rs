//! Data sets of rendered frames with exact truth: every frame is a pure function of set, family, seed and index.

mod catalogue;
mod recipe;
mod render;
mod store;

pub(crate) use catalogue::{NAMES, named};
pub(crate) use recipe::{Bin, Ids, Recipe};
pub(crate) use render::Renderer;
pub(crate) use store::{list, write};
