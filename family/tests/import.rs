//! Tables of other programs: what they hold comes out, and what is wrong with them is named with its line.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use tagbus_family::import::{self, Format, ImportError, Imported, Problem};
use tagbus_family::{Border, Family, Layout};

fn imported(text: &str) -> Imported {
    import::read(text, None, "nameless").unwrap_or_else(|error| panic!("{error} in\n{text}"))
}

fn refused(text: &str) -> ImportError {
    import::read(text, None, "nameless").unwrap_err()
}

/// The numbers that lie between `before` and `after`, one after the other.
fn listed<T>(items: &[T], item: impl Fn(usize, &T) -> String) -> String {
    items.iter().enumerate().map(|(place, it)| item(place, it)).collect()
}

/// A table as the AprilTag library has it, with the bits in the order of `bits`, which are places in ours.
fn c_table(family: &Family, order: &[usize]) -> String {
    let layout = family.layout();
    let last = layout.bit_count() as usize - 1;
    let theirs = |code: u64| order.iter().fold(0, |theirs, bit| theirs << 1 | code >> (last - bit) & 1);
    let places: Vec<[i32; 2]> = order.iter().map(|&bit| layout.bits()[bit]).collect();
    let (name, count) = (family.name(), family.codes().len());
    format!(
        "/* codedata[3] = {{ of a comment */\n#include \"{name}.h\"\nstatic uint64_t codedata[{count}] = {{\n{codes}}};\n\
         apriltag_family_t *{name}_create()\n{{\n   apriltag_family_t *tf = calloc(1, sizeof(apriltag_family_t));\n   \
         tf->name = strdup(\"{name}\");\n   tf->h = {h};\n   tf->ncodes = {count};\n   tf->codes = codedata;\n   tf->nbits = {bits};\n   \
         tf->bit_x = calloc({bits}, sizeof(uint32_t));\n   tf->bit_y = calloc({bits}, sizeof(uint32_t));\n{places}   \
         tf->width_at_border = {border};\n   tf->total_width = {total};\n   tf->reversed_border = {reversed};\n   return tf;\n}}\n",
        codes = listed(family.codes(), |_, &code| format!("   0x{:016x}UL,\n", theirs(code))),
        h = family.distance(),
        bits = layout.bit_count(),
        places = listed(&places, |bit, [x, y]| format!(
            "   tf->bit_x[{bit}] = {x};\n   tf->bit_y[{bit}] = {y};\n"
        )),
        border = layout.width_at_border(),
        total = layout.total_width(),
        reversed = layout.border() == Border::Reversed,
    )
}

fn our_order(family: &Family) -> Vec<usize> {
    (0..family.layout().bit_count() as usize).collect()
}

/// The published families whose distance is measured quickly.
fn small() -> Vec<Family> {
    let names = ["16h5", "25h9", "36h10", "36h11", "21h7", "41h12", "kalibr36h11", "DICT_7X7_50"];
    names.map(|name| Family::published(name).unwrap()).to_vec()
}

#[test]
fn c_tables_of_our_own_families_are_read_as_the_same_families() {
    for family in small() {
        let read = imported(&c_table(&family, &our_order(&family)));
        assert_eq!(read.format, Format::C);
        assert_eq!((read.stated_distance, read.guessed_cells), (Some(family.distance()), 0));
        assert_eq!(read.family, family, "{}", family.name());
    }
}

#[test]
fn the_hole_of_tag_custom48h12_is_known() {
    let whole = Family::published("tagCustom48h12").unwrap();
    let family = Family::new("few", whole.layout().clone(), whole.codes()[..40].to_vec(), 12).unwrap();
    let read = imported(&c_table(&family, &our_order(&family)));
    assert_eq!((read.family.layout(), read.family.codes()), (family.layout(), family.codes()));
}

#[test]
fn bits_in_another_order_are_put_into_ours() {
    for family in small() {
        let mut order = our_order(&family);
        order.reverse();
        order.swap(1, 9);
        let table = c_table(&family, &order);
        assert_ne!(table, c_table(&family, &our_order(&family)));
        assert_eq!(imported(&table).family, family, "{}", family.name());
    }
}

