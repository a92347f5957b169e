//! The page's files, compiled in: nothing is asked of another host.

use axum::http::header;
use axum::response::{IntoResponse, Response};

/// A file with its media type.
fn file(media: &'static str, text: &'static str) -> Response {
    ([(header::CONTENT_TYPE, media)], text).into_response()
}

pub(super) async fn index() -> Response {
    file("text/html; charset=utf-8", include_str!("page/index.html"))
}

pub(super) async fn script() -> Response {
    file("text/javascript; charset=utf-8", include_str!("page/page.js"))
}

pub(super) async fn style() -> Response {
    file("text/css; charset=utf-8", include_str!("page/page.css"))
}

/// uPlot 1.6.32 (MIT, © Leon Sorokin; its licence stands beside it and is served with it).
pub(super) async fn plot_script() -> Response {
    file("text/javascript; charset=utf-8", include_str!("page/vendor/uPlot.iife.min.js"))
}

pub(super) async fn plot_style() -> Response {
    file("text/css; charset=utf-8", include_str!("page/vendor/uPlot.min.css"))
}

pub(super) async fn plot_licence() -> Response {
    file("text/plain; charset=utf-8", include_str!("page/vendor/uPlot.LICENSE"))
}
