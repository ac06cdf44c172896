//! IGES 5.3: rational B-spline curves (entity 126) and surfaces (entity 128).
//!
//! A file is cards of 80 columns in five sections: start (S) and global (G) data in columns 1–72,
//! the directory (D) of two cards for each entity, its parameters (P) in columns 1–64 with the
//! directory entry's number in 66–72, and the counts (T). Columns 73–80 hold section and card
//! number. Source: US PRO/IPO-100, "Initial Graphics Exchange Specification 5.3", sections 2.2,
//! 4.23, 4.24, 4.124.

mod cards;
mod entities;

use cards::Cards;
use entities::Entity;

use super::{
    cad::{NamedShape, Piece, pieces},
    export::too_long,
    label::{Label, SYSTEM},
    number::iges_real,
    text::hollerith,
};
use flankfit_numerics::{cancel, check::Faults};

/// Card numbers have seven digits.
const MOST_CARDS: usize = 9_999_999;

/// Distance up to which CAD should take places for the same, mm.
const RESOLUTION: f64 = 1e-6;

/// The file of `shapes`: parameters as they are, lengths in mm, each name as the property 406:15 of
/// its shape.
///
/// ```
/// use flankfit_formats::{CadShape, Label, NamedShape, UtcTime, iges};
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
/// let file = iges::write(&[NamedShape { name: "edge", shape: CadShape::Curve(&line) }], &label)?;
/// // Lines of 80 columns; a rational B-spline curve is entity 126.
/// assert!(file.lines().all(|line| line.len() == 80) && file.contains("126,"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(shapes: &[NamedShape], label: &Label) -> Result<String, Faults> {
    let pieces = pieces(shapes)?;
    let mut entities = Vec::new();
    for (shape, piece) in &pieces {
        cancel::checkpoint();
        let name = shapes[*shape].name;
        // directory entries are counted by cards, two for each
        let next = 2 * entities.len() + 3;
        let named = (!name.is_empty()).then_some(next);
        entities.push(Entity::of_piece(piece, name, named));
        if named.is_some() {
            entities.push(Entity::of_name(name));
        }
    }

    let mut start = Cards::new('S', 72);
    start.add("Rational B-spline curves (126) and surfaces (128). Lengths are in mm.");
    let mut global = Cards::new('G', 72);
    global.add_list(&global_data(&pieces, label));
    let mut directory = Cards::new('D', 72);
    let mut parameters = Cards::new('P', 72);
    for entity in &entities {
        cancel::checkpoint();
        let (first, owner) = (parameters.len() + 1, directory.len() + 1);
        let lines = parameters.add_parameters(&entity.parameters, owner);
        for card in entity.directory(first, lines) {
            directory.add(&card);
        }
    }
    let counts: Vec<usize> = [&start, &global, &directory, &parameters].map(Cards::len).to_vec();
    if let Some(lines) = counts.iter().copied().find(|n| *n > MOST_CARDS) {
        return Err(Faults::one("samples", too_long(lines, MOST_CARDS)));
    }
    let mut terminate = Cards::new('T', 72);
    terminate.add(&format!("S{:07}G{:07}D{:07}P{:07}", counts[0], counts[1], counts[2], counts[3]));
    Ok([start, global, directory, parameters, terminate].map(Cards::into_text).concat())
}

/// The 26 fields of the global section (2.2.4.3).
fn global_data(pieces: &[(usize, Piece)], label: &Label) -> Vec<String> {
    let points = pieces.iter().flat_map(|(_, piece)| match piece {
        Piece::Curve(curve) => &curve.points,
        Piece::Surface(surface) => &surface.points,
    });
    let farthest = points.flat_map(|p| p.iter()).fold(0.0, |most: f64, x| most.max(x.abs()));
    let written_at = hollerith(&label.written_at.iges());
    let name = hollerith(&label.name);
    vec![
        "1H,".to_owned(),
        "1H;".to_owned(),
        name.clone(),
        name,
        hollerith(SYSTEM),
        hollerith(SYSTEM),
        // bits of an integer; greatest power of ten and digits of single and of double precision
        "32".to_owned(),
        "38".to_owned(),
        "6".to_owned(),
        "308".to_owned(),
        "15".to_owned(),
        hollerith(&label.name),
        // scale; millimetres; one line weight, which is 0.01 mm wide
        "1.0".to_owned(),
        "2".to_owned(),
        "2HMM".to_owned(),
        "1".to_owned(),
        "0.01".to_owned(),
        written_at.clone(),
        iges_real(RESOLUTION),
        iges_real(farthest),
        hollerith(&label.author),
        hollerith(&label.organization),
        // version 5.3, no drafting standard
        "11".to_owned(),
        "0".to_owned(),
        written_at,
        String::new(),
    ]
}
