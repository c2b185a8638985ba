//! `gtfdi serve`: the monitoring service.

use gt_serve::{LogFormat, LogLevel, ServeConfig, ServeError, init_logging, serve};

use crate::Outcome;
use crate::cli::{self, GlobalArgs, ServeArgs};
use crate::failure::Failure;
use crate::output::{complain, print};

/// Runs the verb.
pub fn run(args: &ServeArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let mut config = match &global.config {
        Some(path) => ServeConfig::read(path).map_err(failure)?,
        None => ServeConfig::default(),
    };
    config.http.listen = args.listen.or(config.http.listen);
    config.state_dir = args.state_dir.clone().or(config.state_dir);
    config.lines.stdin |= args.stdin;
    config.check().map_err(failure)?;
    if global.print_config {
        print(&toml::to_string(&config).map_err(Failure::failed)?)?;
        return Ok(Outcome::Done);
    }
    let format = match args.log_format {
        Some(cli::LogFormat::Json) => LogFormat::Json,
        _ => LogFormat::Text,
    };
    let level = match args.log_level {
        Some(cli::LogLevel::Error) => LogLevel::Error,
        Some(cli::LogLevel::Warn) => LogLevel::Warn,
        Some(cli::LogLevel::Debug) => LogLevel::Debug,
        Some(cli::LogLevel::Info) | None => LogLevel::Info,
    };
    init_logging(format, level);
    let scheme = if config.http.tls_certificate.is_some() {
        "https"
    } else {
        "http"
    };
    serve(&config, |address| {
        complain(&format!("{scheme}://{address}/"));
    })
    .map_err(failure)?;
    Ok(Outcome::Done)
}

fn failure(error: ServeError) -> Failure {
    match error {
        ServeError::Listen { .. } | ServeError::System { .. } => Failure::failed(error),
        _ => Failure::input(error),
    }
}
