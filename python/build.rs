//! Links the package small: functions that were compiled to the same instructions are one.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // LLVM's linker is that of Rust 1.90 and later on x86-64 Linux; elsewhere the default stays.
    let is = |name: &str, value: &str| std::env::var(name).is_ok_and(|found| found == value);
    if is("CARGO_CFG_TARGET_OS", "linux") && is("CARGO_CFG_TARGET_ARCH", "x86_64") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,--icf=all");
    }
}
