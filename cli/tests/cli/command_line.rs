//! Flags, the file, what is printed about families.

use std::fs;
use std::io::Read;
use std::process::Stdio;

use crate::support::{Folder, complained, json_lines, printed, tagbus};

#[test]
fn flags_lie_over_the_file_and_the_file_over_defaults() {
    let folder = Folder::new();
    let file = folder.file("t.toml");
    fs::write(&file, "decimate = 4\nids = [1, \"5-7\"]\nfamily = [\"36h11\", \"tag25h9\"]\nrate = 1")
        .unwrap();
    let path = file.to_str().unwrap();
    let error = complained(&mut tagbus(["service", "--config", path]), 2);
    assert!(error.contains("unknown key \"rate\", did you mean ") && error.contains(path), "{error}");
    fs::write(&file, "decimate = 4\nids = [1, \"5-7\"]\nfamily = [\"36h11\", \"tag25h9\"]\nframes = 3")
        .unwrap();
    let shown = printed(&mut tagbus(["service", "--config", path, "--hamming", "1", "--print-config"]), 0);
    for line in [
        "decimate = 4.0",
        "hamming = 1",
        "ids = \"1,5-7\"",
        "family = \"tag36h11,tag25h9\"",
        "camera = \"cam0\"",
    ] {
        assert!(shown.contains(line), "{line:?} is not in\n{shown}");
    }
    assert!(!shown.contains("frames") && shown.contains(path), "{shown}");
}

#[test]
fn the_file_of_the_user_is_found_and_what_is_printed_can_be_read_again() {
    let folder = Folder::new();
    fs::create_dir(folder.file("tagbus")).unwrap();
    fs::write(folder.file("tagbus/tagbus.toml"), "camera = \"left\"\nonce = true").unwrap();
    let shown = printed(tagbus(["run", "--print-config"]).env("XDG_CONFIG_HOME", &folder.0), 0);
    assert!(shown.contains("camera = \"left\"") && shown.contains("once = true"), "{shown}");
    fs::write(folder.file("again.toml"), &shown).unwrap();
    let again = printed(tagbus(["run", "--print-config", "--config"]).arg(folder.file("again.toml")), 0);
    assert_eq!(again.lines().skip(1).collect::<Vec<_>>(), shown.lines().skip(1).collect::<Vec<_>>());
    let looped = printed(tagbus(["run", "--print-config", "--loop"]).env("XDG_CONFIG_HOME", &folder.0), 0);
    assert!(looped.contains("once = false") && looped.contains("loop = true"), "{looped}");
}

#[test]
fn a_value_of_the_wrong_kind_is_refused_with_its_key() {
    let folder = Folder::new();
    let file = folder.file("t.toml");
    for (text, expected) in [
        ("repeat = \"often\"", "repeat"),
        ("family = \"tag36h12\"", "did you mean tag36h11?"),
        ("decimate = ", "t.toml"),
        ("level = \"sse9\"", "sse9"),
    ] {
        fs::write(&file, text).unwrap();
        let error = complained(tagbus(["detect", "x.png", "--config"]).arg(&file), 2);
        assert!(error.contains(expected) && error.contains("t.toml"), "{text}: {error}");
    }
}

#[test]
fn every_command_has_a_help_with_examples() {
    for command in [
        "run",
        "camera",
        "service",
        "watch",
        "control detector",
        "control camera",
        "detect",
        "family list",
        "family show",
        "family explain",
        "family import",
    ] {
        let help = printed(&mut tagbus(command.split(' ').chain(["--help"])), 0);
        assert!(help.contains("Examples:\n  tagbus "), "{command}: {help}");
        assert!(!help.contains("die-with-parent"), "{command}: {help}");
    }
}

#[test]
fn families_are_told_as_text_and_as_json() {
    let table = printed(&mut tagbus(["family", "list"]), 0);
    assert_eq!(table.lines().count(), 1 + 9 + 2 + 19);
    let families = json_lines(&printed(&mut tagbus(["family", "list", "--json"]), 0));
    let circle = families.iter().find(|family| family["name"] == "tagCircle49h12").unwrap();
    assert_eq!((circle["codes"].as_u64(), circle["tag_cells"].as_u64()), (Some(65_698), Some(5)));
    let shown = printed(&mut tagbus(["family", "show", "41h12"]), 0);
    assert!(shown.contains("a print of 100 mm has a tag size of 55.6 mm"), "{shown}");
    let tag = &json_lines(&printed(&mut tagbus(["family", "explain", "tag36h11", "0", "--json"]), 0))[0];
    assert_eq!(tag["cells"][1], "wbbbbbbbbw");
    assert_eq!(tag["rotations"].as_array().unwrap().len(), 3);
    let error = complained(&mut tagbus(["family", "explain", "tag36h11", "587"]), 2);
    assert!(error.contains("587 tags, ids 0 to 586"), "{error}");
    let error = complained(&mut tagbus(["family", "show", "tagStandart41h12"]), 2);
    assert!(error.contains("did you mean tagStandard41h12?"), "{error}");
}

#[test]
fn a_pipe_that_is_closed_is_a_clean_end_and_gets_no_colours() {
    let mut child = tagbus(["family", "explain", "36h11", "1"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut start = [0; 12];
    child.stdout.take().unwrap().read_exact(&mut start).unwrap();
    assert_eq!(&start, b"tag36h11 1\n\n");
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
