use super::parts::*;
use crate::tool::*;

#[test]
fn explore() {
    let shaft = shaft();
    for (name, nose) in [("paper", papers()), ("flat", nose(0.25, flat_support)), ("round", round(0.4))] {
        let tool = Tool::new(&nose);
        for r in [0.4, 0.3865] {
            let c = compensator(&shaft, &nose, r);
            c.check(&geometry()).unwrap();
            for way in Way::ALL {
                let t = std::time::Instant::now();
                match c.carry_out(way) {
                    Ok(done) => {
                        let t1 = t.elapsed();
                        let moves = moves_of(&done.path);
                        let left = remainders(&shaft, &done.path, &moves, &tool);
                        let big = largest(&left).unwrap();
                        let an = c.angles().iter().map(|a| c.setting.left_mm(*a, done.register_mm).abs()).fold(0.0, f64::max);
                        println!("{name} R{r} {way:?}: R {:.4} largest {:.5} um at {} a {:.2}  analytic {:.4}; {} prog, {} path, {} moves {:?} {:?}", done.register_mm, 1e3*big.left_mm, big.at, big.a_rad.to_degrees(), 1e3*an, done.programmed.len(), done.path.len(), moves.len(), t1, t.elapsed());
                        println!("   reached {}/{}", left.iter().filter(|l| l.reached).count(), left.len());
                    }
                    Err(e) => println!("{name} {r} {way:?}: {e}"),
                }
            }
        }
    }
}
