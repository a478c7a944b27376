//! Work on several threads, results in order.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;

/// Works on all items with `n_threads` threads; `show` gets the results in the order of the items, as soon as it can.
pub fn in_order<I: Sync, T: Send>(
    items: &[I],
    n_threads: usize,
    work: impl Fn(&I) -> T + Sync,
    mut show: impl FnMut(T),
) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = channel();
    std::thread::scope(|scope| {
        for _ in 0..n_threads.min(items.len()) {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                while let Some((idx, item)) = {
                    let idx = next.fetch_add(1, Ordering::Relaxed);
                    items.get(idx).map(|item| (idx, item))
                } {
                    // Nobody listens only after the receiver was dropped, which ends the program anyway.
                    let _ = sender.send((idx, work(item)));
                }
            });
        }
        drop(sender);
        let mut early = BTreeMap::new();
        let mut due = 0;
        for (idx, result) in receiver {
            early.insert(idx, result);
            while let Some(result) = early.remove(&due) {
                show(result);
                due += 1;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_for_any_number_of_threads() {
        let items: Vec<usize> = (0..50).collect();
        for n_threads in [1, 2, 8] {
            let mut seen = Vec::new();
            let slow_first = |item: &usize| {
                (0..(50 - item) * 100).for_each(|k| {
                    std::hint::black_box(k);
                });
                item * 2
            };
            in_order(&items, n_threads, slow_first, |result| seen.push(result));
            assert_eq!(seen, items.iter().map(|item| item * 2).collect::<Vec<_>>());
        }
        in_order(&[] as &[usize], 2, |item| *item, |_| panic!("nothing to show"));
    }
}
