//! What plugins say to people: passed on to whoever the program named, and dropped where nobody listens.

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

pub(super) fn say(level: u32, target: String, message: String) {
    let level = match level {
        0 | super::super::abi::RUMBO_LOG_ERROR => LogLevel::Error,
        super::super::abi::RUMBO_LOG_WARN => LogLevel::Warn,
        super::super::abi::RUMBO_LOG_INFO => LogLevel::Info,
        _ => LogLevel::Debug,
    };
    let slot = LISTENER.read().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some(listener) = slot.as_ref() {
        listener(&PluginLog { level, target, message });
    }
}
