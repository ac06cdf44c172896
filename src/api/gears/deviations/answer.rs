//! Deviations of measured points from the nominal flanks, and how the part lies.

use serde::Serialize;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    borders::BordersBody,
    registration::{self, RegistrationBody},
    request::{self, CheckedDeviations, Given},
};
use crate::{
    api::{
        built::Built,
        faults::Faults,
        fits::canonical,
        gears::{
            design::modification,
            of_iteration::{ToothOf, refuse_others, tooth_number},
            plausibility::{implausible_grid, implausible_points},
        },
        json::{gather::gathered, writer::whole},
        problem::{Problem, Room},
        warning::WarningBody,
    },
    jobs::Measurand,
};
use flankfit_engine::gear::{
    Gear, Side,
    deviation::{self, Deviations, NoFoot, Node, Reference, Relief},
    registration::{Registering, Start, register, register_from, start},
    trace::Direction,
};

/// Deviations in the order of the points; `null` where undefined.
#[skip_serializing_none]
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = GearDeviations)]
pub struct DeviationsBody<'a> {
    pub direction: Direction,
    /// Positive where material protrudes. After a registration: of the part carried back.
    pub deviation_um: Vec<Option<f64>>,
    /// Roll length of each point's foot on the nominal flank.
    pub roll_length_mm: Vec<Option<f64>>,
    /// Diameter of each point's foot on the nominal flank.
    pub diameter_mm: Vec<Option<f64>>,
    /// z of each point's foot.
    pub z_mm: Vec<Option<f64>>,
    /// Tooth of each point, counted clockwise from 1, the tooth at the top; 0 where a point is
    /// undefined and none was given.
    pub tooth: Vec<u32>,
    /// Flank that each point belongs to.
    pub flank: Vec<Side>,
    /// True for points that take part: defined and inside the borders.
    pub counts: Vec<bool>,
    /// Number of points that take part.
    pub count: usize,
    /// Points without a deviation.
    pub undefined: usize,
    /// Defined, but outside the borders.
    pub trimmed: usize,
    /// Root mean square of the deviations that take part; absent without any.
    pub rms_um: Option<f64>,
    /// Least deviation of those that take part; absent without any.
    pub least_um: Option<f64>,
    /// Greatest deviation of those that take part; absent without any.
    pub greatest_um: Option<f64>,
    pub borders: Option<BordersBody>,
    /// Points that belong to no flank, where these count as undefined.
    pub strays: Vec<StrayBody>,
    /// Warnings, in particular assumptions about an imported file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<WarningBody>,
    pub registration: Option<RegistrationBody<'a>>,
}

/// A point without a flank.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = StrayPoint)]
pub struct StrayBody {
    /// Index of the point, from 0.
    pub index: usize,
    /// Reason why it belongs to no flank.
    pub reason: String,
}

/// Bytes that a node takes while it is answered: what is computed of it, and its text.
const NODE: usize = 256;

