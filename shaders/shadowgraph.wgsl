// A shadowgraph: Gaussian (or tabulated) edges integrated over the pixel, levels, light over the field, contamination,
// sensor noise, quantisation.
//
// `fill` writes bright field and shadow everywhere, `band` overwrites the rows that an edge touches, `constant`
// writes one value: the floor that full frames are compared with. Pixels are packed 4, 2 or 1 to a 32-bit word
// (8-bit counts, 16-bit counts, f32 counts). The CPU twin is src/render/kernel/{shadowgraph,cpu}.rs: same names, same order.
//
// Written for processors as devices too: there an invocation costs as much as its store, a load from a storage buffer is
// a loop over the lanes, a loop runs under an execution mask and a branch runs both sides. So an invocation fills 16
// rows spelt out, tables lie in uniforms where they fit, keys are computed, and what a frame has not is compiled out.

override pixels_per_word: u32 = 2u;
override with_pattern: u32 = 0u;
override with_overlap: u32 = 0u;
override with_light: u32 = 0u;
override with_stack: u32 = 0u;
override with_profiles: u32 = 0u;
override nodes: u32 = 1u;
override esf_in_uniform: u32 = 1u;

// Segments that fit the largest uniform binding every Vulkan device has for certain: 16 KiB.
const esf_uniform_segments: u32 = 1024u;

struct Params {
    rows: u32,
    columns: u32,
    words: u32,
    nodes: u32,
    row0: u32,
    column0: u32,
    split: u32,
    skip: u32,
    noise_key: vec2<u32>,
    pattern_key: vec2<u32>,
    band_rows: u32,
    esf_segments: u32,
    esf_reach: f32,
    esf_per_unit: f32,
    shadow: f32,
    contrast: f32,
    black: f32,
    electrons_per_count: f32,
    read_variance: f32,
    noise: f32,
    light: u32,
    light_words: u32,
    flat_bright: vec4<f32>,
    flat_shadow: vec4<f32>,
    most: i32,
    overlap: u32,
    pattern: u32,
    hot_share: u32,
    prnu: f32,
    dsnu: f32,
    hot: f32,
    ceiling: f32,
    field: vec4<f32>,
    sag: f32,
    half_diagonals: f32,
    axis: vec2<f32>,
    dark_from: u32,
    dark_steps: u32,
    counts_per_electron: f32,
    padding: u32,
}

struct Edge {
    whole: i32,
    part: f32,
    across: f32,
    along: f32,
    table: u32,
    blend: f32,
}

struct Column {
    top: Edge,
    bottom: Edge,
}

