//! Room `cli` (under construction).
fn main() {}
