//! `tagbus family generate`: what it makes is used, interruptions lose nothing, and what cannot be made is refused.

use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::thread;
use std::time::{Duration, SystemTime};

use rustix::process::{Pid, Signal, kill_process};
use tagbus_family::Family;
use tagbus_family::file::FamilyFile;

use crate::families_of_others::{only_tag, picture_of};
use crate::support::{Folder, Watchdog, complained, printed, tagbus};

pub(crate) fn generate(arguments: &[&str], output: &Path) -> Command {
    let mut command = tagbus(["family", "generate"]);
    command.args(arguments).arg("--output").arg(output);
    command
}

pub(crate) fn family_of(file: &Path) -> FamilyFile {
    FamilyFile::parse(&fs::read_to_string(file).unwrap()).unwrap()
}

#[test]
fn families_of_named_shapes_are_made_and_their_tags_found_without_a_new_build() {
    let _watchdog = Watchdog::of_seconds(300, "generating layouts");
    let folder = Folder::new();
    let (output, picture) = (folder.file("mine.toml"), folder.file("tag.png"));
    for (layout, distance) in [("classic:9", "9"), ("standard:7", "5"), ("circle:9", "7")] {
        let flags = [
            "--layout",
            layout,
            "--distance",
            distance,
            "--codes",
            "12",
            "--candidates",
            "3000000",
            "--force",
        ];
        let told = printed(&mut generate(&flags, &output), 0);
        assert!(told.contains("tags:"), "{told}");
        let file = family_of(&output);
        assert!(file.family.codes().len() > 2, "{layout}: {told}");
        let id = file.family.codes().len() as u32 - 1;
        println!("{layout}, id {id}");
        picture_of(&file.family, id, &picture);
        let tag = only_tag(output.to_str().unwrap(), &picture);
        assert_eq!(
            (tag["family"].as_str(), tag["id"].as_u64()),
            (Some("mine"), Some(u64::from(id))),
            "{layout}"
        );
    }
}

#[test]
fn published_families_are_made_again() {
    let folder = Folder::new();
    let output = folder.file("again.toml");
    for name in ["16h5", "21h7"] {
        let told = printed(&mut generate(&["--published", name, "--force"], &output), 0);
        assert!(told.contains("exactly the published") && told.contains("which are all"), "{told}");
        assert!(family_of(&output).complete);
    }
}

#[test]
fn the_first_codes_of_all_published_families_are_made_again_in_a_table() {
    let _watchdog = Watchdog::of_seconds(300, "all published families");
    let all = |flags: &[&str]| {
        let mut command = tagbus(["family", "generate", "--published", "all"]);
        command.args(flags);
        command
    };
    let told = printed(&mut all(&["--codes", "25"]), 0);
    let rows: Vec<&str> = told.lines().skip(2).collect();
    assert_eq!(rows.len(), Family::PUBLISHED.len(), "{told}");
    for (row, name) in rows.iter().zip(Family::PUBLISHED) {
        let count = Family::published(name).unwrap().codes().len();
        let columns: Vec<&str> = row.split_whitespace().collect();
        assert_eq!(columns[..3], [name, "25", &count.to_string()], "{told}");
        assert!(row.ends_with(&format!("exactly the first 25 of the published {count} codes")), "{row}");
    }
    for flag in ["--output", "--resume"] {
        let complaint = complained(&mut all(&[flag, "a.toml"]), 2);
        assert!(complaint.contains(flag) && complaint.contains("one family"), "{complaint}");
    }
}

#[test]
fn a_search_is_not_lost_when_nobody_reads_what_it_tells() {
    let folder = Folder::new();
    let output = folder.file("mine.toml");
    let mut child = generate(&["--layout", "classic:8", "--distance", "5"], &output)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
    assert!(family_of(&output).complete);
}

/// A search of some seconds.
const SLOW: [&str; 8] =
    ["--layout", "standard:8", "--distance", "9", "--threads", "1", "--level", "portable"];

fn start_slowly(output: &Path, state: &Path) -> Child {
    generate(&SLOW, output)
        .arg("--force")
        .arg("--resume")
        .arg(state)
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap()
}

fn modified(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|file| file.modified()).ok()
}

/// Waits until the state is written anew; false when the search ended before.
fn wait_for_state(child: &mut Child, state: &Path, before: Option<SystemTime>) -> bool {
    while modified(state) == before {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        thread::sleep(Duration::from_millis(5));
    }
    true
}