#[test]
fn c_is_read_however_it_is_written() {
    let written = "uint64_t my_codes[ 2 ]={UINT64_C( 0x0001 ),/* 0x5, */\r\n(uint64_t)0B11ull // }\r\n};\
                   uint32_t bit_x[4] = { 1, 2, 2, 1 }, bit_y[4] = {1,1,2,2,};\
                   f.name=strdup ( \"odd\" ) ; f . total_width\n= 6; f->width_at_border = (uint8_t) 4; f.nbits = 4;";
    let read = imported(written);
    assert_eq!(read.family, Family::new("odd", Layout::classic(6).unwrap(), vec![1, 3], 1).unwrap());
    assert_eq!(read.stated_distance, None);
}

#[test]
fn places_before_the_border_are_read_as_negative_also_when_they_are_written_as_unsigned() {
    let family = Family::published("21h7").unwrap();
    let table = c_table(&family, &our_order(&family));
    let unsigned = table.replace("= -2;", "= 4294967294;").replace("= -1;", "= 4294967295u;");
    assert_ne!(table, unsigned);
    assert_eq!(imported(&unsigned).family, family);
}

#[test]
fn tables_of_apriltag_2_are_read_with_borders_of_one_and_two_cells() {
    let ours = Family::published("36h11").unwrap();
    for (border, expected) in [(1, "36h11"), (2, "kalibr36h11")] {
        let rows =
            |id, &code: &u64| format!("tf->codes[{id}] = 0x{:x}UL;\n", ours.layout().to_row_major(code));
        let codes = listed(ours.codes(), rows);
        let head = "apriltag_family_t *tf;\ntf->name = strdup(\"tag36h11\");\ntf->d = 6;\ntf->h = 11;\ntf->ncodes = 587;\n";
        let table = format!(
            "{head}tf->black_border = {border};\ntf->codes = calloc(587, sizeof(uint64_t));\n{codes}"
        );
        let expected = Family::published(expected).unwrap();
        let read = imported(&table).family;
        assert_eq!(
            (read.layout(), read.codes(), read.name()),
            (expected.layout(), expected.codes(), "tag36h11")
        );
    }
}

#[test]
fn java_classes_of_the_old_generator_are_read_with_their_rows_turned_into_our_order() {
    let family = Family::published("tag16h5").unwrap();
    let codes = listed(family.codes(), |_, &code| format!("0x{:04x}L, ", family.layout().to_row_major(code)));
    assert!(codes.starts_with("0x231bL, 0x2ea5L, 0x346aL"), "{codes}");
    let class = format!(
        "package april.tag;\n/** Tag family with 30 distinct codes. **/\npublic class Tag16h5 extends TagFamily\n{{\n\tpublic Tag16h5()\n\t\
         {{\n\t\tsuper(16, 5, new long[] {{ {codes} }});\n\t}}\n}}\n"
    );
    let read = imported(&class);
    assert_eq!((read.format, read.stated_distance), (Format::Java, Some(5)));
    assert_eq!(read.family, family);
}

/// A class of the newer generator, its codes in two parts.
fn java_of_letters(family: &Family) -> String {
    let code = |_, code: &u64| format!("0x{code:x}L, ");
    let (first, second) = family.codes().split_at(20);
    format!(
        "public class TagCircle21h7 extends TagFamily\n{{\n\
         private static class ConstructCodes0 {{ private static long[] constructCodes() {{\nreturn new long[] {{ {} }}; }} }}\n\
         private static class ConstructCodes1 {{ private static long[] constructCodes() {{\nreturn new long[] {{ {} }}; }} }}\n\
         private static long[] constructCodes() {{\nlong[] codes = new long[{}];\n\
         System.arraycopy(ConstructCodes0.constructCodes(), 0, codes, 0, 20);\nreturn codes; }}\n\
         public TagCircle21h7() {{\nsuper(ImageLayout.Factory.createFromString(\"Circle\", \"{}\"), 7, constructCodes()); }}\n}}",
        listed(first, code),
        listed(second, code),
        family.codes().len(),
        family.layout().text(),
    )
}

#[test]
fn java_classes_of_the_newer_generator_are_read_with_their_layout() {
    let family = Family::published("tagCircle21h7").unwrap();
    let read = imported(&java_of_letters(&family));
    assert_eq!(read.family, family);
    assert_eq!((read.format, read.stated_distance, read.guessed_cells), (Format::Java, Some(7), 0));
}