/// Answers a request; `own` is the gear of the job and `of` what the iteration that the points
/// belong to measured. Processor work.
pub fn build(text: &[u8], own: Option<&Gear>, of: Option<&Measurand>, room: Room) -> Result<Built, Problem> {
    let mut faults = Faults::default();
    let checked = request::read(text, &mut faults)?;
    let Some(mut checked) = checked.filter(|_| faults.is_empty()) else { return Err(Problem::invalid(faults)) };
    room(checked.given.count() * NODE)?;
    let Some(gear) = checked.gear.as_ref().or(own) else {
        return Err(Problem::invalid(Faults::one("/gear", "required")));
    };
    let modifications =
        modification::read(gear, &checked.modifications, checked.modification_range).map_err(Problem::invalid)?;
    let relief = modifications.map(|modifications| {
        move |side: Side, roll_length: f64, z: f64| modifications.relief(side, roll_length, z).value
    });
    let reference = Reference { gear, relief: relief.as_ref().map(|relief| relief as Relief<'_>) };
    let registering = checked.registration.as_ref().map(|(motions, pivot)| Registering {
        motions,
        pivot: *pivot,
        weight: None,
        spec: &checked.spec,
    });
    let mut begun: Option<Start> = None;
    let (method, deviations) = match &mut checked.given {
        Given::Points { touches, measurement } => {
            let (touches, measurement) = (&*touches, &*measurement);
            if let Some(registering) = &registering {
                let found = start(gear, touches, measurement.ball_radius, registering);
                begun = Some(found.map_err(|faults| registration::refused(faults.into()))?);
            }
            let touches = begun.as_ref().map_or(touches, |begun| &begun.touches);
            ("points", deviation::measure(&reference, touches, measurement).map_err(Faults::from))
        }
        Given::Grid(grid) => {
            let own = of.and_then(tooth_number);
            let topography = grid.take_topography(gear, checked.direction, own).map_err(Problem::invalid)?;
            ("grid", deviation::grid(&reference, &topography).map_err(|faults| grid.placed(faults)))
        }
    };
    let mut deviations = deviations.map_err(Problem::invalid)?;
    if let Some(body) = &checked.borders {
        let borders = body.borders(gear).map_err(Problem::invalid)?;
        deviations.set_borders(&borders).map_err(|faults| Problem::invalid(body.placed(&faults)))?;
    }
    let found = registering.as_ref().map(|registering| match &begun {
        Some(begun) => register_from(&reference, &deviations, registering, begun),
        None => register(&reference, &deviations, registering),
    });
    let found = found.transpose().map_err(registration::refused)?;
    let lying = found.as_ref().map_or(&deviations, |found| &found.deviations);
    if let Some(of) = of {
        refuse_other_nodes(of, &checked, lying).map_err(Problem::invalid)?;
    }
    let counted: Vec<f64> = lying.nodes.iter().filter(|node| node.counts()).map(|node| node.deviation).collect();
    let implausible = match &checked.given {
        Given::Points { .. } => implausible_points(&counted, gear),
        Given::Grid(_) => implausible_grid(&counted, gear),
    };
    let digest = canonical::request_sha256(text);
    let body = DeviationsBody {
        borders: checked.borders,
        registration: found.as_ref().map(|found| RegistrationBody::new(found, &digest)),
        warnings: checked.hand_assumed.into_iter().chain(implausible).collect(),
        ..DeviationsBody::new(gear, lying)
    };
    let result = whole(&body).map(gathered).map_err(Problem::not_finite)?;
    Ok(Built { method: method.to_owned(), result })
}

/// Refuses points that lie on other flanks than the one that the iteration measured: given flanks
/// and teeth, and those that were found.
fn refuse_other_nodes(of: &Measurand, checked: &CheckedDeviations, deviations: &Deviations) -> Result<(), Faults> {
    let (flanks_given, teeth_given, places) = match &checked.given {
        Given::Points { touches, .. } => {
            let flanks = touches.iter().any(|touch| touch.side.is_some());
            let teeth = touches.iter().any(|touch| touch.tooth.is_some());
            (
                flanks,
                teeth,
                [("/flanks", flanks), ("/teeth", teeth)].map(|(at, given)| if given { at } else { "/points" }),
            )
        }
        // a tooth that is not given is the iteration's, if the gear has so many
        Given::Grid(grid) => (true, true, ["/grid/flank", if grid.tooth.is_some() { "/grid/tooth" } else { "/gear" }]),
    };
    // without given teeth a registration knows the rotation up to whole pitches only
    let teeth_known = teeth_given || checked.registration.is_none();
    let flanks = deviations.nodes.iter().filter(|node| flanks_given || node.deviation.is_finite()).map(|node| {
        let tooth = if teeth_known && node.tooth > 0 { ToothOf::Counted(node.tooth) } else { ToothOf::Unknown };
        (tooth, node.side)
    });
    refuse_others(of, flanks, places)
}

/// Returns what was imported, as a record keeps it.
pub fn imported(gear: &Gear, deviations: &Deviations, warnings: &[WarningBody]) -> Result<Built, Problem> {
    let body = DeviationsBody { warnings: warnings.to_vec(), ..DeviationsBody::new(gear, deviations) };
    Ok(Built { method: "import".to_owned(), result: whole(&body).map_err(Problem::not_finite)? })
}

impl DeviationsBody<'_> {
    fn new(gear: &Gear, deviations: &Deviations) -> Self {
        let nodes = &deviations.nodes;
        let numbers = |of: &dyn Fn(&Node) -> f64| {
            nodes.iter().map(|node| Some(of(node)).filter(|x| x.is_finite())).collect::<Vec<Option<f64>>>()
        };
        let counted = || nodes.iter().filter(|node| node.counts()).map(|node| node.deviation);
        let stray = |(index, stray): &(usize, NoFoot)| StrayBody { index: *index, reason: stray.to_string() };
        DeviationsBody {
            direction: deviations.direction,
            deviation_um: numbers(&|node| node.deviation),
            roll_length_mm: numbers(&|node| node.roll_length),
            diameter_mm: numbers(&|node| node.diameter(gear)),
            z_mm: numbers(&|node| node.z),
            tooth: nodes.iter().map(|node| node.tooth).collect(),
            flank: nodes.iter().map(|node| node.side).collect(),
            counts: nodes.iter().map(Node::counts).collect(),
            count: deviations.counted(),
            undefined: deviations.undefined(),
            trimmed: deviations.trimmed(),
            rms_um: deviations.rms(),
            least_um: counted().reduce(f64::min),
            greatest_um: counted().reduce(f64::max),
            borders: None,
            strays: deviations.strays.iter().map(stray).collect(),
            warnings: Vec::new(),
            registration: None,
        }
    }
}