#[test]
fn a_search_that_is_killed_goes_on_and_finds_the_same() {
    let _watchdog = Watchdog::of_seconds(600, "killing a search");
    let folder = Folder::new();
    let (whole, pieced, state) =
        (folder.file("whole.toml"), folder.file("pieced.toml"), folder.file("state"));
    printed(&mut generate(&SLOW[..4], &whole), 0);
    let mut kills = 0;
    loop {
        let before = modified(&state);
        let mut child = start_slowly(&pieced, &state);
        let is_saved = wait_for_state(&mut child, &state, before);
        if is_saved && kills < 3 {
            child.kill().unwrap();
            kills += 1;
            child.wait().unwrap();
        } else {
            assert!(child.wait().unwrap().success());
            break;
        }
    }
    assert!(kills > 0, "the search was never killed");
    assert_eq!(family_of(&pieced).family.codes(), family_of(&whole).family.codes());
    assert!(family_of(&pieced).complete);
}

#[test]
fn ctrl_c_writes_what_there_is() {
    let _watchdog = Watchdog::of_seconds(300, "interrupting a search");
    let folder = Folder::new();
    let (output, state) = (folder.file("some.toml"), folder.file("state"));
    // A search of days: it cannot end by itself.
    let mut endless = generate(&["--layout", "standard:10", "--distance", "13"], &output);
    let mut child = endless.arg("--resume").arg(&state).stdout(std::process::Stdio::null()).spawn().unwrap();
    assert!(wait_for_state(&mut child, &state, None), "the search ended at once");
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    assert!(child.wait().unwrap().success());
    let some = family_of(&output);
    assert!(!some.complete && !some.family.codes().is_empty());
    let recipe = some.recipe.unwrap();
    assert!(some.decided.unwrap() < recipe.candidate_count());
}

#[test]
fn what_cannot_be_made_is_refused_with_what_is_wrong_and_where() {
    let folder = Folder::new();
    let output = folder.file("mine.toml");
    let sixty_eight = "d".repeat(64) + "dddd";
    let too_many = "classic:13".to_owned();
    let long_name = "n".repeat(33);
    let cases: [(&[&str], &str); 13] = [
        (&["--layout", "classic:8", "--distance", "5", "--name", &long_name], "33 bytes"),
        (&["--layout", "wwwwww wbbbbw wbddbw wbdwbw wbbbbw wwwwww", "--distance", "3"], "falls on cell"),
        (&["--layout", "dddd dwwd dwwd dddd", "--distance", "3"], "ring"),
        (&["--layout", "wwwwww wbbbbw wbddbw", "--distance", "3"], "18"),
        (&["--layout", &sixty_eight, "--distance", "3"], "68"),
        (&["--layout", "wwwwww wbbbbw wbdqbw wbddbw wbbbbw wwwwww", "--distance", "3"], "'q'"),
        (&["--layout", &too_many, "--distance", "3"], "64"),
        (&["--layout", "classic:8", "--distance", "11"], "ask for 1 to 10"),
        (&["--layout", "classic:8", "--distance", "0"], "ask for 1 to 10"),
        (&["--layout", "classic:8"], "--distance"),
        (&["--distance", "5"], "--layout"),
        (&["--layout", "classic:8", "--distance", "5", "--metric", "area"], "ising, rectangles"),
        (&["--layout", "classic:8", "--distance", "5", "--threshold", "200"], "0.00 % are complex enough"),
    ];
    for (arguments, expected) in cases {
        let complaint = complained(&mut generate(arguments, &output), 2);
        assert!(complaint.contains(expected), "{arguments:?}: {complaint}");
        assert!(!output.exists(), "{arguments:?} left a file");
    }
    fs::write(&output, "precious").unwrap();
    let complaint = complained(&mut generate(&["--layout", "classic:8", "--distance", "5"], &output), 2);
    assert!(complaint.contains("mine.toml exists"), "{complaint}");
    assert_eq!(fs::read_to_string(&output).unwrap(), "precious");
}

#[test]
fn a_state_of_another_recipe_or_a_damaged_one_is_refused() {
    let folder = Folder::new();
    let (output, state) = (folder.file("mine.toml"), folder.file("state"));
    let resume = |distance: &str| {
        let mut command = generate(&["--layout", "classic:8", "--distance", distance, "--force"], &output);
        command.arg("--resume").arg(&state);
        command
    };
    printed(&mut resume("5"), 0);
    let complaint = complained(&mut resume("6"), 2);
    assert!(complaint.contains("its distance is 5, but 6 is asked for"), "{complaint}");
    let text = fs::read_to_string(&state).unwrap();
    fs::write(&state, &text[..text.len() / 2]).unwrap();
    let complaint = complained(&mut resume("5"), 2);
    assert!(complaint.contains("line 1 column"), "{complaint}");
    assert_eq!(fs::read_to_string(&state).unwrap(), text[..text.len() / 2], "the file was touched");
}
