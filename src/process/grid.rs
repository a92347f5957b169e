//! The nodes along a workpiece at which a pass is cut, and the elements between them.
//!
//! Even on a plain shaft. On a stepped one corners of the contour are nodes; a shoulder is two
//! nodes at one place, the side of the chuck first, with an element without length between them.

use crate::plan::{Contour, Side};

/// Nodes and elements from chuck to tailstock.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    /// Machine z of every node, mm, ascending from 0.
    z_mm: Vec<f64>,
    /// Length of every element, mm.
    element_mm: Vec<f64>,
    /// Length of all elements, where they are even, mm.
    even_mm: Option<f64>,
    /// Nominal diameter at every node less the largest one, mm; 0 on a plain shaft.
    relative_mm: Vec<f64>,
}

impl Grid {
    /// Even elements of about `node_mm`.
    pub(super) fn even(length_mm: f64, node_mm: f64) -> Self {
        let elements = (length_mm / node_mm).round().clamp(2.0, 1e6) as usize;
        let step_mm = length_mm / elements as f64;
        Self {
            z_mm: (0..=elements).map(|node| node as f64 * step_mm).collect(),
            element_mm: vec![step_mm; elements],
            even_mm: Some(step_mm),
            relative_mm: vec![0.0; elements + 1],
        }
    }

    /// Elements of about `node_mm` between the ends of the sections and tapers of a contour.
    pub(super) fn along(contour: &Contour, length_mm: f64, node_mm: f64) -> Self {
        let mut corners = vec![0.0, length_mm];
        let ends = contour.sections.iter().map(|s| s.ends_mm);
        for (from, to) in ends.chain(contour.tapers.iter().map(|t| t.ends_mm)) {
            corners.extend([from, to]);
        }
        corners.retain(|z| (0.0..=length_mm).contains(z));
        corners.sort_by(f64::total_cmp);
        corners.dedup();
        let (mut z_mm, mut relative_mm) = (Vec::new(), Vec::new());
        let mut put = |z: f64, side: Side| {
            z_mm.push(z);
            relative_mm.push(contour.relative_mm(z, side));
        };
        for pair in corners.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            put(from, Side::Tailstock);
            let count = ((to - from) / node_mm).round().clamp(1.0, 1e6) as usize;
            let inner = (1..count).map(|i| from + (to - from) * i as f64 / count as f64);
            inner.for_each(|z| put(z, Side::Chuck));
            put(to, Side::Chuck);
        }
        let element_mm = z_mm.windows(2).map(|pair| pair[1] - pair[0]).collect();
        Self { z_mm, element_mm, even_mm: None, relative_mm }
    }

    /// Machine z of every node, mm.
    pub(super) fn z_mm(&self) -> &[f64] {
        &self.z_mm
    }

    /// Length of every element, mm.
    pub(super) fn element_mm(&self) -> &[f64] {
        &self.element_mm
    }

    /// Nominal diameter at every node less the largest one, mm.
    pub(super) fn relative_mm(&self) -> &[f64] {
        &self.relative_mm
    }

    /// Free length, mm.
    pub(super) fn length_mm(&self) -> f64 {
        let even = self.even_mm.map(|step| step * self.element_mm.len() as f64);
        even.unwrap_or_else(|| self.z_mm.last().copied().unwrap_or(0.0))
    }

    /// Number of even nodes, and their distance in mm, of a grid as fine as this one: for what is
    /// drawn along the shaft by seed.
    pub(super) fn like_even(&self, node_mm: f64) -> (usize, f64) {
        let even = self.even_mm.map(|step| (self.z_mm.len(), step));
        even.unwrap_or_else(|| {
            let even = Self::even(self.length_mm(), node_mm);
            (even.z_mm.len(), even.element_mm[0])
        })
    }

    /// The node nearest to a place; of two at one place the later.
    pub(super) fn nearest(&self, z_mm: f64) -> usize {
        if let Some(step) = self.even_mm {
            return (z_mm / step).round().max(0.0) as usize;
        }
        let far = |node: &usize| (self.z_mm[*node] - z_mm).abs();
        (0..self.z_mm.len()).rev().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
    }

    /// A place in nodes: the node before it and the share of the element after that.
    pub(super) fn place(&self, z_mm: f64) -> f64 {
        if let Some(step) = self.even_mm {
            return z_mm / step;
        }
        let last = self.element_mm.len() - 1;
        let node = self.z_mm.partition_point(|z| *z <= z_mm).saturating_sub(1).min(last);
        let length = self.element_mm[node];
        node as f64 + if length > 0.0 { (z_mm - self.z_mm[node]) / length } else { 0.0 }
    }

    /// The same from the other end.
    pub(super) fn mirrored(&self) -> Self {
        let length = self.length_mm();
        Self {
            z_mm: match self.even_mm {
                Some(_) => self.z_mm.clone(),
                None => self.z_mm.iter().rev().map(|z| length - z).collect(),
            },
            element_mm: self.element_mm.iter().rev().copied().collect(),
            even_mm: self.even_mm,
            relative_mm: self.relative_mm.iter().rev().copied().collect(),
        }
    }
}
