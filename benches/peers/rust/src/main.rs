//! Edge points of grey PNGs by the crate subpixel-edge (Canny, then a parabola across the edge), on
//! one thread.
//!
//! `peer-subpixel-edge OUT.csv FRAME.png…` writes `frame,row,column` and prints the shortest time
//! per frame of ten rounds, s.

use std::error::Error;
use std::fmt::Write as _;
use std::time::Instant;

use subpixel_edge::canny_based_subpixel_edges_optimized as edges;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().ok_or("usage: peer-subpixel-edge OUT.csv FRAME.png…")?;
    let frames: Vec<_> = arguments.map(|path| Ok(image::open(path)?.to_luma8())).collect::<Result<_, image::ImageError>>()?;
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let (mut best, mut text) = (f64::INFINITY, String::from("frame,row,column\n"));
    for round in 0..10 {
        let start = Instant::now();
        let found: Vec<_> = frames.iter().map(|frame| edges(frame, 20.0, 80.0, 0.6)).collect();
        best = best.min(start.elapsed().as_secs_f64() / frames.len() as f64);
        if round == 0 {
            for (index, points) in found.iter().enumerate() {
                for (x, y) in points {
                    writeln!(text, "{index},{y},{x}")?;
                }
            }
        }
    }
    std::fs::write(out, text)?;
    println!("{best}");
    Ok(())
}
