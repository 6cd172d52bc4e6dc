//! Proves the embedded tables of the published families: every property that made the search keep a code is measured
//! again here.

use std::path::{Path, PathBuf};
use tagbus_family::published::{FAMILIES, NAMES, Published};
use tagbus_family::{Family, Recipe};

fn families() -> impl Iterator<Item = (&'static Published, Recipe, Family)> {
    let whole = |published: &'static Published| {
        let recipe = published.recipe().expect("a published recipe is one");
        (published, recipe, Family::published(published.name).expect("its name is in the list"))
    };
    FAMILIES.iter().map(whole)
}

#[test]
fn each_family_has_its_number_of_codes() {
    for (published, recipe, family) in families() {
        assert_eq!(family.codes().len(), published.count, "{}", published.name);
        assert_eq!((family.name(), family.distance()), (published.name, recipe.distance()));
    }
}

#[test]
fn codes_come_in_the_order_in_which_they_were_searched() {
    for (published, recipe, family) in families() {
        let candidates = recipe.candidates();
        let number = |&code: &u64| candidates.number(recipe.to_candidate(code));
        let numbers: Vec<u64> = family.codes().iter().map(number).collect();
        assert!(numbers[0] >= 1, "{}", published.name);
        assert!(numbers.windows(2).all(|pair| pair[0] < pair[1]), "{}", published.name);
    }
}

#[test]
fn each_code_is_complex_enough() {
    for (published, recipe, family) in families() {
        for (id, &code) in family.codes().iter().enumerate() {
            assert!(recipe.rule().allows(recipe.layout(), code), "{} id {id}", published.name);
        }
    }
}

#[test]
fn codes_are_as_far_apart_as_the_family_says() {
    // Ten seconds of counting bits in all, most of it for three families: one thread each.
    std::thread::scope(|threads| {
        for (published, recipe, family) in families() {
            threads.spawn(move || {
                let measured = family.minimum_distance();
                assert_eq!(measured.overall(), recipe.distance(), "{}: {measured:?}", published.name);
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
