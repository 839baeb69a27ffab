//! Many jobs on all cores, their results in the order of the jobs.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Does `work` for the jobs 0 to `jobs` - 1 on `threads` threads. `deliver` gets each result on the
/// calling thread, in the order of the jobs and as soon as that is possible; when it breaks, no
/// further job is begun.
pub(super) fn in_order<R: Send>(
    jobs: usize,
    threads: usize,
    work: impl Fn(usize) -> R + Sync,
    mut deliver: impl FnMut(usize, R) -> ControlFlow<()>,
) {
    let next = AtomicUsize::new(0);
    let (sender, results) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..threads.clamp(1, jobs.max(1)) {
            let (next, work, sender) = (&next, &work, sender.clone());
            scope.spawn(move || {
                loop {
                    let job = next.fetch_add(1, Ordering::Relaxed);
                    // The receiver hangs up when nobody wants the results any more.
                    if job >= jobs || sender.send((job, work(job))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let mut waiting = BTreeMap::new();
        let mut due = 0;
        // By value: leaving the loop hangs up on the workers.
        for (job, result) in results {
            waiting.insert(job, result);
            while let Some(result) = waiting.remove(&due) {
                if deliver(due, result).is_break() {
                    next.store(jobs, Ordering::Relaxed);
                    return;
                }
                due += 1;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;

    #[test]
    fn results_come_in_the_order_of_the_jobs() {
        // Job 0 cannot end before job 1 has: both must be in work at once.
        let both = Barrier::new(2);
        let mut seen = Vec::new();
        in_order(
            20,
            4,
            |job| {
                if job < 2 {
                    both.wait();
                }
                job * job
            },
            |job, result| {
                seen.push((job, result));
                ControlFlow::Continue(())
            },
        );
        let wanted: Vec<_> = (0..20).map(|job| (job, job * job)).collect();
        assert_eq!(seen, wanted);
    }

    #[test]
    fn break_begins_no_further_job() {
        let begun = AtomicUsize::new(0);
        let mut delivered = 0;
        in_order(
            1_000_000,
            2,
            |_| begun.fetch_add(1, Ordering::Relaxed),
            |_, _| {
                delivered += 1;
                ControlFlow::Break(())
            },
        );
        assert_eq!(delivered, 1);
        assert!(begun.into_inner() < 1_000_000);
    }

    #[test]
    fn no_jobs_is_fine() {
        in_order(0, 8, |_| (), |_, ()| unreachable!("there is no job"));
    }
}
