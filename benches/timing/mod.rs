//! Times of several contenders, measured side by side in one process.

use std::time::Instant;

/// Rounds that are timed, after one that is not.
const ROUNDS: usize = 15;

/// What is timed: a name for the table, and one run of the work.
pub type Contender<'a> = (&'static str, Box<dyn FnMut() + 'a>);

/// The times of some contenders in seconds, a list a contender, an entry a round.
pub struct Times {
    names: Vec<&'static str>,
    seconds: Vec<Vec<f64>>,
}

/// Runs every contender once a round, so that a disturbance of the machine meets all of them alike.
///
/// `cargo bench` passes `--bench`; without it (`cargo test --benches`) there is a single round,
/// which shows that the bench works and times nothing.
pub fn race(contenders: Vec<Contender>) -> Times {
    race_rounds(contenders, ROUNDS)
}

/// [`race`] with a number of rounds.
pub fn race_rounds(mut contenders: Vec<Contender>, rounds: usize) -> Times {
    let measuring = is_measuring();
    let rounds = if measuring { rounds } else { 0 };
    let mut seconds = vec![Vec::new(); contenders.len()];
    for round in 0..=rounds {
        for ((_, run), times) in contenders.iter_mut().zip(&mut seconds) {
            let start = Instant::now();
            run();
            let elapsed_s = start.elapsed().as_secs_f64();
            if round > 0 || !measuring {
                times.push(elapsed_s);
            }
        }
    }
    let names = contenders.iter().map(|(name, _)| *name).collect();
    Times { names, seconds }
}

/// Whether times are wanted.
pub fn is_measuring() -> bool {
    std::env::args().any(|argument| argument == "--bench")
}

impl Times {
    /// The median time of a contender in seconds.
    pub fn median_s(&self, contender: usize) -> f64 {
        median(self.seconds[contender].clone())
    }

    /// How many times faster a contender is than the base: the median over the rounds of the
    /// quotient of their times in the same round.
    pub fn speed_over(&self, contender: usize, base: usize) -> f64 {
        let pairs = self.seconds[contender].iter().zip(&self.seconds[base]);
        median(pairs.map(|(own, base)| base / own).collect())
    }

    /// Prints a row a contender: its name, the figure called `header` that `figure` makes of its
    /// median time in seconds, its speed over that of each base, and a note.
    pub fn print(
        &self,
        header: &str,
        figure: impl Fn(f64) -> f64,
        bases: &[usize],
        notes: (&str, &[String]),
    ) {
        print!("{:<48}{header:>14}", "");
        for base in bases {
            print!("{:>10}", format!("/ [{base}]"));
        }
        println!("  {}", notes.0);
        for (index, name) in self.names.iter().enumerate() {
            let label = format!("[{index}] {name}");
            print!("{label:<48}{:>14.1}", figure(self.median_s(index)));
            for &base in bases {
                print!("{:>10.2}", self.speed_over(index, base));
            }
            println!("  {}", notes.1.get(index).map_or("", String::as_str));
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
