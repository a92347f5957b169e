//! Thresholds of the instrument as fields with a name, a unit, a value and a reason.
//!
//! A file that decides by thresholds declares them once, in a group made by `limits!`, beside the
//! code that uses them, and reads them by `Group::get()`. A field's comment states what is compared
//! with what, in which unit, and why the value is what it is: a source, a derivation, a quantile,
//! or the study that set it. `shadowgauge study limits` halves and doubles every field and prints
//! what that changes; a field that changes nothing and holds no test's case is deleted.
//!
//! "Tuned: see study limits." in a comment means `study limits` with its default seed, 1. What half
//! and double of such a field change there is in `docs/thresholds_swept.csv`, which test fails when
//! a field is put out of action in `docs/thresholds_held.csv`; `tests/architecture/thresholds.rs`
//! requires one of the two of every tuned field, and a reason of every other.
//!
//! A process has one value of each: the default, or for one field the value that
//! [`replace`] set before anything was measured. They are not parameters of the functions, since no
//! user sets them: what a user chooses stands in
//! [`GaugeSettings`](crate::gauge::GaugeSettings). Sizes that the compiler needs (lengths of
//! arrays) and values of standards stay constants.

use std::sync::OnceLock;

use crate::setting::SettingError;

/// The one field of this process that has not its default value.
static REPLACED: OnceLock<(String, f64)> = OnceLock::new();

/// One threshold: its name (`grey_ends.beyond`) and its default value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Limit {
    /// Group and field, joined by a point.
    pub name: String,
    /// The default value, in the unit that its documentation states.
    pub value: f64,
    /// Whether it is a whole number.
    pub whole: bool,
}

/// Gives one threshold of this process another value. It must be called before anything is
/// measured: a group that has been read keeps its values.
///
/// # Errors
/// One threshold has been replaced already.
pub(crate) fn replace(name: &str, value: f64) -> Result<(), SettingError> {
    let text = "one threshold of a process is replaced, once";
    REPLACED.set((name.to_owned(), value)).map_err(|_| SettingError::at("limits", text))
}

/// A number that a threshold may be.
pub(crate) trait Number: Copy {
    const WHOLE: bool;
    fn to_f64(self) -> f64;
    fn from_f64(value: f64) -> Self;
}

macro_rules! number {
    ($($kind:ty: $whole:expr, $from:expr);*) => { $(
        impl Number for $kind {
            const WHOLE: bool = $whole;
            #[allow(clippy::cast_lossless, clippy::cast_precision_loss, reason = "thresholds are small")]
            fn to_f64(self) -> f64 { self as f64 }
            fn from_f64(value: f64) -> Self { $from(value) as $kind }
        }
    )* };
}

number!(
    f32: false, std::convert::identity;
    f64: false, std::convert::identity;
    usize: true, f64::round;
    u32: true, f64::round;
    i32: true, f64::round
);

/// A group of thresholds.
pub(crate) trait Limits: Sized {
    /// Every field with its default value.
    fn list() -> Vec<Limit>;

    /// The values of this process: the defaults but for a field that was replaced.
    fn of_process() -> Self;
}

/// The field that [`replace`] gave another value.
#[cfg(not(test))]
fn replaced() -> Option<&'static (String, f64)> {
    REPLACED.get()
}

/// The field that the environment gives another value (`SHADOWGAUGE_LIMIT=group.field=value`), in
/// the unit tests alone: `scripts/limits_held.py` finds with it which test holds a threshold. A
/// process prints the groups that it reads where `SHADOWGAUGE_LIMITS_READ` is set.
#[cfg(test)]
fn replaced() -> Option<&'static (String, f64)> {
    static SET: OnceLock<Option<(String, f64)>> = OnceLock::new();
    SET.get_or_init(|| {
        let set = std::env::var("SHADOWGAUGE_LIMIT").ok()?;
        let (name, value) = set.split_once('=')?;
        Some((name.to_owned(), value.parse().expect("SHADOWGAUGE_LIMIT is group.field=value")))
    })
    .as_ref()
}

/// Prints a group that is read, where `SHADOWGAUGE_LIMITS_READ` is set.
#[cfg(test)]
fn note_read(group: &str) {
    if std::env::var_os("SHADOWGAUGE_LIMITS_READ").is_some() {
        eprintln!("limits read: {group}");
    }
}

/// The value of a field in this process.
pub(crate) fn value<T: Number>(group: &str, field: &str, default: T) -> T {
    #[cfg(test)]
    note_read(group);
    match replaced() {
        Some((name, value)) if name.split_once('.') == Some((group, field)) => T::from_f64(*value),
        _ => default,
    }
}

/// Declares a group of thresholds: a struct whose fields have a type, a value and a comment.
macro_rules! limits {
    (
        $(#[$doc:meta])*
        $group:ident = $name:literal;
        $( $(#[$why:meta])* $field:ident: $kind:ty = $value:expr; )*
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $group {
            $( $(#[$why])* pub(crate) $field: $kind, )*
        }

        impl $group {
            /// The thresholds of this process.
            #[inline]
            pub(crate) fn get() -> &'static Self {
                static IN_USE: std::sync::OnceLock<$group> = std::sync::OnceLock::new();
                IN_USE.get_or_init(<Self as $crate::gauge::limit::Limits>::of_process)
            }
        }

        impl $crate::gauge::limit::Limits for $group {
            fn list() -> Vec<$crate::gauge::limit::Limit> {
                vec![$( $crate::gauge::limit::Limit {
                    name: format!("{}.{}", $name, stringify!($field)),
                    value: $crate::gauge::limit::Number::to_f64({ let value: $kind = $value; value }),
                    whole: <$kind as $crate::gauge::limit::Number>::WHOLE,
                }, )*]
            }

            fn of_process() -> Self {
                Self { $( $field: $crate::gauge::limit::value($name, stringify!($field), $value), )* }
            }
        }
    };
}

pub(crate) use limits;
