//! Proves the search: against the plainest form of itself, against the published families, and against itself done in
//! other ways.

use std::ops::ControlFlow;
use tagbus_family::complexity::{Metric, Rule};
use tagbus_family::published::{self, FAMILIES};
use tagbus_family::search::{Ending, Level, Limits, Observer, Search, State};
use tagbus_family::{Layout, Recipe};

/// Never stops.
fn go_on() -> Box<Observer<'static>> {
    Box::new(|_, _| ControlFlow::Continue(()))
}

fn search(search: &Search) -> (Vec<u64>, Ending) {
    let mut state = State::default();
    let ending = search.run(&mut state, &mut *go_on());
    (state.found, ending)
}

/// Each candidate that is far enough from its own rotations and from all codes before is kept, if it is complex enough.
fn plain_search(recipe: &Recipe) -> Vec<u64> {
    let (layout, candidates) = (recipe.layout(), recipe.candidates());
    let far = |left: u64, right: u64| (left ^ right).count_ones() >= recipe.distance();
    let mut numbers = Vec::new();
    let mut codes: Vec<u64> = Vec::new();
    for number in 1..=recipe.candidate_count() {
        let code = recipe.from_candidate(candidates.code(number));
        let turned = layout.rotations(code);
        let is_far = turned[1..].iter().all(|&turned| far(code, turned))
            && codes.iter().all(|&kept| turned.iter().all(|&turned| far(kept, turned)));
        if is_far && recipe.rule().allows(layout, code) {
            codes.push(code);
            numbers.push(number);
        }
    }
    numbers
}

#[test]
fn a_complete_search_finds_what_the_plainest_search_finds() {
    let circle = |metric: Metric, distance| {
        let layout = Layout::circle(9).unwrap();
        let rule = Rule { metric, least: metric.default_least(&layout) };
        Recipe::new(layout, distance, 3, rule).unwrap()
    };
    let hole = || {
        let cells = "xxddddxx xbbbbbbx dbwwwwbd dbwxxwbd dbwxxwbd dbwwwwbd xbbbbbbx xxddddxx";
        let rule = Rule { metric: Metric::Components, least: 3 };
        Recipe::new(Layout::parse(cells).unwrap(), 4, 0, rule).unwrap()
    };
    let recipes = [
        published::named("tag16h5").unwrap().recipe().unwrap(),
        circle(Metric::Ising, 7),
        circle(Metric::Ising, 5),
        circle(Metric::Components, 9),
        hole(),
    ];
    for recipe in recipes {
        let (found, ending) = search(&Search::new(recipe.clone()));
        assert_eq!(ending, Ending::Complete);
        assert!(!found.is_empty());
        assert_eq!(found, plain_search(&recipe), "{recipe:?}");
    }
}

/// So many codes of each published family are searched again in every test run; the whole families take minutes and
/// are a command of their own: `tagbus family generate --published NAME`.
const FIRST_CODES: [(&str, usize); 9] = [
    ("tag16h5", usize::MAX),
    ("tag25h9", usize::MAX),
    ("tag36h10", 900),
    ("tag36h11", 350),
    ("tagCircle21h7", usize::MAX),
    ("tagCircle49h12", 8000),
    ("tagCustom48h12", 8000),
    ("tagStandard41h12", 800),
    ("tagStandard52h13", 8000),
];

#[test]
fn published_families_are_found_again() {
    for (name, count) in FIRST_CODES {
        let family = published::named(name).unwrap();
        let limits = Limits { codes: (count < family.count).then_some(count), candidates: None };
        let (found, ending) =
            search(&Search::new(family.recipe().unwrap()).with_threads(2).with_limits(limits));
        let expected = if limits.codes.is_some() { Ending::Limited } else { Ending::Complete };
        assert_eq!(ending, expected, "{name}");
        assert!(found == family.numbers()[..count.min(family.count)], "{name} differs from its table");
    }
}

#[test]
fn every_level_and_number_of_threads_finds_the_same() {
    for name in ["tag25h9", "tagCircle21h7", "tagStandard52h13"] {
        let recipe = published::named(name).unwrap().recipe().unwrap();
        let limits = Limits { codes: Some(500), candidates: None };
        let one = search(&Search::new(recipe.clone()).with_limits(limits).with_level(Level::PORTABLE));
        for level in Level::available() {
            for threads in [1, 2, 5] {
                let many =
                    Search::new(recipe.clone()).with_limits(limits).with_level(level).with_threads(threads);
                assert_eq!(search(&many), one, "{name}, {level}, {threads} threads");
            }
        }
    }
}

