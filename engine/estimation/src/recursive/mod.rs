//! Recursive estimation (mathematics: keep R, Qᵀy and the residual sum of squares only).
//!
//! Nodes come in blocks and are forgotten: each is a Givens update of `[R | Qᵀ√Ωz]` in
//! double-double, O(n²) whatever was seen before. Everything from the factor on is the way of any
//! fit, so spectrum, λ*, bounds and standard errors are there after every block. After any split
//! into blocks the result equals that of all nodes at once to rounding.
//!
//! Forgetting with a factor φ in (0, 1]: every counted node multiplies the weights of those before
//! it by φ, so the coefficients are those of a fit in which the node k before the last has φᵏ
//! times its weight. All nodes are equally good, the older ones only count less: with
//! S₁ = Σφᵏ and S₂ = Σφ²ᵏ they count as `mₑ = S₁²/S₂` nodes, and with weights times S₁/S₂ the
//! covariance is σ²(XᵀWX)⁻¹ as far as rows fade alike, and RSS/(mₑ − n) estimates σ².
//!
//! The working basis must be chosen before the nodes are known. Where the caller gives a domain it
//! lives there; else, for raw powers, on a box that grows with the nodes.

mod boxes;
mod caller_row;
mod growing;
mod opening;
mod readout;
mod snapshot;
mod state;
mod sums;

pub use opening::Taken;

use super::{
    data::{Form, Nodes, Sample},
    design::{bounding_box, checked_domain, within_knots},
    diagnostics::within_range,
    error::FitError,
    fit::report,
    problem::{Evidence, LinearProblem},
    result::{FitResult, Warning},
    spec::FitSpec,
};
use crate::{design::none_counts, factor::squares_exceed_double};
use flankfit_numerics::check::Faults;
pub use state::State;
use sums::Sums;

/// An estimate that nodes are added to.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, Recursive, fit,
///     spec::{Degree, Model, PolynomialBasis, Terms},
/// };
///
/// // Nodes of a trace come in three blocks.
/// let x: Vec<f64> = (0..30).map(|k| 0.5 * f64::from(k)).collect();
/// let y: Vec<f64> =
///     x.iter().map(|x| 2.0 - 0.3 * x + 0.02 * x * x + 0.05 * (9.0 * x).sin()).collect();
/// let model = Model::Polynomial {
///     degree: Degree::Both(2),
///     basis: PolynomialBasis::Monomial,
///     terms: Terms::Tensor,
/// };
/// let spec = FitSpec::new(model);
/// let mut estimate = Recursive::new(&spec, 1.0)?;
/// for (x, y) in x.chunks(10).zip(y.chunks(10)) {
///     estimate.push(&Nodes::curve(x.to_vec(), y.to_vec(), None)?)?;
/// }
/// // The estimate is that of all nodes at once.
/// let (found, together) = (
///     estimate.result()?.expect("there are enough nodes"),
///     fit(&Nodes::curve(x, y, None)?, &spec)?,
/// );
/// for (a, b) in found.coefficients.iter().zip(&together.coefficients) {
///     assert!((a.value - b.value).abs() < 1e-9 * (1.0 + b.value.abs()));
/// }
/// // It can be written down and taken up again, to the last bit.
/// let state = estimate.state().expect("there were nodes");
/// let restored = Recursive::restore(&spec, 1.0, &state).expect("it is a state of this spec");
/// assert_eq!(restored.result()?, Some(found));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Recursive {
    spec: FitSpec,
    forgetting: f64,
    sums: Option<Sums>,
}

impl Recursive {
    /// An estimate of `spec` before the first node; `forgetting` in (0, 1].
    ///
    /// Refuses what cannot be known node by node (estimators other than least squares, filters,
    /// mapped bases or equal spans without a domain), and what the model rules out whatever the
    /// nodes will be.
    pub fn new(spec: &FitSpec, forgetting: f64) -> Result<Self, Faults> {
        opening::check(spec, forgetting)?;
        Ok(Recursive { spec: spec.clone(), forgetting, sums: None })
    }

