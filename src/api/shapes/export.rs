//! Curves and surfaces as files of other programs.

use std::sync::Arc;

use jiff::{Timestamp, tz::TimeZone};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{
    faults::{Faults, pointer_of},
    json::{members::of_request, request::request, text::ShortText},
    problem::{Problem, Room},
};
use flankfit_engine::{
    formats::{
        CadShape, Label, NamedLine, NamedMesh, NamedShape, QuadMesh, UtcTime, cad, fe_mesh, iges, obj, sampling, step,
        stl, vtk,
    },
    geometry::{
        curve::{Curve, CurveShape},
        space::Vector,
        surface::{Surface, SurfaceShape},
    },
    numerics::{cancel::Asking, check},
    words::Shown,
};

pub use flankfit_engine::formats::Pieces;

/// A file: its name, its media type, what it holds.
#[derive(Debug)]
pub struct File {
    pub name: String,
    pub media: &'static str,
    pub content: Pieces,
}

request! {
    /// A curve to be written as a file. Lengths are millimetres.
    #[schema(as = ExportCurve)]
    pub struct ExportCurveBody as ExportCurveMembers {
        required curve: CurveShape,
        required format: CurveFormatName,
        /// Name of the curve in the file. Default `curve`.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
        optional name: ShortText,
        /// For `obj`, `vtk` and `csv` (polylines): largest distance of a chord from the curve.
        /// Default a thousandth of the curve's extent.
        #[schema(exclusive_minimum = 0)]
        optional tolerance: f64,
    }
}

/// Files of curves: IGES (entity 126) and STEP AP242 contain the curve itself; OBJ, VTK and CSV a
/// polyline of points on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = CurveFormat)]
pub enum CurveFormatName {
    Iges,
    Step,
    Obj,
    Vtk,
    Csv,
}

request! {
    /// A surface to be written as a file. Lengths are millimetres.
    #[schema(as = ExportSurface)]
    pub struct ExportSurfaceBody as ExportSurfaceMembers {
        required surface: SurfaceShape,
        required format: SurfaceFormatName,
        /// Name of the surface in the file. Default `surface`.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
        optional name: ShortText,
        /// For `iges` and `step`: largest distance between a patch that no B-spline equals
        /// (Gregory, bicubic Coons of rational curves) and the one written. Default a millionth of
        /// the surface's extent. For meshes: nodes on common borders within this distance become
        /// one.
        #[schema(exclusive_minimum = 0)]
        optional tolerance: f64,
        /// For all other formats: quadrilaterals along u and along v on each smooth patch. Default
        /// 20 and 20.
        #[schema(value_type = Option<Vec<usize>>, min_items = 2, max_items = 2)]
        optional samples: [usize; 2],
    }
}

/// Files of surfaces: IGES (entity 128) and STEP AP242 contain the surface itself; OBJ, STL and VTK
/// facets for display; CSV, Abaqus and ADINA a mesh of quadrilaterals for finite elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = SurfaceFormat)]
pub enum SurfaceFormatName {
    Iges,
    Step,
    Obj,
    Stl,
    StlText,
    Vtk,
    CsvNodes,
    CsvElements,
    Abaqus,
    Adina,
}

/// Quadrilaterals on each patch along u and v, where none are asked for.
const SAMPLES: [usize; 2] = [20, 20];

/// Bytes of a control point until a CAD file is sent: four numbers and its knots as values, as
/// texts, on their lines and in the file.
const CONTROL_POINT: usize = 1000;
/// Bytes of a point of a chain: place, parameter, and the points that were checked between.
const CHAIN_POINT: usize = 8 * size_of::<f64>();

/// Writes the curve of a request, as far as there is `room` for it. Processor work.
pub fn curve(text: &[u8], now: Timestamp, room: Room) -> Result<File, Problem> {
    let mut faults = Faults::default();
    let members: ExportCurveMembers<'_> = of_request(text, &mut faults)?;
    let shape = members.curve.required(&mut faults);
    let format = members.format.required(&mut faults);
    let name = members.name.read(&mut faults).map(String::from);
    let tolerance = members.tolerance.read(&mut faults);
    let (Some(shape), Some(format)) = (shape, format) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    let name = name.unwrap_or_else(|| "curve".to_owned());
    let label = label(&name, now);
    let (ending, media, content) = write_curve(&shape, format, &name, tolerance, &label, room)?;
    Ok(File { name: file_name(&name, ending), media, content })
}

