//! Numbers whose squares are doubles.

use nalgebra::DMatrix;

use crate::{data::Heights, design::Design, error::FitError};
use flankfit_numerics::{Dd, check::Faults};

/// Lengths of columns are squared: they must neither overflow nor vanish.
pub(crate) fn columns_within_range(design: &Design, caller: &DMatrix<Dd>) -> Result<(), Faults> {
    const RANGE: std::ops::Range<f64> = 1e-145..1e145;
    let rows = caller.nrows();
    for (label, column) in design.labels.iter().zip(caller.as_slice().chunks_exact(rows)) {
        let largest = column.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
        if largest != 0.0 && !RANGE.contains(&largest) {
            return Err(Faults::one(
                "nodes",
                format_args!(
                    "the column of {label} (weights included) is about {largest:.0e} long, whose square exceeds the \
                     range of double precision: choose another unit or basis; weights are relative and may be \
                     divided by their largest"
                ),
            ));
        }
    }
    Ok(())
}

/// Squares of heights are summed: they must neither overflow nor vanish.
pub(crate) fn within_range(list: &str, heights: &Heights) -> Result<(), FitError> {
    let message = if !(heights.about_zero.is_finite() && heights.weight.is_finite()) {
        "squares of these heights exceed the range of double precision: choose a larger unit"
    } else if heights.about_zero < 1e-280 && heights.largest_plain > 0.0 {
        "squares of these heights underflow in double precision: choose a smaller unit"
    } else {
        return Ok(());
    };
    Err(FitError::ExceedsDouble(Faults::one(format_args!("nodes.{list}"), message)))
}
