//! Which components may be the border of a tag, judged by their bounding box alone.

use super::Plane;
use super::labels::{Extent, Label, Labels};
use super::profiles::Profiles;
use super::seams::Crossing;

/// How small a component may be, in pixels of the search grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Width and height of the bounding box.
    pub(crate) side: u16,
    /// Pixels.
    pub(crate) area: u32,
}

/// A component that may be the border of a tag.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Component {
    /// First column.
    pub(crate) left: u16,
    /// One past the last column.
    pub(crate) right: u16,
    /// First row.
    pub(crate) top: u16,
    /// Last row.
    pub(crate) bottom: u16,
    /// Pixels.
    pub(crate) area: u32,
    /// Where the profile begins among those of its place.
    pub(super) offset: u32,
    pub(super) place: Place,
}

/// Where a component's profile is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// In the band of this number, which holds the whole component.
    Band(u8),
    /// With those of the components that cross from band to band.
    Crossing,
}

impl Component {
    /// Columns of the bounding box.
    pub(crate) fn width(&self) -> usize {
        usize::from(self.right - self.left)
    }

    /// Rows of the bounding box.
    pub(crate) fn height(&self) -> usize {
        usize::from(self.bottom - self.top) + 1
    }
}

impl Component {
    pub(super) fn new(extent: &Extent, offset: u32, place: Place) -> Self {
        let (left, right, top, bottom) = (extent.left(), extent.right(), extent.top(), extent.bottom());
        Self { left, right, top, bottom, area: extent.area, offset, place }
    }
}

/// How components of a band are kept, in the order of their first runs.
pub(super) struct Keeping<'a> {
    pub(super) plane: &'a Plane<'a>,
    pub(super) limits: &'a Limits,
    /// The band's number and its first row.
    pub(super) band: usize,
    pub(super) first_row: usize,
    /// The components that cross into other bands, by label; they are decided on already.
    pub(super) crossing: &'a [Crossing],
    /// Where the profiles of the others may begin.
    pub(super) offset: u32,
}

impl Keeping<'_> {
    /// Keeps the components within the limits and lays out their profiles; returns where these end.
    #[inline(always)]
    pub(super) fn keep(
        mut self,
        labels: &mut Labels,
        components: &mut Vec<Component>,
        profiles: &mut Profiles,
    ) -> u32 {
        components.clear();
        labels.slot.resize(labels.count(), 0);
        let mut next = 0;
        for crossing in self.crossing {
            let label = crossing.label as usize;
            self.keep_inside(next..label, labels, components);
            labels.slot[label] = crossing.slot;
            components.extend(crossing.component);
            next = label + 1;
        }
        self.keep_inside(next..labels.count(), labels, components);
        profiles.resize(self.offset as usize);
        self.offset
    }

    /// As [`Self::keep`], for labels of which none crosses.
    #[inline(always)]
    fn keep_inside(
        &mut self,
        some: std::ops::Range<usize>,
        labels: &mut Labels,
        components: &mut Vec<Component>,
    ) {
        for first in some.clone().step_by(BLOCK) {
            let block = first..some.end.min(first + BLOCK);
            let (all, slots) = labels.with_slots();
            slots[block.clone()].fill(Profiles::REJECTED);
            let mut large = large_roots(&all[block.clone()], first, self.limits);
            while large != 0 {
                let label = first + large.trailing_zeros() as usize;
                slots[label] = self.keep_one(&all[label].extent, components);
                large &= large - 1;
            }
            // What is no root has what its root has. A checkerboard has nothing but rejected roots.
            if !(components.is_empty() && self.crossing.is_empty()) {
                for label in block {
                    slots[label] = slots[all[label].parent as usize];
                }
            }
        }
    }

    /// The slot of a large component.
    #[inline(always)]
    fn keep_one(&mut self, extent: &Extent, components: &mut Vec<Component>) -> u32 {
        if crosses_rims(extent, self.plane) {
            return Profiles::REJECTED;
        }
        let offset = self.offset;
        components.push(Component::new(extent, offset, Place::Band(self.band as u8)));
        self.offset += u32::from(extent.bottom() - extent.top()) + 1;
        slot(offset, extent.top(), self.first_row)
    }
}

/// Labels that are looked at together.
const BLOCK: usize = 64;

/// Which labels of a block are roots of components that are large enough, as bits: with a branch for each label, noise would
/// have most of them mispredicted.
#[inline(always)]
fn large_roots(labels: &[Label], first: usize, limits: &Limits) -> u64 {
    let mut large = 0;
    for (place, Label { parent, extent }) in labels.iter().enumerate() {
        let is_root = *parent as usize == first + place;
        large |= u64::from(is_root & is_large(extent, limits)) << place;
    }
    large
}

/// Row `y` of a band is entry `slot + y` of a profile; offsets start past the band's last row, so this never wraps.
pub(super) fn slot(offset: u32, top: u16, first_row: usize) -> u32 {
    offset - (u32::from(top) - first_row as u32)
}

/// Large enough, and at most one side cut by the frame.
pub(super) fn may_be_a_border(extent: &Extent, plane: &Plane, limits: &Limits) -> bool {
    is_large(extent, limits) && !crosses_rims(extent, plane)
}

#[inline(always)]
fn is_large(extent: &Extent, limits: &Limits) -> bool {
    let (width, height) = (extent.right() - extent.left(), extent.bottom() - extent.top() + 1);
    (width >= limits.side) & (height >= limits.side) & (extent.area >= limits.area)
}

/// Whether the frame cuts two sides: a tag that loses a corner cannot be read.
#[inline(always)]
fn crosses_rims(extent: &Extent, plane: &Plane) -> bool {
    let rims = [
        extent.left() == 0,
        extent.top() == 0,
        usize::from(extent.right()) == plane.width,
        usize::from(extent.bottom()) + 1 == plane.height,
    ];
    rims.iter().filter(|touched| **touched).count() > 1
}
