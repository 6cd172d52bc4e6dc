//! A search at work: shown, kept in a file, stopped by a signal.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use tagbus_family::Recipe;
use tagbus_family::search::{Ending, Search, State};

use super::progress::Bar;
use super::saved;
use crate::outcome::Failure;

/// The state is not written more often than this.
const SAVE_EVERY: Duration = Duration::from_secs(1);

pub(super) struct Work<'a> {
    recipe: &'a Recipe,
    resume: Option<&'a Path>,
    stop: Arc<AtomicBool>,
    bar: Bar,
}

impl<'a> Work<'a> {
    /// From now on SIGINT and SIGTERM end the search, not the process.
    pub(super) fn new(
        recipe: &'a Recipe,
        resume: Option<&'a Path>,
        codes: Option<usize>,
    ) -> Result<Self, Failure> {
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            signal_hook::flag::register(signal, Arc::clone(&stop))?;
        }
        Ok(Self { recipe, resume, stop, bar: Bar::new(codes) })
    }

    /// Searches to an end; the state is kept at the end too.
    pub(super) fn run(mut self, search: &Search, state: &mut State) -> Result<Ending, Failure> {
        let mut trouble = None;
        let mut saved = Instant::now();
        let ending = search.run(state, &mut |state, progress| {
            self.bar.show(progress);
            if saved.elapsed() >= SAVE_EVERY {
                trouble = self.save(state).err();
                saved = Instant::now();
            }
            let ends = trouble.is_some() || self.stop.load(Ordering::Relaxed);
            if ends { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        self.bar.clear();
        match trouble {
            Some(error) => Err(error),
            None => self.save(state).map(|()| ending),
        }
    }

    fn save(&self, state: &State) -> Result<(), Failure> {
        self.resume.map_or(Ok(()), |path| saved::save(path, self.recipe, state))
    }
}
