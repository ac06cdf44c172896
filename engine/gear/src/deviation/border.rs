//! Borders of a measured flank: what lies near its edges (chamfers, tip breaks, burr) does not take
//! part.
//!
//! *Toe* is the end of the smaller z, *heel* the other.

use super::{Deviations, Node};
use crate::Gear;
use flankfit_numerics::{
    check::{self, Faults},
    words::Shown,
};

/// Part of an axis that is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Border {
    /// All of it.
    #[default]
    Whole,
    /// Without these percentages of the range that the defined nodes span, at its lower and its
    /// upper end.
    Trimmed {
        /// Share cut off at the lower end, %.
        low: f64,
        /// Share cut off at the upper end, %.
        high: f64,
    },
    /// From and to, mm, ends included.
    Range {
        /// Lower end, mm.
        from: f64,
        /// Upper end, mm.
        to: f64,
    },
}

/// Over roll length and over z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Borders {
    /// Over roll length.
    pub profile: Border,
    /// Over z, from toe to heel.
    pub face: Border,
}

impl Borders {
    /// Percentages at each edge; on internal gears the root is where the roll is longest.
    pub fn trimmed(gear: &Gear, root: f64, tip: f64, toe: f64, heel: f64) -> Self {
        let (low, high) = if gear.data().internal { (tip, root) } else { (root, tip) };
        Borders { profile: Border::Trimmed { low, high }, face: Border::Trimmed { low: toe, high: heel } }
    }
}

impl Border {
    /// The range over nodes at `at`, or what is wrong with it; `None`: everything.
    fn range(&self, at: impl Iterator<Item = f64>) -> Result<Option<[f64; 2]>, String> {
        match *self {
            Border::Whole => Ok(None),
            Border::Range { from, to } if from <= to && from.is_finite() && to.is_finite() => Ok(Some([from, to])),
            Border::Range { from, to } => Err(check::range([from, to])),
            Border::Trimmed { low, high } => {
                let share = |x: f64| (0.0..=100.0).contains(&x);
                if !(share(low) && share(high) && low + high < 100.0) {
                    let [low, high] = [low, high].map(Shown);
                    return Err(format!("{low} % and {high} % leave no range between the edges"));
                }
                let [least, most] =
                    at.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| [least.min(x), most.max(x)]);
                let span = most - least;
                // a node on the border takes part, whatever the rounding of its place
                let slack = 1e-9 * span;
                Ok((span >= 0.0).then_some([least + 0.01 * low * span - slack, most - 0.01 * high * span + slack]))
            }
        }
    }
}

impl Deviations {
    /// Marks the nodes inside `borders`; earlier borders no longer hold. Refuses borders that leave
    /// no node.
    pub fn set_borders(&mut self, borders: &Borders) -> Result<(), Faults> {
        let at = |place: fn(&Node) -> f64| self.nodes.iter().filter(|n| n.deviation.is_finite()).map(place);
        let profile = borders.profile.range(at(|node| node.roll_length));
        let face = borders.face.range(at(|node| node.z));
        let (profile, face) = match (profile, face) {
            (Ok(profile), Ok(face)) => (profile, face),
            (profile, face) => {
                let mut faults = Faults::default();
                for (path, range) in [("diameter_range_mm", profile), ("z_range_mm", face)] {
                    if let Err(message) = range {
                        faults.push(path, message);
                    }
                }
                return Err(faults);
            }
        };
        let inside = |range: Option<[f64; 2]>, x: f64| range.is_none_or(|[from, to]| from <= x && x <= to);
        let within: Vec<bool> = self
            .nodes
            .iter()
            .map(|n| !n.deviation.is_finite() || (inside(profile, n.roll_length) && inside(face, n.z)))
            .collect();
        let left = |(node, within): (&Node, &bool)| *within && node.deviation.is_finite();
        if self.undefined() < self.nodes.len() && !self.nodes.iter().zip(&within).any(left) {
            return Err(Faults::one("", "no measured node lies inside these borders"));
        }
        self.nodes.iter_mut().zip(within).for_each(|(node, within)| node.within = within);
        Ok(())
    }
}
