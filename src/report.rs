//! One HTML file that shows a whole run, works without a network, and can be read on a phone.

mod charts;
mod page;
mod tables;

pub use page::{document, html};
pub use tables::{Figure, figures};
