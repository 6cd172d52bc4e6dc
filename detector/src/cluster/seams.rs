//! Components that cross from band to band: their labels are joined here, and the parts of their profiles put together.
//!
//! Bands are labelled as if they were planes of their own. What crosses a seam is little beside them, so a list of the
//! labels at seams is enough, and one thread for it.

use super::Plane;
use super::band::Band;
use super::components::{Component, Limits, Place, may_be_a_border, slot};
use super::contacts::{Contacts, Join, Row, join_rows};
use super::cut::Cut;
use super::labels::{Connectivity, Extent, Labels};
use super::profiles::Profiles;
use super::runs::{Ranks, filled};
use crate::simd::Level;

/// What crosses seams, and buffers to find it.
#[derive(Default)]
pub(super) struct Seams {
    contacts: Contacts,
    ranks: [Ranks; 2],
    /// Labels that touch, as keys.
    pairs: Vec<[u64; 2]>,
    keys: Vec<u64>,
    /// The labels that cross, by band and label.
    crossing: Vec<Crossing>,
    pieces: Vec<Piece>,
    /// For each band where the profiles of the components that stay inside it may begin.
    offsets: Vec<u32>,
}

/// A band's component that touches one of a neighbouring band.
pub(super) struct Crossing {
    band: usize,
    /// Its label in the band.
    pub(super) label: u32,
    /// The one that it was found to be one component with: an earlier one, or itself.
    parent: usize,
    /// What is known of the band's component; of the whole one when this is its first.
    extent: Extent,
    /// The first of the whole component's pieces.
    piece: usize,
    /// Where its profile begins in the band.
    pub(super) slot: u32,
    /// The whole component, if this is its first label and it is kept.
    pub(super) component: Option<Component>,
}

/// The rows of a kept component that lie in one band.
struct Piece {
    band: usize,
    offset: u32,
    rows: usize,
}

/// Orders labels by band, then as the band does, which is the order of their first runs in the plane.
fn key(band: usize, label: u32) -> u64 {
    (band as u64) << 32 | u64::from(label)
}

/// Notes which components of two bands touch.
struct AcrossSeam<'a> {
    upper: usize,
    ranks: &'a [Ranks; 2],
    labels: [&'a Labels; 2],
    pairs: &'a mut Vec<[u64; 2]>,
}

impl Join for AcrossSeam<'_> {
    #[inline(always)]
    fn join(&mut self, column: usize) {
        let of_side = |side: usize| {
            key(self.upper + side, self.labels[side].component_of(self.ranks[side].run_at(column)))
        };
        let pair = [of_side(0), of_side(1)];
        if self.pairs.last() != Some(&pair) {
            self.pairs.push(pair);
        }
    }
}

impl Seams {
    /// Joins what touches across the seams of labelled bands, and decides which of it is kept.
    pub(super) fn join(&mut self, level: Level, plane: &Plane, cut: &Cut, bands: &[Band], limits: &Limits) {
        self.pairs.clear();
        if cut.bands() == 1 {
            return self.join_nothing(plane);
        }
        for upper in 0..cut.bands() - 1 {
            self.find_pairs(level, plane, cut, bands, upper);
        }
        self.unite(bands);
        self.decide(plane, cut, limits);
    }

    /// What there is to know where there is one band: its profiles begin where any band's may.
    fn join_nothing(&mut self, plane: &Plane) {
        self.crossing.clear();
        self.pieces.clear();
        self.offsets.clear();
        self.offsets.push(Profiles::first_offset(plane.height));
    }

    fn find_pairs(&mut self, level: Level, plane: &Plane, cut: &Cut, bands: &[Band], upper: usize) {
        let row = |y: usize| {
            let bits = &plane.bits[y * plane.words..][..plane.words];
            Row { bits, filled: filled(bits) }
        };
        let rows = cut.rows(upper);
        let (below, last_row) = (rows.end, bands[upper].runs.of_row(rows.len() - 1));
        let (above, below) = (row(below - 1), row(below));
        self.ranks[0].fill(above.bits, &above.filled, last_row.start as u32);
        self.ranks[1].fill(below.bits, &below.filled, 0);
        let mut across = AcrossSeam {
            upper,
            ranks: &self.ranks,
            labels: [&bands[upper].labels, &bands[upper + 1].labels],
            pairs: &mut self.pairs,
        };
        match plane.connectivity {
            Connectivity::Four => {
                join_rows::<false, _>(level, &above, &below, &mut self.contacts, &mut across);
            }
            Connectivity::Eight => {
                join_rows::<true, _>(level, &above, &below, &mut self.contacts, &mut across);
            }
        }
    }

