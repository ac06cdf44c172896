//! The nodes of an iteration as deviations of a flank: heights in µm, u along the profile and v
//! along the axis.

use crate::api::{faults::Faults, measurand::profile_axis::ProfileAxisName};
use flankfit_engine::{
    estimation::{FitSpec, Nodes, spec::Model},
    gear::{
        Gear, ProfileAxis, Side,
        correction::machine::{FlankNode, Ranges},
        evaluation::{
            ToleranceLimits, figures_of_traces,
            flank_surface::{Border, EstimatedFigure, FlankFigures, FlankNodes, SurfaceSettings, estimated_figures},
            settings::{DeviationSign, SlopeSign},
        },
        trace::Direction,
    },
};

/// Deviations in µm, positive where material stands out, in the order posted, row by row of a grid;
/// NaN where missing. `factor` makes them of the heights.
pub fn deviations(nodes: &Nodes, factor: f64) -> Vec<f64> {
    let mut heights = heights(nodes);
    if factor != 1.0 {
        heights.iter_mut().for_each(|z| *z *= factor);
    }
    heights
}

fn heights(nodes: &Nodes) -> Vec<f64> {
    match nodes {
        Nodes::Curve(nodes) => nodes.y().to_vec(),
        Nodes::Scattered(nodes) => nodes.z().to_vec(),
        Nodes::Matrix(nodes) => nodes.y().to_vec(),
        Nodes::Grid(grid) => {
            let valid = |k: usize| grid.valid().as_ref().is_none_or(|valid| valid[k]);
            grid.z().iter().enumerate().map(|(k, z)| if valid(k) { *z } else { f64::NAN }).collect()
        }
    }
}

/// Weights in the same order.
pub fn weights(nodes: &Nodes) -> Option<Vec<f64>> {
    match nodes {
        Nodes::Curve(nodes) => nodes.weight().map(<[f64]>::to_vec),
        Nodes::Scattered(nodes) => nodes.weight().map(<[f64]>::to_vec),
        Nodes::Matrix(nodes) => nodes.weight().map(<[f64]>::to_vec),
        Nodes::Grid(grid) => grid.weight().map(<[f64]>::to_vec),
    }
}

/// What u and v of nodes on a flank are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    pub profile: ProfileAxisName,
    /// What u is multiplied with to be in the unit of that.
    pub u: f64,
    /// What v is multiplied with to be z in mm.
    pub v: f64,
}

/// Where on the flank of a gear the nodes lie; a fault at `/sensitivity` where nobody can say.
pub fn places(nodes: &Nodes, gear: &Gear, side: Side, of: Coordinates) -> Result<Vec<FlankNode>, Faults> {
    let pairs: Vec<(f64, f64)> = match nodes {
        Nodes::Scattered(nodes) => nodes.u().iter().copied().zip(nodes.v().iter().copied()).collect(),
        Nodes::Grid(grid) => grid.u().iter().flat_map(|u| grid.v().iter().map(|v| (*u, *v))).collect(),
        Nodes::Curve(_) | Nodes::Matrix(_) => {
            let detail = "a machine's sensitivity needs nodes with u (along the profile) and v (along the axis)";
            return Err(Faults::one("/sensitivity/machine", detail));
        }
    };
    let (count, mut below) = (pairs.len(), 0usize);
    let mut places = Vec::with_capacity(count);
    for (u, z) in pairs {
        match ProfileAxis::from(of.profile).roll_length(gear, of.profile.value(of.u * u)) {
            Some(roll_length) => places.push(FlankNode { side, roll_length, z: of.v * z }),
            None => below += 1,
        }
    }
    if below > 0 {
        let detail = format!("{below} of the iteration's {count} nodes lie where no involute is: what is their u?");
        return Err(Faults::one("/sensitivity/profile_axis", detail));
    }
    Ok(places)
}

/// A flank that the nodes lie on.
#[derive(Clone, Debug, PartialEq)]
pub struct Flank {
    pub gear: Gear,
    pub side: Side,
    pub places: Vec<FlankNode>,
    pub ranges: Ranges,
    /// The trace of each node, where every trace has a zero of its own.
    pub traces: Option<Vec<usize>>,
}

impl Flank {
    /// The figures of `deviation` (µm, an entry for each node, NaN where undefined) over the
    /// ranges, by the nodes of a `weight` above 0; signs of ISO 1328-1 with DIN's for slopes.
    /// `None` where the nodes do not tell them.
    pub fn figures(&self, deviation: &[f64], weight: Option<&[f64]>) -> Option<FlankFigures> {
        Some(self.estimated_figures(deviation, weight)?.map(|figure| figure.value))
    }

    /// The same with the errors of each.
    pub fn estimated_figures(
        &self,
        deviation: &[f64],
        weight: Option<&[f64]>,
    ) -> Option<FlankFigures<EstimatedFigure>> {
        let [root, tip] = self.ranges.profile;
        if let Some(traces) = self.traces.as_ref().filter(|traces| traces.len() == deviation.len()) {
            let counts = |k: usize| weight.is_none_or(|weight| weight[k] > 0.0);
            let node = |(k, place): (usize, &FlankNode)| {
                let height = if counts(k) { deviation[k] } else { f64::NAN };
                ([place.roll_length, place.z, height], traces[k])
            };
            let nodes: Vec<_> = self.places.iter().enumerate().map(node).collect();
            return figures_of_traces(
                &nodes,
                [[root.min(tip), root.max(tip)], self.ranges.helix],
                &self.gear,
                self.side,
            );
        }
        let valid: Vec<bool> = (0..deviation.len()).map(|k| weight.is_none_or(|weight| weight[k] > 0.0)).collect();
        let of = |coordinate: fn(&FlankNode) -> f64| self.places.iter().map(coordinate).collect::<Vec<f64>>();
        let (profile, z) = (of(|place| place.roll_length), of(|place| place.z));
        let nodes = FlankNodes {
            axis: ProfileAxis::RollLength,
            profile: &profile,
            z: &z,
            deviation,
            valid: Some(&valid),
            grid: false,
        };
        let settings = SurfaceSettings {
            side: self.side,
            profile_range: Some([root.min(tip), root.max(tip)]),
            helix_range: Some(self.ranges.helix),
            border: Border::default(),
            given: DeviationSign::Material,
            // as they are: figures of corrections count along the normal, as their nodes do
            direction: Direction::Transverse,
            sign: SlopeSign::Din,
            limits: ToleranceLimits::default(),
            spec: FitSpec::new(Model::Linear),
        };
        estimated_figures(&self.gear, &nodes, &settings)
    }
}

/// What the nodes span.
pub fn ranges(places: &[FlankNode], gear: &Gear) -> Ranges {
    let span = |of: fn(&FlankNode) -> f64| {
        places.iter().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let [low, high] = span(|place| place.roll_length);
    // from root to tip
    let profile = if gear.outward() < 0.0 { [high, low] } else { [low, high] };
    Ranges { profile, helix: span(|place| place.z) }
}
