//! `/v1/gears`: what follows from a gear's data, its flanks and the evaluation of measured traces;
//! nothing is stored.

use super::prelude::*;
use crate::{
    api::gears::{
        design::{
            flank::{self, FlankBody, FlankRequestBody},
            geometry::{self, GeometryBody, GeometryRequestBody},
            profile::{self, EnvelopeBody, EnvelopeRequestBody, ProfileAnswerBody, ProfileRequestBody},
            solid_mesh::{self, SolidMeshRequestBody},
            tolerances::{self, TolerancesBody, TolerancesRequestBody},
        },
        deviations::{self, answer::DeviationsBody, request::DeviationsRequestBody},
        evaluation::{
            self,
            answer::EvaluationBody,
            flank_surface::{self, FlankSurfaceBody, FlankSurfaceRequestBody},
            pitch::{self, PitchEvaluationBody, PitchRequestBody},
            request::EvaluateBody,
        },
        files::gears::{self, GearsOfFileBody},
        quality_data,
    },
    http::layers::{compute::read_json_in_room, multipart::read_file},
    usecases::import::FileForm,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(gear_geometry))
        .routes(routes!(gear_flank))
        .routes(routes!(read_gears))
        .routes(routes!(gear_profile))
        .routes(routes!(gear_solid_mesh))
        .routes(routes!(gear_envelope))
        .routes(routes!(gear_tolerances))
        .routes(routes!(evaluate_gear))
        .routes(routes!(gear_pitch))
        .routes(routes!(gear_deviations))
        .routes(routes!(gear_flank_surface))
}

/// Compute the tolerances of a class
///
/// Returns the nine tolerances of ISO 1328-1:2013, unrounded and rounded as in the tables of the
/// standard. A gear outside the scope of the standard is refused.
#[utoipa::path(
    post, path = "/v1/gears/tolerances", operation_id = "gear_tolerances", tag = "gears",
    request_body(content = TolerancesRequestBody,
        description = "A gear within the scope of the standard, and a class."),
    responses((status = 200, description = "The tolerances.", body = TolerancesBody))
)]
async fn gear_tolerances(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json(read_json(&state, payload, tolerances::answer).await?))
}

/// Evaluate profile and helix traces
///
/// Returns slope, form and total deviations of each trace by ISO 1328-1:2013 with crowning and
/// class, means over the teeth, twist, and the second-order surface through the traces of a flank.
/// With `Accept: application/x-q-das-dfq` the response is a file for statistical process control.
#[utoipa::path(
    post, path = "/v1/gears/evaluate", operation_id = "evaluate_gear", tag = "gears",
    request_body(content = EvaluateBody, description = "A gear, traces, and settings of the evaluation."),
    responses(
        (status = 200, description = "Slopes, forms and totals in the order of the traces, means, twists and \
        classes. Quality data have a characteristic for each figure, in µm.",
            content((EvaluationBody = "application/json"), (String = "application/x-q-das-dfq")))
    )
)]
async fn evaluate_gear(
    State(state): State<AppState>,
    headers: HeaderMap,
    payload: Payload,
) -> Result<Response, Problem> {
    let format = Format::negotiated(&headers, Format::Dfq, "Evaluations")?;
    let now = state.jobs.now();
    let work = move |text: &[u8]| match format {
        Format::Dfq => quality_data::of_traces(text, now),
        _ => Ok(evaluation::build(text, None, None, None)?.result),
    };
    Ok(format.response(read_json(&state, payload, work).await?))
}

/// Compute deviations of measured points
///
/// Deviations are along the normal of the nominal or modified flank. With a registration, the
/// motions of the part are estimated first, with standard errors. Motions that the points cannot
/// separate are listed.
#[utoipa::path(
    post, path = "/v1/gears/deviations", operation_id = "gear_deviations", tag = "gears",
    request_body(content = DeviationsRequestBody, description = "A gear and points, or deviations on a grid."),
    responses((status = 200, description = "Deviations in the order of the points.", body = DeviationsBody))
)]
async fn gear_deviations(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let work = |text: &[u8], room: Room| Ok(deviations::build(text, None, None, room)?.result);
    Ok(json_held(read_json_in_room(&state, payload, work).await?))
}

/// Evaluate pitches and run-out
///
/// Evaluates index deviations, angles or single pitches of each flank by ISO 1328-1:2013. The
/// run-out is that of the readings, or follows from the pitches of both flanks. With `Accept:
/// application/x-q-das-dfq` the response is a file for statistical process control.
#[utoipa::path(
    post, path = "/v1/gears/pitch", operation_id = "gear_pitch", tag = "gears",
    request_body(content = PitchRequestBody, description = "A gear, and the positions of its flanks."),
    responses(
        (status = 200, description = "Single, cumulative and sector pitch deviations, run-out and classes. \
        Quality data have a characteristic for each figure, in µm.",
            content((PitchEvaluationBody = "application/json"), (String = "application/x-q-das-dfq")))
    )
)]
async fn gear_pitch(State(state): State<AppState>, headers: HeaderMap, payload: Payload) -> Result<Response, Problem> {
    let format = Format::negotiated(&headers, Format::Dfq, "Pitches")?;
    let now = state.jobs.now();
    let work = move |text: &[u8]| match format {
        Format::Dfq => quality_data::of_pitches(text, now),
        _ => Ok(pitch::build(text, None, None, None)?.result),
    };
    Ok(format.response(read_json(&state, payload, work).await?))
}

