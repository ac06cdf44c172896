//! Models of the errors of the nodes given, for those that are left after trimming.

use flankfit_estimation::{
    Faults, FitSpec,
    fault::{ErrorsReason, Field},
    spec::{Errors, Variance},
};

/// The spec whose lines and groups are those of the nodes `kept` of `posted` ones; `None` where it
/// has none of either.
pub(super) fn of_kept(spec: &FitSpec, kept: &[usize], posted: usize) -> Result<Option<FitSpec>, Faults> {
    let of = |list: &[i64], field: Field| {
        if list.len() != posted {
            return Err(Faults::one(field, ErrorsReason::Count { given: list.len(), nodes: posted }));
        }
        Ok(kept.iter().map(|&k| list[k]).collect::<Vec<i64>>())
    };
    let variance = match &spec.variance {
        Variance::Groups(groups) => Variance::Groups(of(groups, Field::VarianceGroups)?),
        Variance::Power { .. } => return Err(Faults::one(Field::Variance, ErrorsReason::Mapped)),
        other => other.clone(),
    };
    let lines = spec.errors.as_ref().and_then(|errors| errors.lines.as_deref());
    let lines = lines.map(|lines| of(lines, Field::ErrorsLine)).transpose()?;
    if lines.is_none() && variance == spec.variance {
        return Ok(None);
    }
    let errors = spec.errors.clone().map(|errors| Errors { lines, ..errors });
    Ok(Some(FitSpec { errors, variance, ..spec.clone() }))
}
