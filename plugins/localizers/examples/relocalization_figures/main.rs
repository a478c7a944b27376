//! Figures of global localization by landmarks.
//!
//! `cargo run --release -p rumbo-localizers --example relocalization_figures -- 300`: the published protocol, 300 trials a map.
//! With a word before the number: `growth [CELLS ...]` maps of up to 2000 x 2000 cells, `alike [STARTS]` rooms that look the
//! same, `hidden [STARTS]` things that hide half of the view.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout)]

mod alike;
mod growth;
mod hidden;
mod protocol;
#[path = "../../benches/relocalization_work/mod.rs"]
mod relocalization_work;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let Some((first, rest)) = words.split_first() else { return protocol::run(300, &[]) };
    let n_starts = || rest.first().map_or(100, |word| word.parse().expect("a number of starts"));
    match first.as_str() {
        "alike" => alike::run(n_starts()),
        "hidden" => hidden::run(n_starts()),
        "growth" => growth::run(rest),
        number => protocol::run(number.parse().expect("a number of trials, or a word"), rest),
    }
}
