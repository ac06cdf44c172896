//! Sections of a surface by planes, and the mesh of curves that two families of planes make.

mod body;
mod request;

use std::collections::BTreeMap;

pub use self::{body::SectionsBody, request::SectionsRequest};

use self::{
    body::{SectionFamilyBody, coordinates, written},
    request::{Checked, MOST_POINTS, Planes, read},
};
use crate::api::{
    faults::Faults,
    json::writer::whole,
    problem::{Problem, Room},
    shapes::places::out_of_range,
    warning::WarningBody,
};
use flankfit_engine::{
    geometry::surface::{
        SurfaceShape,
        section::{
            Description, Family, MeshOfSections, NoMesh, Plane, Section, SectionFault, Sections, mesh_of_sections,
        },
    },
    numerics::cancel::{self, Parts},
    words::{Shown, counted},
};

/// Bytes of a point: itself, as a piece of a curve, and its text.
const POINT: usize = 800;
/// Planes that a warning names, each by itself.
const MOST_TOLD: usize = 10;
/// Bytes of a section in addition to its points.
const SECTION: usize = 400;

/// Answers a request, as far as there is `room` for its points. Processor work.
pub fn answer(text: &[u8], room: Room) -> Result<Vec<u8>, Problem> {
    let Checked { surface, families, how, mesh } = read(text)?;
    let planes: usize = families.iter().map(|planes| planes.offsets.len()).sum();
    // the mesh goes through all planes once more
    let all = cancel::parts(if mesh { 2 * planes } else { planes });
    let found = cut(&surface, &families, how, &all, room)?;
    let mut warnings = Vec::new();
    let mut told = BTreeMap::new();
    let mut answered = Vec::with_capacity(families.len());
    for (k, (planes, found)) in families.iter().zip(&found).enumerate() {
        let mut sections = Vec::with_capacity(found.len());
        for (i, (offset, found)) in planes.offsets.iter().zip(found).enumerate() {
            note(found, how, [k, i], (&mut warnings, &mut told));
            sections.push(written(found, *offset, how.chords).ok_or_else(|| out_of_range("/surface"))?);
        }
        answered.push(SectionFamilyBody { sections });
    }
    for (code, count) in told.into_iter().filter(|(_, count)| *count > MOST_TOLD) {
        let more = counted(count - MOST_TOLD, "more plane", "more planes");
        warnings.push(WarningBody::new(code, format!("/families: the same of {more}")));
    }
    let mut body = SectionsBody { families: answered, mesh: None, mesh_frame: None, mesh_error: None, warnings };
    if let (true, [u, v], [of_u, of_v]) = (mesh, &families[..], &found[..]) {
        let made = all.run(planes, || mesh_of_sections(&surface, [family(u, of_u), family(v, of_v)], how));
        let MeshOfSections { frame, mesh, error } = made.map_err(no_mesh)?;
        body.mesh = Some(mesh);
        body.mesh_frame = Some(frame.iter().map(coordinates).collect());
        body.mesh_error = Some(error);
    }
    whole(&body).map_err(|_| out_of_range("/surface"))
}

fn family<'a>(planes: &'a Planes, sections: &'a [Section]) -> Family<'a> {
    Family { normal: planes.normal, offsets: &planes.offsets, sections }
}

/// The sections by all planes.
fn cut(
    surface: &SurfaceShape,
    families: &[Planes],
    how: Description,
    planes: &Parts,
    room: Room,
) -> Result<Vec<Vec<Section>>, Problem> {
    let sections = Sections::of(surface);
    let mut left = how.most;
    let mut all = Vec::with_capacity(families.len());
    for Planes { normal, offsets } in families {
        let mut of_family = Vec::with_capacity(offsets.len());
        for offset in offsets {
            let plane = Plane { normal: *normal, offset: *offset };
            let by = || sections.by(&plane, Description { most: left, ..how });
            let found = planes.run(1, by).map_err(refused)?;
            let points: usize = found.curves.iter().map(|curve| curve.points.len()).sum();
            left = left.saturating_sub(points);
            room(SECTION + points * POINT)?;
            of_family.push(found);
        }
        all.push(of_family);
    }
    Ok(all)
}

fn refused(fault: SectionFault) -> Problem {
    let (pointer, detail) = match fault {
        SectionFault::TooManyPoints { .. } => (
            "/tolerance",
            format!("the sections need more than {MOST_POINTS} points: use a greater tolerance, or fewer planes"),
        ),
        SectionFault::TooManyPieces { .. } | SectionFault::OutOfRange => ("/surface", fault.to_string()),
    };
    Problem::invalid(Faults::one(pointer, detail))
}

fn no_mesh(fault: NoMesh) -> Problem {
    let (pointer, detail) = match fault {
        NoMesh::Skew { .. } => ("/families".to_owned(), fault.to_string()),
        NoMesh::TooManyPoints { .. } => {
            let detail =
                format!("the mesh needs more than {MOST_POINTS} points: use a greater tolerance, or fewer planes");
            ("/tolerance".to_owned(), detail)
        }
        NoMesh::Curves { family, plane, curves } => (
            format!("/families/{family}/offsets/{plane}"),
            format!(
                "{} over all planes of the other family as heights; a mesh needs one",
                counted(curves, "curve reaches", "curves reach")
            ),
        ),
    };
    Problem::invalid(Faults::one(pointer, detail))
}

/// Adds warnings about a section; `told` counts the planes of each warning.
fn note(
    found: &Section,
    how: Description,
    [family, plane]: [usize; 2],
    (warnings, told): (&mut Vec<WarningBody>, &mut BTreeMap<&'static str, usize>),
) {
    let mut warn = |code: &'static str, what: String| {
        let count = told.entry(code).or_default();
        *count += 1;
        if *count <= MOST_TOLD {
            let message = format!("/families/{family}/offsets/{plane}: {what}");
            warnings.push(WarningBody::new(code, message));
        }
    };
    if found.coincident {
        warn("coincident", "a part of the surface lies in the plane; the curves exclude it".to_owned());
    }
    if let [first, ..] = &found.unresolved[..] {
        let [x, y, z] = [first.x, first.y, first.z].map(Shown);
        warn(
            "unresolved",
            format!(
                "about {}, such as [{x}, {y}, {z}], the surface is too flat, or branches are too close, to determine \
                 the section; curves may end or be missing there",
                counted(found.unresolved.len(), "place", "places")
            ),
        );
    }
    let error = found.curves.iter().map(|curve| curve.error).fold(0.0, f64::max);
    if error > how.tolerance {
        warn(
            "tolerance_not_met",
            format!("a curve is accurate to {error:.1e} only; the requested tolerance is {:.1e}", how.tolerance),
        );
    }
}
