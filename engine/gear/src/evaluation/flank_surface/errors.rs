//! Models of the errors of the nodes given, for those that are left after trimming.

use flankfit_estimation::{
    FitSpec,
    spec::{Errors, Variance},
};
use flankfit_numerics::{check::Faults, words::entries};

/// The spec whose lines and groups are those of the nodes `kept` of `posted` ones; `None` where it
/// has none of either.
pub(super) fn of_kept(spec: &FitSpec, kept: &[usize], posted: usize) -> Result<Option<FitSpec>, Faults> {
    let of = |list: &[i64], path: &str| {
        if list.len() != posted {
            let message = format_args!("{}, but there are {posted} nodes", entries(list.len()));
            return Err(Faults::one(path, message));
        }
        Ok(kept.iter().map(|&k| list[k]).collect::<Vec<i64>>())
    };
    let variance = match &spec.variance {
        Variance::Groups(groups) => Variance::Groups(of(groups, "variance.groups")?),
        Variance::Power { .. } => {
            let message = "the flank's coordinates are mapped to -1 … 1, where a power of a coordinate is meaningless: \
                use groups or hc3";
            return Err(Faults::one("variance", message));
        }
        other => other.clone(),
    };
    let lines = spec.errors.as_ref().and_then(|errors| errors.lines.as_deref());
    let lines = lines.map(|lines| of(lines, "errors.line")).transpose()?;
    if lines.is_none() && variance == spec.variance {
        return Ok(None);
    }
    let errors = spec.errors.clone().map(|errors| Errors { lines, ..errors });
    Ok(Some(FitSpec { errors, variance, ..spec.clone() }))
}
