//! Conformity of an estimate with limits, with its uncertainty (ISO 14253-1).
//!
//! The true value is `value − bias − std_error · T` with |bias| at most `bias_bound` and T
//! Student's. So the probability that it lies between two limits is between its values at the worst
//! and at the best bias. A part conforms only if the probability is at least 0.95: the limits are
//! reduced by a guard band. A part at a limit is then found to conform in at most one measurement
//! of twenty, if the error has the stated distribution (0.02 to 0.071 in simulation,
//! `tests/laws/gear_evaluation_intervals.rs`); errors correlated without being declared so make it
//! more. A part does not conform only if the value is so far outside a limit as that of a part
//! within is measured in at most one of twenty, however close the limits are; for one limit alone
//! the true value then lies outside with 0.95. In between there is no decision.

use super::{doubts::Doubts, noise::Noise, quantile::half_width};
use flankfit_numerics::distribution::Student;

/// The probability from which on a part is said to conform (ISO 14253-1); one less of it is the
/// chance with which a part that conforms is said not to.
pub const CONFORMANCE_PROBABILITY: f64 = 0.95;

/// An estimate, and what is known of its error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inferred {
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
    /// The bias that it may have.
    pub bias_bound: f64,
    /// The distribution of an error over the standard error.
    pub student: Student,
    /// Warnings that the error may have another distribution.
    pub doubts: Doubts,
}

/// Verdict at 0.95, whatever `level` is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum ConformityVerdict {
    /// The least probability is 0.95 at least.
    Conforms,
    /// Neither, or the figure has no interval.
    Undecidable,
    /// The figure is so far outside a limit as that of a part within is measured with a probability
    /// of 0.05 at most: about 1.645 standard errors, 1.96 of very close limits.
    DoesNotConform,
}

/// Comparison of a figure with its limits by its standard error (ISO 14253-1). A guard band narrows
/// the limits: a part at a limit conforms in about one measurement of twenty, and a part within its
/// limits does not conform in at most one of twenty, if errors are as the fit assumes
/// (docs/explanation/intervals.md). Only noise counts: an error that is the same all over a flank
/// (alignment, temperature, calibration) does not show in residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct Conformity {
    /// The limits of the comparison, µm, ascending.
    #[cfg_attr(feature = "contract", serde(rename = "limits_um"))]
    pub limits: [f64; 2],
    /// Least and greatest probability that the true figure lies within the limits, by Student's
    /// distribution about the estimate; they differ if the estimate may be biased.
    pub probability: [f64; 2],
    /// Verdict at 0.95, which holds if the assumptions do.
    pub verdict: ConformityVerdict,
    /// `doubtful` if there are `reasons` against the assumptions about the errors.
    pub assumptions: Assumptions,
    /// Codes of the warnings that contradict the assumptions: checks that errors as assumed would
    /// fail with a probability below 0.001, or two of them below 0.01, others that intervals may
    /// not hold, and those why there is no interval.
    pub reasons: Doubts,
}

/// State of the assumptions that a verdict follows from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Assumptions {
    /// Nothing contradicts them.
    Ok,
    /// The residuals or the request contradict them.
    Doubtful,
}

impl Conformity {
    /// Returns the comparison of a figure without an interval.
    pub fn undecidable(limits: [f64; 2], reasons: Doubts) -> Self {
        let verdict = ConformityVerdict::Undecidable;
        Conformity { limits, probability: [0.0, 1.0], verdict, assumptions: reasons.into(), reasons }
    }
}

impl From<Doubts> for Assumptions {
    fn from(doubts: Doubts) -> Self {
        if doubts.is_empty() { Assumptions::Ok } else { Assumptions::Doubtful }
    }
}

impl Inferred {
    /// The same in another unit or sign.
    pub fn scaled(self, factor: f64) -> Self {
        let size = factor.abs();
        Inferred {
            value: factor * self.value,
            std_error: size * self.std_error,
            bias_bound: size * self.bias_bound,
            ..self
        }
    }

    /// The confidence interval at `level`.
    pub fn interval(&self, level: f64) -> [f64; 2] {
        let noise = Noise { sigma: self.std_error, student: self.student, miss: 1.0 - level };
        let half = half_width(&noise, self.std_error, self.bias_bound);
        [self.value - half, self.value + half]
    }

