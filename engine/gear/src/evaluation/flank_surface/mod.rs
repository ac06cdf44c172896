//! The second-order surface of a whole flank: what its deviations have in common, and what is left
//! as form.
//!
//! Over the evaluation range, less the border, roll length and z are mapped to [-1, 1]²: u from
//! root to tip, v towards greater z. `δ ≈ c₁ + c_u u + c_v v + c_uu u² + c_uv uv + c_vv v²` is a
//! fit with the caller's regularisation, estimator and filters, and
//!
//! | figure | is | positive where material |
//! |---|---|---|
//! | mean | c₁ | protrudes in the middle of the flank |
//! | profile slope | 2 c_u | grows from root to tip |
//! | helix slope | 2 c_v | grows with z (by the sign asked for) |
//! | profile crowning | −c_uu | protrudes half-way between root and tip |
//! | lengthwise crowning | −c_vv | protrudes half-way between the ends |
//! | twist | 4 c_uv | grows more with z at the tip than at the root (by the sign asked for) |
//!
//! all in µm over the trimmed range, with standard errors and with the bounds of their bias that
//! the fit returns (for the use of such a surface see Litvin et al., ASME J. Mech. Des. 115(4),
//! 1993, p. 995). Slopes are extended linearly to their reference lengths, and all figures count
//! along the normal, unless [`FigureTerms`] say otherwise. Crownings and twist are never extended.

mod errors;
mod figures;
mod nodes;
mod own_zeros;
mod projected;
mod roll_lengths;
mod settings;

use super::{
    limits::{Inference, within},
    warning::SurfaceWarning,
};
use crate::{Gear, tolerance::Tolerances, trace::Direction};
pub use figures::{EstimatedFigure, FlankFigures, estimated_figures, flank_figures};
use flankfit_estimation::{
    self, FitError, FitSpec, Unconverged,
    inference::{Conformity, Doubts},
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

/// A gear figure with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = FlankFigure)
)]
pub struct Figure {
    /// The figure itself, in the unit that the name of its field ends in.
    pub value: f64,
    /// Standard error, by the noise that the residuals show or that was given; absent if neither
    /// determines it.
    pub std_error: Option<f64>,
    /// Standard error that ignores the choice of λ* by the nodes; too small.
    pub conditional_std_error: Option<f64>,
    /// Greatest mean displacement by regularisation, for coefficients within the norm limit of the
    /// fit (`bias.coefficient_norm_limit`).
    pub bias_bound: f64,
    /// The figure without regularisation.
    pub least_squares: f64,
    /// Limits, if there are some and the nodes cover enough of the range.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub limits: Option<[f64; 2]>,
    /// True if the estimate lies within its limits (`tolerance_limits`); present if the figure has
    /// limits and is not extrapolated (`range_not_covered`).
    pub within: Option<bool>,
    /// Interval; `None` if the noise is not known.
    #[cfg_attr(feature = "contract", serde(flatten), schema(inline))]
    pub inference: Option<Inference>,
    /// Conformity with the limits, if `within` is given; `undecidable` without an interval.
    pub conformity: Option<Conformity>,
}

/// Residuals of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = FlankForm)
)]
pub struct Remainder {
    /// Greatest minus least of the remainder.
    pub peak_to_valley_um: f64,
    /// Root mean square of the remainder.
    pub rms_um: f64,
    /// Largest amount of the remainder.
    pub max_abs_um: f64,
}

