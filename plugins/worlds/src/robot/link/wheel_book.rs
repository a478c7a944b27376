//! How far the wheels have rolled since this program runs, though the base may be started anew in between.

use rumbo_core::stages::WheelMotion;

/// Adds up what the wheels rolled from one start of the base to the next.
#[derive(Debug, Default)]
pub(super) struct WheelBook {
    boot: Option<u32>,
    /// Up to the last start of the base.
    before: WheelMotion,
    /// The newest sum.
    total: WheelMotion,
}

impl WheelBook {
    /// A session with the base as it was started under this number.
    pub fn begin(&mut self, boot: u32) {
        if self.boot.replace(boot).is_some_and(|last| last != boot) {
            self.before = self.total;
        }
    }

    /// The sum, with what was counted since the base was started.
    pub fn add_up(&mut self, counted: &WheelMotion) -> WheelMotion {
        let mut total = *counted;
        for (sum_m, before_m) in total.rolled_m.iter_mut().zip(self.before.rolled_m) {
            *sum_m += before_m;
        }
        total.turned_rad += self.before.turned_rad;
        self.total = total;
        total
    }
}
