//! Work on all cores.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use gtfdi::plant::{PlantParameters, Run, Scenario, lanes_at_once, simulate_batch};
use rayon::prelude::*;

use crate::error::{CampaignError, During as _};

/// What `make` makes of each of `items`, in order. After a failure nothing behind it is begun, and the
/// error is that of the first item that fails, however many cores there are.
///
/// # Errors
/// As `make`.
pub(crate) fn map<T: Sync, R: Send, E: Send>(
    items: &[T],
    make: impl Fn(&T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let failed = AtomicUsize::new(usize::MAX);
    let made: Vec<Mutex<Option<Result<R, E>>>> = items.iter().map(|_| Mutex::default()).collect();
    for_each(items.len(), &|index| {
        if index < failed.load(Ordering::Relaxed) {
            let result = make(&items[index]);
            if result.is_err() {
                failed.fetch_min(index, Ordering::Relaxed);
            }
            *made[index].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
        }
    });
    let made = made.into_iter().map(Mutex::into_inner);
    made.filter_map(|slot| slot.unwrap_or_else(PoisonError::into_inner))
        .collect()
}

/// Simulates `scenarios`, as many side by side as there are lanes, and gives what `take` makes of the
/// place and the run of each, in order; no more runs are held than are being worked on. `what` names
/// a run by its place.
///
/// # Errors
/// [`CampaignError`] when a run leaves the plant's validity, and as `take`.
pub(crate) fn simulate<T: Send>(
    plant: &PlantParameters,
    scenarios: &[Scenario],
    what: impl Fn(usize) -> String + Sync,
    take: impl Fn(usize, Run) -> Result<T, CampaignError> + Sync,
) -> Result<Vec<T>, CampaignError> {
    let lanes = lanes_at_once();
    let firsts: Vec<usize> = (0..scenarios.len()).step_by(lanes).collect();
    let taken = map(&firsts, |&first| {
        let batch = first..scenarios.len().min(first + lanes);
        let runs = simulate_batch(plant, &scenarios[batch.clone()]);
        let taken = batch.zip(runs).map(|(place, run)| {
            let run = run.during(&what(place))?;
            match run.ended {
                Some(reason) => Err(reason).during(&what(place)),
                None => take(place, run),
            }
        });
        taken.collect::<Result<Vec<T>, CampaignError>>()
    })?;
    Ok(taken.into_iter().flatten().collect())
}

/// Does `work` for each number below `count`, one at a time on each core. It stands once in the
/// program, for work of any kind.
fn for_each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().with_max_len(1).for_each(work);
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn results_keep_the_order_of_the_items() {
        let items: Vec<usize> = (0..1000).collect();
        let squares = map(&items, |&item| Ok::<_, ()>(item * item)).unwrap();
        assert!(
            squares
                .iter()
                .enumerate()
                .all(|(item, &square)| square == item * item)
        );
        assert_eq!(squares.len(), items.len());
        assert_eq!(
            map(&[(); 0], |()| Err::<(), _>("never asked")),
            Ok(Vec::new())
        );
    }

    /// The first item that fails takes longest, and items behind it fail before.
    #[test]
    fn the_first_item_that_fails_is_told_and_those_behind_are_not_begun() {
        let begun = AtomicUsize::new(0);
        let items: Vec<usize> = (0..100_000).collect();
        let result = map(&items, |&item| {
            begun.fetch_add(1, Ordering::Relaxed);
            match item {
                3 => {
                    std::thread::sleep(Duration::from_millis(20));
                    Err(item)
                }
                item if item >= 50_000 => Err(item),
                item => Ok(item),
            }
        });
        assert_eq!(result, Err(3));
        // Of the second half one of each part that a thread begins with.
        let begun = begun.into_inner();
        assert!(begun < 51_000, "{begun} begun");
    }
}
