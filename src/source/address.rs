//! The grammar of SOURCE: where frames come from.
//!
//! `-` is images one after another on stdin, `raw:-` and `raw:FILE` pixels whose layout is stated
//! beside, `sim:CONFIG.toml` the simulated head, `gige:NAME` or `gige:IP` a camera, `usb:SERIAL`
//! one by USB3 Vision, `replay:FILE.mcap` a recording; everything else is a file or a folder. One
//! more kind is a variant and a line of [`Address::of`].

use std::path::{Path, PathBuf};

/// Where frames come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Address {
    /// A file or a folder.
    Path(PathBuf),
    /// Images, or Y4M, on stdin.
    Stdin,
    /// Raw pixels on stdin.
    RawStdin,
    /// Raw pixels in a file.
    RawFile(PathBuf),
    /// A Y4M stream in a file, by its extension.
    Y4m(PathBuf),
    /// The simulated head of a config.
    Simulation(PathBuf),
    /// A GigE Vision camera, by its name or IP address.
    Camera(String),
    /// A USB3 Vision camera, by its serial number.
    UsbCamera(String),
    /// A recording.
    Recording(PathBuf),
}

/// The prefixes, for messages.
const PREFIXES: &str = "raw:-, raw:FILE, sim:CONFIG.toml, gige:NAME, gige:IP, usb:SERIAL, replay:FILE.mcap";

impl Address {
    /// Parses a source.
    ///
    /// # Errors
    /// A prefix that there is not, or one without what it needs: the message names what is right.
    pub(crate) fn of(text: &Path) -> Result<Self, String> {
        let whole = text.to_string_lossy();
        if whole == "-" {
            return Ok(Self::Stdin);
        }
        // A word of one letter is a drive, one with a separator is part of a path.
        let prefix = whole.split_once(':').filter(|(word, _)| {
            word.len() > 1 && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
        });
        let Some((word, rest)) = prefix else {
            let is_y4m = text.extension().is_some_and(|e| e.eq_ignore_ascii_case("y4m"));
            return Ok(if is_y4m { Self::Y4m(text.to_owned()) } else { Self::Path(text.to_owned()) });
        };
        let needs = |what: &str| format!("{whole}: {what} is missing after the colon");
        match (word, rest) {
            ("raw", "") => Err(needs("a file, or - for stdin,")),
            ("raw", "-") => Ok(Self::RawStdin),
            ("raw", file) => Ok(Self::RawFile(file.into())),
            ("sim", "") => Err(needs("a config (.toml)")),
            ("sim", file) => Ok(Self::Simulation(file.into())),
            ("gige", "") => Err(needs("a camera's name or IP address")),
            ("gige", name) => Ok(Self::Camera(name.to_owned())),
            ("usb", "") => Err(needs("a camera's serial number")),
            ("usb", serial) => Ok(Self::UsbCamera(serial.to_owned())),
            ("replay", "") => Err(needs("a recording (.mcap)")),
            ("replay", file) => Ok(Self::Recording(file.into())),
            _ => Err(format!(
                "{whole}: no kind of source is called \"{word}\"; there are {PREFIXES}; a file of that name is ./{whole}"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_parsed() {
        for (text, right) in [
            ("-", Address::Stdin),
            ("frames", Address::Path("frames".into())),
            ("./raw:-", Address::Path("./raw:-".into())),
            ("/data/a:b/c.png", Address::Path("/data/a:b/c.png".into())),
            ("C:\\frames", Address::Path("C:\\frames".into())),
            ("shaft.Y4M", Address::Y4m("shaft.Y4M".into())),
            ("raw:-", Address::RawStdin),
            ("raw:a/b.bin", Address::RawFile("a/b.bin".into())),
            ("sim:my.toml", Address::Simulation("my.toml".into())),
            ("gige:10.0.0.7", Address::Camera("10.0.0.7".into())),
            ("gige:Head 1", Address::Camera("Head 1".into())),
            ("usb:40001", Address::UsbCamera("40001".into())),
            ("replay:a.mcap", Address::Recording("a.mcap".into())),
        ] {
            assert_eq!(Address::of(Path::new(text)), Ok(right), "{text}");
        }
    }

    #[test]
    fn what_is_no_source_is_refused_with_what_there_is() {
        for (text, word) in [
            ("video:0", "gige:NAME"),
            ("video:0", "./video:0"),
            ("usb:", "serial number"),
            ("raw:", "stdin"),
            ("sim:", ".toml"),
            ("gige:", "IP address"),
            ("replay:", ".mcap"),
        ] {
            let error = Address::of(Path::new(text)).unwrap_err();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
