//! The nodes that a correction is made for: those of one iteration, or of each flank the mean over
//! the teeth that were measured.

use super::{
    chosen::{ChosenFigures, OfTeeth, of_teeth},
    iteration_nodes,
    same_nodes::{Measured, same_nodes},
    sensitivity::{Corrected, Level, Sensitivity, SensitivityBody},
};
use crate::api::{faults::Faults, gears::requirements::RequirementsBody, measurand::axes::AxesBody};
use flankfit_engine::gear::{
    Gear, Side,
    correction::{
        Flank, Scatter, Setting, TeethMean,
        machine::FlankNode,
        teeth::{MeanNodes, ScatterOf, Tooth},
    },
};

/// Data that a correction is made for.
pub struct Subject<'a> {
    pub level: Level,
    /// The iteration, or those of the gear.
    pub measured: Vec<&'a Measured>,
    /// The newest iteration of the other flank, for the correction of an iteration.
    pub other: Option<&'a Measured>,
    /// Gear of the job.
    pub gear: Option<&'a Gear>,
    pub requirements: Option<&'a RequirementsBody>,
}

/// The nodes of one flank.
pub struct Block {
    pub side: Option<Side>,
    /// Their places, with a machine.
    pub flank: Option<Flank>,
    pub mean: TeethMean,
    /// The trace of each node, where every trace has a zero of its own.
    pub traces: Option<Vec<usize>>,
    /// The iterations that were taken, the one whose nodes they are first.
    pub numbers: Vec<u32>,
    /// Their teeth, where they say it.
    pub teeth: Vec<String>,
    /// Figures of the chosen fits of the iterations; empty where the nodes have other weights.
    pub chosen: Vec<ChosenFigures>,
}

impl Block {
    /// Returns the figures of the teeth by their fits.
    pub fn fitted(&self) -> OfTeeth {
        self.flank.as_ref().map(|flank| of_teeth(flank, &self.chosen)).unwrap_or_default()
    }

    /// Returns what the scatter of teeth leaves in one of the means of this flank, or in the
    /// difference of two.
    pub fn scatter(&self, means: Vec<&TeethMean>) -> Scatter {
        Scatter::of(&[ScatterOf { means, places: places(self.flank.as_ref()), weight: 1.0 }])
    }
}

/// Options for reading nodes.
#[derive(Clone, Copy)]
pub struct How<'a> {
    pub sensitivity: &'a SensitivityBody,
    pub level: Level,
    /// Gear of the job.
    pub gear: Option<&'a Gear>,
    /// As asked for.
    pub absolute: Option<bool>,
    /// As asked for, of all nodes.
    pub trace: Option<&'a [usize]>,
}

/// Flanks one behind the other, with what the settings do to their nodes.
pub struct Blocks {
    /// The contract's name of the sensitivity.
    pub method: &'static str,
    pub settings: Vec<Setting>,
    pub matrix: Vec<f64>,
    pub blocks: Vec<Block>,
    pub absolute: bool,
    pub traces: Option<Vec<usize>>,
    /// Whether the traces are whole flanks.
    pub flank_zeros: bool,
}

impl Blocks {
    /// Reads the sensitivity for the nodes `measured`. `None` with a fault.
    pub fn read(measured: &[&Measured], how: How<'_>, faults: &mut Faults) -> Option<Self> {
        let groups = groups(measured, how.level);
        let mut found: Vec<Sensitivity> = Vec::with_capacity(groups.len());
        let mut zeros: Vec<Option<Vec<usize>>> = Vec::with_capacity(groups.len());
        let mut before = 0;
        for group in &groups {
            let reference = group.last()?;
            // a matrix is of the nodes of all flanks
            if found.first().is_none_or(|first| first.flank.is_some()) {
                found.push(sensitivity_of(reference, how, faults)?);
            }
            let own = before..before + tooth(reference, how, faults)?.deviation.len();
            before = own.end;
            zeros.push(match how.trace {
                Some(trace) if groups.len() > 1 => trace.get(own).map(<[usize]>::to_vec),
                Some(trace) => Some(trace.to_vec()),
                None => AxesBody::of(&reference.measurand).ok()?.traces(),
            });
        }
        let of_machine = found.first()?.flank.is_some();
        let absolute = how.absolute.unwrap_or(!of_machine && zeros.iter().all(Option::is_none));
        let method = found.first()?.name;
        let (settings, matrix) = stacked(&mut found);
        let mut flanks = found.into_iter().map(|sensitivity| sensitivity.flank);
        let mut blocks = Vec::with_capacity(groups.len());
        for (group, traces) in groups.iter().zip(zeros) {
            let reference = group.last()?;
            let flank = flanks.next().flatten().map(|flank| Flank { traces: traces.clone(), ..flank });
            let side = flank.as_ref().map(|flank| flank.side).or(reference.measurand.flank);
            let mean = match how.level {
                Level::Gear => {
                    let at = At { flank: flank.as_ref(), nodes: reference, absolute, traces: traces.as_deref() };
                    at.mean(group, how, faults)?
                }
                Level::Iteration | Level::OtherFlank => {
                    let Tooth { deviation, weight, .. } = tooth(reference, how, faults)?;
                    TeethMean::one(deviation, weight)
                }
            };
            let numbers = group.iter().rev().map(|one| one.number).collect();
            let teeth = group.iter().rev().filter_map(|one| one.measurand.tooth.clone()).collect();
            let chosen = group.iter().map(|one| one.chosen.clone()).collect();
            blocks.push(Block { side, flank, mean, traces, numbers, teeth, chosen });
        }
        let (traces, flank_zeros) = of_all(&blocks, absolute, how);
        Some(Blocks { method, settings, matrix, blocks, absolute, traces, flank_zeros })
    }

