//! How far a search has come: enough to go on from there.

/// What a search has found and what it has looked at.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct State {
    /// Candidates 1 to this number are decided for good.
    pub decided: u64,
    /// The numbers of the codes found among these, increasing.
    pub found: Vec<u64>,
    /// The sweep through all others, once it has begun.
    pub sweep: Option<Sweep>,
}

/// A pass through all candidates at once, in an order that suits the processor's caches. Nothing beyond
/// [`State::decided`] is sure before it has ended.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sweep {
    /// Values of the low bits that are done.
    pub lows_done: u64,
    /// The numbers of the candidates that are far from all codes found before the sweep, in no particular order.
    pub survivors: Vec<u64>,
}

/// When a search ends before all candidates are decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// With so many codes.
    pub codes: Option<usize>,
    /// After so many candidates.
    pub candidates: Option<u64>,
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Every candidate is decided: no code can be added.
    Complete,
    /// One of the [`Limits`] was reached.
    Limited,
    /// The observer wanted it.
    Stopped,
}

/// Work done so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Codes found for sure.
    pub codes: usize,
    /// Candidates looked at, in this phase.
    pub looked_at: u64,
    /// Candidates to look at in this phase at most.
    pub total: u64,
    /// Whether this phase is the sweep.
    pub sweeping: bool,
}
