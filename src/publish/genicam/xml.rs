//! The XML of a head: GenICam schema 1.1, every feature of the list with its register.
//!
//! EMVA's own parser is stricter than most clients: elements stand in the schema's order (`Unit`
//! before `Representation`), all attributes of the description are present, limits name registers
//! and not features, so that none depends on itself.

use std::fmt::Write as _;

use super::chunk_nodes::{CHUNK_FEATURES, chunk_nodes};
use super::feature::{Access, Category, Feature, Kind, Limit};

/// The lock that clients set while they stream, and the port of the registers.
const LOCK_AND_PORT: &str = concat!(
    "<Integer Name=\"TLParamsLocked\"><Visibility>Invisible</Visibility>",
    "<Value>0</Value><Min>0</Min><Max>1</Max></Integer>\n<Port Name=\"Device\"/>\n",
);

/// Limits that another register moves: node, the sensor's size, what is taken off it.
const LIMITS: [(&str, &str, &str); 4] = [
    ("WidthLimit", "WidthMax_Reg", "OffsetX_Reg"),
    ("HeightLimit", "HeightMax_Reg", "OffsetY_Reg"),
    ("OffsetXLimit", "WidthMax_Reg", "Width_Reg"),
    ("OffsetYLimit", "HeightMax_Reg", "Height_Reg"),
];

/// The XML of these features.
pub(crate) fn xml(features: &[Feature]) -> String {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    out.push_str(concat!(
        "<RegisterDescription ModelName=\"SimulatedHead\" VendorName=\"shadowgauge\" ",
        "ToolTip=\"A simulated shadowgraph head\" StandardNameSpace=\"GEV\" ",
        "SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" ",
        "MajorVersion=\"1\" MinorVersion=\"0\" SubMinorVersion=\"0\" ",
        "ProductGuid=\"6f1d0c1e-5a57-4c1b-9a3e-7368646f7701\" ",
        "VersionGuid=\"6f1d0c1e-5a57-4c1b-9a3e-7368646f7702\" ",
        "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\" ",
        "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" ",
        "xsi:schemaLocation=\"http://www.genicam.org/GenApi/Version_1_1 ",
        "http://www.genicam.org/GenApi/GenApiSchema_Version_1_1.xsd\">\n",
    ));
    categories(features, &mut out);
    out.push_str(LOCK_AND_PORT);
    LIMITS.iter().for_each(|(name, all, off)| formula(name, all, off, &mut out));
    for feature in features {
        node(feature, features, &mut out);
    }
    out.push_str(&chunk_nodes());
    out.push_str("</RegisterDescription>\n");
    out
}

fn formula(name: &str, all: &str, off: &str, out: &mut String) {
    put(out, format_args!("<IntSwissKnife Name=\"{name}\"><pVariable Name=\"ALL\">{all}</pVariable>"));
    put(out, format_args!("<pVariable Name=\"OFF\">{off}</pVariable>"));
    out.push_str("<Formula>ALL - OFF</Formula></IntSwissKnife>\n");
}

fn categories(features: &[Feature], out: &mut String) {
    out.push_str("<Category Name=\"Root\">");
    for category in Category::ALL {
        put(out, format_args!("<pFeature>{}</pFeature>", category.name()));
    }
    out.push_str("</Category>\n");
    for category in Category::ALL {
        put(out, format_args!("<Category Name=\"{}\">", category.name()));
        for feature in features.iter().filter(|f| f.category == category) {
            put(out, format_args!("<pFeature>{}</pFeature>", feature.name));
        }
        if category == Category::ChunkData {
            CHUNK_FEATURES.iter().for_each(|name| put(out, format_args!("<pFeature>{name}</pFeature>")));
        }
        if category == Category::TransportLayer {
            out.push_str("<pFeature>TLParamsLocked</pFeature>");
        }
        out.push_str("</Category>\n");
    }
}

/// Writing to a `String` never fails.
fn put(out: &mut String, text: std::fmt::Arguments<'_>) {
    let _ = out.write_fmt(text);
}

/// A feature's node, and that of its register.
fn node(feature: &Feature, all: &[Feature], out: &mut String) {
    let name = feature.name;
    let tag = match &feature.kind {
        Kind::Integer(..) | Kind::Long | Kind::Bits(..) => "Integer",
        Kind::Float(..) => "Float",
        Kind::Choice(_) | Kind::Switch(_) => "Enumeration",
        Kind::Flag | Kind::Bit(_) => "Boolean",
        Kind::Command(_) => "Command",
        Kind::Text(_) => return text_node(feature, out),
    };
    put(out, format_args!("<{tag} Name=\"{name}\" NameSpace=\"{}\">", name_space(feature)));
    head(feature, out);
    if let Kind::Choice(entries) = &feature.kind {
        entries.iter().for_each(|(entry, value)| choice(entry, *value, out));
    }
    if let Kind::Switch(_) = feature.kind {
        [("Off", 0), ("On", 1)].iter().for_each(|(entry, value)| choice(entry, *value, out));
    }
    put(out, format_args!("<pValue>{name}_Reg</pValue>"));
    limits(feature, out);
    for selected in all.iter().filter(|f| f.selected.is_some_and(|s| s.by == name)) {
        put(out, format_args!("<pSelected>{}</pSelected>", selected.name));
    }
    put(out, format_args!("</{tag}>\n"));
    register(feature, out);
}

