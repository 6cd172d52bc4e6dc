//! Phase 1: which pixels are dark and which are bright, seen from their neighbourhood (paper III-C, after Olson 2011).
//!
//! Tiles of 4x4 pixels give the local extremes; a pixel is compared with the middle between the extremes of the 3x3
//! tiles around it. A second search may use tiles of 2x2. Where these differ by less than the frame's noise can explain,
//! the tile is unsure and its pixels are neither dark nor bright.

mod cuts;
mod light;
mod noise;
mod planes;
pub(crate) mod raster;
mod strip;

pub(crate) use cuts::Cuts;
pub(crate) use planes::{Colours, Contrast, Planes, Scale, binarize};
