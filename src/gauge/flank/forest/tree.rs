//! One decision tree.

/// A node: a split, or a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Node {
    /// Below the threshold to the next node, otherwise to `other`.
    Split {
        /// Feature that is compared.
        feature: u8,
        /// Threshold.
        below: f32,
        /// The node for values that are not below.
        other: u16,
    },
    /// Share of land.
    Leaf(f32),
}

/// Nodes, the root first; the child of smaller values follows its parent.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tree {
    /// The nodes.
    pub nodes: Vec<Node>,
}

impl Tree {
    /// Share of land of the leaf of a pixel; children stand behind their parents, so that it ends.
    pub(crate) fn share(&self, feature: impl Fn(usize) -> f32) -> f32 {
        let mut at = 0;
        loop {
            match self.nodes.get(at) {
                Some(Node::Split { feature: f, below, other }) => {
                    at = if feature(usize::from(*f)) < *below { at + 1 } else { usize::from(*other) };
                }
                Some(Node::Leaf(share)) => return *share,
                None => return 0.5,
            }
        }
    }
}
