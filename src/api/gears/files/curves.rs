//! Curves of a gear tester: evaluated, and as nodes of a flank.

use std::collections::BTreeSet;

use super::{
    content::{FileRead, FlankNodes, notices},
    gears, pitch,
    spec::ImportSpecBody,
};
use crate::api::{
    faults::Faults,
    gears::{
        evaluation::{
            answer::EvaluationBody,
            design_lines, evaluate,
            request::{EvaluateBody, EvaluationSettingsBody},
        },
        gear::GearBody,
        requirements::RequirementsBody,
        trace::TraceBody,
    },
    problem::Problem,
    warning::WarningBody,
};
use flankfit_engine::{
    formats::klingelnberg::{Curves, ProfileAxis, Range, SectionPlane, SignConvention},
    gear::{
        Gear, Kind, Trace,
        evaluation::{
            self, Against, FlankTraces, Levelled, Position, Posted,
            settings::{DeviationSign, PlusMaterial, SlopeSign},
        },
        trace::Direction,
    },
};

/// Reads the traces of a file of curves.
pub(in crate::api) fn read(
    curves: &Curves,
    spec: &ImportSpecBody,
    own: Option<&Gear>,
    required: Option<RequirementsBody>,
) -> Result<FileRead, Problem> {
    let asked = spec.evaluation.as_ref().and_then(|evaluation| evaluation.direction);
    if curves.header.rules().section == Some(SectionPlane::Axial) && asked.is_none() {
        let detail = "the direction of deviations in axial sections (code 183) is not known; give `direction` in \
            `evaluation`";
        return Err(Problem::invalid(Faults::one("/spec/evaluation/direction", detail)));
    }
    let mut notes = curves.notes.clone();
    let facts = curves.gear(&mut notes);
    let mut warnings = Vec::new();
    let gear = gears::chosen(&facts, own, spec.gear.is_some(), &mut warnings)?;
    warnings.extend(notices(&notes));
    let signs = curves.signs();
    for (kind, word) in [(Kind::Profile, "profiles"), (Kind::Helix, "helices")] {
        if !signs.is_known(kind) && curves.curves.iter().any(|curve| curve.kind == kind) {
            let message = format!("the file's settings of signs are not known; those of DIN are assumed for {word}");
            warnings.push(WarningBody::new("sign_assumed", &message));
        }
    }
    let placed = curves.place(&gear).with_sense(signs, SignConvention::Din);
    for lost in &placed.unplaced {
        let message = format!("line {}: the trace of tooth {} has no positions: {}", lost.line, lost.tooth, lost.why);
        warnings.push(WarningBody::new("trace_without_positions", &message));
    }
    let teeth = gear.data().teeth;
    let strange = |tooth: &str| Position::number(tooth).is_some_and(|number| !(1..=u64::from(teeth)).contains(&number));
    let strange: BTreeSet<&str> =
        curves.curves.iter().map(|curve| curve.tooth.as_str()).filter(|t| strange(t)).collect();
    if !strange.is_empty() {
        let named: Vec<&str> = strange.into_iter().take(10).collect();
        let message = format!("the gear has {teeth} teeth; none has the number of {}", named.join(", "));
        warnings.push(WarningBody::new("unknown_tooth", &message));
    }
    let traces: Vec<Trace> = placed.traces.into_iter().map(|placed| placed.trace).collect();
    let accept_units = spec.evaluation.as_ref().and_then(|evaluation| evaluation.accept_units);
    let pitch = pitch::read(curves, &gear, accept_units, required.as_ref(), &mut warnings);
    let settings = settings(curves, &gear, spec.evaluation.clone().unwrap_or_default(), &mut warnings);
    Ok(FileRead { pitch, ..of_traces(gear, traces, settings, required.as_ref(), warnings)? })
}

/// Returns the traces of a file with the settings of their evaluation.
pub(super) fn of_traces(
    gear: Gear,
    traces: Vec<Trace>,
    mut settings: EvaluationSettingsBody,
    required: Option<&RequirementsBody>,
    mut warnings: Vec<WarningBody>,
) -> Result<FileRead, Problem> {
    if settings.against == Some(Against::Design) && required.is_none_or(|required| required.design.is_none()) {
        let detail = "there is no design: add a `design` to the job's requirements";
        return Err(Problem::invalid(Faults::one(format!("/spec{}", design_lines::AT), detail)));
    }
    let mut lines = vec![None; traces.len()];
    let evaluation = design_lines::complete(&mut settings, required, &gear, &traces, &mut lines).and_then(|notices| {
        warnings.extend(notices);
        evaluated(&gear, &traces, &lines, &settings, &mut warnings)
    });
    let evaluation = evaluation.unwrap_or_else(|faults| {
        let why: Vec<String> =
            faults.list().iter().map(|fault| format!("{}: {}", fault.pointer, fault.detail)).collect();
        warnings.push(WarningBody::new("not_evaluated", why.join("; ")));
        None
    });
    let nodes = nodes_of(&gear, &traces, &settings);
    let evaluation = evaluation.map(|mut found| {
        found.warnings.splice(0..0, warnings.iter().cloned());
        found.with_designs(lines.iter().cloned())
    });
    let request = evaluation.as_ref().map(|found| EvaluateBody {
        gear: Some(GearBody::from(gear.data())),
        traces: traces.iter().zip(lines).map(|(trace, design_um)| TraceBody { design_um, ..trace.into() }).collect(),
        modifications: Vec::new(),
        modification_range: None,
        evaluation: found.evaluation.clone(),
    });
    Ok(FileRead { gear, evaluation, request, pitch: None, deviations: None, nodes, warnings })
}