/// A dictionary as OpenCV writes it, in YAML or, with quotes around the keys, in JSON.
fn dictionary(family: &Family, quote: &str) -> String {
    let layout = family.layout();
    let bits = layout.bit_count() as usize;
    let row =
        |id, &code: &u64| format!("{quote}marker_{id}{quote}: \"{:0bits$b}\",\n", layout.to_row_major(code));
    let width = layout.width_at_border() - 2;
    let head = ["nmarkers", "markersize", "maxCorrectionBits"];
    let values = [family.codes().len(), width, 1];
    let head: String =
        head.iter().zip(values).map(|(key, value)| format!("{quote}{key}{quote}: {value},\n")).collect();
    format!("%YAML:1.0\n---\n{head}{}", listed(family.codes(), row))
}

#[test]
fn dictionaries_of_opencv_are_read_from_yaml_and_from_json() {
    for name in ["DICT_4X4_50", "DICT_5X5_100", "DICT_ARUCO_MIP_36h12", "DICT_7X7_50"] {
        let family = Family::published(name).unwrap();
        for quote in ["", "\""] {
            let read = import::read(&dictionary(&family, quote), None, name).unwrap();
            assert_eq!(read.family, family);
            assert_eq!((read.format, read.stated_distance), (Format::OpenCv, Some(3)));
        }
    }
}

#[test]
fn a_marker_is_read_row_after_row_with_1_for_white() {
    let text =
        "%YAML:1.0\n---\nnmarkers: 1\nmarkersize: 4\nmaxCorrectionBits: 0\nmarker_0: \"1011010100110010\"\n";
    let read = imported(text).family;
    assert_eq!((read.name(), read.grid(0)), ("nameless", Family::published("4x4_50").unwrap().grid(0)));
}

#[test]
fn distances_are_measured_whatever_the_table_states() {
    let text = "nmarkers: 2\nmarkersize: 2\nmaxCorrectionBits: 2\nmarker_0: \"1000\"\nmarker_1: \"1100\"\n";
    let read = imported(text);
    assert_eq!((read.stated_distance, read.family.distance()), (Some(5), 1));
    let family = Family::published("36h11").unwrap();
    let table = c_table(&family, &our_order(&family)).replace("tf->h = 11", "tf->h = 12");
    let read = imported(&table);
    assert_eq!((read.stated_distance, read.family), (Some(12), family));
}

#[test]
fn tags_that_look_the_same_after_a_turn_are_refused() {
    for same in ["1111", "1001"] {
        let text = format!("nmarkers: 2\nmarkersize: 2\nmarker_0: \"1000\"\nmarker_1: \"{same}\"\n");
        let refused = refused(&text);
        assert!(
            refused.line == 4 && matches!(refused.problem, Problem::Symmetric { id: 1, .. }),
            "{refused}"
        );
    }
}

fn nth_line(text: &str, part: &str) -> usize {
    1 + text.lines().position(|line| line.contains(part)).unwrap_or_else(|| panic!("no {part} in {text}"))
}

#[test]
fn what_is_wrong_with_a_c_table_is_named_with_its_line() {
    let family = Family::published("16h5").unwrap();
    let table = c_table(&family, &our_order(&family));
    let third = format!("0x{:016x}UL", family.codes()[2]);
    let line = nth_line(&table, &third);
    let changed = |from: &str, to: &str| {
        let changed = table.replacen(from, to, 1);
        assert_ne!(changed, table, "{from}");
        refused(&changed)
    };
    let problem = |from, to| changed(from, to).problem;
    assert_eq!(
        changed(&third, "0x10001"),
        ImportError { line, problem: Problem::CodeTooWide { id: 2, code: 0x1_0001, bit_count: 16 } }
    );
    let turned = family.layout().rotate90(family.codes()[0]);
    assert_eq!(
        changed(&third, &turned.to_string()),
        ImportError { line, problem: Problem::SameTag { first: 0, first_line: line - 2, second: 2 } }
    );
    assert_eq!(changed(&third, "oops").line, line);
    let few = changed("[30]", "[31]");
    assert_eq!(few, ImportError { line: 3, problem: Problem::CodeCount { stated: 31, found: 30 } });
    assert_eq!(problem("ncodes = 30", "ncodes = 29"), Problem::CodeCount { stated: 29, found: 30 });
    assert!(matches!(problem("bit_x[7]", "bit_x[8]"), Problem::Unexpected { .. }));
    assert!(matches!(problem("nbits = 16", "nbits = 17"), Problem::Unexpected { .. }));
    assert!(matches!(problem("bit_y[7] = ", "bit_y[7] = -"), Problem::BitPlace { bit: 7, .. }));
    assert!(matches!(problem("total_width = 8", "total_width = 9"), Problem::Number { .. }));
    assert!(matches!(problem("total_width = 8", "total_width = 4000000000"), Problem::Number { .. }));
    assert_eq!(problem("total_width", "width"), Problem::Missing { what: "total_width" });
    let shown = few.to_string();
    assert!(shown.contains("line 3: the table says that it has 31 codes, but 30 are there"), "{shown}");
}

