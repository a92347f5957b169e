//! The gallery's cases: one frame for every family of edges, feature of a shaft, light,
//! contamination and sensor.
//!
//! Each case is the text of a config, so that a user can run and change it.

/// One frame of the gallery.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    /// File stem.
    pub name: &'static str,
    /// Label below the picture.
    pub label: &'static str,
    /// Size of a pixel on the object, µm.
    pub um_per_px: f64,
    /// Diameter of the shaft, mm.
    pub diameter_mm: f64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
    /// Whether the picture is stretched between its own darkest and brightest greys.
    pub stretched: bool,
    /// Tables of the config beyond part, camera and magnification.
    pub tables: &'static str,
}

const fn case(
    name: &'static str,
    label: &'static str,
    um_per_px: f64,
    diameter_mm: f64,
    tables: &'static str,
) -> Case {
    Case { name, label, um_per_px, diameter_mm, angle_deg: 0.0, stretched: false, tables }
}

const fn stretched(case: Case) -> Case {
    Case { stretched: true, ..case }
}

const fn at(angle_deg: f64, case: Case) -> Case {
    Case { angle_deg, ..case }
}

/// All cases, in the order of the contact sheet.
pub(super) const CASES: &[Case] = &[
    // edges
    case("gaussian", "gaussian edge", 2.0, 0.4, "[optics.esf.gaussian]\nsigma_px = 2.0\n"),
    case(
        "partially_coherent",
        "partial coherence, s = .3",
        1.0,
        0.2,
        "[optics.esf.partially_coherent]\nnumerical_aperture = 0.05\ncoherence_ratio = 0.3\n",
    ),
    case(
        "defocused",
        "the same, out of focus",
        1.0,
        0.2,
        "[optics.esf.partially_coherent]\nnumerical_aperture = 0.05\ncoherence_ratio = 0.3\ndefocus_mm = 0.6\n",
    ),
    case(
        "limb",
        "limb of a thick part",
        2.0,
        0.6,
        "[optics.esf.cylinder]\nnumerical_aperture = 0.05\ncoherence_ratio = 0.3\n",
    ),
    case(
        "laser_shadow",
        "laser shadow, fresnel fringes",
        3.0,
        0.6,
        "[optics.esf.fresnel]\nwavelength_nm = 650.0\nbandwidth_nm = 2.0\ndistance_mm = 12.0\n",
    ),
    case(
        "led_shadow",
        "shadow, 30 nm bandwidth",
        3.0,
        0.6,
        "[optics.esf.fresnel]\nwavelength_nm = 650.0\nbandwidth_nm = 30.0\ndistance_mm = 12.0\n",
    ),
    // shafts
    case("cylinder", "cylinder 25 mm", 86.0, 25.0, ""),
    case(
        "steps",
        "shoulders, chamfer, radius",
        30.0,
        7.0,
        "[shaft]\ncontour = [\n  { z_mm = 0.0, diameter_mm = 5.0 }, { z_mm = 16.0, diameter_mm = 5.0, radius_mm = 0.4 },\n  { z_mm = 16.0, diameter_mm = 7.0, chamfer_mm = 0.4 }, { z_mm = 21.0, diameter_mm = 7.0 },\n  { z_mm = 21.0, diameter_mm = 4.0 }, { z_mm = 23.0, diameter_mm = 4.0 }, { z_mm = 23.0, diameter_mm = 6.0 },\n  { z_mm = 40.0, diameter_mm = 6.0 },\n]\n",
    ),
    case(
        "thread",
        "thread m6 x 1",
        25.0,
        6.0,
        "[[shaft.threads]]\nfrom_mm = 14.5\nto_mm = 40.0\npitch_mm = 1.0\n",
    ),
    case(
        "keyway",
        "keyway turning through the edge",
        25.0,
        6.0,
        "[[shaft.keyways]]\nfrom_mm = 16.0\nto_mm = 24.0\nwidth_mm = 2.0\nfloor_mm = 1.8\nangle_deg = 12.0\n",
    ),
    case(
        "flat",
        "flat",
        25.0,
        6.0,
        "[[shaft.flats]]\nfrom_mm = 18.0\nto_mm = 40.0\ndistance_mm = 2.3\nangle_deg = 20.0\n",
    ),
    case(
        "feed_marks",
        "feed marks, .4 mm/r",
        4.0,
        1.0,
        "[shaft.feed_marks]\nfeed_mm = 0.4\nnose_radius_mm = 0.4\n",
    ),
    case(
        "roughness",
        "roughness 3 um rms",
        2.0,
        0.4,
        "[shaft.texture]\nrms_um = 3.0\ncorrelation_z_mm = 0.03\ncorrelation_theta_deg = 6.0\n",
    ),
    at(
        30.0,
        case(
            "bent",
            "bent, tilted, eccentric",
            60.0,
            8.0,
            "[shaft]\npose = { x_mm = 0.4, tilt_mrad = 60.0 }\neccentricity = { amplitude_mm = 0.5, phase_deg = 20.0 }\nbow = { sagitta_mm = 1.5, phase_deg = 0.0 }\n",
        ),
    ),
    // lens and light
    case(
        "light",
        "vignetting and gradient",
        86.0,
        25.0,
        "[light.field]\nvignetting_2 = 0.45\ngradient_along = 0.25\ngradient_down = -0.15\n",
    ),
    case("distortion", "distortion (exaggerated)", 86.0, 25.0, "[optics.distortion]\nk1 = -0.08\n"),
    case(
        "reflection",
        "grazing reflection",
        4.0,
        1.0,
        "[optics.reflection]\nsource_half_angle_deg = 9.0\nacceptance_half_angle_deg = 9.0\npolished_share = 1.0\n",
    ),
    case(
        "motion",
        "vibration during exposure",
        10.0,
        2.0,
        "[camera]\nexposure_us = 2000.0\n[[motion.vibration]]\namplitude_um = 60.0\nfrequency_hz = 1500.0\n",
    ),
    // contamination
    case(
        "mist",
        "coolant mist",
        86.0,
        25.0,
        "[contamination.mist]\nclouds_per_cm2 = 1.2\noptical_depth = 0.5\nhaze_depth = 0.15\n",
    ),
    case(
        "window_droplets",
        "droplets on the window",
        40.0,
        10.0,
        "[contamination]\nwindow_distance_mm = 6.0\n[contamination.window_droplets]\nper_cm2 = 8.0\nradius_um = { median_um = 300.0, geometric_sd = 1.6, largest_um = 1500.0 }\n",
    ),
    case(
        "air_droplets",
        "droplets in the air",
        40.0,
        10.0,
        "[contamination]\nbeam_depth_mm = 40.0\n[contamination.air_droplets]\nper_cm2 = 30.0\nradius_um = { median_um = 120.0, geometric_sd = 1.6, largest_um = 600.0 }\n",
    ),
    case(
        "chips",
        "chips in flight",
        40.0,
        10.0,
        "[contamination]\nbeam_depth_mm = 40.0\n[contamination.chips]\nper_cm2 = 4.0\nhalf_length_um = { median_um = 700.0, geometric_sd = 1.5, largest_um = 2500.0 }\n",
    ),
    case(
        "films",
        "films that turn with the shaft",
        10.0,
        2.5,
        "[contamination.films]\nper_cm2 = 120.0\nthickness_um = { median_um = 40.0, geometric_sd = 1.6, largest_um = 120.0 }\nhalf_extent_um = { median_um = 400.0, geometric_sd = 1.5, largest_um = 1000.0 }\n",
    ),
    case(
        "dirt",
        "dirt and scratches",
        40.0,
        10.0,
        "[contamination]\nwindow_distance_mm = 2.0\n[contamination.dirt]\nper_cm2 = 8.0\nradius_um = { median_um = 100.0, geometric_sd = 1.8, largest_um = 800.0 }\n[contamination.scratches]\nper_cm2 = 1.0\nwidth_um = { median_um = 40.0, geometric_sd = 1.5, largest_um = 200.0 }\n",
    ),
    // sensor
    stretched(case(
        "dim",
        "little light: shot and read noise",
        10.0,
        2.0,
        "[light]\nbright_counts = 140.0\nshadow_counts = 66.0\n",
    )),
    stretched(case(
        "pattern",
        "prnu, dsnu, hot pixels",
        10.0,
        2.0,
        "[light]\nbright_counts = 300.0\nshadow_counts = 70.0\n[sensor]\nprnu_rel = 0.06\ndsnu_e = 20.0\nhot_pixels_ppm = 400.0\nhot_pixel_e = 900.0\n",
    )),
];

