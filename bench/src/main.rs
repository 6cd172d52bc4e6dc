//! Room `bench` (under construction).
fn main() {}
