//! Effect of a unit of each machine setting on each node: as a matrix, or by a machine.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::iteration_nodes::{self, Coordinates};
use crate::{
    api::{
        faults::Faults,
        gears::fit_figures::missing,
        measurand::{axes::AxesBody, units::canonical},
    },
    jobs::{Measurand, side_name},
};
use flankfit_engine::{
    estimation::Nodes,
    gear::{
        Gear, ProfileAxis, Side,
        correction::{
            Flank, Setting,
            machine::{Machine, Ranges},
        },
        evaluation::flank_surface::FigureTerms,
    },
    numerics::{check, tagged},
    words::entries,
};

/// Effect of a unit of each setting on each node: as a matrix, or by a machine for cylindrical
/// gears that is known here.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[schema(as = Sensitivity)]
pub enum SensitivityBody {
    /// A matrix with a row for each node and a column for each setting.
    Matrix(MatrixSensitivity),
    /// A machine. Nodes have u along the profile and v = z, and the job has a gear.
    Machine(MachineSensitivity),
}

tagged!(SensitivityBody { "matrix" => Matrix, "machine" => Machine });

/// A matrix with a row for each node and a column for each setting.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MatrixSensitivity {
    /// Names of the settings.
    pub settings: Vec<String>,
    /// Units of the settings.
    pub units: Option<Vec<String>>,
    /// µm per unit: a row for each node in the order posted (of a grid row by row, missing ones
    /// too), an entry for each setting.
    pub matrix: Vec<Vec<f64>>,
}

/// A machine. Nodes have u along the profile and v = z, and the job has a gear.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineSensitivity {
    pub machine: Machine,
    /// The measured flank. By default that of the iteration.
    pub flank: Option<Side>,
    /// Quantity of u of the nodes. By default that of the iteration's axes.
    pub profile_axis: Option<ProfileAxis>,
    /// Range that crownings refer to. By default that of the nodes.
    #[schema(min_items = 2, max_items = 2)]
    pub profile_diameter_range_mm: Option<[f64; 2]>,
    /// Range in z over which angle and crowning of the helix are meant, `[from, to]`. By default
    /// that of the nodes.
    #[schema(min_items = 2, max_items = 2)]
    pub helix_range_mm: Option<[f64; 2]>,
    /// Settings that the machine has for each flank separately, such as the profile angle of a
    /// wheel that is dressed on both sides. Their names end in `_left` or `_right`, and they leave
    /// the other flank as it is. Default none: all settings act on both flanks.
    pub by_flank: Option<Vec<String>>,
}

/// A sensitivity, with the settings that it is of.
pub struct Sensitivity {
    /// The contract's name: `matrix`, or the machine.
    pub name: &'static str,
    pub settings: Vec<Setting>,
    pub matrix: Vec<f64>,
    /// The flank that the nodes lie on, where the sensitivity is that of a machine.
    pub flank: Option<Flank>,
}

/// Nodes that a correction is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The nodes of one iteration.
    Iteration,
    /// All teeth of both flanks.
    Gear,
    /// The other flank than that of an iteration, for which no changes are computed.
    OtherFlank,
}

/// The iteration whose nodes are corrected.
#[derive(Clone, Copy)]
pub struct Corrected<'a> {
    pub nodes: &'a Nodes,
    /// Measurand of the nodes.
    pub measurand: &'a Measurand,
    pub axes: &'a AxesBody,
    /// Gear of the job.
    pub gear: Option<&'a Gear>,
    pub level: Level,
}

const AT: &str = "/sensitivity";

impl SensitivityBody {
    /// Returns the sensitivity for the nodes of an iteration; `None` with a fault.
    pub fn read(&self, iteration: Corrected<'_>, faults: &mut Faults) -> Option<Sensitivity> {
        match self {
            SensitivityBody::Matrix(matrix) => matrix.read(faults),
            SensitivityBody::Machine(machine) => machine.read(iteration, faults),
        }
    }
}

impl MatrixSensitivity {
    fn read(&self, faults: &mut Faults) -> Option<Sensitivity> {
        let (names, matrix) = (&self.settings, &self.matrix);
        let wrong =
            |count: usize| (count != names.len()).then(|| format!("{} for {} settings", entries(count), names.len()));
        let before = faults.count();
        if let Some(detail) = self.units.as_ref().and_then(|units| wrong(units.len())) {
            faults.push("/sensitivity/units", detail);
            return None;
        }
        for (k, detail) in matrix.iter().enumerate().filter_map(|(k, row)| Some((k, wrong(row.len())?))) {
            faults.push(format!("/sensitivity/matrix/{k}"), detail);
        }
        let unit = |j: usize| canonical(self.units.as_ref().map_or("", |units| &units[j])).to_owned();
        let settings = names.iter().enumerate().map(|(j, name)| Setting::free(name, unit(j))).collect();
        let sensitivity = Sensitivity { name: "matrix", settings, matrix: matrix.concat(), flank: None };
        (faults.count() == before).then_some(sensitivity)
    }
}

