//! Published families searched again, and compared code by code.

use std::time::Instant;

use tagbus_family::published::{self, FAMILIES, Published};
use tagbus_family::search::{Ending, State};
use tagbus_family::{Family, Recipe};

use super::{GenerateFlags, family_file, level, search, tell, threads};
use crate::new_file::{self, Existing};
use crate::outcome::{Failure, Outcome};

/// Published families of so many bits were searched to the end.
const MOST_SEARCHED_BITS: u32 = 36;
/// Stands for all published families, in the order of their names.
const ALL: &str = "all";

/// Searches the family and says how far it is what was published.
pub(super) fn execute(flags: &GenerateFlags, name: &str) -> Result<Outcome, Failure> {
    if name.eq_ignore_ascii_case(ALL) { all(flags) } else { one(flags, published::named(name)?) }
}

fn one(flags: &GenerateFlags, published: &Published) -> Result<Outcome, Failure> {
    let existing = if flags.force { Existing::Replace } else { Existing::Keep };
    flags.output.as_ref().map_or(Ok(()), |output| new_file::check(output, existing))?;
    let begun = Instant::now();
    let Searched { recipe, state, ending, cpu_s } = Searched::again(flags, published)?;
    let wall_s = begun.elapsed().as_secs_f64();
    if let Some(output) = &flags.output {
        let file = family_file(published.name.to_owned(), &recipe, &state, ending)?;
        new_file::write(output, file.to_text().as_bytes(), existing)?;
    }
    tell(format!(
        "{}: {} codes, {} candidates decided{}; {cpu_s:.1} s of CPU, {wall_s:.1} s, {} threads, {}",
        published.name,
        state.found.len(),
        state.decided,
        if ending == Ending::Complete { ", which are all" } else { "" },
        threads(flags),
        level(flags)?
    ));
    let comparison = Comparison::of(published.name, &recipe.codes(&state.found))?;
    tell(&comparison.told);
    Ok(comparison.outcome())
}

/// All of them, a line each as soon as it is done.
fn all(flags: &GenerateFlags) -> Result<Outcome, Failure> {
    check_flags_for_all(flags)?;
    tell(format!("{} threads, {}", threads(flags), level(flags)?));
    tell(row(["family", "codes", "published", "CPU s"], "compared"));
    let mut outcome = Outcome::Done;
    for published in &FAMILIES {
        let Searched { recipe, state, ending, cpu_s } = Searched::again(flags, published)?;
        let comparison = Comparison::of(published.name, &recipe.codes(&state.found))?;
        let figures = [state.found.len().to_string(), published.count.to_string(), format!("{cpu_s:.1}")];
        let [codes, count, cpu_s] = figures.each_ref().map(String::as_str);
        tell(row([published.name, codes, count, cpu_s], &comparison.told));
        if ending == Ending::Stopped {
            return Err(Failure::new(format!(
                "stopped at {}: it and those after it are not proven",
                published.name
            )));
        }
        if !comparison.is_same {
            outcome = Outcome::Failed;
        }
    }
    Ok(outcome)
}

fn row([name, codes, published, cpu_s]: [&str; 4], compared: &str) -> String {
    format!("{name:<16} {codes:>7} {published:>9} {cpu_s:>7}  {compared}")
}

/// A file holds one family, or the state of one search.
fn check_flags_for_all(flags: &GenerateFlags) -> Result<(), Failure> {
    let files = [("--output", &flags.output), ("--resume", &flags.resume)];
    match files.into_iter().find(|(_, file)| file.is_some()) {
        Some((flag, _)) => Err(Failure::new(format!(
            "{flag} names the file of one family: use it with --published NAME, or --published all without it"
        ))),
        None => Ok(()),
    }
}

/// A published family's search, done again.
struct Searched {
    recipe: Recipe,
    state: State,
    ending: Ending,
    /// CPU time of all threads, seconds.
    cpu_s: f64,
}

impl Searched {
    fn again(flags: &GenerateFlags, published: &Published) -> Result<Searched, Failure> {
        let recipe = published.recipe()?;
        // Searches of more bits were stopped before their end, and the codes found until then published.
        let is_stopped = recipe.layout().bit_count() > MOST_SEARCHED_BITS && !flags.complete;
        let limit = flags.codes.or(is_stopped.then_some(published.count));
        let begun_s = cpu_seconds();
        let (state, ending) = search(flags, &recipe, limit)?;
        Ok(Searched { recipe, state, ending, cpu_s: cpu_seconds() - begun_s })
    }
}

/// CPU time of this process so far.
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Codes that were found beside those that were published.
struct Comparison {
    told: String,
    /// No code differs; there may be fewer or more.
    is_same: bool,
}

impl Comparison {
    fn of(name: &str, codes: &[u64]) -> Result<Comparison, Failure> {
        let family = Family::published(name)?;
        let table = family.codes();
        let same = codes.iter().zip(table).take_while(|(left, right)| left == right).count();
        let is_same = same == codes.len() || same == table.len();
        let told = match (same == codes.len(), same == table.len()) {
            (true, true) => format!("exactly the published {} codes", table.len()),
            (false, true) => {
                format!("the published {same} codes, and {} that come after them", codes.len() - same)
            }
            (true, false) => format!("exactly the first {same} of the published {} codes", table.len()),
            (false, false) => {
                format!("id {same} is {:#x}, but was published as {:#x}", codes[same], table[same])
            }
        };
        Ok(Comparison { told, is_same })
    }

    fn outcome(&self) -> Outcome {
        if self.is_same { Outcome::Done } else { Outcome::Failed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_that_differs_is_named_and_fewer_or_more_codes_are_told() {
        let codes = Family::published("tag16h5").unwrap().codes().to_vec();
        let compared = |codes: &[u64]| {
            let Comparison { told, is_same } = Comparison::of("tag16h5", codes).unwrap();
            (told, is_same)
        };
        assert_eq!(compared(&codes), ("exactly the published 30 codes".to_owned(), true));
        assert_eq!(compared(&codes[..7]), ("exactly the first 7 of the published 30 codes".to_owned(), true));
        let more = [codes.as_slice(), &[1, 2]].concat();
        assert_eq!(compared(&more), ("the published 30 codes, and 2 that come after them".to_owned(), true));
        let mut other = codes.clone();
        other[5] ^= 1;
        let expected = format!("id 5 is {:#x}, but was published as {:#x}", other[5], codes[5]);
        assert_eq!(compared(&other), (expected, false));
    }
}
