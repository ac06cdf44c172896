//! The second-order surface of a whole flank: what its deviations have in common, and what is left
//! as form.
//!
//! Over the evaluation range, less the border, roll length and z are mapped to [-1, 1]²: u from
//! root to tip, v towards greater z. `δ ≈ c₁ + c_u u + c_v v + c_uu u² + c_uv uv + c_vv v²` is a
//! fit with the caller's regularisation, estimator and filters, and
//!
//! | figure | is | positive where material |
//! |---|---|---|
//! | mean | c₁ | stands out in the middle of the flank |
//! | profile slope | 2 c_u | grows from root to tip |
//! | helix slope | 2 c_v | grows with z (by the sign asked for) |
//! | profile crowning | −c_uu | stands out half-way between root and tip |
//! | lengthwise crowning | −c_vv | stands out half-way between the ends |
//! | twist | 4 c_uv | grows more with z at the tip than at the root (by the sign asked for) |
//!
//! all in µm over the trimmed range, with standard errors and with the bounds of their bias that
//! the fit answers (for the use of such a surface see Litvin et al., ASME J. Mech. Des. 115(4),
//! 1993, p. 995). Slopes are extended linearly to their reference lengths, and all figures count
//! along the normal, unless [`FigureTerms`] say otherwise. Crownings and twist are never extended.

mod errors;
mod figures;
mod nodes;
mod own_zeros;
mod projected;
mod roll_lengths;
mod settings;

use super::{limits::Inference, warning::SurfaceWarning};
use crate::{Gear, tolerance::Tolerances};
pub use figures::{EstimatedFigure, FlankFigures, estimated_figures, flank_figures};
use flankfit_estimation::{
    self, FitError, FitSpec, Unconverged,
    result::{FitResult, TermKey, WeightedSum},
    spec::{Degree, Include, Model, PolynomialBasis, Terms},
};
use nodes::Trimmed;
pub use nodes::{FlankNodes, NodeCounts};
pub(crate) use own_zeros::{Sample, TERMS, Through, through};
pub use projected::{FittedFlank, figure_limits};
pub use roll_lengths::{NoRollLengths, over_roll_lengths};
pub(crate) use settings::Slopes;
pub use settings::{Border, FigureTerms, Reference, SurfaceSettings, covers};

/// A figure in µm, in the direction of its [`FigureTerms`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Estimate.
    pub value: f64,
    /// Valid standard error, as that of a coefficient; `None` without degrees of freedom.
    pub std_error: Option<f64>,
    /// Standard error conditional on a λ* that was selected from the heights.
    pub conditional_std_error: Option<f64>,
    /// Most by which regularisation can have moved the figure, given the limit of the coefficients.
    pub bias_bound: f64,
    /// Without regularisation.
    pub least_squares: f64,
    /// What it must lie within, where there are limits and the nodes cover enough of the range to
    /// be held against them.
    pub limits: Option<[f64; 2]>,
    /// Its interval and conformity; `None` where the noise is not known.
    pub inference: Option<Inference>,
}

/// What the surface leaves over, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remainder {
    /// Greatest residual minus least.
    pub peak_to_valley: f64,
    /// Root mean square of the residuals.
    pub rms: f64,
    /// Largest absolute residual.
    pub max_abs: f64,
}

/// The second-order surface of a flank.
#[derive(Clone, Debug, PartialEq)]
pub struct FlankSurface {
    /// Deviation of the surface in the middle of the flank: c₁.
    pub mean: Figure,
    /// Profile slope: 2 c_u.
    pub profile_slope: Figure,
    /// Helix slope: 2 c_v.
    pub helix_slope: Figure,
    /// Profile crowning: −c_uu.
    pub profile_crowning: Figure,
    /// Lengthwise crowning: −c_vv.
    pub helix_crowning: Figure,
    /// Twist: 4 c_uv.
    pub twist: Figure,
    /// What the surface leaves over.
    pub remainder: Remainder,
    /// Roll lengths and z that u = v = ∓1 stand for, mm, after trimming.
    pub roll_lengths: [f64; 2],
    /// Places on the face width, likewise.
    pub z: [f64; 2],
    /// Lengths that the slopes of profile and helix refer to, mm.
    pub references: [f64; 2],
    /// How many nodes there were, and what became of them.
    pub nodes: NodeCounts,
    /// What is to be known of them.
    pub warnings: Vec<SurfaceWarning>,
    /// The fit itself: spectrum, collinearity, regularisation, warnings.
    pub result: FitResult,
}

