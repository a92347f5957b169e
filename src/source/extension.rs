//! Files that are images by their name.

/// Extensions taken for images in a folder.
const EXTENSIONS: [&str; 15] = [
    "png", "tif", "tiff", "btf", "tf8", "jpg", "jpeg", "jpe", "bmp", "pgm", "ppm", "pbm", "pnm", "pam", "pfm",
];

pub(super) fn is_image_extension(extension: &str) -> bool {
    EXTENSIONS.contains(&extension.to_ascii_lowercase().as_str())
}
