//! What a camera is set to, as far as a calibration is bound to it.

use super::features::{Features, exposure_name};
use crate::frame::{CameraBinding, Roi};

/// What the discovery of a camera states.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Identity<'a> {
    /// Serial number.
    pub serial_number: Option<&'a str>,
    /// Model.
    pub model: Option<&'a str>,
}

/// The binding of frames that the camera sends now; what it does not state is left out.
pub(super) fn binding(camera: &impl Features, identity: Identity<'_>) -> CameraBinding {
    let pixels = |name: &str| camera.number(name).map_or(0, |pixels| pixels as u32);
    let flag = |name: &str| match camera.value(name)?.to_ascii_lowercase().as_str() {
        "true" | "1" | "on" => Some(true),
        "false" | "0" | "off" => Some(false),
        _ => None,
    };
    // Binning by enumeration is named X1, x2 and so on.
    let joined = |name: &str| camera.value(name)?.trim_start_matches(['x', 'X']).parse().ok();
    let stated = |text: Option<&str>| text.unwrap_or_default().trim().to_owned();
    CameraBinding {
        serial_number: match stated(identity.serial_number) {
            serial if serial.is_empty() => camera.value("DeviceSerialNumber").unwrap_or_default(),
            serial => serial,
        },
        model: stated(identity.model),
        pixel_format: camera.value("PixelFormat").unwrap_or_default(),
        window: Roi {
            row: pixels("OffsetY"),
            column: pixels("OffsetX"),
            rows: pixels("Height"),
            columns: pixels("Width"),
        },
        binning_horizontal: joined("BinningHorizontal"),
        binning_vertical: joined("BinningVertical"),
        reverse_x: flag("ReverseX"),
        reverse_y: flag("ReverseY"),
        gain_db: camera.number("Gain"),
        black_level: camera.number("BlackLevel"),
        exposure_us: camera.number(exposure_name(camera)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::features::Stated;
    use super::*;

    #[test]
    fn what_a_camera_states_is_in_its_binding_and_nothing_else() {
        let camera = Stated::of(&[
            ("Width", "512"),
            ("Height", "400"),
            ("OffsetX", "16"),
            ("OffsetY", "8"),
            ("PixelFormat", "Mono12"),
            ("BinningHorizontal", "X1"),
            ("ReverseX", "false"),
            ("Gain", "6.5"),
            ("BlackLevel", "64"),
            ("ExposureTimeAbs", "50"),
        ]);
        let identity = Identity { serial_number: Some("40001 "), model: None };
        let right = CameraBinding {
            serial_number: "40001".to_owned(),
            pixel_format: "Mono12".to_owned(),
            window: Roi { row: 8, column: 16, rows: 400, columns: 512 },
            binning_horizontal: Some(1),
            reverse_x: Some(false),
            gain_db: Some(6.5),
            black_level: Some(64.0),
            exposure_us: Some(50.0),
            ..CameraBinding::default()
        };
        assert_eq!(binding(&camera, identity), right);
    }
}
