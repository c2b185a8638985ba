//! From a configuration to a service at work, and to its end.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::net::{SocketAddr, TcpListener};
use std::path::Path;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use axum_server::Handle;
use axum_server::tls_rustls::RustlsConfig;
use gt_log::DetectorFile;
use hyper_util::rt::{TokioExecutor, TokioTimer};
use hyper_util::server::conn::auto::Builder;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::Semaphore;

use crate::clock::now_ms;
use crate::config::{DEFAULT_LISTEN, ServeConfig};
use crate::error::ServeError;
use crate::history::History;
use crate::http::{Access, Service, router, tls};
use crate::hub::{Cell, Hub};
use crate::journal::{Journal, JournalFile, NoJournal};
use crate::pipeline::{Machine, MachineOptions};
use crate::queue::{Queue, QueuePolicy};
use crate::recorder::Recorder;
use crate::source::lines;
use crate::source::mqtt::Broker;
use crate::source::plant::EmbeddedPlant;
use crate::source::replay::Replay;
use crate::{snapshots, worker};

/// The detector of the embedded turbine; `cargo run --release -p gt-serve --example embedded_turbine
/// crates/gt-serve/assets` makes it.
const TURBINE_DETECTOR: &str = include_str!("../assets/turbine_detector.json");
/// Seconds between two snapshots unless the configuration says otherwise.
const SNAPSHOT_S: f64 = 10.0;
/// Messages to the recorder that wait at most.
const RECORDED: usize = 65_536;
/// How long requests may take to end when the service stops.
const GRACE: Duration = Duration::from_secs(2);
/// How long the disk may take with the last events when the service stops.
const LAST_WRITE: Duration = Duration::from_secs(10);
/// How long a connection may take to send a request.
const FIRST_REQUEST: Duration = Duration::from_secs(10);
/// How long a worker may be at one message before the watchdog is no longer answered, ms.
const ALIVE_MS: i64 = 5000;
/// How often a signal is answered to the system's watchdog, at most.
const PATIENCE: Duration = Duration::from_millis(200);

/// Runs a service until it is told to stop, by a signal or the end of standard input where that has
/// its readings. `announce` is called with the address of the page once it can be asked.
///
/// # Errors
/// [`ServeError`] when something that the configuration names cannot be had: nothing has been
/// written then but an empty folder.
pub fn serve(config: &ServeConfig, announce: impl FnOnce(SocketAddr)) -> Result<(), ServeError> {
    config.check()?;
    // TLS of the broker and of the page; nobody else chooses the cryptography of this process.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let access = match &config.http.tokens_file {
        Some(path) => Access::read(path)?,
        None => Access::open(),
    };
    let tls = tls(&config.http)?;
    let listener = listen(config.http.listen)?;
    let tcp = match config.lines.tcp {
        Some(address) => Some(bind("lines.tcp", address)?),
        None => None,
    };
    let broker = config.mqtt.as_ref().map(Broker::new).transpose()?;
    let _lock = config.state_dir.as_deref().map(lock).transpose()?;
    let (mut journal, history) = open_journal(config)?;
    let (hub, plant) = build(config, history)?;
    let hub = Arc::new(hub);
    let replays = config.replays.iter();
    let replays = replays
        .map(|replay| Replay::read(&hub, replay))
        .collect::<Result<Vec<_>, _>>()?;
    let recorder = config.recorder.as_ref();
    let recorder = recorder.map(|own| Recorder::new(&hub, own)).transpose()?;

    let mut threads = Threads::default();
    let recording = match recorder {
        Some(recorder) => {
            let hub = Arc::clone(&hub);
            Some(spawn("recorder", move || recorder.run(&hub))?)
        }
        None => None,
    };
    let telling = {
        let hub = Arc::clone(&hub);
        spawn("telling", move || hub.tell_events())?
    };
    let writing = {
        let hub = Arc::clone(&hub);
        spawn("journal", move || hub.write_events(&mut *journal))?
    };
    for worker in 0..hub.queues.len() {
        let hub = Arc::clone(&hub);
        threads
            .judging
            .push(spawn("worker", move || worker::judge(&hub, worker))?);
    }
    if let Some(folder) = config.state_dir.clone() {
        let period = Duration::from_secs_f64(config.snapshot_s.unwrap_or(SNAPSHOT_S));
        let hub = Arc::clone(&hub);
        threads.sources.push(spawn("snapshots", move || {
            snapshots::run(&hub, &folder, period);
        })?);
    }
    let publisher = broker.as_ref().map(Broker::publisher);
    start_sources(
        config,
        &hub,
        plant.as_ref(),
        tcp,
        broker,
        replays,
        &mut threads,
    )?;
    let service = Arc::new(Service {
        hub: Arc::clone(&hub),
        access,
        streams: Arc::new(Semaphore::new(config.http.streams)),
        plant,
    });
    let served = run_http(tls, service, listener, publisher.clone(), announce);

    hub.stop();
    if let Some(publisher) = publisher {
        publisher.say_goodbye();
    }
    // What they brought is judged, what was judged is written.
    for queue in &hub.queues {
        queue.close();
    }
    for thread in threads.sources.into_iter().chain(threads.judging) {
        let _ = thread.join();
    }
    hub.outbox().close();
    let _ = telling.join();
    // A disk that does not answer is not waited for without end.
    if hub.outbox().is_written(hub.outbox().count(), LAST_WRITE) {
        let _ = writing.join();
    } else {
        tracing::error!("the journal's disk does not answer");
    }
    if let Some(folder) = &config.state_dir {
        snapshots::write_all(&hub, folder);
    }
    if let Some(queue) = &hub.recorder {
        queue.close();
    }
    if let Some(recording) = recording {
        let _ = recording.join();
    }
    served
}

