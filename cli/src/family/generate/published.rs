//! A published family searched again, and compared code by code.

use std::time::Instant;

use tagbus_family::Family;
use tagbus_family::published;
use tagbus_family::search::Ending;

use super::{GenerateFlags, family_file, level, search, tell, threads};
use crate::new_file::{self, Existing};
use crate::outcome::{Failure, Outcome};

/// Published families of so many bits were searched to the end.
const MOST_SEARCHED_BITS: u32 = 36;

/// Searches the family and says how far it is what was published.
pub(super) fn execute(flags: &GenerateFlags, name: &str) -> Result<Outcome, Failure> {
    let existing = if flags.force { Existing::Replace } else { Existing::Keep };
    flags.output.as_ref().map_or(Ok(()), |output| new_file::check(output, existing))?;
    let published = published::named(name)?;
    let recipe = published.recipe()?;
    // Searches of more bits were stopped before their end, and the codes found until then published.
    let is_stopped = recipe.layout().bit_count() > MOST_SEARCHED_BITS && !flags.complete;
    let limit = flags.codes.or(is_stopped.then_some(published.count));
    let begun = Instant::now();
    let (state, ending) = search(flags, &recipe, limit)?;
    let (wall, cpu) = (begun.elapsed().as_secs_f64(), cpu_seconds());
    if let Some(output) = &flags.output {
        let file = family_file(published.name.to_owned(), &recipe, &state, ending)?;
        new_file::write(output, file.to_text().as_bytes(), existing)?;
    }
    tell(format!(
        "{}: {} codes, {} candidates decided{}; {cpu:.1} s of CPU, {wall:.1} s, {} threads, {}",
        published.name,
        state.found.len(),
        state.decided,
        if ending == Ending::Complete { ", which are all" } else { "" },
        threads(flags),
        level(flags)?
    ));
    compare(published.name, &recipe.codes(&state.found))
}

/// CPU time of this process so far.
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fn compare(name: &str, codes: &[u64]) -> Result<Outcome, Failure> {
    let family = Family::published(name)?;
    let table = family.codes();
    let same = codes.iter().zip(table).take_while(|(left, right)| left == right).count();
    let told = match (same == codes.len(), same == table.len()) {
        (true, true) => format!("exactly the published {} codes", table.len()),
        (false, true) => {
            format!("the published {same} codes, and {} that come after them", codes.len() - same)
        }
        (true, false) => format!("exactly the first {same} of the published {} codes", table.len()),
        (false, false) => {
            tell(format!("id {same} is {:#x}, but was published as {:#x}", codes[same], table[same]));
            return Ok(Outcome::Failed);
        }
    };
    tell(told);
    Ok(Outcome::Done)
}
