//! The parameters of a detector: all of them, some of them, and the block in which both travel.

use std::mem::{offset_of, size_of};

use iceoryx2::prelude::ZeroCopySend;

use super::asking::{check_count, read_text};
use super::choices::{RefinementChoice, SamplingChoice, SearchChoice};
use super::fault::ControlFault;
use crate::detection::{FAMILY_NAME_BYTES, MAX_NAMED_FAMILIES};
use crate::text;

/// Ranges of ids that a message has room for.
pub const MAX_ID_RANGES: usize = 64;

/// A rectangle of a frame, in pixels of full resolution; (0,0) is the top-left pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns; never 0.
    pub width: u32,
    /// Rows; never 0.
    pub height: u32,
}

/// Everything that can be chosen about a detector while it runs.
#[derive(Clone, Debug, PartialEq)]
pub struct DetectorParameters {
    /// Full-resolution pixels per decimated pixel.
    pub decimation: f32,
    /// What decimation makes of the pixels that become one.
    pub sampling: SamplingChoice,
    /// How hard quads are looked for.
    pub search: SearchChoice,
    /// Threads that work on a frame.
    pub threads: u32,
    /// Corrected bits at most; `None` for each family's own number.
    pub hamming: Option<u32>,
    /// How corners are refined.
    pub refinement: RefinementChoice,
    /// Sharpening of the sampled cells, 0 for none.
    pub sharpening: f32,
    /// Tags with a smaller decision margin are dropped, grey levels.
    pub min_margin: f32,
    /// Only this part of the frame is searched; `None` for the whole frame.
    pub region: Option<Region>,
    /// Names of the families that are looked for.
    pub families: Vec<String>,
    /// First and last id of each range that is reported; empty for all ids.
    pub ids: Vec<(u32, u32)>,
}

/// Other values for some of the parameters: what is `None` stays as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DetectorChange {
    /// See [`DetectorParameters::decimation`].
    pub decimation: Option<f32>,
    /// See [`DetectorParameters::sampling`].
    pub sampling: Option<SamplingChoice>,
    /// See [`DetectorParameters::search`].
    pub search: Option<SearchChoice>,
    /// See [`DetectorParameters::threads`].
    pub threads: Option<u32>,
    /// See [`DetectorParameters::hamming`]; `Some(None)` goes back to each family's own number.
    pub hamming: Option<Option<u32>>,
    /// See [`DetectorParameters::refinement`].
    pub refinement: Option<RefinementChoice>,
    /// See [`DetectorParameters::sharpening`].
    pub sharpening: Option<f32>,
    /// See [`DetectorParameters::min_margin`].
    pub min_margin: Option<f32>,
    /// See [`DetectorParameters::region`]; `Some(None)` goes back to the whole frame.
    pub region: Option<Option<Region>>,
    /// See [`DetectorParameters::families`]; all that are looked for from then on.
    pub families: Option<Vec<String>>,
    /// See [`DetectorParameters::ids`]; `Some` of an empty list goes back to all ids.
    pub ids: Option<Vec<(u32, u32)>>,
}

/// Bits of a request's mask: the values of its block that count.
pub(super) mod set {
    pub(in crate::control) const DECIMATION: u32 = 1;
    pub(in crate::control) const SAMPLING: u32 = 1 << 1;
    pub(in crate::control) const SEARCH: u32 = 1 << 2;
    pub(in crate::control) const THREADS: u32 = 1 << 3;
    pub(in crate::control) const HAMMING: u32 = 1 << 4;
    pub(in crate::control) const REFINEMENT: u32 = 1 << 5;
    pub(in crate::control) const SHARPENING: u32 = 1 << 6;
    pub(in crate::control) const MIN_MARGIN: u32 = 1 << 7;
    pub(in crate::control) const REGION: u32 = 1 << 8;
    pub(in crate::control) const FAMILIES: u32 = 1 << 9;
    pub(in crate::control) const IDS: u32 = 1 << 10;
    /// All that are known.
    pub(in crate::control) const ALL: u32 = (1 << 11) - 1;
}

/// Parameters as they travel. In a request only those count whose bit is set in its mask.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("tagbus.ParameterBlock.v1")]
pub struct ParameterBlock {
    /// Full-resolution pixels per decimated pixel.
    pub decimation: f32,
    /// A [`SamplingChoice`] code.
    pub sampling: u32,
    /// A [`SearchChoice`] code.
    pub search: u32,
    /// Threads that work on a frame.
    pub threads: u32,
    /// Corrected bits; -1 for each family's own number.
    pub hamming: i32,
    /// A [`RefinementChoice`] code.
    pub refinement: u32,
    /// Sharpening of the sampled cells.
    pub sharpening: f32,
    /// Least decision margin, grey levels.
    pub min_margin: f32,
    /// x, y, width, height in pixels of full resolution; width or height 0 for the whole frame.
    pub region: [u32; 4],
    /// Families in `families`.
    pub family_count: u32,
    /// Ranges in `ids`; 0 for all ids.
    pub id_count: u32,
    /// Names of families, see [`crate::text`].
    pub families: [[u8; FAMILY_NAME_BYTES]; MAX_NAMED_FAMILIES],
    /// First and last id of each range.
    pub ids: [[u32; 2]; MAX_ID_RANGES],
}