    /// Deviations of all nodes.
    pub fn deviation(&self) -> Vec<f64> {
        self.blocks.iter().flat_map(|block| block.mean.deviation.iter().copied()).collect()
    }

    /// Weights of all nodes; means over more teeth weigh more.
    pub fn weight(&self) -> Option<Vec<f64>> {
        if let [one] = &self.blocks[..] {
            return one.mean.weight.clone();
        }
        let most = self.most_teeth();
        if self.blocks.iter().all(|block| block.mean.weight.is_none() && block.mean.count == most) {
            return None;
        }
        let own = |block: &Block| -> Vec<f64> {
            let share = block.mean.count as f64 / most as f64;
            let weight = |k: usize| block.mean.weight.as_ref().map_or(1.0, |weight| weight[k]);
            (0..block.mean.deviation.len()).map(|k| share * weight(k)).collect()
        };
        Some(self.blocks.iter().flat_map(own).collect())
    }

    /// The teeth of the flank that has most.
    pub fn most_teeth(&self) -> usize {
        self.blocks.iter().map(|block| block.mean.count).max().unwrap_or(1)
    }

    /// Returns the scatter of teeth in the means, or in those of a later round minus these.
    pub fn scatter(&self, later: &[Option<TeethMean>]) -> Scatter {
        let most = self.most_teeth() as f64;
        let flanks = self.blocks.iter().enumerate().map(|(k, block)| ScatterOf {
            means: std::iter::once(&block.mean).chain(later.get(k).and_then(Option::as_ref)).collect(),
            places: places(block.flank.as_ref()),
            weight: block.mean.count as f64 / most,
        });
        Scatter::of(&flanks.collect::<Vec<_>>())
    }

    /// The means of a later round at the nodes of this one, of each flank that it has; `before` are
    /// the iterations of this one.
    pub fn again(
        &self,
        before: &[&Measured],
        later: &[&Measured],
        how: How<'_>,
    ) -> Result<Vec<Option<TeethMean>>, Faults> {
        let mut faults = Faults::default();
        let (earlier, later) = (groups(before, how.level), groups(later, how.level));
        let of_side = |groups: &[Vec<&Measured>], side: Option<Side>| {
            groups.iter().position(|group| group.iter().any(|one| one.measurand.flank == side))
        };
        let mean = |block: &Block| {
            let nodes = earlier[of_side(&earlier, block.side)?].last()?;
            let at =
                At { flank: block.flank.as_ref(), nodes, absolute: self.absolute, traces: block.traces.as_deref() };
            at.mean(&later[of_side(&later, block.side)?], how, &mut faults)
        };
        let means = self.blocks.iter().map(mean).collect();
        faults.into_result(means)
    }
}

fn places(flank: Option<&Flank>) -> Option<&[FlankNode]> {
    flank.map(|flank| &flank.places[..])
}

/// Iterations by flank, the left one first. The last of a flank is that whose nodes the mean is
/// taken at: the one with most nodes, of equals the newest.
fn groups<'a>(measured: &[&'a Measured], level: Level) -> Vec<Vec<&'a Measured>> {
    if level != Level::Gear {
        return vec![measured.to_vec()];
    }
    let of = |side: Side| {
        let mut own: Vec<&Measured> =
            measured.iter().copied().filter(|one| one.measurand.flank == Some(side)).collect();
        own.sort_by_key(|one| (one.nodes.posted(), one.number));
        own
    };
    [Side::Left, Side::Right].map(of).into_iter().filter(|group| !group.is_empty()).collect()
}

/// The deviations of an iteration, without their places.
fn tooth(measured: &Measured, how: How<'_>, faults: &mut Faults) -> Option<Tooth> {
    let axes = axes(measured, how, faults)?;
    let factor = axes.deviation_factor().map_err(|why| fault(measured, how, "/sensitivity", &why, faults)).ok()?;
    let deviation = iteration_nodes::deviations(&measured.nodes, factor);
    Some(Tooth { deviation, weight: iteration_nodes::weights(&measured.nodes), places: None })
}

fn axes(measured: &Measured, how: How<'_>, faults: &mut Faults) -> Option<AxesBody> {
    AxesBody::of(&measured.measurand).map_err(|why| fault(measured, how, "/sensitivity", &why, faults)).ok()
}

