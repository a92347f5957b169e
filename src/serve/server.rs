//! The server: routes, limits, its end.

use std::convert::Infallible;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::extract::DefaultBodyLimit;
use axum::http::StatusCode;
use axum::routing::{MethodRouter, get, post, put};
use axum::{Json, Router, middleware};
use thiserror::Error;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, watch};
use tower_http::limit::RequestBodyLimitLayer;
use tower_http::timeout::TimeoutLayer;
use utoipa::OpenApi;

use super::calibrations::LARGEST_CALIBRATION;
use super::health::Health;
use super::hub::Hub;
use super::jobs::Jobs;
use super::making::Making;
use super::picture_file::PictureFile;
use super::problem::Problem;
use super::products::LARGEST_MODEL;
use super::run_config::LONGEST_CONFIG;
use super::settings::ServeSettings;
use super::state::{MOST_STREAMS, Shared, State};
use super::tls::TlsListener;
use super::tools::LARGEST_IMAGE;
use super::workshop::Workshop;
use super::{
    access, calibrations, files, history, live, machines, page, products, programs, run_config, run_jobs,
    runs, tools,
};

/// Time that an answer may take; a day out of ten million stations takes less than a tenth of it.
const ANSWERED: Duration = Duration::from_secs(30);
/// Time that an upload with its reading may take: a minute of work behind others.
const MEASURED: Duration = Duration::from_secs(120);
/// How often the end is looked for.
const LOOKS: Duration = Duration::from_millis(50);
/// Time that open connections have at the end.
const CLOSES: Duration = Duration::from_secs(2);

/// Why nothing is served.
#[derive(Debug, Error)]
pub(crate) enum ServeError {
    /// An address that is not served.
    #[error("{0}")]
    Refused(String),
    /// The port is taken, or the address is not this machine's.
    #[error("{address}: {cause}; give another port with --listen")]
    Bind {
        /// The address.
        address: SocketAddr,
        /// The system's words.
        cause: std::io::Error,
    },
    /// The system refuses.
    #[error("{0}")]
    System(#[from] std::io::Error),
}

/// A server that has its port.
#[derive(Debug)]
pub(crate) struct Server {
    listener: std::net::TcpListener,
    settings: ServeSettings,
}

/// All routes of the API, for `openapi.json`.
#[derive(OpenApi)]
#[openapi(
    info(title = "shadowgauge", description = "Runs, history and a live source of one gauge."),
    paths(
        runs::list,
        runs::show,
        runs::report,
        run_jobs::jobs,
        run_jobs::job,
        run_jobs::start,
        run_jobs::resume,
        run_jobs::stop,
        run_config::schema,
        run_config::values,
        history::history,
        history::checked,
        history::state,
        calibrations::list,
        calibrations::add,
        calibrations::simulated,
        live::live,
        live::events,
        live::picture,
        live::gauge,
        products::list,
        products::add,
        products::show,
        products::model,
        products::contour,
        products::remove,
        tools::list,
        tools::add,
        tools::show,
        tools::image,
        tools::overlay,
        tools::remove,
        machines::list,
        machines::add,
        machines::show,
        machines::change,
        machines::remove,
        programs::list,
        programs::make,
        programs::show,
        programs::nc,
        programs::path
    )
)]
pub(super) struct Documented;

/// Runs, history and the files of the page.
fn watched() -> Router<Shared> {
    let files = page::FILES.iter().fold(Router::new(), |router, file| {
        router.route(file.path, get(move || async move { page::answer(file) }))
    });
    files
        .route("/api/openapi.json", get(|| async { Json(Documented::openapi()) }))
        .route("/api/runs", get(runs::list).post(run_jobs::start))
        .route("/api/runs/{run}", get(runs::show))
        .route("/api/runs/{run}/report", get(runs::report))
        .route("/api/runs/{run}/resume", post(run_jobs::resume))
        .route("/api/runs/{run}/stop", post(run_jobs::stop))
        .route("/api/jobs", get(run_jobs::jobs))
        .route("/api/jobs/{run}", get(run_jobs::job))
        .route("/api/config", get(run_config::schema).post(run_config::values))
        .route("/api/history", get(history::history))
        .route("/api/store", get(history::checked))
        .route("/api/store/state", get(history::state))
        .route("/api/gauge", get(live::gauge))
        .route("/api/live/picture", get(live::picture))
}

/// Products, tools, machines and programs of them.
fn made() -> Router<Shared> {
    Router::new()
        .route("/api/calibrations", get(calibrations::list))
        .route("/api/products", get(products::list).post(products::add))
        .route("/api/products/{name}", get(products::show).delete(products::remove))
        .route("/api/products/{name}/contour", get(products::contour))
        .route("/api/tools", get(tools::list).post(tools::add))
        .route("/api/tools/{name}", get(tools::show).delete(tools::remove))
        .route("/api/tools/{name}/overlay", get(tools::overlay))
        .route("/api/machines", get(machines::list).post(machines::add))
        .route("/api/machines/{name}", get(machines::show).put(machines::change).delete(machines::remove))
        .route("/api/programs", get(programs::list).post(programs::make))
        .route("/api/programs/{id}", get(programs::show))
        .route("/api/programs/{id}/nc", get(programs::nc))
        .route("/api/programs/{id}/path", get(programs::path))
}

