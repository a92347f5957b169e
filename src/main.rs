//! Parses, calls the library, prints the error.
fn main() {}