/// Fit the surface of a flank
///
/// Fits the second-order surface of deviations over roll length and face width, with any estimator
/// and regularisation of a fit. Returns slopes, crownings and twist with standard errors and bias
/// bounds.
#[utoipa::path(
    post, path = "/v1/gears/flank-surface", operation_id = "gear_flank_surface", tag = "gears",
    request_body(content = FlankSurfaceRequestBody, description = "A gear and deviations over one flank."),
    responses((status = 200, description = "The figures of the flank, its form, and the fit.", body = FlankSurfaceBody))
)]
async fn gear_flank_surface(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json(read_json(&state, payload, |text| flank_surface::build(text, None)).await?.result))
}

/// Compute the geometry of a gear
///
/// Returns diameters, pitches and thicknesses by ISO 21771 for external and internal spur and
/// helical gears, and span measurement and dimension over balls on request. Warnings report
/// undercut, a pointed tip and the like.
#[utoipa::path(
    post, path = "/v1/gears/geometry", operation_id = "gear_geometry", tag = "gears",
    request_body(content = GeometryRequestBody, description = "A gear."),
    responses((status = 200, description = "The derived quantities.", body = GeometryBody))
)]
async fn gear_geometry(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json(read_json(&state, payload, geometry::answer).await?))
}

/// Compute nodes of a flank
///
/// Returns nodes of a nominal or modified flank with their normals, on a grid of roll lengths and
/// face width positions. The response is JSON or, with `Accept: text/csv`, a list of points for a
/// measuring machine.
#[utoipa::path(
    post, path = "/v1/gears/flank", operation_id = "gear_flank", tag = "gears",
    request_body(content = FlankRequestBody, description = "A gear, a flank, and the places of the nodes."),
    responses(
        (status = 200, description = "Points and unit normals. CSV has a line `id,x,y,z,i,j,k` for each node, row by \
            row.", content((FlankBody = "application/json"), (String = "text/csv")))
    )
)]
async fn gear_flank(State(state): State<AppState>, headers: HeaderMap, payload: Payload) -> Result<Response, Problem> {
    let format = Format::negotiated(&headers, Format::Csv, "Nodes of a flank")?;
    let work = move |text: &[u8], room: Room| match format {
        Format::Csv => flank::csv(text, room),
        _ => flank::answer(text, room),
    };
    let (text, permit) = read_json_in_room(&state, payload, work).await?.into_parts();
    Ok(with_permit(format.response(text), permit))
}

// Declared for the document.
/// A file.
#[derive(Serialize, ToSchema)]
#[schema(as = GearFileForm)]
struct FileFormBody {
    /// REXS, `.mka` or `.mew`.
    #[schema(value_type = String, format = Binary)]
    file: Vec<u8>,
}

/// Read the gears in a file
///
/// The file is a REXS model, or curves or values of a gear tester. Gears are returned in the form
/// of a job, with a list of missing data. The response also has the contents of the file: traces
/// and pitch tables, which an import uses, and printed values.
#[utoipa::path(
    post, path = "/v1/gears/read", operation_id = "read_gears", tag = "gears",
    request_body(content = FileFormBody, content_type = "multipart/form-data", description = "A REXS model, or a file \
        of a gear tester."),
    responses(
        (status = 200, description = "The gears with their missing data, the traces and the values.",
            body = GearsOfFileBody)
    )
)]
async fn read_gears(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let limit = state.settings.body_limit;
    let work = move || {
        let form = read_file(payload, limit)?;
        let FileForm { file, name, spec, mapping } = &*form;
        for (part, given) in [("spec", spec.is_some()), ("mapping", mapping.is_some())] {
            if given {
                return Err(Problem::invalid(Faults::one(
                    format!("/{part}"),
                    "this file does not use this part: omit it",
                )));
            }
        }
        gears::answer(file, name.as_deref())
    };
    Ok(json(state.pool.run(work).await??))
}

/// Compute the tooth profile of a gear
///
/// Returns the transverse section of a tooth as a closed polygon, and of the whole gear on request.
/// The polygon consists of the tip arc, involutes, fillets and the root arc. The fillets are those
/// that the gear's tool generates.
#[utoipa::path(
    post, path = "/v1/gears/profile", operation_id = "gear_profile", tag = "gears",
    request_body(content = ProfileRequestBody, description = "A gear, and the resolution."),
    responses((status = 200, description = "Closed polygons.", body = ProfileAnswerBody))
)]
async fn gear_profile(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json_held(read_json_in_room(&state, payload, profile::answer).await?))
}

/// Export a solid mesh of teeth
///
/// Writes one tooth or several with fillets and rim as hexahedra for Abaqus and CalculiX, ADINA or
/// Gmsh. Sets of faces or nodes are named: flanks, root, tip, bore, cuts and ends. Material,
/// support and load are up to the caller.
#[utoipa::path(
    post, path = "/v1/gears/solid-mesh", operation_id = "gear_solid_mesh", tag = "gears",
    request_body(content = SolidMeshRequestBody, description = "A gear, and the resolution of the mesh."),
    responses((status = 200, description = "The file.", content((String = "text/plain"))))
)]
async fn gear_solid_mesh(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    let now = state.jobs.now();
    attachment(state, payload, move |text, room| solid_mesh::file(text, now, room)).await
}

/// Compute the envelope of a tool
///
/// The tool is a rack or a pinion that rolls with the gear, given by points of its profile. The
/// response has the flank that the tool generates between two radii, computed numerically.
#[utoipa::path(
    post, path = "/v1/gears/envelope", operation_id = "gear_envelope", tag = "gears",
    request_body(content = EnvelopeRequestBody, description = "A tool's profile and its motion."),
    responses((status = 200, description = "The envelope, and the resulting flank.", body = EnvelopeBody))
)]
async fn gear_envelope(State(state): State<AppState>, payload: Payload) -> Result<Response, Problem> {
    Ok(json_held(read_json_in_room(&state, payload, profile::envelope).await?))
}
