//! The engine alone: `cargo xtask bench`, or `cargo xtask bench NAME` for the benches whose name
//! contains NAME (`fit`, `near`, `surfaces`, …). Options are divan's, such as `--max-time 0.3`.
//!
//! One program for all of them: what they share is compiled and optimised once.

mod curves;
mod enclosure;
mod estimators;
mod filters;
mod fit;
mod gear;
mod gear_evaluation;
mod gear_files;
mod inference;
mod near;
mod recursive;
mod regularization;
mod study;
mod surfaces;

fn main() {
    divan::main();
}
