//! What plugins say to people: passed on to whoever the program named, and dropped where nobody listens.

use super::super::abi::{RUMBO_LOG_ERROR, RUMBO_LOG_INFO, RUMBO_LOG_WARN};
use super::super::export::log_to_host;
use std::sync::RwLock;

/// How much a message matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LogLevel {
    /// Something is wrong.
    Error,
    /// Something is odd.
    Warn,
    /// Worth knowing.
    Info,
    /// For the author.
    Debug,
}

impl std::fmt::Display for LogLevel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            LogLevel::Error => "error",
            LogLevel::Warn => "warning",
            LogLevel::Info => "info",
            LogLevel::Debug => "debug",
        })
    }
}

/// One message of a plugin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PluginLog {
    /// How much it matters.
    pub level: LogLevel,
    /// Who says it.
    pub target: String,
    /// What it says.
    pub message: String,
}

type Listener = Box<dyn Fn(&PluginLog) + Send + Sync>;
static LISTENER: RwLock<Option<Listener>> = RwLock::new(None);

/// From now on every message of a plugin goes to `listener`.
pub fn on_log(listener: impl Fn(&PluginLog) + Send + Sync + 'static) {
    let mut slot = LISTENER.write().unwrap_or_else(std::sync::PoisonError::into_inner);
    *slot = Some(Box::new(listener));
}

/// Says something to people, from a plugin of either tier: `target` is who says it.
pub fn log(level: LogLevel, target: &str, message: &str) {
    if !log_to_host(level as u32 + RUMBO_LOG_ERROR, target, message) {
        tell(&PluginLog { level, target: target.to_owned(), message: message.to_owned() });
    }
}

pub(super) fn say(level: u32, target: String, message: String) {
    let level = match level {
        0 | RUMBO_LOG_ERROR => LogLevel::Error,
        RUMBO_LOG_WARN => LogLevel::Warn,
        RUMBO_LOG_INFO => LogLevel::Info,
        _ => LogLevel::Debug,
    };
    tell(&PluginLog { level, target, message });
}

fn tell(log: &PluginLog) {
    let slot = LISTENER.read().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some(listener) = slot.as_ref() {
        listener(log);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    #[test]
    fn what_is_said_reaches_who_listens() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let ears = heard.clone();
        on_log(move |log| ears.lock().unwrap().push(format!("{} {} {}", log.target, log.level, log.message)));
        log(LogLevel::Warn, "gap", "the way is narrow");
        say(4, "gap".into(), "n = 3".into());
        say(9, "gap".into(), "of a later level".into());
        let expected = ["gap warning the way is narrow", "gap debug n = 3", "gap debug of a later level"];
        assert_eq!(*heard.lock().unwrap(), expected);
    }
}
