//! Row profiles: the outline of a component as the span that it takes in each row.

use super::components::Component;
use super::labels::Labels;
use super::runs::Runs;

/// The profiles of all kept components, one after the other.
#[derive(Default)]
pub(super) struct Profiles {
    spans: Vec<[u16; 2]>,
    slots: Vec<u32>,
}

/// The outline of one component.
#[derive(Clone, Copy)]
pub(crate) struct Profile<'a> {
    /// The first row.
    pub(crate) top: usize,
    /// For each row the first column of the component and one past its last.
    pub(crate) spans: &'a [[u16; 2]],
}

impl Profiles {
    /// The slot of components that were not kept: the first entries, one for each row, take what is written for them, so that the
    /// fill needs no branch.
    pub(super) const REJECTED: u32 = 0;

    pub(super) fn resize(&mut self, entries: usize) {
        if self.spans.len() < entries {
            self.spans.resize(entries, [0; 2]);
        }
    }

    /// Where the first profile of a band of so many rows may begin.
    pub(super) fn first_offset(rows: usize) -> u32 {
        rows as u32
    }

    /// Appends a part of a profile that another band has filled.
    pub(super) fn append(&mut self, other: &Profiles, offset: u32, rows: usize) {
        self.spans.extend_from_slice(&other.spans[offset as usize..][..rows]);
    }

    pub(super) fn clear(&mut self) {
        self.spans.clear();
    }

    #[inline(always)]
    pub(super) fn of(&self, component: &Component) -> Profile<'_> {
        let spans = &self.spans[component.offset as usize..][..component.height()];
        Profile { top: usize::from(component.top), spans }
    }
}

/// Writes the profiles of the kept components, as far as they lie in these rows. A kept component has a run in each of its
/// rows, so nothing needs clearing: ends are stored from left to right and starts from right to left, and the last write is
/// the right one.
#[inline(always)]
pub(super) fn fill_profiles(runs: &Runs, labels: &Labels, profiles: &mut Profiles) {
    let Profiles { spans, slots } = profiles;
    let spans = &mut spans[..];
    for row in 0..runs.rows() {
        let of_row = runs.of_row(row);
        let runs = &runs.spans()[of_row.clone()];
        slots.resize(of_row.len(), 0);
        for ((label, [_, end]), entry) in labels.of_run[of_row].iter().zip(runs).zip(slots.iter_mut()) {
            *entry = labels.slot[*label as usize] + row as u32;
            spans[*entry as usize][1] = *end;
        }
        for (entry, [start, _]) in slots.iter().zip(runs).rev() {
            spans[*entry as usize][0] = *start;
        }
    }
}
