//! The largest diameter in an image: `cargo run --example measure_image -- IMAGE UM_PER_PX`.

use std::error::Error;
use std::path::PathBuf;

use shadowgauge::gauge::stated::stated;
use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings};
use shadowgauge::measurement::known_conditions;
use shadowgauge::source::FileFrames;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let usage = "give an image and its scale in µm per pixel";
    let image = PathBuf::from(arguments.next().ok_or(usage)?);
    let um_per_px: f64 = arguments.next().ok_or(usage)?.parse()?;

    let frame = FileFrames::new(vec![image]).next_stored().ok_or("no image")??.frame;
    let calibration = Calibration::from_scale(um_per_px);
    let conditions = known_conditions(Some(&calibration));
    let gauge = Gauge::new(GaugeSettings::default())?;
    let measured = gauge.measure(&frame.view(), &calibration, &conditions)?;

    let largest = measured.diameter.ok_or("no column has both edges")?;
    let [diameter, expanded] = stated(largest.diameter.d_mm, largest.expanded_u_mm);
    println!("D = {diameter} mm ± {expanded} mm (k = {:.2}; of the image alone)", largest.coverage_factor);
    measured.warnings.iter().for_each(|warning| println!("{warning}"));
    Ok(())
}
