//! The instrument decides by thresholds that a study can vary: numeric constants of `src/gauge`
//! outside `limits!` are counted, every group is listed in `src/gauge/instrument/thresholds.rs`,
//! and every field says why it has its value.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use proc_macro2::TokenStream;
use syn::parse::{Parse, ParseStream};
use syn::visit::{self, Visit};
use syn::{Attribute, Expr, ExprLit, Ident, Lit, LitStr, Token, Type};

use super::texts;

/// Most numeric constants of `src/gauge` outside groups of thresholds: what the compiler needs
/// (lengths of arrays, generics, lanes of a kernel), what stands in the interface, mathematics.
const MOST: usize = 60;

/// Published tables, which nobody tunes: file and name.
const TABLES: [(&str, &str); 2] = [
    // Corner radii of ISO 1832.
    ("src/gauge/nose/centre.rs", "ISO_1832_MM"),
    // Variance of a median of few values (David & Nagaraja, Order Statistics).
    ("src/gauge/diameter/reading_series.rs", "SMALL"),
];

/// A call of `limits!`.
pub(super) struct Group {
    ident: Ident,
    pub(super) name: LitStr,
    /// Every field with its comment, empty where there is none.
    pub(super) fields: Vec<(String, String)>,
}

impl Group {
    /// Fields without a comment.
    fn bare(&self) -> Vec<&str> {
        self.fields.iter().filter(|(_, why)| why.is_empty()).map(|(field, _)| field.as_str()).collect()
    }
}

/// The text of a comment, its lines joined.
fn text_of(comment: &[Attribute]) -> String {
    let line = |a: &Attribute| match &a.meta.require_name_value().ok()?.value {
        Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value().trim().to_owned()),
        _ => None,
    };
    comment.iter().filter_map(line).collect::<Vec<String>>().join(" ")
}

impl Parse for Group {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        Attribute::parse_outer(input)?;
        let ident = input.parse()?;
        input.parse::<Token![=]>()?;
        let name = input.parse()?;
        input.parse::<Token![;]>()?;
        let mut fields = Vec::new();
        while !input.is_empty() {
            let comment = Attribute::parse_outer(input)?;
            let field: Ident = input.parse()?;
            input.parse::<Token![:]>()?;
            input.parse::<Type>()?;
            input.parse::<Token![=]>()?;
            input.parse::<Expr>()?;
            input.parse::<Token![;]>()?;
            fields.push((field.to_string(), text_of(&comment)));
        }
        Ok(Self { ident, name, fields })
    }
}

/// What a file declares, tests left out.
#[derive(Default)]
pub(super) struct Declared {
    constants: Vec<String>,
    pub(super) groups: Vec<Group>,
}

/// Whether a type is a number, or an array, slice or tuple of some.
fn is_numeric(ty: &Type) -> bool {
    const NUMBERS: [&str; 14] = [
        "f32", "f64", "u8", "u16", "u32", "u64", "u128", "usize", "i8", "i16", "i32", "i64", "i128", "isize",
    ];
    match ty {
        Type::Path(path) => path.path.segments.last().is_some_and(|s| NUMBERS.iter().any(|n| s.ident == n)),
        Type::Array(array) => is_numeric(&array.elem),
        Type::Slice(slice) => is_numeric(&slice.elem),
        Type::Reference(to) => is_numeric(&to.elem),
        Type::Tuple(tuple) => tuple.elems.iter().any(is_numeric),
        _ => false,
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    let tokens = |a: &Attribute| a.meta.require_list().map(|list| list.tokens.to_string());
    attributes.iter().any(|a| a.path().is_ident("cfg") && tokens(a).is_ok_and(|text| text == "test"))
}

impl Declared {
    pub(super) fn of(text: &str) -> Self {
        let mut found = Self::default();
        found.visit_file(&syn::parse_file(text).expect("a source file"));
        found
    }

    fn constant(&mut self, ident: &Ident, ty: &Type) {
        if is_numeric(ty) {
            self.constants.push(ident.to_string());
        }
    }
}

impl<'ast> Visit<'ast> for Declared {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        if !is_test(&function.attrs) {
            visit::visit_item_fn(self, function);
        }
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        if !is_test(&item.attrs) {
            self.constant(&item.ident, &item.ty);
        }
    }

    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.constant(&item.ident, &item.ty);
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.constant(&item.ident, &item.ty);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        if call.path.is_ident("limits") {
            let tokens: TokenStream = call.tokens.clone();
            self.groups.push(syn::parse2(tokens).expect("a group of thresholds"));
        }
    }
}

