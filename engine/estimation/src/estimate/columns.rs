//! Properties of the columns that do not depend on heights: their scaling, their directions, their
//! dependencies.

use std::sync::Arc;

use nalgebra::DMatrix;

use crate::{
    design::Design,
    diagnostics::{collinearity, columns_within_range, finite},
    error::FitError,
    factor::Factor,
    result::{CollinearityReport, Warning},
    spec::{FitSpec, Scaling},
    spectrum::{Directions, ScaledColumns, caller_columns},
};
use flankfit_numerics::{Dd, Shared};

/// The caller's columns in Q's coordinates, scaled and analysed.
pub(crate) struct Frame {
    pub caller: DMatrix<Dd>,
    pub columns: ScaledColumns,
    pub directions: Directions,
    /// The same on columns of unit length, where `columns` are scaled otherwise.
    pub unit: Option<(ScaledColumns, Directions)>,
    pub collinearity: Arc<Shared<CollinearityReport>>,
    /// Warnings about the columns.
    pub warnings: Vec<Warning>,
}

impl Frame {
    /// Analyses the columns of `factor`; `weight` is Σw. Reads nothing of it that depends on the
    /// heights.
    pub(crate) fn new(design: &Design, factor: &Factor, spec: &FitSpec, weight: f64) -> Result<Self, FitError> {
        let caller = caller_columns(factor);
        columns_within_range(design, &caller).map_err(FitError::ExceedsDouble)?;
        let columns = ScaledColumns::new(design, &caller, spec.scaling, weight)?;
        let unit = match spec.scaling {
            Scaling::UnitLength => None,
            Scaling::None | Scaling::Standardized => {
                let columns = ScaledColumns::new(design, &caller, Scaling::UnitLength, weight)?;
                let directions = Directions::new(factor, &columns, Scaling::UnitLength, None)?;
                Some((columns, directions))
            }
        };
        let rank = match (&unit, spec.scaling) {
            (Some((_, unit)), Scaling::None) => Some(unit.rank),
            _ => None,
        };
        let directions = Directions::new(factor, &columns, spec.scaling, rank)?;
        let mut warnings = Vec::new();
        let collinearity = collinearity::report(
            design,
            factor,
            &caller,
            unit.as_ref().map_or(&directions, |(_, unit)| unit),
            weight,
            spec.include.collinearity,
            &mut warnings,
        );
        let collinearity = finite::checked_collinearity(collinearity, &mut warnings)?;
        Ok(Frame { caller, columns, directions, unit, collinearity: Arc::new(collinearity.into()), warnings })
    }
}
