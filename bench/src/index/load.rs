//! The published families, ready to be looked up.

use tagbus_family::{Family, Index, UnknownFamily};

use crate::clock::cpu_us;
use crate::memory;
use crate::sweep::Times;

/// Families with an index each.
pub(super) type Loaded = Vec<(Family, Index)>;

/// What it costs to have all families ready.
pub(super) struct Load {
    /// CPU time of the first time in this process, microseconds: memory is fresh, nothing is cached.
    pub(super) first_us: f64,
    /// CPU time of the times after it.
    pub(super) times: Times,
    /// Bytes that families and indexes hold, by the allocator's count.
    pub(super) held: usize,
    /// Bytes that were held at most meanwhile.
    pub(super) peak: usize,
}

/// Loads everything once, and then `rounds` times for the clock.
pub(super) fn measure(hamming: u32, rounds: usize) -> Result<(Load, Loaded), UnknownFamily> {
    let before = memory::live();
    let mut first = (0.0, Ok(Loaded::new()));
    let peak = memory::peak_during(|| first = cpu_us(|| load(hamming)));
    let held = memory::live() - before;
    let (first_us, loaded) = first;
    // What is dropped is dropped after the clock has been read.
    let again = (0..rounds).map(|_| cpu_us(|| load(hamming)).0);
    let load = Load { first_us, times: Times::of(again.collect()), held, peak };
    Ok((load, loaded?))
}

/// As a program that asks for all of them does it: unpacks the codes and arranges them.
fn load(hamming: u32) -> Result<Loaded, UnknownFamily> {
    let one = |name: &&str| {
        let family = Family::published(name)?;
        let index = Index::new(&family, hamming);
        Ok((family, index))
    };
    Family::PUBLISHED.iter().map(one).collect()
}