/// Uploads, each with its own limit.
fn uploads() -> Router<Shared> {
    // a length that is stated is refused at once, another one where it is passed
    let limited = |route: MethodRouter<Shared>, bytes| {
        let route: MethodRouter<Shared> = route.layer(DefaultBodyLimit::max(bytes));
        route.layer::<_, Infallible>(RequestBodyLimitLayer::new(bytes))
    };
    Router::new()
        .route("/api/products/{name}/model", limited(put(products::model), LARGEST_MODEL))
        .route("/api/tools/{name}/images", limited(post(tools::image), LARGEST_IMAGE))
        .route("/api/calibrations", limited(post(calibrations::add), LARGEST_CALIBRATION))
        .route("/api/calibrations/simulated", limited(post(calibrations::simulated), LONGEST_CONFIG))
        .layer(TimeoutLayer::with_status_code(StatusCode::SERVICE_UNAVAILABLE, MEASURED))
}

fn router(state: Shared) -> Router {
    let answers = watched()
        .merge(made())
        .layer(TimeoutLayer::with_status_code(StatusCode::SERVICE_UNAVAILABLE, ANSWERED));
    Router::new()
        .route("/api/live", get(live::live))
        .route("/api/events", get(live::events))
        .merge(answers)
        .fallback(|| async { Problem::absent("no such page; the routes are in /api/openapi.json") })
        .layer(RequestBodyLimitLayer::new(LONGEST_CONFIG))
        .merge(uploads())
        .layer(middleware::from_fn_with_state(Arc::clone(&state), access::guard))
        .with_state(state)
}

impl Server {
    /// Takes the port.
    ///
    /// # Errors
    /// An address beyond this machine, a port that is taken.
    pub(crate) fn bind(mut settings: ServeSettings) -> Result<Self, ServeError> {
        settings.check().map_err(ServeError::Refused)?;
        let address = settings.listen;
        let taken = |cause| ServeError::Bind { address, cause };
        let listener = std::net::TcpListener::bind(address).map_err(taken)?;
        listener.set_nonblocking(true)?;
        settings.listen = listener.local_addr()?;
        Ok(Self { listener, settings })
    }

    /// Where it is found: under the first name that it was given, else by its address.
    pub(crate) fn url(&self) -> String {
        let (scheme, listen) = (self.settings.scheme(), self.settings.listen);
        match self.settings.names.first() {
            Some(name) => format!("{scheme}://{name}:{}/", listen.port()),
            None => format!("{scheme}://{listen}/"),
        }
    }

    /// The address that it has.
    #[cfg(test)]
    pub(crate) fn address(&self) -> SocketAddr {
        self.settings.listen
    }

    /// Serves until `stop` becomes true.
    ///
    /// # Errors
    /// Where the system refuses.
    pub(crate) fn serve(self, stop: &Arc<AtomicBool>) -> Result<(), ServeError> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        runtime.block_on(async {
            let (end, ends) = watch::channel(false);
            let picture = self.settings.source.as_ref().map(|_| PictureFile::new()).transpose()?;
            let state = Arc::new(State {
                settings: self.settings,
                workshop: Workshop::new(),
                making: Making::default(),
                picture,
                hub: Hub::new(),
                jobs: Jobs::default(),
                documents: Mutex::new(()),
                streams: Arc::new(Semaphore::new(MOST_STREAMS)),
                checking: Arc::new(Semaphore::new(1)),
                checked: Mutex::default(),
                health: Health::default(),
                ends,
            });
            files::clear_jobs(&state);
            tokio::spawn(live::watch(Arc::clone(&state)));
            let listener = TcpListener::from_std(self.listener)?;
            let tls = state.settings.tls.clone();
            let stop = Arc::clone(stop);
            let stopped = async move {
                while !stop.load(Ordering::Relaxed) {
                    tokio::time::sleep(LOOKS).await;
                }
                // event streams end by this, others have been answered
                let _ = end.send(true);
            };
            let mut over = state.ends.clone();
            let served = async {
                match tls {
                    Some(tls) => {
                        let listener = TlsListener::new(listener, &tls)?;
                        axum::serve(listener, router(state)).with_graceful_shutdown(stopped).await
                    }
                    None => axum::serve(listener, router(state)).with_graceful_shutdown(stopped).await,
                }
            };
            tokio::select! {
                served = served => served?,
                () = async {
                    let _ = over.changed().await;
                    tokio::time::sleep(CLOSES).await;
                } => {}
            }
            Ok(())
        })
    }
}
