//! Figures as a table, and as files that are kept.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::Path;
use std::time::SystemTime;

use crate::compare::Row;
use crate::machine;

/// A Markdown table; the last column says how many times the median of the first detector the others take.
pub(crate) fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| picture | size | decimation | detector | tags | CPU min ms | CPU median ms | times ours |\n|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let ratio =
            ours(rows, row).map_or_else(String::new, |ours| format!("{:.1}", row.median_us / ours.median_us));
        let Row { picture, size: [width, height], factor, peer, found, min_us, median_us } = row;
        let (min, median) = (min_us / 1e3, median_us / 1e3);
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| {picture} | {width}x{height} | {factor} | {peer} | {found} | {min:.3} | {median:.3} | {ratio} |"
        );
    }
    text + &summary(rows)
}

/// Our row of the same picture and decimation, for rows of others.
fn ours<'a>(rows: &'a [Row], other: &Row) -> Option<&'a Row> {
    let first = rows.first()?;
    let same =
        |row: &&Row| row.peer == first.peer && row.picture == other.picture && row.factor == other.factor;
    rows.iter().find(same).filter(|ours| ours.peer != other.peer)
}

/// The smallest and the median ratio over all rows of others.
fn summary(rows: &[Row]) -> String {
    let mut ratios: Vec<f64> =
        rows.iter().filter_map(|row| ours(rows, row).map(|ours| row.median_us / ours.median_us)).collect();
    ratios.sort_by(f64::total_cmp);
    match (ratios.first(), ratios.get(ratios.len() / 2)) {
        (Some(least), Some(middle)) => {
            format!(
                "\nOver all rows the others take {least:.1} (least) and {middle:.1} (median) times our CPU time.\n"
            )
        }
        _ => "\nNo peers in this build: add `--features peers`.\n".to_owned(),
    }
}

/// Writes the table of `rows` as a page, and the same figures as CSV beside it.
pub(crate) fn write(path: &Path, rows: &[Row], rounds: usize) -> io::Result<()> {
    let how =
        format!("detectors interleaved, one thread pinned to one core, {rounds} rounds after one warm-up");
    write_page(path, "CPU time per picture", &how, &table(rows))?;
    fs::write(path.with_extension("csv"), csv(rows))
}

/// Writes a page: title, date, how and on what was measured, the table.
pub(crate) fn write_page(path: &Path, title: &str, how: &str, table: &str) -> io::Result<()> {
    let date = humantime::format_rfc3339_seconds(SystemTime::now());
    let version = env!("CARGO_PKG_VERSION");
    let facts: String = machine::facts().into_iter().map(|fact| format!("* {fact}\n")).collect();
    fs::write(path, format!("# {title}\n\n* date: {date}\n* tagbus {version}: {how}\n{facts}\n{table}"))
}

fn csv(rows: &[Row]) -> String {
    let mut text = String::from("picture,width,height,decimation,detector,tags,cpu_min_us,cpu_median_us\n");
    for Row { picture, size: [width, height], factor, peer, found, min_us, median_us } in rows {
        // Writing to a String cannot fail.
        let _ =
            writeln!(text, "{picture},{width},{height},{factor},{peer},{found},{min_us:.1},{median_us:.1}");
    }
    text
}
