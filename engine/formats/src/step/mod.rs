//! STEP (ISO 10303-21) by the application protocol AP242, edition 1: managed model based 3D
//! engineering.
//!
//! One product with one shape. Curves are a geometric set; each surface is a face of its whole
//! parameter range, since CAD systems take up faces more willingly than bare surfaces. Entities:
//! ISO 10303-41 (product, context), -42 (geometry, topology), -43 (units).

mod data;
mod spline;
mod topology;

use data::{Data, Id};

use super::{
    cad::{CadCurve, CadSurface, NamedShape, Piece, pieces},
    export::nothing,
    label::{Label, SYSTEM},
    number::real,
    text::step_string,
};
use flankfit_numerics::{cancel, check::Faults};

/// Below this distance, in mm, two places are one.
const UNCERTAINTY: f64 = 1e-6;

/// The file of `shapes`: parameters as they are, lengths in mm.
///
/// ```
/// use flankfit_formats::{CadShape, Label, NamedShape, UtcTime, step};
/// use flankfit_geometry::{BSplineBasis, curve::BSplineCurve, space::{Dimension, Vector}};
///
/// let basis = BSplineBasis::uniform(1, 1, 0.0, 1.0)?;
/// let ends = vec![Vector::zeros(), Vector::new(1.0, 2.0, 3.0)];
/// let line = BSplineCurve::new(basis, Dimension::Space, ends, None)?;
/// let label = Label {
///     name: "edge".into(),
///     author: String::new(),
///     organization: String::new(),
///     written_at: UtcTime::epoch(),
/// };
/// let file = step::write(&[NamedShape { name: "edge", shape: CadShape::Curve(&line) }], &label)?;
/// assert!(file.starts_with("ISO-10303-21;") && file.contains("B_SPLINE_CURVE_WITH_KNOTS"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(shapes: &[NamedShape], label: &Label) -> Result<String, Faults> {
    let mut curves: Vec<(&str, CadCurve)> = Vec::new();
    let mut surfaces: Vec<(&str, CadSurface)> = Vec::new();
    for (shape, piece) in pieces(shapes)? {
        cancel::checkpoint();
        match piece {
            Piece::Curve(curve) => curves.push((shapes[shape].name, curve)),
            Piece::Surface(surface) => surfaces.push((shapes[shape].name, surface)),
        }
    }

    let mut data = Data::default();
    let name = step_string(&label.name);
    let shape = product(&mut data, &name);
    let context = geometric_context(&mut data);
    let placement = placement(&mut data);
    let mut representations = Vec::new();
    if !surfaces.is_empty() {
        let shells =
            surfaces.iter().map(|(name, surface)| topology::shell(&mut data, name, surface)).collect::<Vec<_>>();
        let model = data.add(format!("SHELL_BASED_SURFACE_MODEL({name},{})", list(&shells)));
        let items = list(&[placement, model]);
        representations.push(data.add(format!("MANIFOLD_SURFACE_SHAPE_REPRESENTATION({name},{items},{context})")));
    }
    if !curves.is_empty() {
        let elements = curves.iter().map(|(name, curve)| spline::curve(&mut data, name, curve)).collect::<Vec<_>>();
        let set = data.add(format!("GEOMETRIC_CURVE_SET({name},{})", list(&elements)));
        let items = list(&[placement, set]);
        representations
            .push(data.add(format!("GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION({name},{items},{context})")));
    }
    let (first, others) = representations.split_first().ok_or_else(nothing)?;
    data.add(format!("SHAPE_DEFINITION_REPRESENTATION({shape},{first})"));
    for other in others {
        data.add(format!("SHAPE_REPRESENTATION_RELATIONSHIP('','',{first},{other})"));
    }
    Ok(format!("{}{}", header(label), data.into_text()))
}

fn header(label: &Label) -> String {
    let [name, author, organization, system] =
        [&label.name, &label.author, &label.organization, SYSTEM].map(step_string);
    let written_at = label.written_at.iso_8601();
    format!(
        "ISO-10303-21;\nHEADER;\n\
         FILE_DESCRIPTION(('B-spline curves and surfaces'),'2;1');\n\
         FILE_NAME({name},'{written_at}',({author}),({organization}),{system},{system},'');\n\
         FILE_SCHEMA(('AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF {{ 1 0 10303 442 1 1 4 }}'));\n\
         ENDSEC;\n"
    )
}

/// The product and its definition; returns the definition's shape.
fn product(data: &mut Data, name: &str) -> Id {
    let application = data.add("APPLICATION_CONTEXT('managed model based 3d engineering')");
    data.add(format!(
        "APPLICATION_PROTOCOL_DEFINITION('international standard',\
         'ap242_managed_model_based_3d_engineering',2014,{application})"
    ));
    let context = data.add(format!("PRODUCT_CONTEXT('',{application},'mechanical')"));
    let product = data.add(format!("PRODUCT({name},{name},'',({context}))"));
    data.add(format!("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({product}))"));
    let formation = data.add(format!("PRODUCT_DEFINITION_FORMATION('','',{product})"));
    let stage = data.add(format!("PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')"));
    let definition = data.add(format!("PRODUCT_DEFINITION('design','',{formation},{stage})"));
    data.add(format!("PRODUCT_DEFINITION_SHAPE('','',{definition})"))
}

/// Space in mm and radians.
fn geometric_context(data: &mut Data) -> Id {
    let length = data.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
    let angle = data.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    let solid_angle = data.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
    let uncertainty = data.add(format!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),{length},'distance_accuracy_value','confusion accuracy')",
        real(UNCERTAINTY)
    ));
    data.add(format!(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({uncertainty}))\
         GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))REPRESENTATION_CONTEXT('',''))"
    ))
}

/// The origin with the axes of the coordinates.
fn placement(data: &mut Data) -> Id {
    let origin = data.add("CARTESIAN_POINT('',(0.0,0.0,0.0))");
    let z = data.add("DIRECTION('',(0.0,0.0,1.0))");
    let x = data.add("DIRECTION('',(1.0,0.0,0.0))");
    data.add(format!("AXIS2_PLACEMENT_3D('',{origin},{z},{x})"))
}

fn list<T: std::fmt::Display>(items: &[T]) -> String {
    let items: Vec<String> = items.iter().map(ToString::to_string).collect();
    format!("({})", items.join(","))
}
