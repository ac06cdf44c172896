//! What of a regularised fit is used for others, and how a piece suits the nodes, as it is
//! answered.

use super::declare::{FieldsAs, ListAs, WriteAs, answer};
use crate::api::{fits::spec::representative::PieceBody, json::writer::Object};
use flankfit_engine::estimation::{
    result::RepresentativeReport,
    spec::{Include, Piece},
};

answer! {
    /// How the matrix B of a representative piece suits these nodes.
    #[schema(as = RepresentativeResult)]
    pub struct RepresentativeResultBody from RepresentativeReport { of, alignment } {
        /// The iteration of the job that the piece is; absent where it was posted.
        iteration?: usize = of.iteration.map(|number| number as usize),
        /// The fit of it that was used.
        fit_id?: String = of.fit_id,
        /// Cosine of the largest angle between the directions of the piece and as many of these
        /// nodes' own, those with the smallest eigenvalues: 1 where both are alike, as they are
        /// where the nodes lie at the same places. Below 0.95 the warning
        /// `representative_misaligned` says that much of the error stays.
        alignment: f64 = alignment,
    }
}

impl WriteAs<Option<serde_json::Value>> for Option<Piece> {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, _: &Include) {
        if let Some(piece) = self {
            object.field(name, &PieceBody::from(piece));
        }
    }
}
