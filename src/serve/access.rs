//! Who may do what, and the headers that keep other sites' pages out.
//!
//! A request is answered where its `Host` is this server (a name that another site has pointed here
//! is not), a change where it has the header `x-shadowgauge` (which no form and no other site's
//! script can send without being asked first, and we never agree) and a token of a role that may.

use axum::extract::{Request, State as Extract};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::Response;

use super::problem::Problem;
use super::settings::{Role, ServeSettings};
use super::state::Shared;

/// Header of every change.
const CHANGES: &str = "x-shadowgauge";

/// Nothing is loaded from elsewhere, and no other page frames this one (CSP level 3).
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                      connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
/// A report is a page of its own with its style and script in it, and no connection anywhere.
const REPORT_POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; \
                             frame-ancestors 'self'; base-uri 'none'; form-action 'none'; sandbox allow-scripts";

/// Who asks, for the audit: the name of the token, `page` without tokens.
#[derive(Clone, Debug)]
pub(super) struct Who(pub String);

/// What those who operate may change; the rest of what is stored is set up.
const OPERATED: [&str; 3] = ["/api/runs", "/api/programs", "/api/config"];

/// Lets through what is allowed, and adds the headers.
pub(super) async fn guard(
    Extract(state): Extract<Shared>,
    mut request: Request,
    next: Next,
) -> Result<Response, Problem> {
    check_host(&state.settings, request.headers())?;
    let needed = needed(&state.settings, (request.method(), request.uri().path()), request.headers())?;
    // the page's own files hold nothing of this gauge, and ask for the token
    let is_file = needed == Role::View && !request.uri().path().starts_with("/api/");
    let (role, who) = match role(&state.settings, request.headers()) {
        Err(_) if is_file => (Role::View, Who(String::new())),
        found => found?,
    };
    if role < needed {
        let words = match needed {
            Role::SetUp => "this token may not change what is stored: role set_up may",
            _ => "this token may read, and not change",
        };
        return Err(Problem::new(StatusCode::FORBIDDEN, words));
    }
    request.extensions_mut().insert(who);
    let is_report = request.uri().path().ends_with("/report");
    let mut response = next.run(request).await;
    let policy = if is_report { REPORT_POLICY } else { POLICY };
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, policy),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    Ok(response)
}

fn text(headers: &HeaderMap, name: impl header::AsHeaderName) -> Option<&str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

fn check_host(settings: &ServeSettings, headers: &HeaderMap) -> Result<(), Problem> {
    let host = text(headers, header::HOST).unwrap_or_default();
    if settings.hosts().iter().any(|own| own.eq_ignore_ascii_case(host)) {
        return Ok(());
    }
    let (scheme, own) = (settings.scheme(), settings.hosts().pop().unwrap_or_default());
    let words = format!("{host:?} is no name of this server; open {scheme}://{own}/");
    Err(Problem::new(StatusCode::MISDIRECTED_REQUEST, words))
}

/// The role that a request needs; a change must come from this page.
fn needed(
    settings: &ServeSettings,
    (method, path): (&Method, &str),
    headers: &HeaderMap,
) -> Result<Role, Problem> {
    if matches!(*method, Method::GET | Method::HEAD) {
        return Ok(Role::View);
    }
    if settings.read_only {
        return Err(Problem::new(StatusCode::FORBIDDEN, "this server was started with --read-only"));
    }
    let own = |origin: &str| {
        let host = origin.strip_prefix(settings.scheme()).and_then(|rest| rest.strip_prefix("://"));
        host.is_some_and(|host| settings.hosts().iter().any(|own| own.eq_ignore_ascii_case(host)))
    };
    let is_ours = text(headers, header::ORIGIN).is_none_or(own);
    if text(headers, CHANGES).is_none() || !is_ours {
        return Err(Problem::new(StatusCode::FORBIDDEN, format!("a change needs the header {CHANGES}: 1")));
    }
    let operates = OPERATED.iter().any(|operated| path.starts_with(operated));
    Ok(if operates { Role::Operate } else { Role::SetUp })
}

/// The role of who asks: all of it on this machine where no tokens are set.
fn role(settings: &ServeSettings, headers: &HeaderMap) -> Result<(Role, Who), Problem> {
    let Some(tokens) = &settings.tokens else { return Ok((Role::SetUp, Who("page".to_owned()))) };
    let given = text(headers, header::AUTHORIZATION).and_then(|value| value.strip_prefix("Bearer "));
    let given = given.or_else(|| cookie(headers)).unwrap_or_default();
    let found = tokens.token.iter().find(|token| equal(token.token.as_bytes(), given.as_bytes()));
    found.map(|token| (token.role, Who(token.name.clone()))).ok_or_else(|| {
        Problem::new(StatusCode::UNAUTHORIZED, "a token is needed: Authorization: Bearer …, or on the page")
    })
}

/// The token that the page keeps for this session.
fn cookie(headers: &HeaderMap) -> Option<&str> {
    let all = text(headers, header::COOKIE)?;
    all.split(';').find_map(|pair| pair.trim().strip_prefix("shadowgauge_token="))
}

/// Compares in a time that is the same however much is right.
fn equal(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |different, (x, y)| different | (x ^ y)) == 0
}
