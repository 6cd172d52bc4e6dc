//! The state of a search as a file: whole at any moment, and checked before it is believed.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use tagbus_family::Recipe;
use tagbus_family::search::{State, Sweep, first_too_close, swept_lows};

use crate::new_file::{self, Existing};
use crate::outcome::Failure;

/// What the file holds.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Saved {
    recipe: SavedRecipe,
    decided: u64,
    sweep: Option<SavedSweep>,
    found: Vec<u64>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct SavedRecipe {
    layout: String,
    distance: u32,
    metric: String,
    least_complexity: u32,
    seed_complexity: u32,
    bit_order: String,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct SavedSweep {
    lows_done: u64,
    survivors: Vec<u64>,
}

impl SavedRecipe {
    fn of(recipe: &Recipe) -> Self {
        Self {
            layout: recipe.layout().text(),
            distance: recipe.distance(),
            metric: recipe.rule().metric.to_string(),
            least_complexity: recipe.rule().least,
            seed_complexity: recipe.seed_complexity(),
            bit_order: recipe.order().name().to_owned(),
        }
    }

    /// The first field in which two recipes differ, with both values.
    fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        let fields = |recipe: &Self| {
            [
                ("layout", recipe.layout.clone()),
                ("distance", recipe.distance.to_string()),
                ("metric", recipe.metric.clone()),
                ("threshold", recipe.least_complexity.to_string()),
                ("seed-complexity", recipe.seed_complexity.to_string()),
                ("bit order", recipe.bit_order.clone()),
            ]
        };
        let both = fields(self).into_iter().zip(fields(other));
        both.into_iter()
            .find(|(here, there)| here != there)
            .map(|((name, here), (_, there))| (name, here, there))
    }
}

/// Writes the state; what was there stays until the new one is on the disk.
pub(super) fn save(path: &Path, recipe: &Recipe, state: &State) -> Result<(), Failure> {
    let sweep = state.sweep.as_ref();
    let saved = Saved {
        recipe: SavedRecipe::of(recipe),
        decided: state.decided,
        sweep: sweep
            .map(|sweep| SavedSweep { lows_done: sweep.lows_done, survivors: sweep.survivors.clone() }),
        found: state.found.clone(),
    };
    let text = serde_json::to_string(&saved)? + "\n";
    Ok(new_file::write(path, text.as_bytes(), Existing::Replace)?)
}

/// The state of a search with this recipe; `None` when there is no file yet.
pub(super) fn load(path: &Path, recipe: &Recipe) -> Result<Option<State>, SavedError> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(SavedError::Read { path: path.to_owned(), error }),
    };
    let damaged = |what: String| SavedError::Damaged { path: path.to_owned(), what };
    let saved: Saved = serde_json::from_str(&text).map_err(|error| damaged(error.to_string()))?;
    if let Some((field, here, there)) = saved.recipe.difference(&SavedRecipe::of(recipe)) {
        return Err(SavedError::OtherRecipe { path: path.to_owned(), field, here, there });
    }
    let state = saved.state();
    check(&state, recipe).map_err(damaged)?;
    Ok(Some(state))
}

impl Saved {
    fn state(self) -> State {
        let sweep = self.sweep.map(|saved| Sweep { lows_done: saved.lows_done, survivors: saved.survivors });
        State { decided: self.decided, found: self.found, sweep }
    }
}

/// Nothing is believed that a search could not have written.
fn check(state: &State, recipe: &Recipe) -> Result<(), String> {
    let count = recipe.candidate_count();
    if state.decided > count {
        return Err(format!("{} candidates are decided, but there are {count}", state.decided));
    }
    if let Some(place) = state.found.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(format!(
            "code {} has candidate number {}, not more than the one before",
            place + 1,
            state.found[place + 1]
        ));
    }
    if state.found.iter().any(|&number| number == 0 || number > state.decided) {
        return Err(format!("a code lies beyond the {} candidates that are decided", state.decided));
    }
    if let Some(close) = first_too_close(recipe.layout(), &recipe.codes(&state.found), recipe.distance()) {
        return Err(format!("codes {} and {} differ in {} bits only", close.first, close.second, close.bits));
    }
    check_sweep(state, recipe)
}

fn check_sweep(state: &State, recipe: &Recipe) -> Result<(), String> {
    let Some(sweep) = &state.sweep else { return Ok(()) };
    let (lows, count) = (swept_lows(recipe).unwrap_or(0), recipe.candidate_count());
    if lows == 0 || sweep.lows_done > lows {
        return Err(format!("{} parts of a sweep are done, but there are {lows}", sweep.lows_done));
    }
    let is_candidate = |number: &u64| (state.decided + 1..=count).contains(number);
    match sweep.survivors.iter().find(|number| !is_candidate(number)) {
        Some(number) => Err(format!("candidate {number} cannot have been left by the sweep")),
        None => Ok(()),
    }
}

/// Why a state was not read.
#[derive(Debug)]
pub(super) enum SavedError {
    Read { path: PathBuf, error: io::Error },
    Damaged { path: PathBuf, what: String },
    OtherRecipe { path: PathBuf, field: &'static str, here: String, there: String },
}

impl fmt::Display for SavedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, error } => {
                write!(f, "cannot read the state of the search {}: {error}", path.display())
            }
            Self::Damaged { path, what } => write!(
                f,
                "{} is no state of a search that can be believed: {what}; remove it to begin anew",
                path.display()
            ),
            Self::OtherRecipe { path, field, here, there } => write!(
                f,
                "{} belongs to another recipe: its {field} is {here}, but {there} is asked for; name another file with --resume",
                path.display()
            ),
        }
    }
}

impl std::error::Error for SavedError {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;
    use tagbus_family::published;
    use tagbus_family::search::Search;

    fn recipe() -> Recipe {
        published::named("tag25h9").unwrap().recipe().unwrap()
    }

    fn half_done() -> State {
        let mut state = State::default();
        let mut steps = 0;
        Search::new(recipe()).run(&mut state, &mut |_, _| {
            steps += 1;
            if steps < 6 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        assert!(state.found.len() > 5);
        state
    }

    #[test]
    fn a_state_is_read_back_and_a_false_one_is_not_believed() {
        let folder = std::env::temp_dir().join(format!("tagbus-saved-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("state");
        assert!(load(&path, &recipe()).unwrap().is_none());
        let state = half_done();
        save(&path, &recipe(), &state).unwrap();
        assert_eq!(load(&path, &recipe()).unwrap().as_ref(), Some(&state));

        let changes: [fn(&mut State); 5] = [
            |state| state.sweep = Some(Sweep::default()),
            |state| state.found.swap(1, 2),
            |state| state.decided = state.found[3],
            |state| state.decided = u64::MAX,
            |state| state.found.insert(1, state.found[0] + 1),
        ];
        for (number, change) in changes.into_iter().enumerate() {
            let mut changed = state.clone();
            change(&mut changed);
            save(&path, &recipe(), &changed).unwrap();
            let error = load(&path, &recipe()).unwrap_err();
            assert!(matches!(error, SavedError::Damaged { .. }), "change {number}: {error}");
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}