#[derive(Default)]
struct Threads {
    sources: Vec<JoinHandle<()>>,
    judging: Vec<JoinHandle<()>>,
}

fn spawn(name: &str, run: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, ServeError> {
    let builder = thread::Builder::new().name(name.to_owned());
    builder.spawn(run).map_err(|cause| ServeError::System {
        what: "a thread",
        cause,
    })
}

fn bind(option: &'static str, address: SocketAddr) -> Result<TcpListener, ServeError> {
    TcpListener::bind(address).map_err(|cause| ServeError::Listen {
        option,
        address: address.to_string(),
        cause,
    })
}

/// The address asked for; without one the default, or a free port where that is taken.
fn listen(asked: Option<SocketAddr>) -> Result<TcpListener, ServeError> {
    match asked {
        Some(address) => bind("http.listen", address),
        None => bind("http.listen", DEFAULT_LISTEN).or_else(|_| {
            let free = SocketAddr::new(DEFAULT_LISTEN.ip(), 0);
            bind("http.listen", free)
        }),
    }
}

/// Two services that write one state would undo each other.
fn lock(folder: &Path) -> Result<File, ServeError> {
    std::fs::create_dir_all(folder).map_err(|cause| ServeError::io("make", folder, &cause))?;
    let path = folder.join("lock");
    let file = OpenOptions::new()
        .create(true)
        .truncate(false)
        .write(true)
        .open(&path);
    let file = file.map_err(|cause| ServeError::io("open", &path, &cause))?;
    file.try_lock().map_err(|_| {
        ServeError::option(
            format!("state_dir {}", folder.display()),
            "a folder that no other service uses",
            "one that another service has locked",
        )
    })?;
    Ok(file)
}

/// Where events are written, and what happened before.
fn open_journal(config: &ServeConfig) -> Result<(Box<dyn Journal>, History), ServeError> {
    let Some(folder) = &config.state_dir else {
        return Ok((Box::new(NoJournal), History::default()));
    };
    let (journal, history) = JournalFile::open(&folder.join("alarms.jsonl"))?;
    Ok((Box::new(journal), history))
}

/// The machines with what they remember, and the embedded turbine.
fn build(
    config: &ServeConfig,
    mut history: History,
) -> Result<(Hub, Option<Arc<EmbeddedPlant>>), ServeError> {
    let cores = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let embedded = config.embedded();
    let count = config.machines.len() + usize::from(embedded.is_some());
    let workers = config.queue.workers.unwrap_or(cores).min(count.max(1));
    let mut cells = Vec::with_capacity(count);
    let first_id = history.largest_id() + 1;
    let mut add = |name: &str,
                   file: Option<&Path>,
                   options: MachineOptions,
                   aliases: HashMap<String, String>|
     -> Result<(), ServeError> {
        let (detector, text) = read_detector(file)?;
        let place = cells.len();
        let machine = Machine::new(name, &detector, options);
        let mut machine = machine.map_err(|cause| ServeError::Machine {
            machine: name.to_owned(),
            cause,
        })?;
        machine.set_ids(first_id + place as u64, count as u64);
        let folder = config.state_dir.as_deref();
        let snapshot = folder.and_then(|folder| snapshots::read(folder, name));
        let had_snapshot = snapshot.is_some();
        if let Some(why) = machine.resume(history.open_of(name), snapshot, now_ms())
            && had_snapshot
        {
            tracing::warn!(machine = name, why, "begins afresh");
        }
        let cell = Cell::new(
            machine,
            file.map(Path::to_owned),
            aliases,
            &text,
            place % workers,
        );
        for tag in cell.aliases.values() {
            if !cell.places.contains_key(tag) {
                let tags: Vec<&str> = cell.places.keys().map(String::as_str).collect();
                return Err(ServeError::option(
                    format!("machine `{name}`: tags"),
                    format!("names of the detector's tags ({})", tags.join(", ")),
                    format!("`{tag}`"),
                ));
            }
        }
        cells.push(cell);
        Ok(())
    };
    for machine in &config.machines {
        let options = MachineOptions {
            hygiene: machine.hygiene,
            alarms: machine.alarms.clone(),
        };
        let aliases = machine.tags.clone().into_iter().collect();
        add(&machine.name, Some(&machine.detector), options, aliases)?;
    }
    let mut plant = None;
    if let Some(embedded) = &embedded {
        let mut options = MachineOptions::default();
        if embedded.speed > 1.0 {
            // Its time runs ahead of the clock.
            options.hygiene.future_s = 86_400.0;
            options.hygiene.restart_s = 1.0;
        }
        add(
            &embedded.machine,
            embedded.detector.as_deref(),
            options,
            HashMap::new(),
        )?;
        plant = Some(Arc::new(EmbeddedPlant::new(
            config.machines.len(),
            embedded,
        )?));
    }
    let queue = &config.queue;
    let queues = (0..workers).map(|_| Queue::new(queue.capacity, queue.policy));
    let recorder = config.recorder.as_ref();
    let recorder = recorder.map(|own| {
        let policy = own.policy.unwrap_or(if config.has_live_source() {
            QueuePolicy::DropOldest
        } else {
            QueuePolicy::Block
        });
        Queue::new(RECORDED, policy)
    });
    history.forget_machines_but(
        &cells
            .iter()
            .map(|cell| cell.name.as_str())
            .collect::<Vec<_>>(),
    );
    Ok((Hub::new(cells, queues.collect(), history, recorder), plant))
}

fn read_detector(file: Option<&Path>) -> Result<(DetectorFile, Vec<u8>), ServeError> {
    if let Some(path) = file {
        let text = std::fs::read(path).map_err(|cause| ServeError::io("read", path, &cause))?;
        return Ok((DetectorFile::read(path)?, text));
    }
    let isolator = serde_json::from_str(TURBINE_DETECTOR);
    let isolator = isolator.map_err(|cause| ServeError::Config {
        path: "the built-in detector".into(),
        cause: cause.to_string(),
    })?;
    let text = TURBINE_DETECTOR.as_bytes().to_vec();
    Ok((DetectorFile::Isolator(Box::new(isolator)), text))
}

fn start_sources(
    config: &ServeConfig,
    hub: &Arc<Hub>,
    plant: Option<&Arc<EmbeddedPlant>>,
    tcp: Option<TcpListener>,
    broker: Option<Broker>,
    replays: Vec<Replay>,
    threads: &mut Threads,
) -> Result<(), ServeError> {
    if let Some(plant) = plant {
        let (plant, hub) = (Arc::clone(plant), Arc::clone(hub));
        threads
            .sources
            .push(spawn("plant", move || plant.run(&hub))?);
    }
    let lines = &config.lines;
    let (longest_line, connections) = (lines.longest_line, lines.connections);
    if let Some(listener) = tcp {
        let hub = Arc::clone(hub);
        threads.sources.push(spawn("lines", move || {
            lines::listen(&hub, &listener, longest_line, connections);
        })?);
    }
    if lines.stdin {
        let hub = Arc::clone(hub);
        // Not waited for: it may wait for a line that never comes.
        spawn("stdin", move || {
            lines::read_all(&hub, std::io::stdin(), longest_line, "stdin");
            hub.stop();
        })?;
    }
    if let Some(broker) = broker {
        let hub = Arc::clone(hub);
        // Not waited for: it may wait for a broker that is away.
        spawn("mqtt", move || broker.run(&hub))?;
    }
    for replay in replays {
        let hub = Arc::clone(hub);
        threads
            .sources
            .push(spawn("replay", move || replay.play(&hub))?);
    }
    Ok(())
}

/// Answers requests until the service is to stop.
fn run_http(
    tls: Option<RustlsConfig>,
    service: Arc<Service>,
    listener: TcpListener,
    publisher: Option<crate::source::mqtt::Publisher>,
    announce: impl FnOnce(SocketAddr),
) -> Result<(), ServeError> {
    let system = |what: &'static str| move |cause| ServeError::System { what, cause };
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(system("the page's threads"))?;
    let address = listener
        .local_addr()
        .map_err(system("the page's address"))?;
    let hub = Arc::clone(&service.hub);
    let app = router(service).into_make_service_with_connect_info::<SocketAddr>();
    let result = runtime.block_on(async {
        let handle = Handle::new();
        let stopping = tokio::spawn(watch_for_stop(Arc::clone(&hub), handle.clone()));
        if let Some(publisher) = publisher {
            tokio::spawn(publisher.run(Arc::clone(&hub)));
        }
        announce(address);
        let served = if let Some(tls) = tls {
            let server = axum_server::from_tcp_rustls(listener, tls);
            let server = server.map_err(system("the page's address"))?;
            let mut server = server.handle(handle).first_request_timeout(FIRST_REQUEST);
            limit_waiting(server.http_builder());
            server.serve(app).await
        } else {
            let server = axum_server::from_tcp(listener);
            let server = server.map_err(system("the page's address"))?;
            let mut server = server.handle(handle).first_request_timeout(FIRST_REQUEST);
            limit_waiting(server.http_builder());
            server.serve(app).await
        };
        stopping.abort();
        served.map_err(system("the page"))
    });
    runtime.shutdown_timeout(GRACE);
    result
}

/// Ends connections that do not ask within [`FIRST_REQUEST`], the first time or after an answer.
fn limit_waiting(builder: &mut Builder<TokioExecutor>) {
    let mut http1 = builder.http1();
    http1
        .timer(TokioTimer::new())
        .header_read_timeout(FIRST_REQUEST);
}

/// Waits for a signal or for another part that stops the service; loads detectors again on SIGHUP
/// and answers the system's watchdog.
async fn watch_for_stop(hub: Arc<Hub>, handle: Handle<SocketAddr>) {
    let signals = [
        SignalKind::interrupt(),
        SignalKind::terminate(),
        SignalKind::hangup(),
    ];
    let [Ok(mut interrupt), Ok(mut terminate), Ok(mut hangup)] = signals.map(signal) else {
        tracing::error!("signals cannot be waited for");
        return;
    };
    notify(Notice::Ready);
    loop {
        tokio::select! {
            _ = interrupt.recv() => break,
            _ = terminate.recv() => break,
            _ = hangup.recv() => {
                let own = Arc::clone(&hub);
                let _ = tokio::task::spawn_blocking(move || reload_all(&own)).await;
            }
            () = tokio::time::sleep(PATIENCE) => {
                if hub.is_stopping() {
                    break;
                }
                // A worker that hangs is for the system to end.
                if hub.is_alive(ALIVE_MS) {
                    notify(Notice::Alive);
                }
            }
        }
    }
    tracing::info!("stopping");
    notify(Notice::Stopping);
    hub.stop();
    handle.graceful_shutdown(Some(GRACE));
}

fn reload_all(hub: &Hub) {
    for (place, cell) in hub.cells.iter().enumerate() {
        if cell.detector_file.is_none() {
            continue;
        }
        match hub.reload(place) {
            Ok(sha256) => tracing::info!(machine = cell.name, sha256, "detector loaded"),
            Err(error) => {
                tracing::error!(machine = cell.name, %error, "the detector stays as it was");
            }
        }
    }
}

#[derive(Clone, Copy)]
enum Notice {
    Ready,
    Alive,
    Stopping,
}

#[cfg(target_os = "linux")]
fn notify(notice: Notice) {
    use sd_notify::NotifyState;

    let state = match notice {
        Notice::Ready => NotifyState::Ready,
        Notice::Alive => NotifyState::Watchdog,
        Notice::Stopping => NotifyState::Stopping,
    };
    // Without systemd nobody is there to be told.
    let _ = sd_notify::notify(&[state]);
}

#[cfg(not(target_os = "linux"))]
fn notify(_notice: Notice) {}

/// A hub of the embedded turbine alone, for tests.
#[cfg(any(test, fuzzing))]
pub(crate) fn turbine_hub() -> Arc<Hub> {
    use std::sync::LazyLock;

    #[allow(clippy::unwrap_used)] // a failed step is a failed test
    static HUB: LazyLock<Arc<Hub>> = LazyLock::new(|| {
        Arc::new(
            build(&ServeConfig::default(), History::default())
                .unwrap()
                .0,
        )
    });
    Arc::clone(&HUB)
}
