//! Points measured on a gear, and topographies of a model, as nodes of its flanks.

use super::{
    content::{FileRead, FlankNodes, nothing_measured, notices},
    curves, gears,
    spec::ImportSpecBody,
};
use crate::api::{
    faults::{Faults, pointer_of},
    gears::requirements::RequirementsBody,
    problem::Problem,
    warning::WarningBody,
};
use flankfit_engine::{
    formats::{
        rexs::{RexsFlank, RexsGear, RexsModel, TracePlaces},
        table::ListedPoint,
    },
    gear::{
        Gear, Trace,
        deviation::{self, Deviations, FootlessPoints, MeasuredPoint, Measurement, Node, Reference},
        evaluation::settings::DeviationSign,
        trace::Direction,
    },
    words::counted,
};

/// Reads points measured on a gear.
pub(in crate::api) fn of_list(
    points: &[ListedPoint],
    spec: &ImportSpecBody,
    own: Option<&Gear>,
) -> Result<FileRead, Problem> {
    let Some(gear) = own else {
        let detail = "missing: points need a gear; send `gear`, or add it to the job";
        return Err(Problem::invalid(Faults::one("/spec/gear", detail)));
    };
    let touch =
        |listed: &ListedPoint| MeasuredPoint { normal: listed.direction, ..MeasuredPoint::anywhere(listed.point) };
    let touches: Vec<MeasuredPoint> = points.iter().map(touch).collect();
    let measurement = Measurement {
        ball_radius: spec.probe_radius_mm.unwrap_or(0.0),
        strays: FootlessPoints::Undefined,
        ..Measurement::default()
    };
    let reference = Reference::new(gear);
    let deviations = deviation::measure(&reference, &touches, &measurement).map_err(|faults| {
        Problem::invalid(Faults::placed(&faults, |path| match path {
            "probe_radius_mm" => "/spec/probe_radius_mm".to_owned(),
            _ => format!("/file{}", pointer_of(path)),
        }))
    })?;
    let mut warnings = Vec::new();
    for (index, stray) in &deviations.strays {
        let message = format!("line {}: {stray}", points[*index].line);
        warnings.push(WarningBody::new("stray_point", &message));
    }
    of_deviations(gear.clone(), deviations, warnings)
}

/// Reads the measurements of one gear of a model: topographies or, without any, traces. Deviations
/// are along the normal, with the sign stored.
pub(in crate::api) fn of_model(
    model: &RexsModel,
    spec: &ImportSpecBody,
    own: Option<&Gear>,
    required: Option<RequirementsBody>,
) -> Result<FileRead, Problem> {
    let of_gear = model
        .gear(spec.component.as_deref())
        .map_err(|error| Problem::invalid(Faults::one("/spec/component", error.to_string())))?;
    let topographies = of_gear.flanks.iter().any(|flank| flank.topography.is_some() || !flank.scattered.is_empty());
    if !topographies && of_gear.flanks.iter().all(|flank| flank.traces.is_empty()) {
        let what = format!("the flanks of gear {} of this REXS model have no topography and no traces", of_gear.id);
        return Err(nothing_measured(&what));
    }
    let mut warnings = Vec::new();
    let gear = gears::chosen(&of_gear.facts, own, spec.gear.is_some(), &mut warnings)?;
    warnings.extend(notices(&model.notes));
    let message = "a model does not define the sign of its amounts; they are assumed to be along the normal, positive \
        where material protrudes";
    warnings.push(WarningBody::new("sign_assumed", message));
    if !topographies {
        let traces = traces(of_gear, &gear, &mut warnings);
        let mut settings = spec.evaluation.clone().unwrap_or_default();
        settings.direction = settings.direction.or(Some(Direction::Normal));
        settings.deviation_sign = settings.deviation_sign.or(Some(DeviationSign::Material));
        return curves::of_traces(gear, traces, settings, required.as_ref(), warnings);
    }
    let mut nodes = Vec::new();
    for flank in &of_gear.flanks {
        let before = nodes.len();
        let amounts = amounts(flank);
        let count = amounts.len();
        nodes.extend(amounts.into_iter().filter_map(|[diameter, z, deviation]| {
            let roll_length = gear.roll_length(diameter).filter(|_| on_the_tooth(&gear, diameter, z))?;
            // a model has one tooth for all
            Some(Node { tooth: 1, side: flank.side, roll_length, z, deviation, within: true })
        }));
        let lost = count - (nodes.len() - before);
        if lost > 0 {
            let message = format!(
                "omitted from flank {}: {} outside the involute of the tooth",
                flank.id,
                counted(lost, "amount", "amounts")
            );
            warnings.push(WarningBody::new("off_the_tooth", &message));
        }
    }
    let deviations = Deviations { direction: Direction::Normal, ball_radius: 0.0, nodes, strays: Vec::new() };
    of_deviations(gear, deviations, warnings)
}