    /// Against ascending limits.
    ///
    /// ```
    /// use flankfit_estimation::inference::{ConformityVerdict, Inferred};
    ///
    /// // 3 µm below the limit of 10 µm with a standard error of 2 µm: Φ(1.5) = 0.933
    /// let slope = Inferred { value: 7.0, std_error: 2.0, ..Inferred::default() };
    /// let found = slope.conformity([-10.0, 10.0]);
    /// assert!((found.probability[0] - 0.933_192_8).abs() < 1e-7);
    /// assert_eq!(found.verdict, ConformityVerdict::Undecidable);
    /// ```
    pub fn conformity(&self, limits: [f64; 2]) -> Conformity {
        let [low, high] = limits;
        let within = |bias: f64| {
            let value = self.value + bias;
            if !(self.std_error > 0.0) {
                return if low <= value && value <= high { 1.0 } else { 0.0 };
            }
            let [from, to] = [low, high].map(|limit| (limit - value) / self.std_error);
            // differences of the tails that are small
            let inside = match from + to > 0.0 {
                true => self.student.upper_tail(from) - self.student.upper_tail(to),
                false => self.student.upper_tail(-to) - self.student.upper_tail(-from),
            };
            inside.clamp(0.0, 1.0)
        };
        // greatest in the middle of the limits, and falling to both sides
        let centre = 0.5 * (low + high) - self.value;
        let farthest = if centre > 0.0 { -self.bias_bound } else { self.bias_bound };
        let most = within(centre.clamp(-self.bias_bound, self.bias_bound));
        // where both are nearly 1 the last digit may fall either way
        let probability = [within(farthest).min(most), most];
        let verdict = if probability[0] >= CONFORMANCE_PROBABILITY {
            ConformityVerdict::Conforms
        } else if self.is_outside(limits) {
            ConformityVerdict::DoesNotConform
        } else {
            ConformityVerdict::Undecidable
        };
        Conformity { limits, probability, verdict, assumptions: self.doubts.into(), reasons: self.doubts }
    }