/// Figures of the second-order surface of a flank, in µm, and what the surface leaves over. Slopes
/// are over their reference lengths, the other figures over the trimmed range.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, utoipa::ToSchema))]
pub struct FlankSurface {
    /// Deviation of the surface in the middle of the flank: c₁.
    #[cfg_attr(feature = "contract", serde(rename = "mean_um"))]
    pub mean: Figure,
    /// Profile slope, 2 c_u, from root to tip; positive where material grows towards the tip.
    #[cfg_attr(feature = "contract", serde(rename = "profile_slope_um"))]
    pub profile_slope: Figure,
    /// Helix slope, 2 c_v, over the width, in the requested sign.
    #[cfg_attr(feature = "contract", serde(rename = "helix_slope_um"))]
    pub helix_slope: Figure,
    /// Profile crowning, −c_uu; positive where material protrudes half-way between root and tip.
    #[cfg_attr(feature = "contract", serde(rename = "profile_crowning_um"))]
    pub profile_crowning: Figure,
    /// Helix crowning, −c_vv; positive where material protrudes half-way between the ends.
    #[cfg_attr(feature = "contract", serde(rename = "helix_crowning_um"))]
    pub helix_crowning: Figure,
    /// Twist, 4 c_uv: profile slope at the end of great z minus that at the end of small z, over
    /// the whole evaluation ranges, in the requested sign. On traces `twists` have another figure
    /// of that name, between the measured sections.
    #[cfg_attr(feature = "contract", serde(rename = "twist_um"))]
    pub twist: Figure,
    /// Direction of figures and form.
    pub direction: Direction,
    /// Length that the profile slope refers to.
    pub profile_reference_length_mm: f64,
    /// Length that the helix slope refers to.
    pub helix_reference_length_mm: f64,
    /// Residuals of the surface.
    pub form: Remainder,
    /// Roll lengths at u = ∓1, after trimming.
    pub roll_length_range_mm: [f64; 2],
    /// Values of z at v = ∓1, after trimming.
    pub z_range_mm: [f64; 2],
    /// Numbers of nodes.
    pub nodes: NodeCounts,
    /// Warnings about the nodes.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub warnings: Vec<SurfaceWarning>,
    /// The fit: spectrum, collinearity, regularisation, warnings.
    #[cfg_attr(feature = "contract", serde(skip))]
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
    let form = Remainder {
        peak_to_valley_um: scale * (highest - lowest),
        rms_um: scale * result.residuals.rms,
        max_abs_um: scale * highest.max(-lowest),
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
    let [profile_covered, helix_covered] = trimmed.covered;
    let figure = |powers: [usize; 2], factor: f64, limits: Option<[f64; 2]>| {
        let found = result.coefficients.iter().find(|c| matches!(&c.key, TermKey::Powers(p) if p[..] == powers));
        found
            .map(|coefficient| Figure::new(&coefficient.into(), scale * factor, limits, result.doubts()))
            .ok_or(FitError::NotConverged(Unconverged::SecondOrder))
    };
    Ok(FlankSurface {
        mean: figure([0, 0], 1.0, None)?,
        profile_slope: figure([1, 0], 2.0 * profile * slopes.factors[0], slope_of_profile.filter(|_| profile_covered))?,
        helix_slope: figure([0, 1], 2.0 * helix * slopes.factors[1], slope_of_helix.filter(|_| helix_covered))?,
        profile_crowning: figure([2, 0], -1.0, limits.profile_crowning_um.filter(|_| profile_covered))?,
        helix_crowning: figure([0, 2], -1.0, limits.helix_crowning_um.filter(|_| helix_covered))?,
        twist: figure([1, 1], 4.0 * helix, limits.twist_um.filter(|_| profile_covered && helix_covered))?,
        direction: settings.terms.direction,
        profile_reference_length_mm: slopes.references[0],
        helix_reference_length_mm: slopes.references[1],
        form,
        roll_length_range_mm: trimmed.roll,
        z_range_mm: trimmed.z,
        nodes: counts,
        warnings: trimmed.warnings,
        result,
    })
}

impl Figure {
    /// Returns `factor` times an estimate; `doubts` are those of its fit.
    fn new(estimate: &WeightedSum, factor: f64, limits: Option<[f64; 2]>, doubts: Doubts) -> Self {
        let inference = estimate.interval.map(|interval| {
            let [a, b] = interval.ends.map(|end| factor * end);
            let about = interval.about.scaled(factor);
            Inference::with([a.min(b), a.max(b)], interval.kind, about)
        });
        let compared = |limits| match &inference {
            Some(inference) => inference.about.conformity(limits),
            None => Conformity::undecidable(limits, doubts),
        };
        Figure {
            value: factor * estimate.value,
            std_error: estimate.std_error.map(|e| e * factor.abs()),
            conditional_std_error: estimate.conditional_std_error.map(|e| e * factor.abs()),
            bias_bound: estimate.bias_bound * factor.abs(),
            least_squares: factor * estimate.least_squares,
            limits,
            within: within(factor * estimate.value, limits),
            inference,
            conformity: limits.map(compared),
        }
    }
}
