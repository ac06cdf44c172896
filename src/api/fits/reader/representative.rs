//! The matrix B of a representative piece: wire parts to checked values.

use super::model::model;
use crate::api::{
    faults::Faults,
    fits::spec::representative::{RawPiece, RawRepresentative},
    json::value::read_value,
};
use flankfit_engine::estimation::spec::{Piece, PieceOf, Regularization, Representative};

/// The piece, or where it is to be found; whether it suits the model is the engine's to say.
pub fn read(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Regularization> {
    let body: RawRepresentative<'_> = read_value(slice, at, faults)?;
    let before = faults.count();
    if body.iteration == Some(0) {
        faults.push(format!("{at}/iteration"), "iterations are counted from 1");
    }
    if body.fit_id.is_some() && body.iteration.is_none() {
        faults.push(format!("{at}/fit_id"), "it belongs to `iteration`");
    }
    if body.iteration.is_none() && body.piece.is_none() {
        faults.push(at, "give `iteration` or `piece`");
    }
    let piece = body.piece.and_then(|slice| read_piece(slice.0, &format!("{at}/piece"), faults));
    let of = PieceOf { iteration: body.iteration, fit_id: body.fit_id.map(|id| id.0.to_string()) };
    let asked = Representative { of, piece: piece.map(Box::new) };
    (faults.count() == before).then_some(Regularization::Representative(asked))
}

fn read_piece(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Piece> {
    let raw: RawPiece<'_> = read_value(slice, at, faults)?;
    let model = model(raw.model.0, &format!("{at}/model"), faults)?;
    Some(raw.piece(model))
}
