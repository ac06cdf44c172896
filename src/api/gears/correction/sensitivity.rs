//! What a unit of each machine setting does to each node: as a matrix, or by a machine.

use super::iteration_nodes::{self, Coordinates};
use crate::{
    api::{
        faults::Faults,
        gears::fit_figures::missing,
        json::{members::of_object, request::request},
        measurand::{axes::AxesBody, side::SideName, units::canonical},
    },
    jobs::{Measurand, side_name},
};
pub use flankfit_engine::gear::correction::machine::Machine as MachineName;
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
    numerics::check,
    words::entries,
};

request! {
    /// What a unit of each setting does to each node: as a matrix, or by a machine for cylindrical
    /// gears that is known here.
    #[schema(as = Sensitivity)]
    pub struct SensitivityBody as SensitivityMembers {
        /// Names of the settings, with `matrix`.
        optional settings: Vec<String>,
        /// Units of the settings, with `matrix`.
        optional units: Vec<String>,
        /// µm per unit: a row for each node in the order posted (of a grid row by row, missing ones
        /// too), an entry for each setting.
        optional matrix: Vec<Vec<f64>>,
        /// In place of a matrix. Nodes then have u along the profile and v = z, and the job has a
        /// gear.
        optional machine: MachineName,
        /// With `machine`: the flank that was measured. By default that of the iteration.
        optional flank: SideName,
        /// With `machine`: what u of the nodes is. By default what the iteration's axes say.
        optional profile_axis: ProfileAxis,
        /// With `machine`: what crownings refer to. By default what the nodes span.
        #[schema(min_items = 2, max_items = 2)]
        optional profile_diameter_range_mm: [f64; 2],
        /// Range in z over which angle and crowning of the helix are meant, `[from, to]`. By
        /// default that of the nodes.
        #[schema(min_items = 2, max_items = 2)]
        optional helix_range_mm: [f64; 2],
        /// With `machine`: settings that it has for each flank by itself, such as the profile angle
        /// of a wheel that is dressed on both sides. Their names end in `_left` or `_right`, and
        /// they leave the other flank as it is. Default none: all settings act on both flanks.
        optional by_flank: Vec<String>,
    }
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

/// What a correction is made for.
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
    /// What they are of.
    pub measurand: &'a Measurand,
    pub axes: &'a AxesBody,
    /// Of the job.
    pub gear: Option<&'a Gear>,
    pub level: Level,
}

const AT: &str = "/sensitivity";

/// Reads the sensitivity for the nodes of an iteration.
pub fn read(slice: &[u8], iteration: Corrected<'_>, faults: &mut Faults) -> Option<Sensitivity> {
    let members: SensitivityMembers<'_> = of_object(slice, AT, faults)?;
    let of_machine_only = [
        members.flank.name_if_given(),
        members.profile_axis.name_if_given(),
        members.profile_diameter_range_mm.name_if_given(),
        members.helix_range_mm.name_if_given(),
        members.by_flank.name_if_given(),
    ];
    let of_matrix_only =
        [members.settings.name_if_given(), members.units.name_if_given(), members.matrix.name_if_given()];
    let before = faults.count();
    let (kind, foreign) = match members.machine.is_given() {
        true => ("machine", &of_matrix_only[..]),
        false => ("matrix", &of_machine_only[..]),
    };
    for name in foreign.iter().flatten() {
        faults.push(format!("{AT}/{name}"), format!("it does not belong to a `{kind}`"));
    }
    if faults.count() > before {
        return None;
    }
    match members.machine.is_given() {
        true => of_machine(&members, iteration, faults),
        false => of_matrix(&members, faults),
    }
}

fn of_matrix(members: &SensitivityMembers<'_>, faults: &mut Faults) -> Option<Sensitivity> {
    let names = members.settings.required_text(faults);
    let matrix = members.matrix.required_text(faults);
    names?;
    let names = members.settings.read(faults)?;
    let units = members.units.optional(faults)?;
    if let Some(units) = units.as_ref().filter(|units| units.len() != names.len()) {
        faults.push("/sensitivity/units", format!("{} for {} settings", entries(units.len()), names.len()));
        return None;
    }
    matrix?;
    let (matrix, lengths) = members.matrix.rows(faults)?;
    let before = faults.count();
    for (k, length) in lengths.iter().enumerate().filter(|(_, length)| **length != names.len()) {
        faults.push(format!("/sensitivity/matrix/{k}"), format!("{} for {} settings", entries(*length), names.len()));
    }
    let unit = |j: usize| canonical(units.as_ref().map_or("", |units| &units[j])).to_owned();
    let settings = names.into_iter().enumerate().map(|(j, name)| Setting::free(name, unit(j))).collect();
    (faults.count() == before).then_some(Sensitivity { name: "matrix", settings, matrix, flank: None })
}

fn of_machine(members: &SensitivityMembers<'_>, iteration: Corrected<'_>, faults: &mut Faults) -> Option<Sensitivity> {
    let Corrected { nodes, measurand, axes, gear, level } = iteration;
    let machine: Machine = members.machine.read(faults)?;
    let by_flank = by_flank(members, machine, faults)?;
    let side: Option<Side> = members.flank.optional(faults)?;
    if level == Level::Gear && side.is_some() {
        let detail = "a correction of the gear takes the flanks that were measured; leave it out";
        faults.push("/sensitivity/flank", detail);
        return None;
    }
    let side = side.filter(|_| level == Level::Iteration);
    let axis = members.profile_axis.optional(faults)?;
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
    let coordinates = coordinates(axis, axes, faults);
    let (gear, side) = gear.zip(side)?;
    let coordinates = coordinates.filter(|_| faults.count() == before)?;
    let diameters = members.profile_diameter_range_mm.optional(faults)?;
    let helix = members.helix_range_mm.optional(faults)?;
    let places = iteration_nodes::places(nodes, gear, side, coordinates).map_err(|more| faults.append(more)).ok()?;
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

/// The settings that a machine has for each flank.
fn by_flank(members: &SensitivityMembers<'_>, machine: Machine, faults: &mut Faults) -> Option<Vec<String>> {
    let names = members.by_flank.optional(faults)?.unwrap_or_default();
    let settings: Vec<String> = machine.settings().into_iter().map(|setting| setting.name).collect();
    let before = faults.count();
    for (k, _) in names.iter().enumerate().filter(|(_, name)| !settings.contains(name)) {
        let detail = format!("the machine has no such setting; it has `{}`", settings.join("`, `"));
        faults.push(format!("{AT}/by_flank/{k}"), detail);
    }
    (faults.count() == before).then_some(names)
}

/// What u and v of the iteration are, as its axes say.
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
