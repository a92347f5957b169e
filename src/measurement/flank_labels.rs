//! Lands drawn by hand: the polygons of Labelme's JSON as a mask.

use image::{GrayImage, Luma};
use imageproc::drawing::draw_polygon_mut;
use imageproc::point::Point;
use serde::Deserialize;

use crate::gauge::flank::Raster;

/// What is read of a Labelme file; the image inside of it is not.
#[derive(Debug, Deserialize)]
struct LabelmeFile {
    shapes: Vec<LabelmeShape>,
    #[serde(rename = "imageWidth")]
    width: u32,
    #[serde(rename = "imageHeight")]
    height: u32,
}

#[derive(Debug, Deserialize)]
struct LabelmeShape {
    #[serde(default)]
    shape_type: Option<String>,
    points: Vec<[f64; 2]>,
}

/// The mask of a Labelme file: 1 inside of a polygon, whatever its label, 0 elsewhere.
///
/// # Errors
/// Text that is no such file, another size than the image's, a shape that is no polygon: in words.
pub(crate) fn labelme_mask(text: &str, (rows, columns): (usize, usize)) -> Result<Raster, String> {
    let file: LabelmeFile = serde_json::from_str(text).map_err(|e| format!("not a Labelme file: {e}"))?;
    if (file.height as usize, file.width as usize) != (rows, columns) {
        return Err(format!(
            "it is of an image of {} x {} px (imageHeight, imageWidth), this one has {rows} x {columns}",
            file.height, file.width
        ));
    }
    let mut image = GrayImage::new(file.width, file.height);
    for (k, shape) in file.shapes.iter().enumerate() {
        let kind = shape.shape_type.as_deref().unwrap_or("polygon");
        let mut points: Vec<Point<i32>> = Vec::new();
        for [x, y] in &shape.points {
            if !(x.abs() < 1e6 && y.abs() < 1e6) {
                return Err(format!("shape {k}: a point at {x}, {y}"));
            }
            points.push(Point::new(x.round() as i32, y.round() as i32));
        }
        points.dedup();
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if kind != "polygon" || points.len() < 3 {
            return Err(format!(
                "shape {k} is a {kind} of {} points: a polygon of 3 or more is needed",
                points.len()
            ));
        }
        draw_polygon_mut(&mut image, &points, Luma([1]));
    }
    Ok(Raster { rows, columns, values: image.pixels().map(|p| f32::from(p.0[0])).collect() })
}

/// The mask of a grey image: land is at least half of its full scale.
pub(crate) fn grey_mask(raster: &Raster, full_scale: f32) -> Raster {
    raster.map(|v| f32::from(u8::from(v >= 0.5 * full_scale)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_covers_its_pixels() {
        let text = r#"{"imageWidth": 20, "imageHeight": 10, "imageData": null, "shapes":
            [{"label": "land", "shape_type": "polygon", "points": [[2, 3], [8, 3], [8, 6], [2, 6], [2, 3]]}]}"#;
        let mask = labelme_mask(text, (10, 20)).unwrap();
        assert_eq!(mask.values.iter().sum::<f32>(), 28.0);
        assert_eq!((mask.at(3, 2), mask.at(2, 2), mask.at(6, 8)), (1.0, 0.0, 1.0));
        assert!(labelme_mask(text, (10, 21)).unwrap_err().contains("10 x 20"));
    }

    #[test]
    fn what_is_no_polygon_is_named() {
        let of = |shape: &str| {
            let text = format!(r#"{{"imageWidth": 20, "imageHeight": 10, "shapes": [{shape}]}}"#);
            labelme_mask(&text, (10, 20)).unwrap_err()
        };
        assert!(
            of(r#"{"shape_type": "circle", "points": [[2, 3], [8, 3]]}"#).contains("shape 0 is a circle")
        );
        assert!(of(r#"{"points": [[2, 3], [1e9, 3]]}"#).contains("shape 0"));
        assert!(labelme_mask("[]", (1, 1)).is_err());
    }
}
