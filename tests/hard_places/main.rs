//! Drives of the search robot in hard places, against what the worlds know: rows of the specification's section 13.4 that need
//! the whole pipeline.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod leaning;
mod swaying;
mod watch;