/// Fits the surface.
pub fn flank_surface(gear: &Gear, nodes: &FlankNodes, settings: &SurfaceSettings) -> Result<FlankSurface, FitError> {
    let (trimmed, counts, posted) = Trimmed::new(gear, nodes, settings)?;
    let model = Model::Polynomial { degree: Degree::Both(2), basis: PolynomialBasis::Monomial, terms: Terms::Total };
    let of_kept = errors::of_kept(&settings.spec, &trimmed.kept, counts.posted).map_err(FitError::from)?;
    let asked = of_kept.as_ref().unwrap_or(&settings.spec);
    let include = Include { residuals: true, ..asked.include };
    let mut result = flankfit_estimation::fit(&posted, &FitSpec { model, domain: None, include, ..asked.clone() })?;
    let residuals = result.residuals.values.take().unwrap_or_default();
    let (lowest, highest) =
        residuals.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &r| (a.min(r), b.max(r)));
    let scale = settings.terms.factor(gear, settings.direction);
    let remainder = Remainder {
        peak_to_valley: scale * (highest - lowest),
        rms: scale * result.residuals.rms,
        max_abs: scale * highest.max(-lowest),
    };
    if asked.include.residuals {
        result.residuals.values = Some(residuals);
    } else {
        result.residuals.node_indices = None;
    }
    let [profile, helix] = settings.signs();
    let (slopes, limits) = (trimmed.slopes(gear, settings.terms), &settings.limits);
    let tolerances = Tolerances::new(gear);
    limits.check(&tolerances, true).within("tolerance_limits").into_result(())?;
    let [slope_of_profile, slope_of_helix] = slopes.limits(limits, tolerances.as_ref().ok());
    // figures over a range that the nodes hardly cover are not compared with limits
    let [profile_told, helix_told] = trimmed.covered;
    let figure = |powers: [usize; 2], factor: f64, limits: Option<[f64; 2]>| {
        let found = result.coefficients.iter().find(|c| matches!(&c.key, TermKey::Powers(p) if p[..] == powers));
        found
            .map(|coefficient| Figure::new(&coefficient.into(), scale * factor, limits))
            .ok_or(FitError::NotConverged(Unconverged::SecondOrder))
    };
    Ok(FlankSurface {
        mean: figure([0, 0], 1.0, None)?,
        profile_slope: figure([1, 0], 2.0 * profile * slopes.factors[0], slope_of_profile.filter(|_| profile_told))?,
        helix_slope: figure([0, 1], 2.0 * helix * slopes.factors[1], slope_of_helix.filter(|_| helix_told))?,
        profile_crowning: figure([2, 0], -1.0, limits.profile_crowning.filter(|_| profile_told))?,
        helix_crowning: figure([0, 2], -1.0, limits.helix_crowning.filter(|_| helix_told))?,
        twist: figure([1, 1], 4.0 * helix, limits.twist.filter(|_| profile_told && helix_told))?,
        remainder,
        roll_lengths: trimmed.roll,
        z: trimmed.z,
        references: slopes.references,
        nodes: counts,
        warnings: trimmed.warnings,
        result,
    })
}

impl Figure {
    /// `factor` times an estimate.
    fn new(estimate: &WeightedSum, factor: f64, limits: Option<[f64; 2]>) -> Self {
        let inference = estimate.interval.map(|interval| {
            let [a, b] = interval.ends.map(|end| factor * end);
            let about = interval.about.scaled(factor);
            Inference {
                interval: [a.min(b), a.max(b)],
                kind: interval.kind,
                about,
                conformity: limits.map(|limits| about.conformity(limits)),
            }
        });
        Figure {
            value: factor * estimate.value,
            std_error: estimate.std_error.map(|e| e * factor.abs()),
            conditional_std_error: estimate.conditional_std_error.map(|e| e * factor.abs()),
            bias_bound: estimate.bias_bound * factor.abs(),
            least_squares: factor * estimate.least_squares,
            limits,
            inference,
        }
    }
}
