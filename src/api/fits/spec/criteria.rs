//! The criteria by which λ*, k or λ is chosen, as they are written: one list for what may be asked
//! for and for what is answered.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use flankfit_engine::estimation::spec::Criterion;

/// The name of a value that the caller gave.
pub const FIXED: &str = "fixed";
/// The name of no regularisation.
pub const LEAST_SQUARES: &str = "least_squares";

/// Declares both enums from the list of criteria, and the ways between them and [`Criterion`].
macro_rules! criteria {
    ($($(#[$attribute:meta])* $name:ident,)*) => {
        /// Criterion that chooses λ*, k or λ; `fixed` takes `value` of the request.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum CriterionName {
            $($(#[$attribute])* $name,)*
            Fixed,
        }

        /// Criterion that chose λ*.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum ChosenBy {
            $($(#[$attribute])* $name,)*
            /// The caller gave the value.
            Fixed,
            /// Not regularised, for comparison.
            LeastSquares,
        }

        impl From<Criterion> for CriterionName {
            fn from(criterion: Criterion) -> Self {
                match criterion {
                    $(Criterion::$name => CriterionName::$name,)*
                }
            }
        }

        impl From<Criterion> for ChosenBy {
            fn from(criterion: Criterion) -> Self {
                match criterion {
                    $(Criterion::$name => ChosenBy::$name,)*
                }
            }
        }

        impl ChosenBy {
            /// As it is written.
            pub fn name(self) -> &'static str {
                match self {
                    $(ChosenBy::$name => Criterion::$name.name(),)*
                    ChosenBy::Fixed => FIXED,
                    ChosenBy::LeastSquares => LEAST_SQUARES,
                }
            }
        }

        impl CriterionName {
            /// As it is written.
            pub fn name(self) -> &'static str {
                self.criterion().map_or(FIXED, Criterion::name)
            }

            /// The criterion; `None` for a value that the caller gives.
            pub fn criterion(self) -> Option<Criterion> {
                match self {
                    $(CriterionName::$name => Some(Criterion::$name),)*
                    CriterionName::Fixed => None,
                }
            }
        }
    };
}

criteria! {
    MinMse,
    MinCondition,
    Gcv,
    Discrepancy,
    LCurve,
    /// Ridge: (p−2) σ²/‖Â‖² (Hoerl, Kennard and Baldwin, the modified form).
    Hkb,
    /// Ridge: p σ²/‖Â‖² (Hoerl, Kennard and Baldwin 1975).
    #[serde(rename = "hkb_1975")]
    Hkb1975,
    /// Ridge: (p−2) σ² λ̄/Σλᵢaᵢ² (Lawless and Wang).
    LawlessWang,
    /// Attraction: the explicit minimiser of the predicted mean squared error.
    Optimal,
    /// Greatest restricted (marginal) likelihood, the penalty read as a prior of the coefficients.
    Reml,
    /// Least sum of squared leave-one-out residuals, the penalty held.
    Press,
    /// Least sum of squared residuals of nodes left out in blocks (`folds`), the penalty held.
    BlockedCv,
    /// Stein's unbiased estimate of the risk of the fitted heights, RSS + 2σ² Σf.
    Sure,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_criterion_has_one_name() {
        for criterion in Criterion::every() {
            let asked = CriterionName::from(criterion);
            assert_eq!(asked.criterion(), Some(criterion));
            assert_eq!(serde_json::to_value(asked).unwrap(), criterion.name());
            assert_eq!(serde_json::to_value(ChosenBy::from(criterion)).unwrap(), criterion.name());
        }
        for chosen in [ChosenBy::Fixed, ChosenBy::LeastSquares] {
            assert_eq!(serde_json::to_value(chosen).unwrap(), chosen.name());
        }
        assert_eq!(serde_json::to_value(CriterionName::Fixed).unwrap(), CriterionName::Fixed.name());
    }
}
