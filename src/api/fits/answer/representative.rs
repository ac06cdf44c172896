//! What of a regularised fit is used for others, and how a piece suits the nodes, as it is
//! answered.

use super::declare::{FieldsAs, ListAs, WriteAs, answer};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{
    result::RepresentativeReport,
    spec::{Domain, Include, Piece},
};

answer! {
    /// Fit of the matrix B of a representative piece to these nodes.
    #[schema(as = RepresentativeResult)]
    pub struct RepresentativeResultBody from RepresentativeReport { of, alignment } {
        /// The iteration of the job that the piece is; absent where it was posted.
        iteration?: usize = of.iteration.map(|number| number as usize),
        /// The fit of it that was used.
        fit_id?: String = of.fit_id,
        /// Cosine of the largest angle between the regularised directions of the piece and as many
        /// directions of these nodes, those with the smallest eigenvalues: 1 where they agree, as
        /// for nodes at the same places. Below 0.95 the warning `representative_misaligned` gives
        /// the share of the error that remains.
        alignment: f64 = alignment,
    }
}

impl WriteAs<Option<Piece>> for Option<Piece> {
    fn write_as(&self, object: &mut Object<'_>, name: &'static str, include: &Include) {
        let Some(Piece { model, domain, scheme, lambda_star, eigenvalues, directions, scale }) = self else { return };
        object.object(name, |object| {
            object.field("model", model);
            WriteAs::<Option<Domain>>::write_as(domain, object, "domain", include);
            object
                .field("scheme", scheme)
                .number("lambda_star", *lambda_star)
                .numbers("eigenvalues", eigenvalues)
                .rows("directions", directions)
                .numbers("scale", scale);
        });
    }
}