/// Ranges and lengths of the file where the caller left them out; deviations have the sign of DIN.
fn settings(
    curves: &Curves,
    gear: &Gear,
    mut asked: EvaluationSettingsBody,
    warnings: &mut Vec<WarningBody>,
) -> EvaluationSettingsBody {
    let (profile, helix) = (curves.header.profile_setup(), curves.header.helix_setup());
    let rules = curves.header.rules();
    let diameter = |x: f64| match profile.axis {
        ProfileAxis::Diameter => Some(x),
        ProfileAxis::RollLength => Some(gear.diameter(x)),
        ProfileAxis::RollAngle => Some(gear.diameter(x.to_radians() * gear.base_radius())),
        ProfileAxis::Unknown(_) => None,
    };
    let ascending = |Range { start, end }: Range| [start.min(end), start.max(end)];
    if asked.profile_diameter_range_mm.is_none() {
        asked.profile_diameter_range_mm = profile
            .evaluated
            .left
            .or(profile.evaluated.right)
            .map(ascending)
            .and_then(|[low, high]| Some([diameter(low)?, diameter(high)?]));
    }
    if asked.tip_relief_diameter_range_mm.is_none() {
        asked.tip_relief_diameter_range_mm = profile
            .tip_relief
            .left
            .or(profile.tip_relief.right)
            .map(ascending)
            .and_then(|[low, high]| Some([diameter(low)?, diameter(high)?]))
            // some testers write zeros where there is no tip relief
            .filter(|[low, high]| low < high && gear.roll_length(*low).is_some());
    }
    if asked.helix_range_mm.is_none() {
        asked.helix_range_mm = helix.evaluated.left.or(helix.evaluated.right).map(ascending);
    }
    if asked.profile_reference_length_mm.is_none() && asked.profile_reference.is_none() {
        let length = rules.profile_length.length;
        asked.profile_reference_length_mm = length.left.or(length.right).filter(|length| *length > 0.0);
    }
    if asked.helix_reference_length_mm.is_none() && asked.helix_reference.is_none() {
        let length = rules.helix_length.length;
        asked.helix_reference_length_mm = length.left.or(length.right).filter(|length| *length > 0.0);
    }
    for (code, of_file, place) in [
        (181, rules.helix_plus_material, &mut asked.helix_plus_material),
        (182, rules.profile_plus_material, &mut asked.profile_plus_material),
    ] {
        // files with rule 0 print figures without plus material, whatever follows the 0
        let Some(rule) = of_file.rule.filter(|rule| *rule != 0 && place.is_none()) else { continue };
        let counts = |setting: Option<i64>| setting.is_some_and(|setting| setting != 0);
        let taken = match [of_file.total, of_file.form].map(counts) {
            [true, true] => PlusMaterial::FormAndTotal,
            [true, false] => PlusMaterial::Total,
            [false, true] => PlusMaterial::Form,
            [false, false] => PlusMaterial::Ignored,
        };
        *place = Some(taken);
        let message = format!(
            "code {code} has the unknown rule {rule} for plus material; its settings for total and form are used"
        );
        warnings.push(WarningBody::new("plus_material_assumed", &message));
    }
    if rules.section == Some(SectionPlane::Normal) {
        asked.direction = asked.direction.or(Some(Direction::Normal));
    }
    asked.sign = asked.sign.or(Some(SlopeSign::Din));
    asked.deviation_sign = Some(DeviationSign::Din);
    asked
}

fn evaluated(
    gear: &Gear,
    traces: &[Trace],
    lines: &[Option<Vec<f64>>],
    settings: &EvaluationSettingsBody,
    warnings: &mut Vec<WarningBody>,
) -> Result<Option<EvaluationBody>, Faults> {
    if traces.is_empty() {
        return Ok(None);
    }
    let accept_units = settings.accept_units == Some(true);
    let posted: Vec<Posted<'_>> =
        traces.iter().zip(lines).map(|(trace, line)| Posted { trace, design: line.as_deref() }).collect();
    let (found, implausible) = evaluate::evaluated(gear, &posted, settings.settings_on(gear)?, accept_units)?;
    warnings.extend(implausible);
    let explicit = settings.explicit(&found);
    Ok(Some(EvaluationBody::new(found, explicit)))
}

/// The flanks with their samples as nodes, along the normal. Zeros that traces have by themselves
/// are set so that the traces meet in the second-order surface that they tell.
fn nodes_of(gear: &Gear, traces: &[Trace], settings: &EvaluationSettingsBody) -> Vec<FlankNodes> {
    let to_normal = gear.base_helix_angle().cos();
    let settings = settings.settings();
    let nodes = |flank: FlankTraces| {
        let (places, own_zeros) = match settings.traces_share_zero {
            true => (flank.places.clone(), None),
            false => {
                let Levelled { places, zeros } = flank.levelled(gear, &settings);
                (places, Some(zeros))
            }
        };
        FlankNodes {
            traces: flank.traces(),
            places: places.iter().map(|[roll, z, deviation]| [*roll, *z, deviation * to_normal]).collect(),
            own_zeros,
            tooth: flank.tooth,
            side: flank.side,
        }
    };
    evaluation::flank_traces(gear, &posted(traces), &settings).into_iter().map(nodes).collect()
}

fn posted(traces: &[Trace]) -> Vec<Posted<'_>> {
    traces.iter().map(|trace| Posted { trace, design: None }).collect()
}
