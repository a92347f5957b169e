//! Shaders without a GPU: every one is valid, and the host's structs have the shader's layouts.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::mem::offset_of;
use std::path::Path;

use shadowgauge::render::columns::{Column, Edge};
use shadowgauge::render::esf::Node;
use shadowgauge::render::noise::{DENOMINATOR, NUMERATOR};
use shadowgauge::render::params::Params;

fn parse(path: &Path) -> naga::Module {
    let source = std::fs::read_to_string(path).unwrap();
    naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)))
}

fn shadowgraph() -> naga::Module {
    parse(&Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/shadowgraph.wgsl"))
}

#[test]
fn every_shader_is_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let module = parse(&path);
        let result = naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        )
        .validate(&module);
        assert!(result.is_ok(), "{}: {result:?}", path.display());
        count += 1;
    }
    assert!(count > 0, "no shader was found");
}

#[test]
fn a_broken_shader_would_be_found() {
    let source = include_str!("../../shaders/shadowgraph.wgsl").replace("return sum;", "return centre_;");
    assert!(naga::front::wgsl::parse_str(&source).is_err());
}

/// Members (name, offset) and size of a struct in the shader.
fn layout(module: &naga::Module, name: &str) -> (Vec<(String, usize)>, usize) {
    let found = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name));
    let Some((_, naga::Type { inner: naga::TypeInner::Struct { members, span }, .. })) = found else {
        panic!("{name} is no struct of the shader")
    };
    let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset as usize)).collect();
    (members, *span as usize)
}

/// Offsets of fields in groups, under the shader's names.
macro_rules! places {
    ($host:ty, $($in_shader:ident: $($field:ident).+),+) => {
        vec![$((stringify!($in_shader).to_owned(), offset_of!($host, $($field).+))),+]
    };
}

macro_rules! same_layout {
    ($module:expr, $shader:literal, $host:ty, $($field:ident),+ $(; $last:ident = $in_shader:literal)?) => {{
        let (members, size) = layout($module, $shader);
        #[allow(unused_mut, reason = "only some structs name a member differently")]
        let mut host = vec![$((stringify!($field).to_owned(), offset_of!($host, $field))),+];
        $(host.push(($in_shader.to_owned(), offset_of!($host, $last)));)?
        assert_eq!(members[..host.len()], host, "{}", $shader);
        assert_eq!(size, size_of::<$host>(), "size of {}", $shader);
    }};
}

#[test]
fn host_and_shader_agree_on_every_struct() {
    let module = shadowgraph();
    let (members, size) = layout(&module, "Params");
    let host = places!(
        Params,
        rows: size.rows,
        columns: size.columns,
        words: size.words,
        nodes: size.nodes,
        row0: place.row0,
        column0: place.column0,
        split: place.split,
        skip: place.skip,
        noise_key: keys.noise,
        pattern_key: keys.pattern,
        band_rows: edge.band_rows,
        esf_segments: edge.segments,
        esf_reach: edge.reach,
        esf_per_unit: edge.per_unit,
        shadow: signal.shadow,
        contrast: signal.contrast,
        black: signal.black,
        electrons_per_count: signal.electrons_per_count,
        read_variance: signal.read_variance,
        noise: signal.noise,
        light: light.kind,
        light_words: light.words,
        flat_bright: flat.bright,
        flat_shadow: flat.shadow,
        most: pixels.most,
        overlap: pixels.overlap,
        pattern: pixels.pattern,
        hot_share: pixels.hot_share,
        prnu: pixels.prnu,
        dsnu: pixels.dsnu,
        hot: pixels.hot,
        ceiling: pixels.ceiling,
        field: field.polynomial,
        sag: field.sag,
        half_diagonals: field.half_diagonals,
        axis: field.axis,
        dark_from: dark.from,
        dark_steps: dark.steps,
        counts_per_electron: counts_per_electron,
        padding: padding
    );
    assert_eq!(members, host, "Params");
    assert_eq!(size, size_of::<Params>(), "size of Params");
    same_layout!(&module, "Edge", Edge, whole, part, across, along, table, blend);
    same_layout!(&module, "Column", Column, top, bottom);
    same_layout!(&module, "Node", Node, along, down, weight, padding);
}

#[test]
fn shader_carries_the_constants_of_the_noise() {
    let source = include_str!("../../shaders/shadowgraph.wgsl");
    for constant in NUMERATOR.iter().chain(&DENOMINATOR) {
        assert!(source.contains(&format!("{constant}")), "{constant} is not in the shader");
    }
}

#[test]
fn twin_has_every_function_of_the_shader() {
    let twin = concat!(
        include_str!("../../src/render/kernel/shadowgraph.rs"),
        include_str!("../../src/render/kernel/cpu.rs")
    );
    for (_, function) in shadowgraph().functions.iter() {
        let name = function.name.as_deref().unwrap();
        let twin_name = name
            .replace("flat_pixel", "flat_pixels")
            .replace("shaped", "noise_polynomial")
            .replace("fill_word", "fill_block")
            .replace("even_word", "fill_block");
        assert!(twin.contains(&format!("fn {twin_name}")), "{name} has no twin");
    }
}
