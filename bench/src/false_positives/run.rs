//! The experiment.

use std::path::PathBuf;

use tagbus_family::Family;

use super::contenders::{Contender, Field, Pair, SHARE_SAMPLE};
use super::families::{KINDS, Kind, Maker};
use super::interval::Counts;
use super::matches::{histogram, most_bits};
use super::{material, quads};
use crate::sweep::bar;

type Failure = Box<dyn std::error::Error>;

/// Seeds that give too few codes are passed over, but not more than this for each that is wanted.
const MOST_PASSED_OVER: usize = 50;

/// How much is done.
pub(crate) struct Plan {
    pub(crate) folders: Vec<PathBuf>,
    /// Pictures whose names begin with the same of these words show the same place.
    pub(crate) same_place: Vec<String>,
    /// Families of each contender.
    pub(crate) seeds: usize,
    pub(crate) threads: usize,
}

/// All tables and what they are made of.
pub(crate) struct Findings {
    pub(super) pictures: usize,
    /// Names of pictures that hold codes.
    pub(super) left_out: Vec<String>,
    pub(super) outcomes: Vec<Outcome>,
}

/// One table.
pub(super) struct Outcome {
    pub(super) kind: &'static Kind,
    pub(super) bit_count: u32,
    /// Bits that are corrected at most: all that leave no doubt.
    pub(super) most_bits: usize,
    /// Quads of each place.
    pub(super) quads: Vec<usize>,
    pub(super) lines: Vec<Line>,
    /// What is compared, by places in `lines`.
    pub(super) pairs: Vec<Pair>,
    /// Seeds that give some contender too few codes.
    pub(super) passed_over: Vec<u32>,
}

/// The families of one contender.
pub(super) struct Line {
    pub(super) contender: Contender,
    /// The share of random codes that pass.
    pub(super) share: f64,
    pub(super) counts: Counts,
}

impl Outcome {
    pub(super) fn quad_count(&self) -> usize {
        self.quads.iter().sum()
    }

    /// Families of each contender.
    pub(super) fn seeds(&self) -> usize {
        self.lines.first().map_or(0, |line| line.counts.len())
    }
}

/// Reads the quads of all pictures and counts them against families of every contender.
///
/// # Errors
/// Pictures that cannot be read, too few places, no quads, seeds that give too few codes.
pub(crate) fn run(plan: &Plan) -> Result<Findings, Failure> {
    let families: Vec<Family> =
        KINDS.iter().map(|kind| Family::published(kind.family)).collect::<Result<_, _>>()?;
    let material = material::load(&plan.folders, &plan.same_place)?;
    let codes = quads::read(&families, &material.places)?;
    let tables = KINDS.iter().zip(&families).zip(&codes);
    let outcomes: Result<_, _> =
        tables.map(|((kind, family), codes)| table(kind, family, codes, plan)).collect();
    let pictures = material.places.iter().map(Vec::len).sum();
    Ok(Findings { pictures, left_out: material.left_out, outcomes: outcomes? })
}

fn table(kind: &'static Kind, family: &Family, codes: &[Vec<u64>], plan: &Plan) -> Result<Outcome, Failure> {
    let quads: Vec<usize> = codes.iter().map(Vec::len).collect();
    if quads.iter().sum::<usize>() == 0 {
        return Err(
            format!("no quad of {} is seen in these pictures: take more, or richer ones", kind.name).into()
        );
    }
    let Field { contenders, shares, pairs } = Field::new(family.layout(), SHARE_SAMPLE);
    let (counts, passed_over) = counts(kind, family, &contenders, codes, plan)?;
    let lines = contenders.into_iter().zip(shares).zip(counts);
    Ok(Outcome {
        kind,
        bit_count: family.layout().bit_count(),
        most_bits: most_bits(family.distance()),
        quads,
        lines: lines.map(|((contender, share), counts)| Line { contender, share, counts }).collect(),
        pairs,
        passed_over,
    })
}

/// The counts of each contender, and the seeds that were passed over: all contenders have the same seeds.
fn counts(
    kind: &Kind,
    family: &Family,
    contenders: &[Contender],
    codes: &[Vec<u64>],
    plan: &Plan,
) -> Result<(Vec<Counts>, Vec<u32>), Failure> {
    let (layout, distance) = (family.layout(), family.distance());
    let maker = Maker { layout, distance, codes: kind.codes, threads: plan.threads };
    let bar = bar(plan.seeds, &format!("families of {}", kind.name));
    let (mut counts, mut passed_over) = (vec![Counts::new(); contenders.len()], Vec::new());
    for seed in 0.. {
        if counts[0].len() == plan.seeds {
            break;
        }
        if passed_over.len() > MOST_PASSED_OVER * plan.seeds {
            return Err(format!("{} seeds give too few codes of {}", passed_over.len(), kind.name).into());
        }
        let Some(families) = maker.families(contenders, seed)? else {
            passed_over.push(seed);
            continue;
        };
        for (counts, known) in counts.iter_mut().zip(&families) {
            counts.push(codes.iter().map(|codes| histogram(codes, known)).collect());
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok((counts, passed_over))
}