const _: () = {
    assert!(size_of::<ParameterBlock>() == 1080);
    assert!(offset_of!(ParameterBlock, decimation) == 0);
    assert!(offset_of!(ParameterBlock, sampling) == 4);
    assert!(offset_of!(ParameterBlock, search) == 8);
    assert!(offset_of!(ParameterBlock, threads) == 12);
    assert!(offset_of!(ParameterBlock, hamming) == 16);
    assert!(offset_of!(ParameterBlock, refinement) == 20);
    assert!(offset_of!(ParameterBlock, sharpening) == 24);
    assert!(offset_of!(ParameterBlock, min_margin) == 28);
    assert!(offset_of!(ParameterBlock, region) == 32);
    assert!(offset_of!(ParameterBlock, family_count) == 48);
    assert!(offset_of!(ParameterBlock, id_count) == 52);
    assert!(offset_of!(ParameterBlock, families) == 56);
    assert!(offset_of!(ParameterBlock, ids) == 568);
};

impl Default for ParameterBlock {
    fn default() -> Self {
        Self {
            decimation: 0.0,
            sampling: 0,
            search: 0,
            threads: 0,
            hamming: -1,
            refinement: 0,
            sharpening: 0.0,
            min_margin: 0.0,
            region: [0; 4],
            family_count: 0,
            id_count: 0,
            families: [[0; FAMILY_NAME_BYTES]; MAX_NAMED_FAMILIES],
            ids: [[0; 2]; MAX_ID_RANGES],
        }
    }
}

impl ParameterBlock {
    /// All parameters. Families and ranges of ids beyond the room are left out; the counts tell how many there are.
    pub(super) fn of(parameters: &DetectorParameters) -> Self {
        let mut block = Self {
            decimation: parameters.decimation,
            sampling: parameters.sampling.code(),
            search: parameters.search.code(),
            threads: parameters.threads,
            hamming: hamming_code(parameters.hamming),
            refinement: parameters.refinement.code(),
            sharpening: parameters.sharpening,
            min_margin: parameters.min_margin,
            region: region_code(parameters.region),
            family_count: parameters.families.len() as u32,
            id_count: parameters.ids.len() as u32,
            ..Self::default()
        };
        for (field, name) in block.families.iter_mut().zip(&parameters.families) {
            text::write_cut(field, name);
        }
        for (field, &(first, last)) in block.ids.iter_mut().zip(&parameters.ids) {
            *field = [first, last];
        }
        block
    }

    /// All parameters of a reply.
    pub(super) fn checked(&self) -> Result<DetectorParameters, ControlFault> {
        let families = (self.family_count as usize).min(MAX_NAMED_FAMILIES);
        let ids = (self.id_count as usize).min(MAX_ID_RANGES);
        Ok(DetectorParameters {
            decimation: number(self.decimation, "decimation")?,
            sampling: SamplingChoice::from_code(self.sampling)?,
            search: SearchChoice::from_code(self.search)?,
            threads: self.threads,
            hamming: hamming(self.hamming)?,
            refinement: RefinementChoice::from_code(self.refinement)?,
            sharpening: number(self.sharpening, "sharpening")?,
            min_margin: number(self.min_margin, "least margin")?,
            region: region(self.region),
            families: self.families_up_to(families)?,
            ids: self.ids_up_to(ids)?,
        })
    }

    fn families_up_to(&self, count: usize) -> Result<Vec<String>, ControlFault> {
        self.families[..count].iter().map(|field| read_text(field, "family's name")).collect()
    }

    fn ids_up_to(&self, count: usize) -> Result<Vec<(u32, u32)>, ControlFault> {
        self.ids[..count].iter().map(|&[first, last]| check_range(first, last)).collect()
    }
}

