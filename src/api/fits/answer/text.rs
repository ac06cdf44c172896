//! A fit's answer as JSON text, written from the domain's result at once.
//!
//! What is written is what [`FitResultBody`] declares; the tests read every text into it and write
//! it again to the same bytes. That numbers are finite has been looked at by the fit
//! (`estimation::diagnostics::finite`); the writer only refuses to write one that is not.

use super::{
    declare::FieldsAs,
    result::{FitAnswer, FitResultBody},
};
use crate::api::json::writer::{Json, NotFinite};
use flankfit_engine::estimation::{FitResult, near::Shape, spec::Include};

/// The text of an answer without its spec; see [`FitAnswer`].
pub fn write(
    result: &FitResult,
    shape: Option<&Shape>,
    input_sha256: &str,
    include: Include,
) -> Result<Vec<u8>, NotFinite> {
    write_answer(&FitAnswer { result, shape, input_sha256, spec: None }, include)
}

/// The text of an answer. What grows with the nodes or with the square of the coefficients is
/// written only where it is included.
pub fn write_answer(answer: &FitAnswer<'_>, include: Include) -> Result<Vec<u8>, NotFinite> {
    let mut json = Json::with_capacity(room(answer.result, include));
    let mut object = json.object();
    FieldsAs::<FitResultBody>::fields_as(answer, &mut object, &include);
    object.end();
    json.finish()
}

/// A little more than the text takes, so that it is laid once: some 20 bytes a number.
fn room(result: &FitResult, include: Include) -> usize {
    let FitResult { coefficients, residuals, robust, matrix_b, .. } = result;
    let n = coefficients.len();
    let lists = [&residuals.values, &residuals.fitted, &residuals.heights];
    let values = lists.into_iter().flatten().map(Vec::len).sum::<usize>()
        + robust.as_ref().filter(|_| include.robust_weights).map_or(0, |report| report.weights.len())
        + matrix_b.as_ref().map_or(0, |rows| rows.len() * n);
    let squares = (3 * usize::from(include.collinearity) + usize::from(include.covariance)) * n * n;
    4096 + 22 * (squares + 40 * n + values)
}

#[cfg(test)]
#[path = "text_tests.rs"]
mod tests;
