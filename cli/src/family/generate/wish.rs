//! From flags to a recipe, and what can be said of it before the search.

use std::fs;
use std::path::Path;

use tagbus_family::complexity::{Metric, Rule};
use tagbus_family::{Layout, LayoutError, Recipe};

use super::GenerateFlags;
use crate::family::list::border_name;
use crate::outcome::Failure;

/// Random codes that are judged to tell how strict a recipe is.
const SAMPLE: u64 = 4000;

/// The recipe that is asked for.
pub(super) fn recipe(flags: &GenerateFlags) -> Result<Recipe, Failure> {
    let layout = wanted_layout(flags)?;
    let missing = || Failure::new("say with --distance BITS how far apart the tags must be");
    let distance = flags.distance.or(flags.hamming).ok_or_else(missing)?;
    let metric = metric(&flags.metric, &layout)?;
    let least = flags.threshold.unwrap_or_else(|| metric.default_least(&layout));
    Ok(Recipe::new(layout, distance, flags.seed_complexity, Rule { metric, least })?)
}

fn wanted_layout(flags: &GenerateFlags) -> Result<Layout, Failure> {
    match (&flags.layout, &flags.layout_file) {
        (Some(text), _) => layout(text).map_err(|error| Failure::new(format!("--layout: {error}"))),
        (None, Some(path)) => layout_of_file(path),
        (None, None) => Err(Failure::new(
            "say with --layout or --layout-file what the tag looks like, such as --layout standard:9, or with --published NAME which \
             published family is to be searched again",
        )),
    }
}

fn layout_of_file(path: &Path) -> Result<Layout, Failure> {
    let text = fs::read_to_string(path)
        .map_err(|error| Failure::new(format!("cannot read {}: {error}", path.display())))?;
    layout(&text).map_err(|error| Failure::new(format!("{}: {error}", path.display())))
}

fn layout(text: &str) -> Result<Layout, LayoutError> {
    let named = text.trim().split_once(':').and_then(|(shape, width)| Some((shape, width.parse().ok()?)));
    match named {
        Some(("classic", width)) => Layout::classic(width),
        Some(("standard", width)) => Layout::standard(width),
        Some(("circle", width)) => Layout::circle(width),
        _ => Layout::parse(text),
    }
}

fn metric(name: &str, layout: &Layout) -> Result<Metric, Failure> {
    let names = || Metric::ALL.map(Metric::name).join(", ");
    let metric = Metric::named(name);
    let metric =
        metric.ok_or_else(|| Failure::new(format!("there is no metric {name:?}: use one of {}", names())))?;
    let width = layout.bit_count().isqrt();
    if metric == Metric::DataRectangles && !(width * width == layout.bit_count() && width <= 8) {
        let bits = layout.bit_count();
        return Err(Failure::new(format!(
            "data-rectangles wants a square of data bits, but {bits} is no square: use rectangles"
        )));
    }
    Ok(metric)
}

/// Which part of random codes passes each of the rules that look at one code alone.
pub(super) struct Share {
    pub(super) complex: f64,
    pub(super) own_distance: f64,
}

impl Share {
    pub(super) fn of(recipe: &Recipe) -> Share {
        let (layout, candidates) = (recipe.layout(), recipe.candidates());
        let sample = || (1..=SAMPLE).map(|number| recipe.from_candidate(candidates.code(number)));
        let is_far = |code: &u64| {
            let [_, turns @ ..] = layout.rotations(*code);
            turns.iter().all(|turned| (code ^ turned).count_ones() >= recipe.distance())
        };
        let share = |count: usize| count as f64 / SAMPLE as f64;
        Share {
            complex: share(sample().filter(|&code| recipe.rule().allows(layout, code)).count()),
            own_distance: share(sample().filter(is_far).count()),
        }
    }
}

/// What is searched, and how strict it is: wide borders and fixed cells make the same limit stricter.
pub(super) fn describe(recipe: &Recipe) -> String {
    let (layout, rule) = (recipe.layout(), recipe.rule());
    format!(
        "{} bits, border {}, tag size {} of {} cells; distance {}; {} of at least {}, which {:.1} % of random codes have",
        layout.bit_count(),
        border_name(layout.border()),
        layout.width_at_border(),
        layout.total_width(),
        recipe.distance(),
        rule.metric,
        rule.least,
        Share::of(recipe).complex * 100.0
    )
}