/// Returns the traces of a gear, all on the one tooth of a model.
fn traces(of_gear: &RexsGear, gear: &Gear, warnings: &mut Vec<WarningBody>) -> Vec<Trace> {
    let mut traces = Vec::new();
    for flank in &of_gear.flanks {
        for measured in &flank.traces {
            let at: Option<Vec<f64>> = match &measured.places {
                TracePlaces::Z(at) | TracePlaces::RollLengths(at) => Some(at.clone()),
                TracePlaces::Diameters(diameters) => diameters.iter().map(|d| gear.roll_length(*d)).collect(),
            };
            let Some(at) = at else {
                let message = format!("trace {} extends below the base circle; it is omitted", measured.id);
                warnings.push(WarningBody::new("trace_without_positions", &message));
                continue;
            };
            traces.push(Trace {
                tooth: "1".to_owned(),
                side: flank.side,
                kind: measured.kind(),
                at,
                section: measured.section,
                deviation: measured.deviation.clone(),
            });
        }
    }
    traces
}

fn of_deviations(gear: Gear, deviations: Deviations, warnings: Vec<WarningBody>) -> Result<FileRead, Problem> {
    let mut nodes: Vec<FlankNodes> = deviations
        .flanks()
        .into_iter()
        .map(|flank| FlankNodes {
            tooth: flank.tooth.to_string(),
            side: flank.side,
            traces: 0,
            own_zeros: None,
            places: (0..flank.z.len()).map(|k| [flank.roll_length[k], flank.z[k], flank.deviation[k]]).collect(),
        })
        .collect();
    nodes.sort_by_key(|flank| std::cmp::Reverse(flank.places.len()));
    if nodes.is_empty() {
        return Err(nothing_measured("no point lies on a flank of this gear"));
    }
    Ok(FileRead { gear, evaluation: None, request: None, pitch: None, deviations: Some(deviations), nodes, warnings })
}

/// Returns true if a place is between root and tip circle, and not far outside the face (whose z
/// may begin at its end or in its middle).
fn on_the_tooth(gear: &Gear, diameter: f64, z: f64) -> bool {
    let (tip, root) = (2.0 * gear.tip_radius(), 2.0 * gear.root_radius());
    let slack = 0.1 * gear.data().normal_module;
    let within = tip.min(root) - slack <= diameter && diameter <= tip.max(root) + slack;
    within && gear.data().face_width.is_none_or(|face| z.abs() <= 2.0 * face)
}

/// Diameter, z and amount of everything that is defined.
fn amounts(flank: &RexsFlank) -> Vec<[f64; 3]> {
    let mut all: Vec<[f64; 3]> =
        flank.scattered.iter().map(|point| [point.diameter, point.z, point.deviation]).collect();
    if let Some(grid) = &flank.topography {
        let places = grid.diameter.iter().flat_map(|d| grid.z.iter().map(move |z| [*d, *z]));
        all.extend(places.zip(&grid.deviation).map(|([d, z], deviation)| [d, z, *deviation]));
    }
    all.retain(|[_, _, deviation]| deviation.is_finite());
    all
}
