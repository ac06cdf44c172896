//! What was known before: wire parts to checked values.

use crate::api::{
    faults::Faults,
    fits::spec::{
        prior::{MoveBody, PriorBody, PriorIterationsBody},
        zeros::unsigned_zeros,
    },
    json::value::read_value,
};
use flankfit_engine::estimation::spec::{Chain, Moves, Prior, PriorSpread, Which};

/// Iterations at most.
pub const MOST_ITERATIONS: usize = 100;

/// Relative to the variances, how far the halves of a covariance matrix may differ.
const ROUNDING: f64 = 1e-9;

/// The prior, when nothing is wrong with it; whether it suits the model is the engine's to say.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<Prior> {
    let body: PriorBody = read_value(slice, "/prior", faults)?;
    let before = faults.count();
    let prior = if body.iterations.is_some() { of_iterations(body, faults) } else { given(body, faults) };
    prior.filter(|_| faults.count() == before)
}

fn given(body: PriorBody, faults: &mut Faults) -> Option<Prior> {
    let PriorBody { mean, std_error, covariance, moves, correction, .. } = body;
    for (name, there) in [("move", moves.is_some()), ("correction", correction.is_some())] {
        if there {
            faults.push(format!("/prior/{name}"), "it belongs to `iterations`");
        }
    }
    let spread = match (std_error, covariance) {
        (Some(deviations), None) => Some(PriorSpread::StdError(deviations)),
        (None, Some(rows)) => lower_triangle(rows, faults).map(PriorSpread::Covariance),
        (Some(_), Some(_)) => {
            faults.push("/prior/covariance", "give either `std_error` or `covariance`, not both");
            None
        }
        (None, None) => {
            faults.push("/prior", "give `mean` with `std_error` or `covariance`, or `iterations`");
            return None;
        }
    };
    if mean.is_none() {
        faults.push("/prior/mean", "missing");
    }
    Some(Prior::Given { mean: unsigned_zeros(&mean?), spread: spread? })
}

/// The lower triangle of a matrix that may have come whole.
fn lower_triangle(rows: Vec<Vec<f64>>, faults: &mut Faults) -> Option<Vec<Vec<f64>>> {
    let n = rows.len();
    if n < 2 || !rows.iter().all(|row| row.len() == n) {
        return Some(rows);
    }
    let variance = |i: usize| rows[i][i].abs();
    for i in 0..n {
        for j in 0..i {
            if (rows[i][j] - rows[j][i]).abs() > ROUNDING * (variance(i) * variance(j)).sqrt() {
                faults.push(format!("/prior/covariance/{i}/{j}"), "the matrix is not symmetric");
                return None;
            }
        }
    }
    Some(
        rows.into_iter()
            .enumerate()
            .map(|(i, mut row)| {
                row.truncate(i + 1);
                row
            })
            .collect(),
    )
}

fn of_iterations(body: PriorBody, faults: &mut Faults) -> Option<Prior> {
    let PriorBody { mean, std_error, covariance, iterations, moves, correction } = body;
    let strangers =
        [("mean", mean.is_some()), ("std_error", std_error.is_some()), ("covariance", covariance.is_some())];
    for (name, _) in strangers.iter().filter(|(_, there)| *there) {
        faults.push(format!("/prior/{name}"), "give either `iterations`, or `mean` with its spread");
    }
    let which = match iterations? {
        PriorIterationsBody::Previous(_) => Which::Previous,
        PriorIterationsBody::Listed(numbers) => {
            check(&numbers, faults);
            Which::Listed(numbers)
        }
    };
    let moves = match moves {
        None | Some(MoveBody::Estimated(_)) => Moves::Estimated,
        Some(MoveBody::StdError(deviations)) => Moves::StdError(deviations),
    };
    Some(Prior::Iterations(Chain { which, moves, correction: correction.unwrap_or(true), earlier: None }))
}

fn check(numbers: &[u32], faults: &mut Faults) {
    if numbers.is_empty() {
        faults.push("/prior/iterations", "there are none: leave `prior` out, or write \"previous\"");
    }
    if numbers.len() > MOST_ITERATIONS {
        let detail = format!("{} iterations; at most {MOST_ITERATIONS} are taken", numbers.len());
        faults.push("/prior/iterations", detail);
    }
    if numbers.first() == Some(&0) {
        faults.push("/prior/iterations/0", "iterations are counted from 1");
    }
    for (i, pair) in numbers.windows(2).enumerate().filter(|(_, pair)| pair[1] <= pair[0]) {
        faults.push(format!("/prior/iterations/{}", i + 1), format!("{} does not come after {}", pair[1], pair[0]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::json::writer::text_of;

    fn faults_of(text: &str) -> Vec<String> {
        let mut faults = Faults::default();
        let read = read(text.as_bytes(), &mut faults);
        assert_eq!(read.is_none(), !faults.is_empty(), "{text}");
        faults.list().iter().map(|fault| fault.pointer.clone()).collect()
    }

    #[test]
    fn what_is_wrong_is_told_by_its_place() {
        for (text, pointers) in [
            (r#"{}"#, &["/prior"][..]),
            (r#"{"mean": [1]}"#, &["/prior"]),
            (r#"{"std_error": [1]}"#, &["/prior/mean"]),
            (r#"{"mean": [1], "std_error": [1], "covariance": [[1]]}"#, &["/prior/covariance"]),
            (r#"{"mean": [1], "std_error": [1], "move": "estimated"}"#, &["/prior/move"]),
            (r#"{"mean": [1, 2], "covariance": [[1, 0.5], [0.4, 1]]}"#, &["/prior/covariance/1/0"]),
            (r#"{"iterations": "previous", "mean": [1]}"#, &["/prior/mean"]),
            (r#"{"iterations": "latest"}"#, &["/prior/iterations"]),
            (r#"{"iterations": []}"#, &["/prior/iterations"]),
            (r#"{"iterations": [0, 2]}"#, &["/prior/iterations/0"]),
            (r#"{"iterations": [2, 2, 1]}"#, &["/prior/iterations/1", "/prior/iterations/2"]),
            (r#"{"iterations": [1], "move": "much"}"#, &["/prior/move"]),
            (r#"{"iterations": [1], "moves": "estimated"}"#, &["/prior/moves"]),
        ] {
            assert_eq!(faults_of(text), pointers, "{text}");
        }
    }

    #[test]
    fn a_prior_is_written_as_it_is_read() {
        for (text, written) in [
            (r#"{"mean":[1.0,0],"std_error":[0.5,2]}"#, r#"{"mean":[1.0,0.0],"std_error":[0.5,2.0]}"#),
            (r#"{"mean":[1,2],"covariance":[[4,1],[1,9]]}"#, r#"{"mean":[1.0,2.0],"covariance":[[4.0],[1.0,9.0]]}"#),
            (r#"{"iterations":"previous"}"#, r#"{"iterations":"previous","move":"estimated","correction":true}"#),
            (
                r#"{"iterations":[2,5],"move":[1,2],"correction":false}"#,
                r#"{"iterations":[2,5],"move":[1.0,2.0],"correction":false}"#,
            ),
        ] {
            let mut faults = Faults::default();
            let prior = read(text.as_bytes(), &mut faults).unwrap();
            let again = text_of(&PriorBody::from(&prior));
            assert_eq!(again, written);
            assert_eq!(read(again.as_bytes(), &mut faults), Some(prior));
        }
    }
}