/// Rows and columns of a gallery frame.
pub(super) const FRAME: [u32; 2] = [360, 480];

impl Case {
    /// The case's config.
    pub(super) fn toml(&self) -> String {
        let [rows, columns] = FRAME;
        let d = self.diameter_mm;
        // The case's own `[camera]` or `[optics]` table is merged with the common one.
        let mut camera = format!("columns = {columns}\nrows = {rows}\npixel_um = 3.0\n");
        let mut rest = String::new();
        for table in
            self.tables.split_inclusive('\n').collect::<Vec<_>>().chunk_by(|_, b| !b.starts_with('['))
        {
            match table.first() {
                Some(&"[camera]\n") => camera.extend(table[1..].iter().copied()),
                _ => rest.extend(table.iter().copied()),
            }
        }
        format!(
            "# {label}\nname = \"{name}\"\nseed = 3\n\n[part]\nlength_mm = 40.0\nstock_diameter_mm = {stock}\nnominal_diameter_mm = [{d:?}]\naim_mm = 0.0\n\n[scan]\nfields = 1\nangles = 1\n\n[masters]\nframes_each = 1\npins = [{{ diameter_mm = {small}, expanded_u_mm = 0.0001 }}, {{ diameter_mm = {large}, expanded_u_mm = 0.0001 }}]\n\n[camera]\n{camera}\n[optics]\nmagnification = {magnification}\n\n{rest}",
            label = self.label,
            name = self.name,
            stock = 1.1 * d,
            small = 0.9 * d,
            large = 1.05 * d,
            magnification = 3.0 / self.um_per_px,
        )
    }
}
