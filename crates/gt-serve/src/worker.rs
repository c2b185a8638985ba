//! What judges: a thread for some of the machines.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::clock::now_ns;
use crate::hub::{Batch, Frame, Hub, Recorded};
use crate::pipeline::{Band, Machine, Sample};
use crate::queue::Popped;

/// How often machines are looked at that nothing comes from.
const TICK: Duration = Duration::from_millis(100);
/// Time between two frames of a machine, ms.
const FRAME_MS: i64 = 100;

/// Values of a machine that were not told yet.
#[derive(Default)]
struct Untold {
    since_ms: i64,
    series: Vec<Band>,
}

/// Judges what comes to worker `worker` until its queue is closed and empty.
pub fn judge(hub: &Arc<Hub>, worker: usize) {
    let own: Vec<usize> = (0..hub.cells.len())
        .filter(|place| hub.cells[*place].worker == worker)
        .collect();
    let mut untold: Vec<Untold> = hub.cells.iter().map(|_| Untold::default()).collect();
    let mut ticked = Instant::now();
    loop {
        hub.beat(worker);
        match hub.queues[worker].pop(TICK) {
            Popped::Item(batch) => take(hub, &batch, &mut untold),
            Popped::Nothing => {}
            Popped::Closed => break,
        }
        if ticked.elapsed() >= TICK {
            ticked = Instant::now();
            for place in &own {
                tick(hub, *place, &mut untold[*place]);
            }
        }
    }
    for place in own {
        let mut machine = hub.cells[place].lock();
        machine.drain(|machine, sample| tell(hub, place, machine, sample, &mut untold[place]));
        hub.commit(place, &mut machine);
    }
}

fn take(hub: &Hub, batch: &Batch, untold: &mut [Untold]) {
    let Some(cell) = hub.cells.get(batch.machine) else {
        return;
    };
    let place = batch.machine;
    let mut machine = cell.lock();
    let mut judged = 0_u32;
    for reading in &batch.readings {
        machine.offer(reading, batch.arrived_ns, |machine, sample| {
            judged += 1;
            tell(hub, place, machine, sample, &mut untold[place]);
        });
    }
    hub.commit(place, &mut machine);
    drop(machine);
    if judged > 0 {
        hub.metrics.delays.take(now_ns() - batch.arrived_ns);
    }
}

fn tick(hub: &Hub, place: usize, untold: &mut Untold) {
    let now_ns = now_ns();
    let mut machine = hub.cells[place].lock();
    machine.tick(now_ns / 1_000_000);
    machine.drain_if_silent(now_ns, |machine, sample| {
        tell(hub, place, machine, sample, untold);
    });
    hub.commit(place, &mut machine);
}

/// Passes a judged sample on.
fn tell(hub: &Hub, place: usize, machine: &Machine, sample: &Sample, untold: &mut Untold) {
    let watch = machine.watch();
    if let Some(recorder) = &hub.recorder {
        recorder.push(Recorded::Sample {
            machine: place,
            sample: sample.clone(),
            residuals: watch.residuals().to_vec(),
            statistics: watch.statistics().to_vec(),
        });
    }
    if !hub.is_seen() {
        return;
    }
    let time_ms = sample.time_ns / 1_000_000;
    let values = sample.values.iter();
    let values = values.chain(watch.residuals()).chain(watch.statistics());
    for (place, value) in values.enumerate() {
        if untold.series.len() <= place {
            untold.series.push(None);
        }
        if value.is_finite() {
            let band = untold.series[place].get_or_insert([*value, *value]);
            *band = [band[0].min(*value), band[1].max(*value)];
        }
    }
    if (time_ms - untold.since_ms).abs() >= FRAME_MS {
        untold.since_ms = time_ms;
        hub.show(Frame {
            machine: machine.name().to_owned(),
            time_ms,
            series: std::mem::take(&mut untold.series),
        });
    }
}