fn sensitivity_of(measured: &Measured, how: How<'_>, faults: &mut Faults) -> Option<Sensitivity> {
    let axes = axes(measured, how, faults)?;
    let Measured { nodes, measurand, .. } = measured;
    let iteration = Corrected { nodes, measurand, axes: &axes, gear: how.gear, level: how.level };
    let mut own = Faults::default();
    let found = how.sensitivity.read(iteration, &mut own);
    for one in own.list() {
        fault(measured, how, &one.pointer, &one.detail, faults);
    }
    found
}

/// Adds a fault, which of a gear names the iteration where it is about its nodes.
fn fault(measured: &Measured, how: How<'_>, pointer: &str, detail: &str, faults: &mut Faults) {
    const OF_NODES: [&str; 4] =
        ["/sensitivity", "/sensitivity/machine", "/sensitivity/profile_axis", "/sensitivity/flank"];
    match how.level == Level::Gear && how.gear.is_some() && OF_NODES.contains(&pointer) {
        true => faults.push(pointer, format!("iteration {}: {detail}", measured.number)),
        false => faults.push(pointer, detail),
    }
}

/// Settings of all flanks by their names, in the order in which the flanks have them, and their
/// matrix.
fn stacked(all: &mut [Sensitivity]) -> (Vec<Setting>, Vec<f64>) {
    if let [one] = all {
        return (std::mem::take(&mut one.settings), std::mem::take(&mut one.matrix));
    }
    let mut settings: Vec<Setting> = Vec::new();
    for j in 0..all.iter().map(|one| one.settings.len()).max().unwrap_or(0) {
        for setting in all.iter().filter_map(|one| one.settings.get(j)) {
            if settings.iter().all(|there| there.name != setting.name) {
                settings.push(setting.clone());
            }
        }
    }
    let mut matrix = Vec::new();
    for one in all.iter() {
        let place = |setting: &Setting| settings.iter().position(|there| there.name == setting.name);
        let places: Vec<Option<usize>> = one.settings.iter().map(place).collect();
        for row in one.matrix.chunks(one.settings.len().max(1)) {
            let start = matrix.len();
            matrix.resize(start + settings.len(), 0.0);
            for (x, place) in row.iter().zip(&places) {
                if let Some(place) = place {
                    matrix[start + place] = *x;
                }
            }
        }
    }
    (settings, matrix)
}

/// The zeros of all nodes, and whether they are those of whole flanks: without a datum every flank
/// has one of its own.
fn of_all(blocks: &[Block], absolute: bool, how: How<'_>) -> (Option<Vec<usize>>, bool) {
    if let Some(trace) = how.trace {
        return (Some(trace.to_vec()), false);
    }
    if let [one] = blocks {
        return (one.traces.clone(), false);
    }
    let none = blocks.iter().all(|block| block.traces.is_none());
    if absolute && none {
        return (None, false);
    }
    let mut all = Vec::new();
    for (number, block) in blocks.iter().enumerate() {
        let label = |trace: usize| trace * blocks.len() + number;
        all.extend(match &block.traces {
            Some(traces) => traces.iter().map(|trace| label(*trace)).collect(),
            None => vec![label(0); block.mean.deviation.len()],
        });
    }
    (Some(all), none)
}

/// Nodes at which a mean is taken.
struct At<'a> {
    flank: Option<&'a Flank>,
    /// The iteration whose nodes they are.
    nodes: &'a Measured,
    absolute: bool,
    traces: Option<&'a [usize]>,
}

impl At<'_> {
    /// The mean over the iterations of a flank.
    fn mean(&self, group: &[&Measured], how: How<'_>, faults: &mut Faults) -> Option<TeethMean> {
        // first the one whose nodes they are
        let each = group.iter().rev().map(|one| self.tooth(one, how, faults));
        let teeth: Vec<Tooth> = each.collect::<Option<_>>()?;
        let count = match self.flank {
            Some(flank) => flank.places.len(),
            None => tooth(self.nodes, how, faults)?.deviation.len(),
        };
        let traces = self.traces.filter(|traces| traces.len() == count);
        let nodes = MeanNodes { count, places: places(self.flank), absolute: self.absolute, traces };
        let unmatched = |number: u32| {
            format!(
                "iteration {number} has its nodes at other places, and a second-order surface cannot be fitted to \
                 them: choose `teeth` without it"
            )
        };
        let found = TeethMean::of(&teeth, nodes);
        found.map_err(|why| faults.push("/teeth", unmatched(group[group.len() - 1 - why.tooth].number))).ok()
    }

    fn tooth(&self, measured: &Measured, how: How<'_>, faults: &mut Faults) -> Option<Tooth> {
        let found = tooth(measured, how, faults)?;
        if self.flank.is_some() {
            let flank = sensitivity_of(measured, how, faults)?.flank?;
            return Some(Tooth { places: Some(flank.places), ..found });
        }
        match same_nodes(self.nodes, measured, None, measured.number) {
            Ok(()) => Some(found),
            Err(why) => {
                faults.push("/teeth", format!("{why}: with a matrix all teeth of a flank have the same nodes"));
                None
            }
        }
    }
}
