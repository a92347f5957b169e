//! Each of the 21 errors alone, from its key in a config through the chain of a run to the tool,
//! the diameter that is cut and the head, against the closed forms of both topologies.
//!
//! [`super::chain`] has the chains against tables by hand; here the keys and the stations are in it
//! too: an error that is read under another's name, or a head that stands at the tool's levers,
//! changes a row here.

use super::close;
use crate::config;
use crate::job::MachineRow;
use crate::machine::ErrorName;

const JOB: &str = include_str!("../../../configs/small_shaft.toml");
/// Levers: tool t, head t, carriage w (all differ), tip above the axis, mm.
const T: [f64; 3] = [110.0, 90.25, 70.0];
const H: [f64; 3] = [60.0, 90.0, 130.0];
const W: [f64; 3] = [40.0, 80.0, 120.0];
const TIP: f64 = 0.25;
/// Size of an error, µm or µrad.
const SIZE: f64 = 3.0;

/// Values of all errors and orientations by their names of ISO 230-1; µm and mrad, so that an angle
/// times a lever in mm is in µm.
#[derive(Clone, Copy, Default)]
struct Values([f64; 21]);

impl Values {
    fn of(&self, name: ErrorName) -> f64 {
        self.0[name as usize]
    }
}

/// Where something stands: its lever on the X slide, position of that slide, x and z of the point.
struct Place {
    t: [f64; 3],
    slide_mm: f64,
    x_mm: f64,
    z_mm: f64,
    /// From the Z slide's reference to the point with X at 0 (carriage).
    w: [f64; 3],
}

/// Shift (µm) and turns a, b (mrad) relative to the part, as the formulas of the two chains print
/// them, component by component.
fn closed_form(is_carriage: bool, v: &Values, p: &Place) -> [f64; 5] {
    use ErrorName as E;
    let e = |name| v.of(name);
    let ([tx, ty, tz], [wx, wy, wz]) = (p.t, p.w);
    // what carries the part counts with the sign reversed; on a carriage lathe the Z slide carries
    // the tool, and its lever is that of the tool, without z
    let (s, wz) = if is_carriage { (-1.0, wz) } else { (1.0, wz + p.z_mm) };
    let (x, z) = (p.x_mm, p.z_mm);
    let e_x = e(E::Exx) + e(E::Ebx) * tz
        - e(E::Ecx) * ty
        - s * (e(E::Exz) + e(E::Ebz) * wz - e(E::Ecz) * wy)
        - e(E::B0c) * z
        - e(E::Exc)
        - e(E::Ebc) * z;
    let e_y =
        e(E::Eyx) + e(E::Ecx) * tx - e(E::Eax) * tz - s * (e(E::Eyz) + e(E::Ecz) * (wx + x) - e(E::Eaz) * wz)
            + e(E::A0c) * z
            - e(E::Eyc)
            + e(E::Eac) * z
            - e(E::Ecc) * x;
    let e_z = e(E::Ezx) - e(E::Ebx) * tx + e(E::Eax) * ty
        - s * (e(E::Ezz) - e(E::Ebz) * (wx + x) + e(E::Eaz) * wy)
        - e(E::B0x) * p.slide_mm
        + e(E::B0c) * x
        - e(E::Ezc)
        + e(E::Ebc) * x;
    let a = e(E::Eax) - s * e(E::Eaz) - e(E::Eac) - e(E::A0c);
    let b = e(E::Ebx) - s * e(E::Ebz) - e(E::Ebc) - e(E::B0c);
    [e_x, e_y, e_z, a, b]
}

/// Change of the diameter, µm, of a tool whose tip stands [`TIP`] above the axis: 2(|p + e| − R)
/// with
/// |p| = R, to second order 2·e_n + e_t²/R with e_n towards the axis and e_t across.
fn cut_um(radius_mm: f64, [e_x, e_y]: [f64; 2]) -> f64 {
    let sine = TIP / radius_mm;
    let cosine = (1.0 - sine * sine).sqrt();
    let (towards, across) = (e_x * cosine + e_y * sine, e_y * cosine - e_x * sine);
    2.0 * towards + 1e-3 * across * across / radius_mm
}

