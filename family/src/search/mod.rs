//! The search for a family's codes: greedy, exact, and the same for any number of threads and any level.
//!
//! ```
//! use std::ops::ControlFlow;
//! use tagbus_family::search::{Ending, Search, State};
//! use tagbus_family::{Family, published};
//!
//! let recipe = published::named("tag16h5")?.recipe()?;
//! let mut state = State::default();
//! let ending = Search::new(recipe.clone()).run(&mut state, &mut |_, _| ControlFlow::Continue(()));
//! assert_eq!(ending, Ending::Complete);
//! assert_eq!(recipe.codes(&state.found), Family::published("tag16h5")?.codes());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod apart;
mod balls;
mod direct;
mod judge;
mod level;
mod near;
mod state;
mod sweep;

pub(crate) use apart::least_bits;
pub use apart::{TooClose, first_too_close};
pub use level::{Kernel, Level, UnknownLevel};
pub use state::{Ending, Limits, Progress, State, Sweep};

use crate::recipe::Recipe;
use direct::Direct;
use judge::Judge;
use std::ops::ControlFlow;
use sweep::Sweeper;

/// Codes with fewer bits are searched in their order to the end.
const LEAST_SWEPT_BITS: u32 = 30;
/// With more bits no sweep ends within days.
const MOST_SWEPT_BITS: u32 = 44;
/// The share of all candidates (2 to minus this) that are decided in their order before the sweep begins.
const DIRECT_SHARE: u32 = 11;

/// Called between two steps with the state, which is whole, and the progress; may end the search.
pub type Observer<'a> = dyn FnMut(&State, Progress) -> ControlFlow<()> + 'a;

/// A search and how it is to be done.
#[derive(Clone, Debug)]
pub struct Search {
    recipe: Recipe,
    limits: Limits,
    threads: usize,
    level: Level,
}

impl Search {
    /// A complete search with one thread.
    pub fn new(recipe: Recipe) -> Search {
        Search { recipe, limits: Limits::default(), threads: 1, level: Level::best() }
    }

    /// Ends when a limit is reached.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Search {
        Search { limits, ..self }
    }

    /// Works with so many threads, at least one. The codes do not depend on it.
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Search {
        Search { threads: threads.max(1), ..self }
    }

    /// Uses these instructions. The codes do not depend on it.
    #[must_use]
    pub fn with_level(self, level: Level) -> Search {
        Search { level, ..self }
    }

    /// Goes on from `state` until all candidates are decided, a limit is reached or `observer` wants to stop.
    pub fn run(&self, state: &mut State, observer: &mut Observer) -> Ending {
        let judge = Judge::new(&self.recipe);
        if state.sweep.is_none() {
            if let Some(ending) = self.run_directly(&judge, state, observer) {
                return ending;
            }
            state.sweep = Some(Sweep::default());
        }
        self.run_sweep(&judge, state, observer)
    }

    /// Decides candidates in their order; `None` when it is time for the sweep.
    fn run_directly(&self, judge: &Judge, state: &mut State, observer: &mut Observer) -> Option<Ending> {
        let mut direct = Direct::new(self, judge, &state.found);
        let total = self.last_candidate();
        loop {
            if let Some(ending) = self.ending(state) {
                return Some(ending);
            }
            if self.is_time_to_sweep(state) {
                return None;
            }
            state.decided = direct.advance(state.decided + 1, total, &mut state.found);
            self.cut_to_code_limit(state);
            let progress =
                Progress { codes: state.found.len(), looked_at: state.decided, total, sweeping: false };
            if observer(state, progress).is_break() {
                return Some(Ending::Stopped);
            }
        }
    }

    fn run_sweep(&self, judge: &Judge, state: &mut State, observer: &mut Observer) -> Ending {
        let sweeper = Sweeper::new(self, judge, state.decided, &state.found);
        let per_low = 1 << balls::HIGH_BITS;
        let mut sweep = state.sweep.take().unwrap_or_default();
        while sweep.lows_done < sweeper.lows() {
            sweeper.advance(&mut sweep);
            let (looked_at, total) = (sweep.lows_done * per_low, sweeper.lows() * per_low);
            state.sweep = Some(sweep);
            let progress = Progress { codes: state.found.len(), looked_at, total, sweeping: true };
            if observer(state, progress).is_break() {
                return Ending::Stopped;
            }
            sweep = state.sweep.take().unwrap_or_default();
        }
        self.finish_sweep(judge, state, sweep.survivors)
    }

    fn finish_sweep(&self, judge: &Judge, state: &mut State, mut survivors: Vec<u64>) -> Ending {
        survivors.sort_unstable();
        let last = self.last_candidate();
        survivors.truncate(survivors.partition_point(|&number| number <= last));
        direct::decide(judge, self.recipe.candidates(), self.recipe.distance(), &survivors, &mut state.found);
        state.decided = last;
        self.cut_to_code_limit(state);
        self.ending(state).unwrap_or(Ending::Complete)
    }

    /// The number of the last candidate that is wanted.
    fn last_candidate(&self) -> u64 {
        self.recipe.candidate_count().min(self.limits.candidates.unwrap_or(u64::MAX))
    }

    fn ending(&self, state: &State) -> Option<Ending> {
        let has_all_codes = self.limits.codes.is_some_and(|codes| state.found.len() >= codes);
        if state.decided >= self.recipe.candidate_count() {
            Some(Ending::Complete)
        } else if has_all_codes || state.decided >= self.last_candidate() {
            Some(Ending::Limited)
        } else {
            None
        }
    }

    /// Codes beyond the limit are not found yet: the search could go on behind the last that is wanted.
    fn cut_to_code_limit(&self, state: &mut State) {
        let Some(codes) = self.limits.codes.filter(|&codes| codes < state.found.len()) else { return };
        state.found.truncate(codes);
        state.decided = state.found.last().copied().unwrap_or(0);
    }

    /// A sweep goes through all candidates, so it does not pay when few are wanted.
    fn is_time_to_sweep(&self, state: &State) -> bool {
        swept_lows(&self.recipe).is_some()
            && state.decided >= self.recipe.candidate_count() >> DIRECT_SHARE
            && self.last_candidate() >= self.recipe.candidate_count() >> 6
    }
}

/// How many values of the low bits a sweep for this recipe goes through; none when it is searched in order only.
pub fn swept_lows(recipe: &Recipe) -> Option<u64> {
    let bits = recipe.layout().bit_count();
    (LEAST_SWEPT_BITS..=MOST_SWEPT_BITS).contains(&bits).then(|| 1 << (bits - balls::HIGH_BITS))
}

/// What `work` gives on each of so many threads, all together. Which thread did what is left open.
fn on_threads(threads: usize, work: impl Fn() -> Vec<u64> + Sync) -> Vec<u64> {
    if threads == 1 {
        return work();
    }
    std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(&work)).collect();
        let results = running.into_iter().map(|thread| match thread.join() {
            Ok(numbers) => numbers,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        results.flatten().collect()
    })
}
