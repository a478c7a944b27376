//! The request to stop working on something that nobody waits for any more.

use crate::boundary::export::HostFlag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that long computations look at: raised once, never lowered.
#[doc(alias = "cancellation token")]
#[derive(Debug, Clone, Default)]
pub struct GiveUp {
    own: Arc<AtomicBool>,
    parent: Option<Arc<AtomicBool>>,
    host: Option<Arc<HostFlag>>,
}

impl GiveUp {
    /// A flag that is also raised when this one is.
    pub fn child(&self) -> GiveUp {
        GiveUp { own: Arc::default(), parent: Some(self.own.clone()), host: self.host.clone() }
    }

    /// A flag that is also raised when that of the program is, which loaded this plugin.
    pub(crate) fn of_host(flag: Arc<HostFlag>) -> GiveUp {
        GiveUp { host: Some(flag), ..GiveUp::default() }
    }

    /// Asks to stop.
    pub fn raise(&self) {
        self.own.store(true, Ordering::Relaxed);
    }

    /// Somebody asked to stop.
    pub fn is_raised(&self) -> bool {
        let raised = |flag: &Arc<AtomicBool>| flag.load(Ordering::Relaxed);
        raised(&self.own)
            || self.parent.as_ref().is_some_and(raised)
            || self.host.as_ref().is_some_and(|flag| flag.is_raised())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_child_hears_its_parent_but_not_the_other_way_round() {
        let parent = GiveUp::default();
        let (a, b) = (parent.child(), parent.child());
        a.raise();
        assert!(a.is_raised() && !b.is_raised() && !parent.is_raised());
        parent.raise();
        assert!(b.is_raised());
    }
}
