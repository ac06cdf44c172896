use flankfit_numerics::check::Fault;
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::fault;
use crate::spec::{Chain, Moves, PriorSpread, Which};

/// Relative to the variances, how far the halves of a covariance matrix may differ.
const ROUNDING: f64 = 1e-9;

/// Prior knowledge of the coefficients: `mean` with `std_error` or `covariance`; or, for iterations
/// and their further fits, `iterations`. `value` of a coefficient is then the mean of the posterior
/// and `std_error` its standard deviation; `regularization` must be `none`.
#[skip_serializing_none]
#[derive(Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"iterations": "previous", "move": "estimated", "correction": true}))]
pub(in crate::spec) struct Prior {
    /// One number for each coefficient, in the order and unit of the result.
    #[schema(min_items = 1)]
    mean: Option<Vec<f64>>,
    /// Standard deviations of independent coefficients about `mean`, each above 0.
    #[schema(min_items = 1)]
    std_error: Option<Vec<f64>>,
    /// Covariance matrix of the coefficients about `mean`: its lower triangle by rows, like
    /// `covariance.coefficients` of a fit, or all of it. It must be positive definite.
    #[schema(min_items = 1)]
    covariance: Option<Vec<Vec<f64>>>,
    /// Earlier iterations of the job.
    iterations: Option<Which>,
    /// Standard deviation of the flank's change from one iteration to the next. Default
    /// `estimated`.
    #[serde(rename = "move", skip_serializing_if = "Option::is_none")]
    moves: Option<Moves>,
    /// If true, the change predicted by a correction of an earlier iteration is added to the prior.
    /// By default true.
    correction: Option<bool>,
}

impl TryFrom<Prior> for super::super::Prior {
    type Error = Fault;

    fn try_from(prior: Prior) -> Result<Self, Fault> {
        match prior.iterations {
            Some(_) => of_iterations(prior).map(Self::Iterations),
            None => given(prior),
        }
    }
}

fn given(prior: Prior) -> Result<super::super::Prior, Fault> {
    let Prior { mean, std_error, covariance, iterations: _, moves, correction } = prior;
    for (name, is_given) in [("move", moves.is_some()), ("correction", correction.is_some())] {
        if is_given {
            return Err(fault(name, "it belongs to `iterations`"));
        }
    }
    let spread = match (std_error, covariance) {
        (Some(deviations), None) => PriorSpread::StdError(deviations),
        (None, Some(rows)) => PriorSpread::Covariance(lower_triangle(rows)?),
        (Some(_), Some(_)) => return Err(fault("covariance", "give either `std_error` or `covariance`, not both")),
        (None, None) => return Err(fault("", "give `mean` with `std_error` or `covariance`, or `iterations`")),
    };
    let mean = mean.ok_or_else(|| fault("mean", "missing"))?;
    Ok(super::super::Prior::Given { mean, spread })
}

/// Returns the lower triangle of a matrix that may be given whole.
fn lower_triangle(mut rows: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, Fault> {
    let n = rows.len();
    if n < 2 || !rows.iter().all(|row| row.len() == n) {
        return Ok(rows);
    }
    let variance = |i: usize| rows[i][i].abs();
    for i in 0..n {
        for j in 0..i {
            if (rows[i][j] - rows[j][i]).abs() > ROUNDING * (variance(i) * variance(j)).sqrt() {
                return Err(fault(&format!("covariance[{i}][{j}]"), "the matrix is not symmetric"));
            }
        }
    }
    rows.iter_mut().enumerate().for_each(|(i, row)| row.truncate(i + 1));
    Ok(rows)
}

fn of_iterations(prior: Prior) -> Result<Chain, Fault> {
    let Prior { mean, std_error, covariance, iterations, moves, correction } = prior;
    let others = [("mean", mean.is_some()), ("std_error", std_error.is_some()), ("covariance", covariance.is_some())];
    if let Some((name, _)) = others.iter().find(|(_, is_given)| *is_given) {
        return Err(fault(name, "give either `iterations`, or `mean` with its spread"));
    }
    let which = iterations.unwrap_or(Which::Previous);
    if let Which::Listed(numbers) = &which {
        check(numbers)?;
    }
    Ok(Chain { which, moves: moves.unwrap_or(Moves::Estimated), correction: correction.unwrap_or(true), earlier: None })
}

fn check(numbers: &[u32]) -> Result<(), Fault> {
    match numbers.windows(2).position(|pair| pair[1] <= pair[0]) {
        None => Ok(()),
        Some(i) => {
            let message = format_args!("{} does not come after {}", numbers[i + 1], numbers[i]);
            Err(fault(&format!("iterations[{}]", i + 1), message))
        }
    }
}

/// With the iterations that were found, where they have been looked up.
impl From<super::super::Prior> for Prior {
    fn from(prior: super::super::Prior) -> Self {
        match prior {
            super::super::Prior::Given { mean, spread } => {
                let (std_error, covariance) = match spread {
                    PriorSpread::StdError(deviations) => (Some(deviations), None),
                    PriorSpread::Covariance(triangle) => (None, Some(triangle)),
                };
                Prior { mean: Some(mean), std_error, covariance, ..Prior::default() }
            }
            super::super::Prior::Iterations(Chain { which, moves, correction, earlier }) => {
                let found = earlier.as_deref().filter(|earlier| !earlier.is_empty());
                let numbers = found.map(|earlier| Which::Listed(earlier.iter().map(|one| one.number).collect()));
                Prior {
                    iterations: Some(numbers.unwrap_or(which)),
                    moves: Some(moves),
                    correction: Some(correction),
                    ..Prior::default()
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, from_value, json, to_value};

    use crate::spec::Prior;

    fn path_of(value: Value) -> String {
        from_value::<Prior>(value).unwrap_err().to_string()
    }

    #[test]
    fn errors_have_the_path_of_their_field() {
        for (value, path) in [
            (json!({"std_error": [1]}), "at `mean`: "),
            (json!({"mean": [1], "std_error": [1], "covariance": [[1]]}), "at `covariance`: "),
            (json!({"mean": [1], "std_error": [1], "move": "estimated"}), "at `move`: "),
            (json!({"mean": [1, 2], "covariance": [[1, 0.5], [0.4, 1]]}), "at `covariance[1][0]`: "),
            (json!({"iterations": "previous", "mean": [1]}), "at `mean`: "),
            (json!({"iterations": [2, 2, 1]}), "at `iterations[1]`: "),
            (json!({}), "give `mean` with"),
        ] {
            let text = path_of(value.clone());
            assert!(text.starts_with(path), "{value}: {text}");
        }
    }

    #[test]
    fn a_prior_is_written_as_it_is_read() {
        for (value, written) in [
            (json!({"mean": [1.0, 0], "std_error": [0.5, 2]}), json!({"mean": [1.0, 0.0], "std_error": [0.5, 2.0]})),
            (
                json!({"mean": [1, 2], "covariance": [[4, 1], [1, 9]]}),
                json!({"mean": [1.0, 2.0], "covariance": [[4.0], [1.0, 9.0]]}),
            ),
            (
                json!({"iterations": "previous"}),
                json!({"iterations": "previous", "move": "estimated", "correction": true}),
            ),
            (
                json!({"iterations": [2, 5], "move": [1, 2], "correction": false}),
                json!({"iterations": [2, 5], "move": [1.0, 2.0], "correction": false}),
            ),
        ] {
            let prior: Prior = from_value(value).unwrap();
            assert_eq!(to_value(&prior).unwrap(), written);
            assert_eq!(from_value::<Prior>(written).unwrap(), prior);
        }
    }
}
