//! Which components may be the border of a tag, judged by their bounding box alone.

use super::Plane;
use super::labels::{Extent, Labels};
use super::profiles::Profiles;

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
    /// Where the profile begins among all profiles.
    pub(super) offset: u32,
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

/// Merges labels into components, keeps those within `limits` and lays out their profiles.
pub(super) fn keep_components(
    labels: &mut Labels,
    plane: &Plane,
    limits: &Limits,
    components: &mut Vec<Component>,
    profiles: &mut Profiles,
) {
    merge_extents(labels);
    components.clear();
    let count = labels.count();
    labels.slot.resize(count, 0);
    let mut offset = Profiles::FIRST.max(plane.height) as u32;
    for label in 0..count {
        let root = labels.parent[label] as usize;
        if root != label {
            labels.slot[label] = labels.slot[root];
            continue;
        }
        let extent = labels.extent[label];
        if !may_be_a_border(&extent, plane, limits) {
            labels.slot[label] = Profiles::REJECTED;
            continue;
        }
        // Row `y` of the component is entry `slot + y`; offsets start past the highest row, so this never wraps.
        labels.slot[label] = offset - u32::from(extent.top);
        let Extent { left, right, top, bottom, .. } = extent;
        components.push(Component { left, right, top, bottom, offset });
        offset += u32::from(bottom - top) + 1;
    }
    profiles.resize(offset as usize);
}

/// Makes every label point at its root and adds its extent there. Parents are smaller, so one pass upwards is enough.
fn merge_extents(labels: &mut Labels) {
    for label in 0..labels.count() {
        let parent = labels.parent[label] as usize;
        if parent != label {
            let root = labels.parent[parent];
            labels.parent[label] = root;
            let extent = labels.extent[label];
            labels.extent[root as usize].add(&extent);
        }
    }
}

/// Large enough, and at most one side cut by the frame: a tag that loses a corner cannot be read.
fn may_be_a_border(extent: &Extent, plane: &Plane, limits: &Limits) -> bool {
    let rims = [
        extent.left == 0,
        extent.top == 0,
        usize::from(extent.right) == plane.width,
        usize::from(extent.bottom) + 1 == plane.height,
    ];
    extent.right - extent.left >= limits.side
        && extent.bottom - extent.top + 1 >= limits.side
        && extent.area >= limits.area
        && rims.iter().filter(|touched| **touched).count() <= 1
}
