//! The page's files, compiled in: nothing is asked of another host.

use axum::http::header;
use axum::response::{IntoResponse, Response};

/// A file of the page.
#[derive(Debug)]
pub(super) struct PageFile {
    pub path: &'static str,
    media: &'static str,
    text: &'static str,
}

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

macro_rules! file {
    ($path:literal, $media:expr, $file:literal) => {
        PageFile { path: $path, media: $media, text: include_str!(concat!("page/", $file)) }
    };
}

/// All of them. uPlot 1.6.32 (MIT, © Leon Sorokin) comes with its licence.
pub(super) static FILES: [PageFile; 17] = [
    file!("/", HTML, "index.html"),
    file!("/base.js", SCRIPT, "base.js"),
    file!("/picture.js", SCRIPT, "picture.js"),
    file!("/live.js", SCRIPT, "live.js"),
    file!("/runs.js", SCRIPT, "runs.js"),
    file!("/form.js", SCRIPT, "form.js"),
    file!("/compare.js", SCRIPT, "compare.js"),
    file!("/health.js", SCRIPT, "health.js"),
    file!("/history.js", SCRIPT, "history.js"),
    file!("/setup.js", SCRIPT, "setup.js"),
    file!("/gauge.js", SCRIPT, "gauge.js"),
    file!("/programs.js", SCRIPT, "programs.js"),
    file!("/page.js", SCRIPT, "page.js"),
    file!("/page.css", STYLE, "page.css"),
    file!("/uplot.js", SCRIPT, "vendor/uPlot.iife.min.js"),
    file!("/uplot.css", STYLE, "vendor/uPlot.min.css"),
    file!("/uplot.txt", "text/plain; charset=utf-8", "vendor/uPlot.LICENSE"),
];

/// A file with its media type.
pub(super) fn answer(file: &'static PageFile) -> Response {
    ([(header::CONTENT_TYPE, file.media)], file.text).into_response()
}
