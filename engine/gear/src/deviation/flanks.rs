//! The deviations flank by flank, as a fit of a surface or an evaluation takes them.

use std::collections::BTreeMap;

use super::Deviations;
use crate::Side;
use flankfit_numerics::cancel::Asking;

/// The nodes of one flank that take part, in the order given.
#[derive(Clone, Debug, PartialEq)]
pub struct FlankDeviations {
    /// From 1, clockwise.
    pub tooth: u32,
    /// Flank of the tooth.
    pub side: Side,
    /// Which node each entry was.
    pub index: Vec<usize>,
    /// mm.
    pub roll_length: Vec<f64>,
    /// mm.
    pub z: Vec<f64>,
    /// µm.
    pub deviation: Vec<f64>,
}

impl FlankDeviations {}

impl Deviations {
    /// Every flank on which a node takes part, by tooth, the left one first.
    pub fn flanks(&self) -> Vec<FlankDeviations> {
        let mut flanks = BTreeMap::new();
        for (index, node) in self.nodes.iter().enumerate().asking(50).filter(|(_, node)| node.counts()) {
            let flank = flanks.entry((node.tooth, node.side)).or_insert_with(|| FlankDeviations {
                tooth: node.tooth,
                side: node.side,
                index: Vec::new(),
                roll_length: Vec::new(),
                z: Vec::new(),
                deviation: Vec::new(),
            });
            flank.index.push(index);
            flank.roll_length.push(node.roll_length);
            flank.z.push(node.z);
            flank.deviation.push(node.deviation);
        }
        flanks.into_values().collect()
    }
}