/// A recipe with just enough bits to be swept.
fn swept() -> Recipe {
    let cells = "wwwwwwwwww wbbbbbbbbw wbddddddbw wbddddddbw wbddwwddbw
                 wbddwwddbw wbddddddbw wbddddddbw wbbbbbbbbw wwwwwwwwww";
    let layout = Layout::parse(cells).expect("a layout");
    let rule = Rule { metric: Metric::Ising, least: Metric::Ising.default_least(&layout) };
    Recipe::new(layout, 9, 1, rule).expect("a possible distance")
}

#[test]
fn a_sweep_begins_with_what_a_search_in_order_finds() {
    let (whole, ending) = search(&Search::new(swept()).with_threads(2));
    assert_eq!(ending, Ending::Complete);
    // So few candidates are not worth a sweep.
    let last = swept().candidate_count() / 100;
    let limits = Limits { codes: None, candidates: Some(last) };
    let (ordered, _) = search(&Search::new(swept()).with_limits(limits));
    let both = whole.partition_point(|&number| number <= last);
    assert!(both < whole.len(), "nothing was found by the sweep alone");
    assert_eq!(ordered, whole[..both]);
}

#[test]
fn a_sweep_leaves_nothing_out_and_takes_nothing_twice() {
    let recipe = swept();
    let found = search(&Search::new(recipe.clone()).with_threads(2)).0;
    let (layout, candidates) = (recipe.layout(), recipe.candidates());
    let turned: Vec<[u64; 4]> =
        found.iter().map(|&number| layout.rotations(candidates.code(number))).collect();
    let is_near = |code: u64, other: u64| (code ^ other).count_ones() < recipe.distance();
    let hit = |code: u64, before: usize| turned[..before].iter().flatten().any(|&other| is_near(code, other));
    for (id, [code, once, twice, _]) in turned.iter().enumerate() {
        assert!(!hit(*code, id) && !is_near(*code, *once) && !is_near(*code, *twice), "id {id}");
    }
    // A prime step, so that all parts of the sequence are asked.
    for number in (1..=recipe.candidate_count()).step_by(40_009) {
        let code = candidates.code(number);
        let before = found.partition_point(|&earlier| earlier < number);
        let [_, once, twice, _] = layout.rotations(code);
        let is_out = is_near(code, once) || is_near(code, twice) || hit(code, before);
        let is_found = found.get(before) == Some(&number);
        assert!(is_found || is_out || !recipe.rule().allows(layout, code), "candidate {number} was left out");
    }
}

#[test]
fn a_sweep_can_be_interrupted() {
    let whole = search(&Search::new(swept()).with_threads(2));
    let mut state = State::default();
    let mut stops_in_the_sweep = 0;
    while Search::new(swept()).run(&mut state, &mut |_, _| ControlFlow::Break(())) == Ending::Stopped {
        stops_in_the_sweep += u32::from(state.sweep.is_some());
    }
    assert!(stops_in_the_sweep > 0);
    assert_eq!(state.found, whole.0);
    assert_eq!(state.sweep, None);
}

#[test]
fn an_interrupted_search_goes_on_to_the_same_end() {
    let recipe = published::named("tag25h9").unwrap().recipe().unwrap();
    let whole = search(&Search::new(recipe.clone()));
    let mut state = State::default();
    let mut steps = 0;
    loop {
        steps += 1;
        let ending = Search::new(recipe.clone()).run(&mut state, &mut |_, _| ControlFlow::Break(()));
        if ending != Ending::Stopped {
            break;
        }
    }
    assert!(steps > 3, "stopped only {steps} times");
    assert_eq!(state.found, whole.0);
}

#[test]
fn limits_end_a_search_that_can_go_on() {
    let recipe = published::named("tagCircle21h7").unwrap().recipe().unwrap();
    let whole = search(&Search::new(recipe.clone())).0;
    for codes in [1, 2, 17, whole.len()] {
        let mut state = State::default();
        let limited =
            Search::new(recipe.clone()).with_limits(Limits { codes: Some(codes), candidates: None });
        limited.run(&mut state, &mut *go_on());
        assert_eq!(state.found, whole[..codes]);
        assert_eq!(Search::new(recipe.clone()).run(&mut state, &mut *go_on()), Ending::Complete);
        assert_eq!(state.found, whole);
    }
    let limits = Limits { codes: None, candidates: Some(whole[20]) };
    assert_eq!(search(&Search::new(recipe).with_limits(limits)), (whole[..=20].to_vec(), Ending::Limited));
}

#[test]
fn published_recipes_name_every_published_family() {
    for family in &FAMILIES {
        assert_eq!(family.recipe().unwrap().distance(), family.distance, "{}", family.name);
    }
}
