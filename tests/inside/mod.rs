//! Tests that reach into the library: physics, properties and goldens of what is not public.
//!
//! They are compiled with the library (`cargo test --lib inside::NAME`), so that nothing has to be
//! public for a test's sake; what is public, and the program, are tested from outside by the files
//! in `tests/`. One file or folder an idea; helpers that several share are in `support`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod contamination_field;
mod control_guards;
mod control_laws;
mod control_learning;
mod control_run;
mod control_stability;
mod deflected;
mod deflected_golden;
mod encoder_frames;
mod field;
mod flank;
mod flat_field_limits;
mod form_features;
mod form_photon_transfer;
mod form_turn;
mod form_zones;
mod gauge_edges;
mod gauge_line;
mod gauge_stream;
mod in_process;
mod job_stations;
mod linuxcnc;
mod live;
mod machine;
mod nc_air_cut;
mod nc_probing;
mod nc_programs;
mod nc_replay;
mod nc_scan;
mod nc_sinumerik;
mod nose;
mod optics_cylinder;
mod optics_esf;
mod optics_lens;
mod optics_limb;
mod probe_run;
mod process;
mod process_studies;
mod publish;
mod reference_pin;
mod render_frames;
mod render_golden;
mod render_light;
mod render_limbs;
mod render_noise;
mod render_optics;
mod render_rolling;
mod render_sensor;
mod render_shaders;
mod render_shaft;
mod ring_measure;
mod run_truth;
mod settled;
mod stepped;
mod stl;
mod tool;
mod uncertainty;
#[cfg(feature = "camera")]
mod wire_cell;

#[path = "../support/mod.rs"]
mod support;