/// What the files of the instrument declare, but for files of tests.
pub(super) fn declared() -> Vec<(PathBuf, Declared)> {
    let of_gauge = |file: &Path| file.starts_with("src/gauge") && !file.ends_with("tests.rs");
    let files = texts().into_iter().filter(|(file, _)| of_gauge(file));
    files.map(|(file, text)| (file, Declared::of(&text))).collect()
}

fn is_table(file: &Path, name: &str) -> bool {
    TABLES.iter().any(|(of, table)| file == Path::new(of) && name == *table)
}

#[test]
fn numeric_constants_of_the_instrument_are_few() {
    let mut lines = BTreeMap::new();
    for (file, found) in declared() {
        let names: Vec<String> = found.constants.into_iter().filter(|n| !is_table(&file, n)).collect();
        if !names.is_empty() {
            lines.insert(file, names);
        }
    }
    let count: usize = lines.values().map(Vec::len).sum();
    println!("numeric constants of src/gauge outside groups of thresholds: {count}");
    let list: Vec<String> =
        lines.iter().map(|(file, names)| format!("{}: {}", file.display(), names.join(" "))).collect();
    assert!(count <= MOST, "{count} numeric constants, at most {MOST}:\n{}", list.join("\n"));
}

#[test]
fn every_threshold_is_listed_and_has_a_reason() {
    let all = declared();
    let is_list = |file: &Path| file.ends_with("gauge/instrument/thresholds.rs");
    let listed = texts().into_iter().find(|(file, _)| is_list(file)).unwrap().1;
    let mut bad = Vec::new();
    let mut names = Vec::new();
    for (file, group) in all.iter().flat_map(|(file, found)| found.groups.iter().map(move |g| (file, g))) {
        let file = file.display();
        if !listed.contains(&format!("{}::list()", group.ident)) {
            bad.push(format!("{file}: {} is not listed in gauge/instrument/thresholds.rs", group.ident));
        }
        bad.extend(group.bare().into_iter().map(|field| format!("{file}: {field} has no reason")));
        names.push(group.name.value());
    }
    let fields: usize = all.iter().flat_map(|(_, found)| &found.groups).map(|group| group.fields.len()).sum();
    println!("groups of thresholds: {}, their fields: {fields}", names.len());
    let different: std::collections::BTreeSet<&String> = names.iter().collect();
    assert_eq!(different.len(), names.len(), "two groups have one name: {names:?}");
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn planted_constants_are_found() {
    let planted = [
        ("const LEAST: f64 = 0.5;", 1),
        ("pub(crate) const SIZES: (usize, usize) = (3, 12);", 1),
        ("const WIDTHS: [usize; 2] = [5, 7];", 1),
        ("fn f() { const STEP: f32 = 0.25; }", 1),
        ("impl A { pub const FAR: f64 = 7.0; }", 1),
        ("mod inner { static MOST: &[i32] = &[1]; }", 1),
        ("const TEXT: &str = \"7\"; const NAMES: [&str; 1] = [\"a\"];", 0),
        ("#[cfg(test)] mod tests { const SIZE: usize = 4; }", 0),
        ("limits! { A = \"a\"; /// Why.\n most: f64 = 1.0; }", 0),
    ];
    for (text, count) in planted {
        assert_eq!(Declared::of(text).constants.len(), count, "{text}");
    }
    let group = |text: &str| Declared::of(text).groups.remove(0);
    assert!(group("limits! { /// A.\n A = \"a\"; /// Why.\n most: f64 = 1.0; }").bare().is_empty());
    assert_eq!(group("limits! { A = \"a\"; most: f64 = 1.0; least: usize = 2; }").bare(), ["most", "least"]);
}