/// Writes the surface of a request, as far as there is `room` for its mesh. Processor work.
pub fn surface(text: &[u8], now: Timestamp, room: Room) -> Result<File, Problem> {
    let mut faults = Faults::default();
    let members: ExportSurfaceMembers<'_> = of_request(text, &mut faults)?;
    let shape = members.surface.required(&mut faults);
    let format = members.format.required(&mut faults);
    let name = members.name.read(&mut faults).map(String::from);
    let tolerance = members.tolerance.read(&mut faults);
    let samples = members.samples.optional(&mut faults).flatten();
    if samples.is_some_and(|samples| samples.contains(&0)) {
        faults.push("/samples", "at least 1 along each parameter");
    }
    let (Some(shape), Some(format)) = (shape, format) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    let name = name.unwrap_or_else(|| "surface".to_owned());
    let label = label(&name, now);
    let settings = MeshSettings { samples: samples.unwrap_or(SAMPLES), tolerance };
    let (ending, media, content) = write_surface(&shape, format, &name, &settings, &label, room)?;
    Ok(File { name: file_name(&name, ending), media, content })
}

struct MeshSettings {
    samples: [usize; 2],
    tolerance: Option<f64>,
}

type Written = (&'static str, &'static str, Pieces);

fn write_curve(
    shape: &CurveShape,
    format: CurveFormatName,
    name: &str,
    tolerance: Option<f64>,
    label: &Label,
    room: Room,
) -> Result<Written, Problem> {
    let refused = |fault| refused("/curve")(fault);
    if matches!(format, CurveFormatName::Iges | CurveFormatName::Step) {
        let spline = shape.to_b_spline().map_err(|_| Problem::invalid(Faults::one("/curve", cad::not_finite(0))))?;
        // of a curve in the plane whose height is rational the degree is raised
        let raised = if spline.weights().is_some() { 2 } else { 1 };
        room(raised * spline.control_points().len() * CONTROL_POINT)?;
        let shapes = [NamedShape { name, shape: CadShape::Curve(&spline) }];
        return if format == CurveFormatName::Iges {
            Ok(("igs", "model/iges", Pieces::new().text(iges::write(&shapes, label).map_err(refused)?)))
        } else {
            Ok(("stp", "model/step", Pieces::new().text(step::write(&shapes, label).map_err(refused)?)))
        };
    }
    let tolerance = tolerance.unwrap_or_else(|| 1e-3 * curve_extent(shape));
    let parameters = sampling::curve_parameters(shape, tolerance).map_err(refused)?;
    room(parameters.len() * CHAIN_POINT)?;
    let points = sampling::curve_nodes(shape, &parameters).map_err(refused)?;
    write_chain(points, parameters, format, name, label).map_err(refused)
}

fn write_chain(
    points: Vec<Vector>,
    parameters: Vec<f64>,
    format: CurveFormatName,
    name: &str,
    label: &Label,
) -> Result<Written, check::Faults> {
    let line = |points: Vec<Vector>| NamedLine { name, points: points.into() };
    Ok(match format {
        CurveFormatName::Obj => ("obj", "model/obj", obj::write(&[], &[line(points)], label)?),
        CurveFormatName::Vtk => ("vtk", "text/plain", vtk::poly_data(&[], &[line(points)], label)?),
        // what is left: CAD files are written from splines
        CurveFormatName::Csv | CurveFormatName::Iges | CurveFormatName::Step => {
            let count = points.len();
            let row = move |i: usize, out: &mut Vec<u8>| {
                let (t, p) = (parameters[i], points[i]);
                out.extend(format!("{t},{},{},{}\n", p.x, p.y, p.z).bytes());
            };
            ("csv", "text/csv", Pieces::new().text("parameter,x,y,z\n").lines(count, row))
        }
    })
}

fn write_surface(
    shape: &SurfaceShape,
    format: SurfaceFormatName,
    name: &str,
    settings: &MeshSettings,
    label: &Label,
    room: Room,
) -> Result<Written, Problem> {
    // once: it looks at all of the surface
    let tolerance = settings.tolerance.unwrap_or_else(|| 1e-6 * surface_extent(shape));
    let refused = |fault| refused("/surface")(fault);
    if matches!(format, SurfaceFormatName::Iges | SurfaceFormatName::Step) {
        return write_splines(shape, format, name, tolerance, label, room);
    }
    let patches: Vec<&dyn Surface> = match shape {
        SurfaceShape::Patchwork(work) => work.patches().iter().map(SurfaceShape::surface).collect(),
        single => vec![single.surface()],
    };
    let with_normals = matches!(format, SurfaceFormatName::Obj | SurfaceFormatName::Vtk);
    room(QuadMesh::bytes(&patches, settings.samples, with_normals).map_err(refused)?)?;
    let mesh = QuadMesh::of_surfaces(&patches, settings.samples, tolerance, with_normals).map_err(refused)?;
    write_mesh(Arc::new(mesh), format, name, label).map_err(refused)
}

