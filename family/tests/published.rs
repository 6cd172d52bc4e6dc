//! Proves the embedded tables of the published families: every property that made the search keep a code is measured
//! again here.

use std::path::{Path, PathBuf};
use tagbus_family::complexity::{ising_energy, least_ising_energy, rectangle_count};
use tagbus_family::published::{self, BitOrder, NAMES, RECIPES, Recipe};
use tagbus_family::{Family, Layout};

fn families() -> impl Iterator<Item = (&'static Recipe, Family)> {
    RECIPES.iter().map(|recipe| (recipe, Family::published(recipe.name).expect("its name is in the list")))
}

#[test]
fn each_family_has_its_number_of_codes() {
    for (recipe, family) in families() {
        assert_eq!(family.codes().len(), recipe.count, "{}", recipe.name);
        assert_eq!((family.name(), family.distance()), (recipe.name, recipe.distance));
    }
}

#[test]
fn codes_come_in_the_order_in_which_they_were_searched() {
    for (recipe, family) in families() {
        let layout = family.layout();
        let candidates = recipe.candidates(layout);
        let number = |&code: &u64| candidates.number(recipe.to_candidate(layout, code));
        let numbers: Vec<u64> = family.codes().iter().map(number).collect();
        assert!(numbers[0] >= 1, "{}", recipe.name);
        assert!(numbers.windows(2).all(|pair| pair[0] < pair[1]), "{}", recipe.name);
    }
}

#[test]
fn each_code_is_complex_enough() {
    for (recipe, family) in families() {
        let layout = family.layout();
        for (id, &code) in family.codes().iter().enumerate() {
            let (complexity, least) = complexity_and_least(recipe, layout, code);
            assert!(complexity >= least, "{} id {id}: {complexity}, at least {least}", recipe.name);
        }
    }
}

fn complexity_and_least(recipe: &Recipe, layout: &Layout, code: u64) -> (u32, u32) {
    let rectangles = || rectangle_count(layout.to_row_major(code), layout.bit_count().isqrt());
    match recipe.order {
        BitOrder::Rows => (rectangles(), recipe.complexity),
        BitOrder::Quadrants => (ising_energy(&layout.draw(code)), least_ising_energy(layout.area())),
    }
}

/// The search by which a family was made, in its plainest form: each candidate that is far enough from its own
/// rotations and from all codes before is kept, if it is complex enough.
fn greedy_search(recipe: &Recipe, layout: &Layout) -> Vec<u64> {
    let candidates = recipe.candidates(layout);
    let far = |left: u64, right: u64| (left ^ right).count_ones() >= recipe.distance;
    let mut codes: Vec<u64> = Vec::new();
    for number in 1..=1 << layout.bit_count() {
        let code = recipe.from_candidate(layout, candidates.code(number));
        let once = layout.rotate90(code);
        let twice = layout.rotate90(once);
        let turned = [code, once, twice, layout.rotate90(twice)];
        let is_far = turned[1..].iter().all(|&turned| far(code, turned))
            && codes.iter().all(|&kept| turned.iter().all(|&turned| far(kept, turned)));
        let (complexity, least) = if is_far { complexity_and_least(recipe, layout, code) } else { (0, 1) };
        if complexity >= least {
            codes.push(code);
        }
    }
    codes
}

#[test]
fn small_families_are_all_that_a_search_of_every_code_finds() {
    for name in ["tag16h5", "tagCircle21h7"] {
        let recipe = published::recipe(name).unwrap();
        let family = Family::published(name).unwrap();
        assert_eq!(greedy_search(recipe, family.layout()), family.codes(), "{name}");
    }
}

#[test]
fn codes_are_as_far_apart_as_the_family_says() {
    // Ten seconds of counting bits in all, most of it for three families: one thread each.
    std::thread::scope(|threads| {
        for (recipe, family) in families() {
            threads.spawn(move || {
                let measured = family.minimum_distance();
                assert_eq!(measured.overall(), recipe.distance, "{}: {measured:?}", recipe.name);
            });
        }
    });
}

#[test]
fn tables_equal_those_of_the_test_data() {
    let Some(folder) = std::env::var_os("TAGBUS_TEST_DATA").map(PathBuf::from) else {
        eprintln!(
            "SKIPPED: the tables were not compared, TAGBUS_TEST_DATA does not name the folder of test data"
        );
        return;
    };
    for name in NAMES {
        let table = read_table(&folder.join("families").join(format!("{name}.txt")));
        let family = Family::published(name).unwrap();
        // The table of tagStandard41h12 goes on where the released family was stopped.
        let released = if name == "tagStandard41h12" { 2115 } else { table.len() };
        assert!(family.codes() == &table[..released], "{name} differs from its table");
    }
}

fn read_table(path: &Path) -> Vec<u64> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
    lines.map(|line| u64::from_str_radix(line.trim(), 16).expect("a hexadecimal code")).collect()
}