    /// True if a part within the limits would be measured as far outside them seldom enough. The
    /// part at the nearer limit is measured so most often, outside either limit.
    fn is_outside(&self, [low, high]: [f64; 2]) -> bool {
        let beyond = (self.value - high).max(low - self.value) - self.bias_bound;
        if !(beyond > 0.0 && self.std_error > 0.0) {
            return beyond > 0.0;
        }
        let beyond_other = beyond + 2.0 * self.bias_bound + (high - low);
        let tail = |distance: f64| self.student.upper_tail(distance / self.std_error);
        tail(beyond) + tail(beyond_other) <= 1.0 - CONFORMANCE_PROBABILITY
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn normal(value: f64, std_error: f64, bias_bound: f64) -> Inferred {
        Inferred { value, std_error, bias_bound, ..Inferred::default() }
    }

    #[test]
    fn without_error_the_limits_themselves_conform() {
        for (value, outcome) in [(2.0, ConformityVerdict::Conforms), (2.1, ConformityVerdict::DoesNotConform)] {
            assert_eq!(normal(value, 0.0, 0.0).conformity([-2.0, 2.0]).verdict, outcome);
        }
        assert_eq!(normal(1.9, 0.0, 0.2).conformity([-2.0, 2.0]).verdict, ConformityVerdict::Undecidable);
    }

    /// Limits that no figure reaches say that there is none on that side.
    #[test]
    fn a_limit_may_be_as_far_as_a_double_reaches() {
        for student in [Student::NORMAL, Student::new(1.0), Student::new(9.0), Student::new(400.0)] {
            for far in [1e155, 1e308, f64::MAX] {
                for (value, bias_bound) in [(0.0, 0.0), (-5.0, 0.3), (3.0, 1.0)] {
                    let slope = Inferred { value, std_error: 0.1, bias_bound, student, ..Inferred::default() };
                    let [none, upper, lower] =
                        [[-far, far], [-far, value], [value, far]].map(|limits| slope.conformity(limits));
                    assert_eq!((none.probability, none.verdict), ([1.0, 1.0], ConformityVerdict::Conforms), "{far:e}");
                    assert!(upper.probability[1].min(lower.probability[1]) > 0.5 - 1e-9, "{upper:?} {lower:?}");
                    assert!(upper.probability[0].max(lower.probability[0]) < 0.5 + 1e-9, "{upper:?} {lower:?}");
                }
            }
        }
    }

    #[test]
    fn the_guard_band_is_that_of_one_tail() {
        // 1.6448536 standard errors inside and outside of one limit, the other far away
        for (value, outcome) in [
            (-1.645, ConformityVerdict::Conforms),
            (-1.644, ConformityVerdict::Undecidable),
            (1.644, ConformityVerdict::Undecidable),
            (1.645, ConformityVerdict::DoesNotConform),
        ] {
            assert_eq!(normal(value, 1.0, 0.0).conformity([-100.0, 0.0]).verdict, outcome, "{value}");
        }
        // t(0.95; 4) = 2.131847
        let few = Inferred { student: Student::new(4.0), ..normal(-2.131, 1.0, 0.0) };
        assert_eq!(few.conformity([-100.0, 0.0]).verdict, ConformityVerdict::Undecidable);
        assert_eq!(Inferred { value: -2.132, ..few }.conformity([-100.0, 0.0]).verdict, ConformityVerdict::Conforms);
    }

    #[test]
    fn limits_closer_than_the_error_never_conform() {
        assert_eq!(normal(0.0, 1.0, 0.0).conformity([-1.0, 1.0]).verdict, ConformityVerdict::Undecidable);
    }

    /// The value that is refused solves 1 − Φ(x − 0.02 − b) + 1 − Φ(x + 0.02 + b) = 0.05.
    #[test]
    fn a_value_centred_in_narrow_limits_is_undecided() {
        let narrow = normal(0.0, 1.0, 0.0).conformity([-0.02, 0.02]);
        assert!((narrow.probability[1] - 0.015_956_5).abs() < 1e-6, "{narrow:?}");
        assert_eq!(narrow.verdict, ConformityVerdict::Undecidable);
        for (value, bias_bound, outcome) in [
            (1.960, 0.0, ConformityVerdict::Undecidable),
            (1.961, 0.0, ConformityVerdict::DoesNotConform),
            (-1.960, 0.0, ConformityVerdict::Undecidable),
            (-1.961, 0.0, ConformityVerdict::DoesNotConform),
            (1.973, 0.1, ConformityVerdict::Undecidable),
            (1.975, 0.1, ConformityVerdict::DoesNotConform),
        ] {
            let found = normal(value, 1.0, bias_bound).conformity([-0.02, 0.02]);
            assert_eq!(found.verdict, outcome, "{value} {bias_bound}");
        }
    }

    /// Probability that a part does not conform whose value errs by `bias` and by normal errors:
    /// the density, summed at values a hundredth of the standard error apart.
    fn refused(truth: f64, bias: f64, (std_error, bias_bound): (f64, f64), limits: [f64; 2]) -> f64 {
        let decided = |error: f64| normal(truth + bias + std_error * error, std_error, bias_bound).conformity(limits);
        (-800..800)
            .map(|k| 0.01 * (f64::from(k) + 0.5))
            .filter(|error| decided(*error).verdict == ConformityVerdict::DoesNotConform)
            .map(|error| 0.01 * (-0.5 * error * error).exp() / (2.0 * std::f64::consts::PI).sqrt())
            .sum()
    }

    proptest! {
        /// A part within limits, however close, is found not to conform in one measurement of
        /// twenty at most, and at a limit in just as many where the bias is the worst.
        #[test]
        fn values_within_limits_are_rarely_found_nonconforming(
            (low, width, place) in (-8.0..4.0f64, prop_oneof![0.0..0.1f64, 0.1..6.0f64], 0.0..=1.0f64),
            (std_error, bound, share) in (0.01..4.0f64, prop_oneof![Just(0.0), 0.0..3.0f64], -1.0..=1.0f64),
        ) {
            let limits = [low, low + width];
            let within = refused(low + place * width, share * bound, (std_error, bound), limits);
            prop_assert!(within < 0.052, "{}", within);
            let at_limit = refused(limits[1], bound, (std_error, bound), limits);
            prop_assert!((at_limit - 0.05).abs() < 0.002, "{}", at_limit);
        }

        /// Every bias within the bound gives a probability between the two; both are reached.
        #[test]
        fn bounds_of_the_probability_are_sharp(
            (value, std_error, bound) in (-9.0..9.0f64, 0.01..4.0f64, 0.0..5.0f64),
            (low, width, freedom) in (-8.0..4.0f64, 0.1..9.0f64, 1.0..60.0f64),
        ) {
            let limits = [low, low + width];
            let student = Student::new(freedom);
            let about = Inferred { value, std_error, bias_bound: bound, student, ..Inferred::default() };
            let [least, most] = about.conformity(limits).probability;
            let (mut low, mut high) = (1.0f64, 0.0f64);
            for k in -200..=200 {
                let moved = value + bound * f64::from(k) / 200.0;
                let [p, same] =
                    Inferred { value: moved, std_error, student, ..Inferred::default() }.conformity(limits).probability;
                prop_assert_eq!(p, same);
                prop_assert!(least <= p + 1e-12 && p <= most + 1e-12, "{} {} {}", least, p, most);
                (low, high) = (low.min(p), high.max(p));
            }
            prop_assert!(low - least < 1e-12 && most - high < 0.02, "{} {} {} {}", least, low, high, most);
        }
    }
}