/// The rows of the first pass with one error of [`SIZE`], stated under its own key.
fn rows(chain: &str, name: ErrorName) -> Vec<MachineRow> {
    let code = name.code().to_lowercase();
    let (orientation, error) = match name {
        ErrorName::B0x | ErrorName::A0c | ErrorName::B0c => {
            (format!("{code}_urad = {SIZE:.1}"), String::new())
        }
        _ => {
            let unit = if name.is_length() { "um" } else { "urad" };
            let drift = format!("drift = {{ offset_{unit}_per_k = {SIZE:.1} }}");
            (String::new(), format!("[machine.stated.errors.{code}]\n{drift}\n"))
        }
    };
    let machine = format!(
        "[machine]\ntemperature_c = 21.0\n[machine.stated]\nchain = \"{chain}\"\ntool_mm = {T:?}\nhead_mm = {H:?}\ncarriage_mm = {W:?}\n\
         tip_above_axis_mm = {TIP}\nx_travel_mm = [-1.0, 60.0]\nz_travel_mm = [-80.0, 100.0]\n{orientation}\n{error}"
    );
    config::parse(&format!("{JOB}{machine}"), "job.toml").unwrap().machine_rows(1).unwrap()
}

#[test]
fn each_error_alone_reaches_tool_cut_and_head_with_its_own_sign() {
    for (chain, is_carriage) in [("t_shaped", false), ("carriage", true)] {
        for name in ErrorName::ALL {
            let mut values = Values::default();
            values.0[name as usize] = if name.is_length() { SIZE } else { 1e-3 * SIZE };
            let rows = rows(chain, name);
            let mut seen = 0.0_f64;
            for row in &rows {
                let what = format!("{name:?} of {chain} at {}", row.z_mm);
                // the job's first pass is cut at 11.5 mm
                let radius = 5.75;
                let at = Place { t: T, slide_mm: radius, x_mm: radius, z_mm: row.z_mm, w: W };
                let [e_x, e_y, e_z, ..] = closed_form(is_carriage, &values, &at);
                // the second order: (3 µrad)² · 200 mm
                close(row.tool_x_um, e_x, 1e-5, &format!("{what}: tool x"));
                close(row.tool_y_um, e_y, 1e-5, &format!("{what}: tool y"));
                close(row.tool_z_um, e_z, 1e-5, &format!("{what}: tool z"));
                close(row.cut_um, cut_um(radius, [e_x, e_y]), 1e-5, &format!("{what}: cut"));
                let on_axis = [W[0], W[1] + H[1] - T[1], W[2] + H[2] - T[2]];
                let w = if is_carriage { on_axis } else { W };
                let head = Place { t: H, slide_mm: T[0] - H[0], x_mm: 0.0, z_mm: row.z_mm, w };
                let [u_x, u_y, u_z, a, b] = closed_form(is_carriage, &values, &head);
                close(row.head_x_um, u_x, 1e-5, &format!("{what}: head x"));
                close(row.head_y_um, u_y, 1e-5, &format!("{what}: head y"));
                close(row.head_z_um, u_z, 1e-5, &format!("{what}: head z"));
                close(row.head_a_urad, 1e3 * a, 1e-6, &format!("{what}: head a"));
                close(row.head_b_urad, 1e3 * b, 1e-6, &format!("{what}: head b"));
                close(row.midline_um, -u_x, 1e-5, &format!("{what}: midline"));
                seen = seen.max([e_x, e_y, e_z, u_x, u_y, u_z].into_iter().map(f64::abs).fold(0.0, f64::max));
            }
            assert!(!rows.is_empty() && seen > 0.01, "{name:?} of {chain} does nothing");
        }
    }
}