#[test]
fn what_is_wrong_with_a_dictionary_is_named_with_its_line() {
    let table = dictionary(&Family::published("4x4_50").unwrap(), "");
    let changed = |from: &str, to: &str| refused(&table.replacen(from, to, 1));
    let marker = ImportError { line: 6, problem: Problem::Marker { id: 0, bit_count: 16 } };
    assert_eq!(changed("1011010100110010", "101101010011001"), marker);
    assert_eq!(changed("1011010100110010", "1011010100110012"), marker);
    assert_eq!(changed("marker_7:", "marker_50:").line, 13);
    assert_eq!(changed("marker_7:", "marker_8:").line, 14);
    assert_eq!(changed("markersize: 4", "markersize: 9").line, 4);
    assert_eq!(changed("nmarkers: 50", "nmarkers: 51").problem, Problem::CodeCount { stated: 51, found: 50 });
    assert_eq!(changed("nmarkers: 50", "nmarkers: 99999999999").line, 3);
    assert_eq!(changed("nmarkers", "markers").problem, Problem::Missing { what: "nmarkers" });
    let twice = changed("0000111110011010", "1011010100110010");
    assert_eq!(
        twice,
        ImportError { line: 7, problem: Problem::SameTag { first: 0, first_line: 6, second: 1 } }
    );
}

#[test]
fn what_is_wrong_with_a_java_class_is_named_with_its_line() {
    let class = java_of_letters(&Family::published("21h7").unwrap());
    let changed = |from: &str, to: &str| refused(&class.replacen(from, to, 1));
    assert_eq!(
        changed("new long[38]", "new long[39]"),
        ImportError { line: 8, problem: Problem::CodeCount { stated: 39, found: 38 } }
    );
    let layout = changed("\"xxxddd", "\"wxxddd");
    assert!(layout.line == 12 && matches!(layout.problem, Problem::Layout(_)), "{layout}");
    assert_eq!(changed("0x", "0xf000").line, 4);
    assert!(matches!(changed("super", "supper").problem, Problem::Missing { .. }));
    assert!(matches!(changed("), 7, c", "), c").problem, Problem::Unexpected { .. }));
    let bits = refused("class A extends TagFamily { A() {\nsuper(17, 5, new long[] { 1L }); } }");
    assert!(bits.line == 2 && matches!(bits.problem, Problem::Number { .. }), "{bits}");
}

#[test]
fn tables_that_are_cut_anywhere_are_refused_and_never_read_as_smaller_families() {
    let family = Family::published("25h9").unwrap();
    let circle = Family::published("21h7").unwrap();
    let dictionary = dictionary(&Family::published("4x4_50").unwrap(), "");
    for table in [c_table(&family, &our_order(&family)), java_of_letters(&circle), dictionary] {
        let whole = imported(&table).family;
        for end in 0..table.trim_end().len() {
            match import::read(&table[..end], None, "nameless") {
                Ok(read) => assert_eq!(read.family, whole, "cut at {end}: {}", &table[..end]),
                Err(error) => assert!(error.line <= 1 + table[..end].matches('\n').count(), "{error}"),
            }
        }
    }
}

#[test]
fn what_is_no_table_is_told_which_there_are() {
    for text in ["", "\n", "hello", "\u{feff}", "{}", "[1, 2]"] {
        assert_eq!(refused(text), ImportError { line: 1, problem: Problem::UnknownFormat });
    }
    for format in [Format::C, Format::Java, Format::OpenCv] {
        for text in [
            "",
            "\"",
            "/*",
            "{",
            "tf->h = ",
            "bit_x[",
            "super(",
            "super(1,2,3",
            "new long[] {",
            "marker_:",
            "marker_0",
        ] {
            assert!(import::read(text, Some(format), "nameless").is_err(), "{format:?} {text:?}");
        }
    }
    assert!(refused("hello").to_string().contains("a dictionary of OpenCV in YAML"));
}