    /// Kinds of nodes that an estimate of `spec` takes, as far as that is known before the first.
    pub fn takes(spec: &FitSpec) -> Taken {
        opening::taken(spec)
    }

    /// Specification of the fit.
    pub fn spec(&self) -> &FitSpec {
        &self.spec
    }

    /// Counted nodes so far.
    pub fn count(&self) -> usize {
        self.sums.as_ref().map_or(0, |sums| sums.summary.count)
    }

    /// n, once the first block has decided it.
    pub fn size(&self) -> Option<usize> {
        self.sums.as_ref().map(|sums| sums.design.size())
    }

    /// Adds a block. After an error nothing has changed.
    pub fn push(&mut self, nodes: &Nodes) -> Result<(), Faults> {
        let sample = Sample::new(nodes);
        if sample.count() == 0 {
            return Err(none_counts(nodes));
        }
        // the long look at the columns costs O(n³): it is for the first nodes on a box, and for
        // nodes far from 1
        let mut unusual = self.sums.is_none();
        let mut sums = match &self.sums {
            Some(sums) => {
                sums.form.check(nodes)?;
                sums.clone()
            }
            None => {
                let (form, design, boxes) = opening::begin(nodes, &sample, &self.spec)?;
                Sums::new(form, design, boxes, &sample, &self.spec)
            }
        };
        if !matches!(nodes, Nodes::Matrix(_)) {
            let surface = sums.form == Form::Surface;
            checked_domain(nodes, &sample, surface, self.spec.domain, bounding_box(&sample))?;
            within_knots(&sums.design, nodes, &sample)?;
            unusual |= sums.make_room(&sample, &self.spec)?;
        }
        sums.add(&sample, self.forgetting, self.spec.node_uncertainty.is_some());
        if !sums.is_finite() {
            return Err(squares_exceed_double());
        }
        if unusual || !sums.are_plain(&sample) {
            sums.columns_within_range()?;
        }
        self.sums = Some(sums);
        Ok(())
    }

    /// The fit of all nodes so far; `None` while there are fewer than coefficients.
    ///
    /// Results that need the nodes themselves are left out with a warning: `max_abs`, single
    /// residuals and B.
    pub fn result(&self) -> Result<Option<FitResult>, FitError> {
        let Some(sums) = self.sums.as_ref().filter(|sums| sums.summary.count >= sums.design.size()) else {
            return Ok(None);
        };
        let (sums, [effective_count, scale]) = &sums.faded(self.forgetting);
        let design = sums.caller_design(&self.spec);
        let heights = sums.heights();
        within_range(if sums.form == Form::Surface { "z" } else { "y" }, &heights)?;
        let factor = sums.factor(&design, &heights)?;
        let linear = LinearProblem {
            design: &design,
            factor: &factor,
            heights: heights.about_zero,
            evidence: Evidence::Summed(&sums.summary),
        };
        let mut result = report(&linear, &heights, &self.spec)?;
        result.warnings.push(Warning::NodesNotKept);
        if self.forgetting < 1.0 {
            result.warnings.push(Warning::Forgetting {
                forgetting_factor: self.forgetting,
                nodes: self.count(),
                effective_count: *effective_count,
            });
            let residuals = &mut result.residuals;
            residuals.count = self.count();
            (residuals.rss, residuals.least_squares_rss) = (residuals.rss / scale, residuals.least_squares_rss / scale);
        }
        Ok(Some(result.with_doubts()))
    }

    /// Everything that [`Recursive::restore`] needs in addition to spec and forgetting factor;
    /// `None` before the first block.
    pub fn state(&self) -> Option<State> {
        self.sums.as_ref().map(Sums::state)
    }

    /// The estimate whose [`Recursive::state`] this is, to the last bit; `None` when it is not one
    /// of this spec.
    pub fn restore(spec: &FitSpec, forgetting: f64, state: &State) -> Option<Self> {
        let sums = Sums::restore(spec, state)?;
        Some(Recursive { spec: spec.clone(), forgetting, sums: Some(sums) })
    }
}