struct Node {
    along: f32,
    down: f32,
    weight: f32,
    padding: f32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> columns: array<Column>;
@group(0) @binding(2) var<storage, read> band_start: array<vec2<i32>>;
@group(0) @binding(3) var<uniform> quadrature: array<Node, 64>;
@group(0) @binding(4) var<uniform> esf_small: array<vec4<f32>, esf_uniform_segments>;
@group(0) @binding(5) var<storage, read> esf: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> image: array<u32>;
@group(0) @binding(7) var<storage, read> light_map: array<u32>;

// Row of the sensor that a row of the frame shows: a second window may follow the first.
fn sensor_row(row: u32) -> u32 {
    return params.row0 + row + select(0u, params.skip, row >= params.split);
}

// Keys of a sensor row from those of the frame: one of them is different in every row.
fn row_key(key: vec2<u32>, row: u32) -> vec2<u32> {
    var x = row ^ key.x;
    x = (x ^ (x >> 16u)) * 0x7feb352du;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    return vec2<u32>(x ^ (x >> 16u), x + key.y);
}

// 32 random bits of a pixel.
fn hash(key: vec2<u32>, column: u32) -> u32 {
    var x = (column * 0x9e3779b9u) ^ key.x;
    x = (x ^ (x >> 16u)) * 0x7feb352du;
    x = x + key.y;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    return x ^ (x >> 16u);
}

// A standard normal deviate from 32 bits: two 16-bit numbers add up to a triangular one, which is bent.
fn standard_normal(bits: u32) -> f32 {
    let v = i32(bits >> 16u) + i32(bits & 0xffffu) - 65535;
    let x = f32(v) * 1.52587890625e-5;
    let u = 1.0 - abs(x);
    let p = 5.0540056 + u * (917.0068 + u * (9288.955 + u * (-1999.6582 + u * 4506.544)));
    let q = 1.0 + u * (246.3685 + u * (3911.3911 + u * 986.76636));
    return x * (p / q);
}

// Coefficients of counts = k0 + k1 z + k2 z² + k3 z³ about a mean grey value.
fn shaped(mean: f32) -> vec4<f32> {
    let electrons = max((mean - params.black) * params.electrons_per_count, 0.0);
    let variance = max(params.read_variance + electrons, 1e-6);
    let inverse = 1.0 / variance;
    let sd = params.noise * sqrt(variance) * params.counts_per_electron;
    let ratio = electrons * inverse;
    let kurtosis = ratio * inverse;
    let skew2 = ratio * kurtosis;
    let k2 = params.noise * params.counts_per_electron * 0.16666667 * ratio;
    let k1 = sd * (1.0 - kurtosis * 0.125 + skew2 * 0.1388888888888889);
    let k3 = sd * (kurtosis * 0.041666666666666664 - skew2 * 0.05555555555555555);
    return vec4<f32>(mean - k2, k1, k2, k3);
}

fn sample(k: vec4<f32>, z: f32) -> f32 {
    return k.x + z * (k.y + z * (k.z + z * k.w));
}

// What the sensor's fixed pattern adds to a mean grey value: gain, offset and hot pixels, the same in every frame.
fn fixed_pattern(mean: f32, row: u32, column: u32) -> f32 {
    let key = row_key(params.pattern_key, row);
    let a = hash(key, column);
    let b = hash(key.yx, column);
    let response = params.prnu * (mean - params.black) * standard_normal(a);
    let dark = params.dsnu * standard_normal(b);
    let hot = select(0.0, params.hot, (a + b) * 0x9e3779b9u < params.hot_share);
    return response + dark + hot;
}

// Counts as bits: for integers rounded half to even by adding 1.5·2²³, then clamped as integers; untouched for f32. The
// full well clips first: a sum added to a constant without something between them may be added up in another order.
fn quantise(counts: f32) -> u32 {
    let clipped = min(counts, params.ceiling);
    if (pixels_per_word == 1u) {
        return bitcast<u32>(clipped);
    }
    return u32(clamp(bitcast<i32>(clipped + 12582912.0) - 0x4b400000, 0, params.most));
}

// Share of the light at u, by one tabulated edge-spread function.
fn edge_spread(u: f32, table: u32) -> f32 {
    let place = clamp((u + params.esf_reach) * params.esf_per_unit, 0.0, f32(params.esf_segments));
    let segment = min(u32(place), params.esf_segments - 1u);
    let t = place - f32(segment);
    var c: vec4<f32>;
    if (esf_in_uniform != 0u) {
        c = esf_small[table * params.esf_segments + segment];
    } else {
        c = esf[table * params.esf_segments + segment];
    }
    return c.x + t * (c.y + t * (c.z + t * c.w));
}

// Share of the light of a pixel past an edge that is no straight line: read from the edge's own profile down the column,
// which lies behind the tables, four rows a vector.
fn profile(edge: Edge, row: i32) -> f32 {
    let i = row - edge.whole;
    if (i < 0 || i >= i32(edge.blend)) {
        return select(0.0, 1.0, (i < 0) == (edge.across < 0.0));
    }
    let at = (edge.table & 0x7fffffffu) + u32(i);
    return esf[at >> 2u][at & 3u];
}

// Share of the light that a pixel gets past one edge, integrated over the pixel's area.
fn transmitted(edge: Edge, row: i32) -> f32 {
    if (with_profiles != 0u && edge.table >= 0x80000000u) {
        return profile(edge, row);
    }
    let centre = ((f32(row - edge.whole)) - edge.part) * edge.across;
    var sum = 0.0;
    for (var i = 0u; i < nodes; i++) {
        let node = quadrature[i];
        let u = (centre + node.down * edge.across) + node.along * edge.along;
        var light = edge_spread(u, edge.table);
        if (with_stack != 0u) {
            light = light + edge.blend * (edge_spread(u, edge.table + 1u) - light);
        }
        sum = sum + node.weight * light;
    }
    return sum;
}

// Light over the field: vignetting times the backlight's gradient, 1 on the axis.
fn field_light(row: u32, column: u32) -> f32 {
    let u = (f32(column) - params.axis.x) * params.half_diagonals;
    let v = (f32(row) - params.axis.y) * params.half_diagonals;
    let r2 = u * u + v * v;
    let lens = 1.0 - r2 * (params.field.x + r2 * params.field.y);
    return lens * (1.0 + params.field.z * u + params.field.w * v - params.sag * r2);
}

// What contamination leaves of the light of a pixel of the frame.
fn clear_light(row: u32, column: u32) -> f32 {
    let word = light_map[row * params.light_words + (column >> 1u)];
    return f32((word >> ((column & 1u) << 4u)) & 0xffffu) * 3.0517578125e-5;
}

// Light of the bright field at a pixel of the frame, 1 where it is even and clear.
fn field_factor(row: u32, column: u32) -> f32 {
    var factor = field_light(sensor_row(row), params.column0 + column);
    if (with_light > 1u) {
        factor = factor * clear_light(row, min(column, params.columns - 1u));
    }
    return factor;
}

// A pixel of a known mean, with noise and fixed pattern.
fn pixel(k: vec4<f32>, mean: f32, key: vec2<u32>, row: u32, column: u32) -> u32 {
    let sensor_column = params.column0 + column;
    var counts = sample(k, standard_normal(hash(key, sensor_column)));
    if (with_pattern != 0u) {
        counts = counts + fixed_pattern(mean, row, sensor_column);
    }
    return quantise(counts);
}

// A pixel far from the edges; the band overwrites what is near.
fn flat_pixel(inside: bool, key: vec2<u32>, row: u32, column: u32) -> u32 {
    var k = select(params.flat_bright, params.flat_shadow, inside);
    var mean = params.shadow + select(params.contrast, 0.0, inside);
    if (with_light != 0u) {
        mean = params.shadow + select(params.contrast * field_factor(row, column), 0.0, inside);
        k = shaped(mean);
    }
    return pixel(k, mean, key, sensor_row(row), column);
}

// A pixel in the shadow of all columns.
fn even_pixel(key: vec2<u32>, row: u32, column: u32) -> u32 {
    return pixel(params.flat_shadow, params.shadow, key, sensor_row(row), column);
}

// A pixel near an edge; the other edge adds light only where the two bands overlap.
fn edge_pixel(row: i32, column: u32, key: vec2<u32>, lower: bool) -> u32 {
    let c = columns[min(column, params.columns - 1u)];
    var near = c.top;
    var other = c.bottom;
    if (lower) {
        near = c.bottom;
        other = c.top;
    }
    var light = transmitted(near, row);
    if (with_overlap != 0u) {
        light = light + transmitted(other, row);
    }
    if (with_light != 0u) {
        light = light * field_factor(u32(row), column);
    }
    let mean = params.shadow + params.contrast * light;
    return pixel(shaped(mean), mean, key, sensor_row(u32(row)), column);
}

// The pixels of one word of a row, far from the edges.
fn fill_word(x: u32, row: u32, start: vec2<i32>) {
    let inside = i32(row) >= start.x && i32(row) < start.y + i32(params.band_rows);
    let key = row_key(params.noise_key, sensor_row(row));
    let column = x * pixels_per_word;
    var word = flat_pixel(inside, key, row, column);
    if (pixels_per_word > 1u) {
        word = word | (flat_pixel(inside, key, row, column + 1u) << ((32u / pixels_per_word) & 31u));
    }
    if (pixels_per_word > 2u) {
        word = word | (flat_pixel(inside, key, row, column + 2u) << 16u);
        word = word | (flat_pixel(inside, key, row, column + 3u) << 24u);
    }
    image[row * params.words + x] = word;
}

// The pixels of one word of a row, in the shadow.
fn even_word(x: u32, row: u32) {
    let key = row_key(params.noise_key, sensor_row(row));
    let column = x * pixels_per_word;
    var word = even_pixel(key, row, column);
    if (pixels_per_word > 1u) {
        word = word | (even_pixel(key, row, column + 1u) << ((32u / pixels_per_word) & 31u));
    }
    if (pixels_per_word > 2u) {
        word = word | (even_pixel(key, row, column + 2u) << 16u);
        word = word | (even_pixel(key, row, column + 3u) << 24u);
    }
    image[row * params.words + x] = word;
}

// Sixteen rows of a column of words in the shadow, where the rest of the frame has light to work out.
@compute @workgroup_size(64, 1, 1)
fn shade(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let x = group.x * 64u + local;
    if (x >= params.words) {
        return;
    }
    let row = (group.y + params.dark_from) * 16u;
    even_word(x, row);
    even_word(x, row + 1u);
    even_word(x, row + 2u);
    even_word(x, row + 3u);
    even_word(x, row + 4u);
    even_word(x, row + 5u);
    even_word(x, row + 6u);
    even_word(x, row + 7u);
    even_word(x, row + 8u);
    even_word(x, row + 9u);
    even_word(x, row + 10u);
    even_word(x, row + 11u);
    even_word(x, row + 12u);
    even_word(x, row + 13u);
    even_word(x, row + 14u);
    even_word(x, row + 15u);
}

// Sixteen rows of a column of words; the image has room for rows beyond the frame's last.
@compute @workgroup_size(64, 1, 1)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let x = group.x * 64u + local;
    if (x >= params.words) {
        return;
    }
    let start = band_start[x];
    let row = (group.y + select(0u, params.dark_steps, group.y >= params.dark_from)) * 16u;
    fill_word(x, row, start);
    fill_word(x, row + 1u, start);
    fill_word(x, row + 2u, start);
    fill_word(x, row + 3u, start);
    fill_word(x, row + 4u, start);
    fill_word(x, row + 5u, start);
    fill_word(x, row + 6u, start);
    fill_word(x, row + 7u, start);
    fill_word(x, row + 8u, start);
    fill_word(x, row + 9u, start);
    fill_word(x, row + 10u, start);
    fill_word(x, row + 11u, start);
    fill_word(x, row + 12u, start);
    fill_word(x, row + 13u, start);
    fill_word(x, row + 14u, start);
    fill_word(x, row + 15u, start);
}

@compute @workgroup_size(64, 1, 1)
fn band(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= params.words || id.y >= 2u * params.band_rows) {
        return;
    }
    let lower = id.y >= params.band_rows;
    let first = select(band_start[id.x].x, band_start[id.x].y, lower);
    let row = first + i32(id.y) - select(0, i32(params.band_rows), lower);
    if (row < 0 || row >= i32(params.rows)) {
        return;
    }
    let key = row_key(params.noise_key, sensor_row(u32(row)));
    let column = id.x * pixels_per_word;
    var word = 0u;
    for (var i = 0u; i < pixels_per_word; i++) {
        word = word | (edge_pixel(row, column + i, key, lower) << (i * (32u / pixels_per_word)));
    }
    image[u32(row) * params.words + id.x] = word;
}

@compute @workgroup_size(64, 1, 1)
fn constant(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= params.words || id.y >= params.rows) {
        return;
    }
    image[id.y * params.words + id.x] = params.words;
}
