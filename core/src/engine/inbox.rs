//! A letter box for orders from outside while the engine runs.

use super::order::Order;
use std::sync::{Arc, Mutex, PoisonError};

/// Hands orders to a running engine from anywhere: another thread, a world that plays a recording. They are obeyed in
/// the step that comes next, or in the present one if it has not come to orders yet.
#[derive(Debug, Clone, Default)]
pub struct Inbox(Arc<Mutex<Vec<Order>>>);

impl Inbox {
    /// Puts in an order.
    pub fn put(&self, order: Order) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(order);
    }

    /// Takes out all orders, oldest first.
    pub(super) fn empty(&self) -> Vec<Order> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
