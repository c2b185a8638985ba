//! Progress on standard error; bars are drawn here and nowhere below.

use std::io::{IsTerminal, Write, stderr};
use std::time::Duration;

use gt_campaign::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::ProgressMode;

/// What shows the progress of long work.
pub enum Shown {
    /// A bar.
    Bar(ProgressBar),
    /// A JSON object a line.
    Json,
    /// Nothing.
    Nothing,
}

impl Shown {
    /// As asked for; without a wish, a bar where standard error is a terminal.
    pub fn new(mode: Option<ProgressMode>) -> Self {
        let terminal = stderr().is_terminal();
        match mode {
            Some(ProgressMode::Json) => Self::Json,
            Some(ProgressMode::Bar) | None if terminal => {
                let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
                if let Ok(style) = ProgressStyle::with_template(
                    "{bar:30} {pos}/{len} {elapsed} (left {eta}) {msg}",
                ) {
                    bar.set_style(style);
                }
                bar.enable_steady_tick(Duration::from_millis(200));
                Self::Bar(bar)
            }
            _ => Self::Nothing,
        }
    }
}

impl Progress for Shown {
    fn report(&self, what: &str, done: usize, total: usize) {
        match self {
            Self::Bar(bar) => {
                // The time left is that of what is under way, from where it begins.
                let begins = bar.message() != what;
                if begins {
                    bar.reset();
                    bar.set_message(what.to_owned());
                }
                bar.set_length(total as u64);
                bar.set_position(done as u64);
                if begins {
                    bar.reset_eta();
                }
                if done >= total {
                    bar.finish_and_clear();
                }
            }
            Self::Json => {
                let line = serde_json::json!({"what": what, "done": done, "total": total});
                // The lock keeps lines whole; a reader that went away is no failure.
                let _ = writeln!(stderr().lock(), "{line}");
            }
            Self::Nothing => {}
        }
    }
}