/// The block and the mask of a change.
pub(super) fn write_change(change: &DetectorChange) -> Result<(ParameterBlock, u32), ControlFault> {
    let mut block = ParameterBlock::default();
    let mut mask = 0;
    let mut take = |bit, is_set| mask |= if is_set { bit } else { 0 };
    take(set::DECIMATION, change.decimation.is_some());
    take(set::SAMPLING, change.sampling.is_some());
    take(set::SEARCH, change.search.is_some());
    take(set::THREADS, change.threads.is_some());
    take(set::HAMMING, change.hamming.is_some());
    take(set::REFINEMENT, change.refinement.is_some());
    take(set::SHARPENING, change.sharpening.is_some());
    take(set::MIN_MARGIN, change.min_margin.is_some());
    take(set::REGION, change.region.is_some());
    take(set::FAMILIES, change.families.is_some());
    take(set::IDS, change.ids.is_some());
    block.decimation = change.decimation.unwrap_or_default();
    block.sampling = change.sampling.map_or(0, SamplingChoice::code);
    block.search = change.search.map_or(0, SearchChoice::code);
    block.threads = change.threads.unwrap_or_default();
    block.hamming = hamming_code(change.hamming.flatten());
    block.refinement = change.refinement.map_or(0, RefinementChoice::code);
    block.sharpening = change.sharpening.unwrap_or_default();
    block.min_margin = change.min_margin.unwrap_or_default();
    block.region = region_code(change.region.flatten());
    write_families(&mut block, change.families.as_deref().unwrap_or_default())?;
    write_ids(&mut block, change.ids.as_deref().unwrap_or_default())?;
    Ok((block, mask))
}

fn write_families(block: &mut ParameterBlock, names: &[String]) -> Result<(), ControlFault> {
    let (seen, room) = (names.len(), MAX_NAMED_FAMILIES);
    if seen > room {
        return Err(ControlFault::Count { what: "families", seen, room });
    }
    for (field, name) in block.families.iter_mut().zip(names) {
        text::write(field, name).map_err(|long| ControlFault::Long {
            what: "family's name",
            text: long.text,
            room: long.limit,
        })?;
    }
    block.family_count = seen as u32;
    Ok(())
}

fn write_ids(block: &mut ParameterBlock, ranges: &[(u32, u32)]) -> Result<(), ControlFault> {
    let (seen, room) = (ranges.len(), MAX_ID_RANGES);
    if seen > room {
        return Err(ControlFault::Count { what: "ranges of ids", seen, room });
    }
    for (field, &(first, last)) in block.ids.iter_mut().zip(ranges) {
        check_range(first, last)?;
        *field = [first, last];
    }
    block.id_count = seen as u32;
    Ok(())
}

/// The change that a request's block and mask say.
pub(super) fn read_change(block: &ParameterBlock, mask: u32) -> Result<DetectorChange, ControlFault> {
    if mask & !set::ALL != 0 {
        return Err(ControlFault::Parameter { bits: mask & !set::ALL });
    }
    let has = |bit| mask & bit != 0;
    let families = || {
        let count = check_count(block.family_count, MAX_NAMED_FAMILIES, "families")?;
        block.families_up_to(count)
    };
    let ids = || block.ids_up_to(check_count(block.id_count, MAX_ID_RANGES, "ranges of ids")?);
    Ok(DetectorChange {
        decimation: has(set::DECIMATION).then(|| number(block.decimation, "decimation")).transpose()?,
        sampling: has(set::SAMPLING).then(|| SamplingChoice::from_code(block.sampling)).transpose()?,
        search: has(set::SEARCH).then(|| SearchChoice::from_code(block.search)).transpose()?,
        threads: has(set::THREADS).then_some(block.threads),
        hamming: has(set::HAMMING).then(|| hamming(block.hamming)).transpose()?,
        refinement: has(set::REFINEMENT)
            .then(|| RefinementChoice::from_code(block.refinement))
            .transpose()?,
        sharpening: has(set::SHARPENING).then(|| number(block.sharpening, "sharpening")).transpose()?,
        min_margin: has(set::MIN_MARGIN).then(|| number(block.min_margin, "least margin")).transpose()?,
        region: has(set::REGION).then(|| region(block.region)),
        families: has(set::FAMILIES).then(families).transpose()?,
        ids: has(set::IDS).then(ids).transpose()?,
    })
}

fn number(seen: f32, what: &'static str) -> Result<f32, ControlFault> {
    if seen.is_finite() { Ok(seen) } else { Err(ControlFault::Number { what, seen }) }
}

fn hamming(code: i32) -> Result<Option<u32>, ControlFault> {
    match code {
        -1 => Ok(None),
        code => u32::try_from(code).map(Some).map_err(|_| ControlFault::Hamming(code)),
    }
}

fn hamming_code(hamming: Option<u32>) -> i32 {
    hamming.map_or(-1, |bits| i32::try_from(bits).unwrap_or(i32::MAX))
}

fn region([x, y, width, height]: [u32; 4]) -> Option<Region> {
    (width > 0 && height > 0).then_some(Region { x, y, width, height })
}

fn region_code(region: Option<Region>) -> [u32; 4] {
    region.map_or([0; 4], |Region { x, y, width, height }| [x, y, width, height])
}

fn check_range(first: u32, last: u32) -> Result<(u32, u32), ControlFault> {
    if first <= last { Ok((first, last)) } else { Err(ControlFault::Range { first, last }) }
}