fn write_splines(
    shape: &SurfaceShape,
    format: SurfaceFormatName,
    name: &str,
    tolerance: f64,
    label: &Label,
    room: Room,
) -> Result<Written, Problem> {
    let refused = |fault| refused("/surface")(fault);
    let patches = match shape {
        SurfaceShape::Patchwork(work) => work.patches(),
        single => std::slice::from_ref(single),
    };
    let mut parts = Vec::new();
    for patch in patches {
        for part in patch.to_b_splines(tolerance) {
            if part.deviation > tolerance {
                let [deviation, tolerance] = [part.deviation, tolerance].map(Shown);
                let detail =
                    format!("the nearest B-spline deviates by {deviation} from a patch, more than {tolerance}");
                return Err(Problem::invalid(Faults::one("/tolerance", detail)));
            }
            // of heights that are rational both degrees are raised
            let raised = if part.surface.weights().is_some() { 4 } else { 1 };
            room(raised * part.surface.control_points().len() * CONTROL_POINT)?;
            parts.push(part);
        }
    }
    let shapes: Vec<_> =
        parts.iter().map(|part| NamedShape { name, shape: CadShape::Surface(&part.surface) }).collect();
    Ok(if format == SurfaceFormatName::Iges {
        ("igs", "model/iges", Pieces::new().text(iges::write(&shapes, label).map_err(refused)?))
    } else {
        ("stp", "model/step", Pieces::new().text(step::write(&shapes, label).map_err(refused)?))
    })
}

fn write_mesh(
    mesh: Arc<QuadMesh>,
    format: SurfaceFormatName,
    name: &str,
    label: &Label,
) -> Result<Written, check::Faults> {
    Ok(match format {
        SurfaceFormatName::Stl => ("stl", "model/stl", stl::binary_file(mesh, label)?),
        SurfaceFormatName::StlText => ("stl", "model/stl", stl::ascii_file(mesh, label)?),
        SurfaceFormatName::Vtk => ("vtk", "text/plain", vtk::poly_data(&[NamedMesh { name, mesh }], &[], label)?),
        SurfaceFormatName::CsvNodes => ("nodes.csv", "text/csv", fe_mesh::nodes_csv(mesh)),
        SurfaceFormatName::CsvElements => ("elements.csv", "text/csv", fe_mesh::elements_csv(mesh)),
        SurfaceFormatName::Abaqus => ("inp", "text/plain", fe_mesh::abaqus(mesh, label)?),
        SurfaceFormatName::Adina => ("in", "text/plain", fe_mesh::adina(mesh, label)?),
        // what is left: CAD files are written from splines
        SurfaceFormatName::Obj | SurfaceFormatName::Iges | SurfaceFormatName::Step => {
            ("obj", "model/obj", obj::write(&[NamedMesh { name, mesh }], &[], label)?)
        }
    })
}

/// Returns the header of the file.
pub(in crate::api) fn label(name: &str, now: Timestamp) -> Label {
    Label { name: name.to_owned(), author: String::new(), organization: String::new(), written_at: utc(now) }
}

/// A time as files tell it.
pub(in crate::api) fn utc(time: Timestamp) -> UtcTime {
    let time = time.to_zoned(TimeZone::UTC).datetime();
    let small = |n: i8| u8::try_from(n).unwrap_or(0);
    let date = [u16::try_from(time.year()).unwrap_or(0), small(time.month()).into(), small(time.day()).into()];
    let clock = [small(time.hour()), small(time.minute()), small(time.second()).min(59)];
    // a time that the service runs at is in the calendar
    UtcTime::new(date, clock).unwrap_or_else(UtcTime::epoch)
}

/// A name that every file system takes.
pub(in crate::api) fn file_name(name: &str, ending: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    format!("{}.{ending}", name.chars().take(80).map(plain).collect::<String>().trim_start_matches('.'))
}

/// A writer's refusal of the shape at `pointer`; samples are those of surfaces.
fn refused(pointer: &'static str) -> impl Fn(check::Faults) -> Problem {
    move |found| {
        Problem::invalid(Faults::placed(&found, |path| match path {
            "tolerance" => pointer_of(path),
            "samples" | "samples[0]" if pointer == "/surface" => pointer_of(path),
            _ => pointer.to_owned(),
        }))
    }
}

/// The longest side of the box around points of the curve.
fn curve_extent(curve: &CurveShape) -> f64 {
    let places = curve.breaks();
    extent(sampling::between(&places, 8).into_iter().map(|t| curve.place(t)[0]))
}

fn surface_extent(surface: &SurfaceShape) -> f64 {
    // patch by patch: the lines of one are no lines of the others
    let patches = match surface {
        SurfaceShape::Patchwork(work) => work.patches(),
        single => std::slice::from_ref(single),
    };
    extent(patches.iter().flat_map(|patch| {
        let [us, vs] = patch.breaks().map(|breaks| sampling::between(&breaks, 4));
        us.into_iter().flat_map(move |u| vs.clone().into_iter().map(move |v| patch.place(u, v).value))
    }))
}

fn extent(points: impl Iterator<Item = Vector>) -> f64 {
    let mut bounds: Option<[Vector; 2]> = None;
    for point in points.into_iter().asking(300) {
        bounds = Some(bounds.map_or([point; 2], |[low, high]| [low.inf(&point), high.sup(&point)]));
    }
    bounds.map_or(0.0, |[low, high]| (high - low).amax())
}
