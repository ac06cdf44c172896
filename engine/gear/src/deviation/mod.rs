//! Deviations of a measured gear from its nominal, modified flanks.
//!
//! Measured points or centres of a probe ball ([`measure`]) and topographies that an instrument
//! already gave in µm ([`grid`]) become the same
//! [`Deviations`]: for each point the tooth, the flank, the place on it and the deviation there. A
//! deviation belongs to the foot of the normal of the *unmodified* helicoid; the modification's
//! relief at that foot is added, so that a flank that was machined as designed deviates by 0.
//! [`Direction`] says along which line the size is taken.
//!
//! Tooth 1 is the one at the top (+y at z = 0); numbers go clockwise as the viewer sees them, up to
//! z. A point that is undefined (NaN) keeps its place in the list and has no deviation.

pub mod border;
mod flanks;
pub mod foot;
mod grid;
pub(crate) mod measure;

pub use border::{Border, Borders};
pub use flanks::FlankDeviations;
pub use foot::{Foot, NoFoot};
pub use grid::{Topography, grid};
pub use measure::{FootlessPoints, MeasuredPoint, Measurement, measure};

pub use super::trace::Direction;
use super::{Gear, Side};
use flankfit_geometry::space::Vector;

impl Direction {
    /// Factor by which a size along the normal is multiplied.
    pub fn from_normal(self, gear: &Gear) -> f64 {
        match self {
            Direction::Normal => 1.0,
            Direction::Transverse => 1.0 / gear.base_helix_angle().cos(),
        }
    }
}

/// Material that a modification removes at a side, a roll length and a z (mm), along the normal,
/// µm; NaN where it is not defined.
pub type Relief<'a> = &'a (dyn Fn(Side, f64, f64) -> f64 + Sync);

/// Reference of deviations.
#[derive(Clone, Copy)]
pub struct Reference<'a> {
    /// The nominal gear.
    pub gear: &'a Gear,
    /// Designed modification; `None` for unmodified involutes.
    pub relief: Option<Relief<'a>>,
}

impl<'a> Reference<'a> {
    /// The unmodified flanks of a gear.
    pub fn new(gear: &'a Gear) -> Self {
        Reference { gear, relief: None }
    }

    /// µm; 0 without a modification.
    pub fn relief(&self, side: Side, roll_length: f64, z: f64) -> f64 {
        self.relief.map_or(0.0, |relief| relief(side, roll_length, z))
    }

    /// The node at a foot.
    pub(crate) fn node(&self, foot: &Foot, direction: Direction) -> Result<Node, NoFoot> {
        let relief = self.relief(foot.side, foot.roll_length, foot.z);
        if !relief.is_finite() {
            return Err(NoFoot::NoRelief { roll_length: foot.roll_length, z: foot.z });
        }
        Ok(Node {
            tooth: foot.tooth,
            side: foot.side,
            roll_length: foot.roll_length,
            z: foot.z,
            deviation: (1e3 * foot.distance + relief) * direction.from_normal(self.gear),
            within: true,
        })
    }
}

/// A point of a flank and its deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// From 1, clockwise. Of an undefined point tooth and side are those given, else 0 (none) and
    /// left.
    pub tooth: u32,
    /// Flank of the tooth.
    pub side: Side,
    /// mm; NaN where a measured point is undefined.
    pub roll_length: f64,
    /// mm; NaN where a measured point is undefined.
    pub z: f64,
    /// µm, positive where material protrudes; NaN where undefined.
    pub deviation: f64,
    /// True inside the borders.
    pub within: bool,
}

impl Node {
    /// Returns true for a node that takes part: defined and inside the borders.
    pub fn counts(&self) -> bool {
        self.within && self.deviation.is_finite()
    }

    /// mm; NaN where undefined.
    pub fn diameter(&self, gear: &Gear) -> f64 {
        gear.diameter(self.roll_length)
    }
}

/// Deviations in the order in which their points were given.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviations {
    /// Line along which deviations are taken.
    pub direction: Direction,
    /// Radius of the probe ball whose centres were measured, mm; 0 where points of the surface
    /// were.
    pub ball_radius: f64,
    /// A node for each point given.
    pub nodes: Vec<Node>,
    /// Points without a foot that were taken for undefined, by index.
    pub strays: Vec<(usize, NoFoot)>,
}

impl Deviations {
    /// How many nodes are undefined.
    pub fn undefined(&self) -> usize {
        self.nodes.iter().filter(|node| !node.deviation.is_finite()).count()
    }

    /// How many nodes are defined, but outside the borders.
    pub fn trimmed(&self) -> usize {
        self.nodes.iter().filter(|node| node.deviation.is_finite() && !node.within).count()
    }

    /// How many nodes take part.
    pub fn counted(&self) -> usize {
        self.nodes.iter().filter(|node| node.counts()).count()
    }

    /// √mean of the squares of the nodes that take part, µm; `None` without any.
    pub fn rms(&self) -> Option<f64> {
        let (count, sum) = self
            .nodes
            .iter()
            .filter(|node| node.counts())
            .fold((0.0, 0.0), |(count, sum), node| (count + 1.0, sum + node.deviation * node.deviation));
        (count > 0.0).then(|| (sum / count).sqrt())
    }

    /// Place of the point (the centre of the ball) of a node, mm; `None` for an undefined one.
    pub fn point(&self, reference: &Reference, index: usize) -> Option<Vector> {
        let node = self.nodes.get(index).filter(|node| node.deviation.is_finite())?;
        let normal = node.deviation / self.direction.from_normal(reference.gear);
        let distance = 1e-3 * (normal - reference.relief(node.side, node.roll_length, node.z)) + self.ball_radius;
        Some(foot::above(reference.gear, node.tooth, node.side, node.roll_length, node.z, distance))
    }
}
