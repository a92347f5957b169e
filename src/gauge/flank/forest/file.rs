//! The file of a forest: eight bytes that name it, a line of JSON, then the nodes.
//!
//! After the line, little-endian, the first trees and then the second: the number of trees (u16),
//! then of each tree the number of its nodes (u16) and a node as feature (u8, 255 a leaf), value
//! (f32: threshold or share of land) and other child (u16). At most 1 MiB.

use super::tree::{Node, Tree};
use super::{Forest, ForestFacts};

/// What a file begins with.
pub(crate) const MAGIC: &str = "SGFLANK2";
/// Largest file, bytes.
pub(crate) const MOST_BYTES: usize = 1 << 20;
/// Feature of a leaf.
const LEAF: u8 = u8::MAX;

/// The bytes of a forest.
///
/// # Errors
/// More than [`MOST_BYTES`]; a header that cannot be written.
pub(crate) fn write(forest: &Forest) -> Result<Vec<u8>, String> {
    let mut bytes = MAGIC.as_bytes().to_vec();
    bytes.extend(serde_json::to_vec(&forest.facts).map_err(|e| e.to_string())?);
    bytes.push(b'\n');
    for trees in [&forest.trees, &forest.second] {
        write_trees(trees, &mut bytes);
    }
    if bytes.len() > MOST_BYTES {
        return Err(format!(
            "the model has {} bytes, at most {MOST_BYTES} are allowed: fewer or smaller trees",
            bytes.len()
        ));
    }
    Ok(bytes)
}

fn write_trees(trees: &[Tree], bytes: &mut Vec<u8>) {
    bytes.extend((trees.len() as u16).to_le_bytes());
    for tree in trees {
        bytes.extend((tree.nodes.len() as u16).to_le_bytes());
        for node in &tree.nodes {
            let (feature, value, other) = match *node {
                Node::Split { feature, below, other } => (feature, below, other),
                Node::Leaf(share) => (LEAF, share, 0),
            };
            bytes.push(feature);
            bytes.extend(value.to_le_bytes());
            bytes.extend(other.to_le_bytes());
        }
    }
}

/// Bytes that are read one after another.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (first, rest) = self.0.split_first_chunk::<N>().ok_or("it ends early")?;
        self.0 = rest;
        Ok(*first)
    }
}

/// Reads a forest of so many features, and so many more of the second trees.
///
/// # Errors
/// Bytes that are no forest, or one of other features, in words.
pub(crate) fn read(bytes: &[u8], (features, context): (usize, usize)) -> Result<Forest, String> {
    if bytes.len() > MOST_BYTES {
        return Err(format!("{} bytes, at most {MOST_BYTES}", bytes.len()));
    }
    let body = bytes.strip_prefix(MAGIC.as_bytes()).ok_or("not a file of `tool train`")?;
    let end = body.iter().position(|b| *b == b'\n').ok_or("no header")?;
    let facts: ForestFacts = serde_json::from_slice(&body[..end]).map_err(|e| format!("header: {e}"))?;
    if facts.features != features {
        return Err(format!("trained on {} features a pixel, this program has {features}", facts.features));
    }
    let mut reader = Reader(&body[end + 1..]);
    let trees = trees_of(&mut reader, features)?;
    let second = trees_of(&mut reader, features + context)?;
    if trees.is_empty() || !reader.0.is_empty() {
        return Err("no trees, or more than the trees it states".to_owned());
    }
    Ok(Forest { trees, second, facts })
}

fn trees_of(reader: &mut Reader<'_>, features: usize) -> Result<Vec<Tree>, String> {
    let count = u16::from_le_bytes(reader.take()?);
    (0..count).map(|_| tree(reader, features)).collect()
}

fn tree(reader: &mut Reader<'_>, features: usize) -> Result<Tree, String> {
    let count = u16::from_le_bytes(reader.take()?);
    let mut nodes = Vec::with_capacity(usize::from(count));
    for at in 0..count {
        let [feature] = reader.take()?;
        let value = f32::from_le_bytes(reader.take()?);
        let other = u16::from_le_bytes(reader.take()?);
        if !value.is_finite() {
            return Err(format!("node {at} is not a number"));
        }
        nodes.push(match feature {
            LEAF => Node::Leaf(value.clamp(0.0, 1.0)),
            f if usize::from(f) < features && other > at && other < count && at + 1 < count => {
                Node::Split { feature, below: value, other }
            }
            _ => return Err(format!("node {at} points nowhere")),
        });
    }
    if nodes.is_empty() { Err("a tree without nodes".to_owned()) } else { Ok(Tree { nodes }) }
}