fn name_space(feature: &Feature) -> &'static str {
    match feature.category {
        Category::Head | Category::Fault => "Custom",
        _ => "Standard",
    }
}

fn head(feature: &Feature, out: &mut String) {
    put(out, format_args!("<ToolTip>{}</ToolTip><Visibility>", feature.about));
    out.push_str(match feature.category {
        Category::TransportLayer | Category::Fault => "Expert</Visibility>",
        _ => "Beginner</Visibility>",
    });
    if feature.access == Access::WriteAtRest {
        out.push_str("<pIsLocked>TLParamsLocked</pIsLocked>");
    }
}

fn choice(name: &str, value: u32, out: &mut String) {
    put(out, format_args!("<EnumEntry Name=\"{name}\"><Value>{value}</Value></EnumEntry>"));
}

fn limits(feature: &Feature, out: &mut String) {
    match &feature.kind {
        Kind::Integer(least, Limit::Is(largest)) => {
            put(out, format_args!("<Min>{least}</Min><Max>{largest}</Max>"));
        }
        Kind::Integer(least, Limit::Node(node, _)) => {
            put(out, format_args!("<Min>{least}</Min><pMax>{node}</pMax>"));
        }
        Kind::Bits(_, [least, largest]) => {
            put(out, format_args!("<Min>{least}</Min><Max>{largest}</Max>"));
        }
        Kind::Float(least, largest, unit) => {
            put(out, format_args!("<Min>{least:?}</Min><Max>{largest:?}</Max>"));
            if !unit.is_empty() {
                put(out, format_args!("<Unit>{unit}</Unit>"));
            }
        }
        Kind::Command(value) => put(out, format_args!("<CommandValue>{value}</CommandValue>")),
        Kind::Flag | Kind::Bit(_) => out.push_str("<OnValue>1</OnValue><OffValue>0</OffValue>"),
        Kind::Long | Kind::Choice(_) | Kind::Switch(_) | Kind::Text(_) => {}
    }
}

/// What every register node begins with: place, length, access, port; nothing is cached.
fn place(feature: &Feature, out: &mut String) {
    put(out, format_args!("<Address>0x{:x}</Address>", feature.address));
    if let Some(selected) = feature.selected {
        put(out, format_args!("<pIndex Offset=\"{}\">{}_Reg</pIndex>", selected.stride, selected.by));
    }
    let access = if feature.access == Access::Read { "RO" } else { "RW" };
    put(out, format_args!("<Length>{}</Length><AccessMode>{access}</AccessMode>", feature.kind.bytes()));
    out.push_str("<pPort>Device</pPort><Cachable>NoCache</Cachable>");
}

fn register(feature: &Feature, out: &mut String) {
    let name = feature.name;
    let (tag, part) = match &feature.kind {
        Kind::Float(..) => ("FloatReg", String::new()),
        Kind::Bit(bit) | Kind::Switch(bit) => ("MaskedIntReg", format!("<Bit>{bit}</Bit>")),
        Kind::Bits([first, last], _) => ("MaskedIntReg", format!("<LSB>{last}</LSB><MSB>{first}</MSB>")),
        _ => ("IntReg", String::new()),
    };
    put(out, format_args!("<{tag} Name=\"{name}_Reg\" NameSpace=\"Custom\">"));
    place(feature, out);
    out.push_str(&part);
    if tag != "FloatReg" {
        out.push_str("<Sign>Unsigned</Sign>");
    }
    put(out, format_args!("<Endianess>BigEndian</Endianess></{tag}>\n"));
}

fn text_node(feature: &Feature, out: &mut String) {
    put(out, format_args!("<StringReg Name=\"{}\" NameSpace=\"{}\">", feature.name, name_space(feature)));
    head(feature, out);
    place(feature, out);
    out.push_str("</StringReg>\n");
}

#[cfg(test)]
mod tests {
    use super::super::feature::Feature;
    use super::*;

    #[test]
    fn every_name_that_is_used_is_defined_once() {
        let sheet = super::super::data_sheet::DataSheet::of_tests();
        let features: Vec<Feature> = super::super::features(&sheet);
        // entries of a choice have names of their own
        let xml = xml(&features).replace("<EnumEntry Name=\"", "<EnumEntry Entry=\"");
        let between = |open: &str, close: &str| -> Vec<String> {
            let parts = xml.split(open).skip(1);
            parts.map(|part| part.split(close).next().unwrap_or_default().to_owned()).collect()
        };
        let is_definition = |name: &String| !xml.contains(&format!("<pVariable Name=\"{name}\""));
        let mut defined: Vec<String> = between(" Name=\"", "\"").into_iter().filter(is_definition).collect();
        let count = defined.len();
        defined.sort();
        defined.dedup();
        assert_eq!(defined.len(), count, "a node is defined twice");
        for tag in ["pFeature>", "pValue>", "pMax>", "pSelected>", "pPort>", "pIsLocked>"] {
            for name in between(&format!("<{tag}"), "</") {
                assert!(defined.contains(&name), "{tag} names {name}, which no node is");
            }
        }
        let opened = xml.matches('<').count() - xml.matches("</").count() - xml.matches("/>").count() - 1;
        assert_eq!(opened, xml.matches("</").count(), "an element is not closed");
    }
}