    /// Makes a list of the labels in `pairs` in which each points at the first one of its component.
    fn unite(&mut self, bands: &[Band]) {
        let Self { pairs, keys, crossing, .. } = self;
        keys.clear();
        keys.extend(pairs.as_flattened());
        keys.sort_unstable();
        keys.dedup();
        crossing.clear();
        crossing.extend(keys.iter().enumerate().map(|(place, key)| {
            let (band, label) = ((key >> 32) as usize, *key as u32);
            let extent = bands[band].labels.all()[label as usize].extent;
            let slot = Profiles::REJECTED;
            Crossing { band, label, parent: place, extent, piece: 0, slot, component: None }
        }));
        for pair in pairs.iter() {
            // Every key of a pair is in the list.
            let [a, b] = pair.map(|key| root(crossing, keys.partition_point(|known| *known < key)));
            crossing[a.max(b)].parent = a.min(b);
        }
        for place in 0..crossing.len() {
            let parent = crossing[place].parent;
            if parent != place {
                let (root, extent) = (crossing[parent].parent, crossing[place].extent);
                crossing[place].parent = root;
                crossing[root].extent.add(&extent);
            }
        }
    }

    /// Keeps components within the limits and lays out their pieces.
    fn decide(&mut self, plane: &Plane, cut: &Cut, limits: &Limits) {
        self.pieces.clear();
        self.offsets.clear();
        self.offsets.extend((0..cut.bands()).map(|band| Profiles::first_offset(cut.rows(band).len())));
        let mut offset = 0;
        for place in 0..self.crossing.len() {
            let Crossing { parent, extent, band, .. } = self.crossing[place];
            if parent == place && may_be_a_border(&extent, plane, limits) {
                self.crossing[place].piece = self.pieces.len();
                self.crossing[place].component = Some(Component::new(&extent, offset, Place::Crossing));
                offset += self.lay_out(&extent, cut);
            }
            let first = &self.crossing[parent];
            if first.component.is_some() {
                let offset = self.pieces[first.piece + band - first.band].offset;
                let first_row = cut.rows(band).start;
                let top = usize::from(first.extent.top()).max(first_row);
                self.crossing[place].slot = slot(offset, top as u16, first_row);
            }
        }
    }

    /// Makes room for a component in every band that it lies in; returns its rows.
    fn lay_out(&mut self, extent: &Extent, cut: &Cut) -> u32 {
        let (top, end) = (usize::from(extent.top()), usize::from(extent.bottom()) + 1);
        for band in cut.band_of(top)..=cut.band_of(end - 1) {
            let of_band = cut.rows(band);
            let rows = end.min(of_band.end) - top.max(of_band.start);
            self.pieces.push(Piece { band, offset: self.offsets[band], rows });
            self.offsets[band] += rows as u32;
        }
        (end - top) as u32
    }

    /// The labels of a band that cross its seams.
    pub(super) fn of_band(&self, band: usize) -> &[Crossing] {
        let first = self.crossing.partition_point(|crossing| crossing.band < band);
        let end = self.crossing.partition_point(|crossing| crossing.band <= band);
        &self.crossing[first..end]
    }

    /// Where the profiles of the components that stay inside a band may begin.
    pub(super) fn offset(&self, band: usize) -> u32 {
        self.offsets[band]
    }

    /// Puts the profiles of the components that cross together.
    pub(super) fn gather(&self, bands: &[Band], profiles: &mut Profiles) {
        profiles.clear();
        for Piece { band, offset, rows } in &self.pieces {
            profiles.append(&bands[*band].profiles, *offset, *rows);
        }
    }
}

/// The first label of the component, halving the path on the way.
fn root(crossing: &mut [Crossing], mut place: usize) -> usize {
    while crossing[place].parent != place {
        let parent = crossing[place].parent;
        crossing[place].parent = crossing[parent].parent;
        place = crossing[place].parent;
    }
    place
}