impl MachineSensitivity {
    fn read(&self, iteration: Corrected<'_>, faults: &mut Faults) -> Option<Sensitivity> {
        let Corrected { nodes, measurand, axes, gear, level } = iteration;
        let machine = self.machine;
        let by_flank = self.by_flank(faults)?;
        if level == Level::Gear && self.flank.is_some() {
            let detail = "a correction of the gear uses the measured flanks; omit it";
            faults.push("/sensitivity/flank", detail);
            return None;
        }
        let side = self.flank.filter(|_| level == Level::Iteration);
        let before = faults.count();
        if let (Some(requested), Some(measured)) = (side, measurand.flank)
            && requested != measured
        {
            let detail = format!("the iteration is of {}, not of the {} one", measurand.words(), side_name(requested));
            faults.push("/sensitivity/flank", detail);
        }
        let side = side.or(measurand.flank);
        for (code, how) in missing(axes, side, gear.is_some()) {
            let place = if code == "flank_missing" { "flank" } else { "machine" };
            faults.push(format!("{AT}/{place}"), how);
        }
        let coordinates = coordinates(self.profile_axis, axes, faults);
        let (gear, side) = gear.zip(side)?;
        let coordinates = coordinates.filter(|_| faults.count() == before)?;
        let (diameters, helix) = (self.profile_diameter_range_mm, self.helix_range_mm);
        let places =
            iteration_nodes::places(nodes, gear, side, coordinates).map_err(|more| faults.append(more)).ok()?;
        let mut ranges: Ranges = iteration_nodes::ranges(nodes, &places, gear);
        if let Some(diameters) = diameters {
            match diameters.map(|diameter| gear.roll_length(diameter)) {
                [Some(low), Some(high)] => ranges.profile = [low, high],
                _ => {
                    faults.push("/sensitivity/profile_diameter_range_mm", "a diameter lies below the base circle");
                    return None;
                }
            }
        }
        ranges.helix = helix.unwrap_or(ranges.helix);
        let given = [diameters.is_some(), helix.is_some()];
        let found = machine.sensitivity(gear, &places, ranges).map_err(|more| faults.append(placed(&more, given)));
        let terms = FigureTerms::default();
        let flank = Some(Flank { gear: gear.clone(), side, places, ranges, traces: None, terms });
        let mut found = found.ok()?;
        for setting in found.settings.iter_mut().filter(|setting| by_flank.contains(&setting.name)) {
            setting.name = format!("{}_{}", setting.name, side_name(side));
        }
        Some(Sensitivity { name: machine.name(), settings: found.settings, matrix: found.matrix, flank })
    }

    /// Returns the settings that the machine has for each flank.
    fn by_flank(&self, faults: &mut Faults) -> Option<&[String]> {
        let machine = self.machine;
        let names = self.by_flank.as_deref().unwrap_or_default();
        let settings: Vec<String> = machine.settings().into_iter().map(|setting| setting.name).collect();
        let before = faults.count();
        for (k, _) in names.iter().enumerate().filter(|(_, name)| !settings.contains(name)) {
            let detail = format!("the machine has no such setting; it has `{}`", settings.join("`, `"));
            faults.push(format!("{AT}/by_flank/{k}"), detail);
        }
        (faults.count() == before).then_some(names)
    }
}

/// Returns u and v of the iteration by its axes.
fn coordinates(requested: Option<ProfileAxis>, axes: &AxesBody, faults: &mut Faults) -> Option<Coordinates> {
    let of_axes = axes.profile().map_err(|why| faults.push("/sensitivity/machine", why)).ok()?;
    let v = axes.along().map_err(|why| faults.push("/sensitivity/machine", why)).ok()?;
    let (profile, u) = of_axes?;
    if requested.is_some_and(|requested| requested != profile) {
        let detail = format!("u of the iteration is `{}`, as its axes say", profile.name());
        faults.push("/sensitivity/profile_axis", detail);
        return None;
    }
    Some(Coordinates { profile, u, v })
}

/// Faults of a machine's sensitivity by places in the request, one for each place; the pair says
/// which ranges are in it.
fn placed(found: &check::Faults, [profile, helix]: [bool; 2]) -> Faults {
    let mut faults = Faults::default();
    let is_of_nodes = |fault: &check::Fault| fault.path.starts_with("nodes");
    let nodes = found.list().iter().filter(|fault| is_of_nodes(fault)).count();
    for fault in found.list() {
        let pointer = match &*fault.path {
            "profile_diameter_range_mm" if profile => "/sensitivity/profile_diameter_range_mm",
            "helix_range_mm" if helix => "/sensitivity/helix_range_mm",
            _ if is_of_nodes(fault) => "/sensitivity/profile_axis",
            // the nodes themselves have no such range
            _ => "/sensitivity/machine",
        };
        if faults.list().iter().any(|there| there.pointer == pointer) {
            continue;
        }
        let message = &fault.message;
        let more = if is_of_nodes(fault) && nodes > 1 {
            let count = found.count() - (found.list().len() - nodes);
            format!("{count} nodes of the iteration have no place on the flank; the first: {message}")
        } else {
            message.clone()
        };
        faults.push(pointer, more);
    }
    faults
}
