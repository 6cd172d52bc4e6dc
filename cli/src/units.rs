//! Numbers as a person reads them.

/// A time with three digits that count: `12 us`, `1.23 ms`.
pub(crate) fn time(us: f64) -> String {
    match us.abs() {
        size if size < 1e3 => format!("{us:.0} us"),
        size if size < 1e4 => format!("{:.2} ms", us / 1e3),
        size if size < 1e6 => format!("{:.1} ms", us / 1e3),
        _ => format!("{:.1} s", us / 1e6),
    }
}

/// An amount of memory, in powers of ten: `9.2 MB`.
pub(crate) fn bytes(bytes: u64) -> String {
    match bytes as f64 {
        size if size < 1e3 => format!("{size:.0} B"),
        size if size < 1e6 => format!("{:.1} kB", size / 1e3),
        size if size < 1e9 => format!("{:.1} MB", size / 1e6),
        size => format!("{:.1} GB", size / 1e9),
    }
}

/// A number of things with its noun: `1 message`, `2 messages`.
pub(crate) fn of(count: u64, noun: &str) -> String {
    if count == 1 { format!("{count} {noun}") } else { format!("{count} {noun}s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_memory_are_told_in_the_unit_that_fits() {
        let told = [0.4, 12.6, 1_234.0, 98_765.0, 2_500_000.0, -3.0].map(time);
        assert_eq!(told, ["0 us", "13 us", "1.23 ms", "98.8 ms", "2.5 s", "-3 us"]);
        let told = [0, 999, 9_216_000, 3_200_000_000].map(bytes);
        assert_eq!(told, ["0 B", "999 B", "9.2 MB", "3.2 GB"]);
        assert_eq!((of(1, "camera"), of(0, "camera")), ("1 camera".to_owned(), "0 cameras".to_owned()));
    }
}
