//! The server: routes, limits, its end.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::http::StatusCode;
use axum::routing::{get, post};
use axum::{Json, Router, middleware};
use thiserror::Error;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, watch};
use tower_http::limit::RequestBodyLimitLayer;
use tower_http::timeout::TimeoutLayer;
use utoipa::OpenApi;

use super::hub::Hub;
use super::jobs::Jobs;
use super::problem::Problem;
use super::runs::LONGEST_CONFIG;
use super::settings::ServeSettings;
use super::state::{MOST_STREAMS, Shared, State};
use super::{access, history, live, page, runs};

/// Time that an answer may take; a day out of ten million stations takes less than a tenth of it.
const ANSWERED: Duration = Duration::from_secs(30);
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
        runs::jobs,
        runs::start,
        runs::resume,
        runs::stop,
        history::history,
        history::checked,
        live::live
    )
)]
pub(super) struct Documented;

fn router(state: Shared) -> Router {
    let answers = Router::new()
        .route("/api/openapi.json", get(|| async { Json(Documented::openapi()) }))
        .route("/api/runs", get(runs::list).post(runs::start))
        .route("/api/runs/{run}", get(runs::show))
        .route("/api/runs/{run}/report", get(runs::report))
        .route("/api/runs/{run}/resume", post(runs::resume))
        .route("/api/runs/{run}/stop", post(runs::stop))
        .route("/api/jobs", get(runs::jobs))
        .route("/api/history", get(history::history))
        .route("/api/store", get(history::checked))
        .route("/", get(page::index))
        .route("/page.js", get(page::script))
        .route("/page.css", get(page::style))
        .route("/uplot.js", get(page::plot_script))
        .route("/uplot.css", get(page::plot_style))
        .route("/uplot.txt", get(page::plot_licence))
        .layer(TimeoutLayer::with_status_code(StatusCode::SERVICE_UNAVAILABLE, ANSWERED));
    Router::new()
        .route("/api/live", get(live::live))
        .merge(answers)
        .fallback(|| async { Problem::absent("no such page; the routes are in /api/openapi.json") })
        .layer(RequestBodyLimitLayer::new(LONGEST_CONFIG))
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

    /// Where it is found.
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
            let state = Arc::new(State {
                settings: self.settings,
                hub: Hub::new(),
                jobs: Jobs::default(),
                streams: Arc::new(Semaphore::new(MOST_STREAMS)),
                ends,
            });
            tokio::spawn(live::watch(Arc::clone(&state)));
            let listener = TcpListener::from_std(self.listener)?;
            let stop = Arc::clone(stop);
            let stopped = async move {
                while !stop.load(Ordering::Relaxed) {
                    tokio::time::sleep(LOOKS).await;
                }
                // event streams end by this, others have been answered
                let _ = end.send(true);
            };
            let mut over = state.ends.clone();
            let served = axum::serve(listener, router(state)).with_graceful_shutdown(stopped);
            tokio::select! {
                served = async { served.await } => served?,
                () = async {
                    let _ = over.changed().await;
                    tokio::time::sleep(CLOSES).await;
                } => {}
            }
            Ok(())
        })
    }
}
