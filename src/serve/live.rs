//! A source that is watched: its lines to every page.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::State as Extract;
use axum::http::{StatusCode, header};
use axum::response::IntoResponse;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::stream::{Stream, unfold};
use tokio::sync::broadcast::{Receiver, error::RecvError};

use super::child::{self, LONGEST_LINE, add_words};
use super::health::GaugeHealth;
use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::state::Shared;

/// Age from which a frame is no reading of now, as `watch` has it by default.
const STALE: Duration = Duration::from_secs(1);
/// Frames that wait while one is measured: a page's trend is to have every frame, and browsers on
/// the same two cores held an event back for 43 ms at most (`benches/serve/load.sh`), two frames at
/// 50 a second, of which each takes 4 ms of a core.
const WAITING: u8 = 3;
/// Pause before a source that has ended is watched again.
const AGAIN: Duration = Duration::from_secs(2);

/// Watches the source again and again until the server ends.
pub(super) async fn watch(state: Shared) {
    let Some((source, more)) = &state.settings.source else { return };
    let picture = state.picture.as_ref().map(|picture| picture.path().to_string_lossy().into_owned());
    let arguments = arguments(source, picture, more);
    let mut ends = state.ends.clone();
    loop {
        let why = tokio::select! {
            why = watched(&state, &arguments) => why,
            _ = ends.changed() => return,
        };
        state.hub.end(&why);
        tokio::select! {
            () = tokio::time::sleep(AGAIN) => {}
            _ = ends.changed() => return,
        }
    }
}

/// What the source is watched with.
fn arguments(source: &str, picture: Option<String>, more: &[String]) -> Vec<String> {
    let mut all = vec!["watch".to_owned(), source.to_owned(), "--json".to_owned()];
    if let Some(picture) = picture {
        all.extend(["--picture".to_owned(), picture]);
    }
    // what the gauge is set up by, once a second: the pages show it
    if !is_stated(more, "--setup") {
        all.push("--setup".to_owned());
    }
    if !is_stated(more, "--waiting") {
        all.extend(["--waiting".to_owned(), WAITING.to_string()]);
    }
    all.extend(more.iter().cloned());
    all
}

/// Whether an option is among these, as `--name` or `--name=value`.
fn is_stated(arguments: &[String], option: &str) -> bool {
    arguments.iter().any(|argument| argument.split('=').next() == Some(option))
}

/// Watches once; why it ended.
async fn watched(state: &Shared, arguments: &[String]) -> String {
    let mut running = match child::start(arguments, None) {
        Ok(running) => running,
        Err(why) => return format!("watch does not start: {why}"),
    };
    let mut last = String::new();
    loop {
        tokio::select! {
            line = running.out.next_line() => match line {
                Ok(Some(line)) if line.len() <= LONGEST_LINE => {
                    state.health.take(&line);
                    state.hub.line(&line);
                }
                Ok(Some(_)) => {}
                Ok(None) | Err(_) => break,
            },
            Ok(Some(line)) = running.err.next_line() => add_words(&mut last, &line),
        }
    }
    while let Ok(Some(line)) = running.err.next_line().await {
        add_words(&mut last, &line);
    }
    match running.child.wait().await {
        Ok(status) if status.success() => "the source has ended".to_owned(),
        _ if last.is_empty() => "watch has ended".to_owned(),
        _ => last,
    }
}

/// Frames and events of the source, as they come.
#[utoipa::path(get, path = "/api/live", responses((status = 200, body = String, content_type = "text/event-stream"), (status = 503, body = Words)))]
pub(super) async fn live(
    Extract(state): Extract<Shared>,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, Problem> {
    let Ok(place) = Arc::clone(&state.streams).try_acquire_owned() else {
        return Err(Problem::new(StatusCode::SERVICE_UNAVAILABLE, "too many pages are open: close some"));
    };
    let (first, coming) = state.hub.join(STALE);
    let ends = state.ends.clone();
    let reader = (first, coming, ends, place);
    let stream = unfold(reader, |(first, mut coming, mut ends, place)| async move {
        let line = match first {
            Some(line) => line,
            None => tokio::select! {
                line = newest(&mut coming) => line?,
                _ = ends.changed() => return None,
            },
        };
        Some((Ok(Event::default().data(&*line)), (None, coming, ends, place)))
    });
    Ok(Sse::new(stream).keep_alive(KeepAlive::default()))
}

/// The same events under the name that paper 004's platform has for them.
#[utoipa::path(get, path = "/api/events", responses((status = 200, body = String, content_type = "text/event-stream"), (status = 503, body = Words)))]
pub(super) async fn events(
    state: Extract<Shared>,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, Problem> {
    live(state).await
}

/// The next line; those that a slow reader has missed are left out.
async fn newest(coming: &mut Receiver<Arc<str>>) -> Option<Arc<str>> {
    loop {
        match coming.recv().await {
            Ok(line) => return Some(line),
            Err(RecvError::Lagged(_)) => {}
            Err(RecvError::Closed) => return None,
        }
    }
}

/// Window and drift of the source: now, and by the minute.
#[utoipa::path(get, path = "/api/gauge", responses((status = 200, body = GaugeHealth)))]
pub(super) async fn gauge(Extract(state): Extract<Shared>) -> Json<GaugeHealth> {
    Json(state.health.shown(!state.hub.is_dead(STALE)))
}

/// The newest frame with its edges.
///
/// The body: the length of a JSON text (32 bits, little-endian), that text and an 8-bit PNG, all of
/// the same frame. The text has `frame` (its number in the lines of `/api/live`), `rows` and
/// `columns` of the camera, `column_step` (columns from one of the PNG to the next; it has every
/// row), `grey_full_scale` in counts, and `top_px` and `bottom_px`: the row of each edge in every
/// column of the PNG, null in a gap, empty where the frame was refused; `pitch_mm` along the axis,
/// `d_mm` and `expanded_u_mm` of every column (of a frame in pixels `d_px` and `expanded_u_px`).
#[utoipa::path(get, path = "/api/live/picture", responses((status = 200, body = Vec<u8>, content_type = "application/octet-stream"), (status = 404, body = Words)))]
pub(super) async fn picture(Extract(state): Extract<Shared>) -> Result<impl IntoResponse, Problem> {
    let none = || Problem::absent("no frame yet: is a source watched (--source)?");
    if state.hub.is_dead(STALE) {
        return Err(Problem::absent("no frame of now"));
    }
    let bytes = off_thread(move || {
        let picture = state.picture.as_ref().ok_or_else(none)?;
        std::fs::read(picture.path()).map_err(|_| none())
    })
    .await?;
    Ok(([(header::CONTENT_TYPE, "application/octet-stream")], bytes))
}

#[cfg(test)]
mod tests {
    use super::arguments;

    #[test]
    fn a_source_is_watched_with_its_setup_and_frames_that_wait_unless_something_else_is_stated() {
        let by = |more: &[&str]| {
            let more: Vec<String> = more.iter().map(|word| (*word).to_owned()).collect();
            arguments("camera.toml", Some("p".to_owned()), &more).join(" ")
        };
        let given = "watch camera.toml --json --picture p --setup";
        assert_eq!(by(&["--fps", "50"]), format!("{given} --waiting 3 --fps 50"));
        assert_eq!(by(&["--waiting=0"]), format!("{given} --waiting=0"));
        assert_eq!(
            by(&["--waiting", "8", "--setup"]),
            "watch camera.toml --json --picture p --waiting 8 --setup"
        );
    }
}
