//! Independent pieces of work on as many threads as the machine has.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Largest number of threads: beyond it memory, not arithmetic, sets the pace.
const MOST: usize = 16;

/// `work` of every task, results in the tasks' order.
///
/// Tasks are taken in order, so the dearest should come first. Each result depends on its task alone:
/// the number of threads never shows in a result. `worth` says whether threads pay at all.
pub(crate) fn each<T: Sync, R: Send>(tasks: &[T], worth: bool, work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = if worth { cores.min(tasks.len()).min(MOST) } else { 1 };
    if threads <= 1 {
        return tasks.iter().map(work).collect();
    }
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, R)>> = Mutex::new(Vec::with_capacity(tasks.len()));
    let run = || {
        let mut own = Vec::new();
        while let Some((i, task)) = take(&next, tasks) {
            own.push((i, work(task)));
        }
        // A poisoned lock means that a task panicked, which the scope below passes on.
        done.lock().unwrap_or_else(std::sync::PoisonError::into_inner).append(&mut own);
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(run);
        }
        run();
    });
    let mut done = done.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, result)| result).collect()
}

fn take<'a, T>(next: &AtomicUsize, tasks: &'a [T]) -> Option<(usize, &'a T)> {
    let i = next.fetch_add(1, Ordering::Relaxed);
    tasks.get(i).map(|task| (i, task))
}

#[cfg(test)]
mod tests {
    #[test]
    fn results_stand_in_the_order_of_the_tasks() {
        let tasks: Vec<u64> = (0..200).collect();
        let squares: Vec<u64> = tasks.iter().map(|i| i * i).collect();
        assert_eq!(super::each(&tasks, true, |i| i * i), squares);
        assert_eq!(super::each(&tasks, false, |i| i * i), squares);
        assert!(super::each(&[0_u8; 0], true, |i| *i).is_empty());
    }
}
