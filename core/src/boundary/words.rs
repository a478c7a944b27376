//! Words of plugins that the framework keeps as constants: names of drawings, nouns of errors.

use std::collections::BTreeSet;
use std::sync::Mutex;

/// Words that are kept at most for the life of the program, and the longest of them.
const MOST_WORDS: usize = 4096;
const LONGEST_WORD: usize = 240;

/// A word of a plugin that lives as long as the program. Words are few (names of drawings, nouns of errors); a plugin
/// that makes up new ones for ever gets a placeholder.
pub(super) fn intern(word: &str) -> &'static str {
    static WORDS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut words = WORDS.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some(known) = words.get(word) {
        return known;
    }
    if words.len() >= MOST_WORDS || word.len() > LONGEST_WORD {
        return "(too many or too long words)";
    }
    let kept: &'static str = Box::leak(word.to_owned().into_boxed_str());
    words.insert(kept);
    kept
}
