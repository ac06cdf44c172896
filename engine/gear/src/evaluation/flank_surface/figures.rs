//! The named figures of a flank by themselves, as far as its nodes tell them.
//!
//! Nodes over the whole flank tell the second-order surface with all of them. Crossed profiles and
//! leads determine it without the mixed term, that is all but the twist; a single trace determines
//! none of it. What is determined has a condition below Belsley's limit, of columns over [-1, 1] as
//! they are: scaled to one length, a column that hardly is there would look as good as any other.

use super::{Figure, FlankNodes, Slopes, SurfaceSettings, Trimmed, flank_surface};
use crate::Gear;
use flankfit_estimation::{
    self, FitError, FitResult, FitSpec, Nodes,
    inference::{Doubts, Inferred},
    spec::{DEFAULT_CONDITION_LIMIT, Model, Regularization, Scaling, Variance},
};
use flankfit_numerics::distribution::{Student, fisher::student_two_sided};

/// Figures in µm: slopes over their reference lengths, the others over the trimmed range, signs by
/// the settings; absent if the nodes do not determine them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct FlankFigures<T = f64> {
    /// f_Hα, 2 c_u: positive where material grows from root to tip.
    #[cfg_attr(feature = "contract", serde(rename = "profile_slope_um"))]
    pub profile_slope: Option<T>,
    /// f_Hβ, 2 c_v: by DIN positive where the helix deviates towards the right hand.
    #[cfg_attr(feature = "contract", serde(rename = "helix_slope_um"))]
    pub helix_slope: Option<T>,
    /// C_α, −c_uu: positive where material protrudes half-way between root and tip.
    #[cfg_attr(feature = "contract", serde(rename = "profile_crowning_um"))]
    pub profile_crowning: Option<T>,
    /// C_β, −c_vv: positive where material protrudes half-way between the ends.
    #[cfg_attr(feature = "contract", serde(rename = "helix_crowning_um"))]
    pub helix_crowning: Option<T>,
    /// Twist, 4 c_uv: profile slope at the end of great z minus that at the end of small z, with
    /// the sign of helix slopes.
    #[cfg_attr(feature = "contract", serde(rename = "twist_um"))]
    pub twist: Option<T>,
}

impl<T> Default for FlankFigures<T> {
    /// No figure.
    fn default() -> Self {
        FlankFigures {
            profile_slope: None,
            helix_slope: None,
            profile_crowning: None,
            helix_crowning: None,
            twist: None,
        }
    }
}

impl<T> FlankFigures<T> {
    /// Applies `f` to each figure.
    pub fn map<U>(self, f: impl Fn(T) -> U) -> FlankFigures<U> {
        FlankFigures {
            profile_slope: self.profile_slope.map(&f),
            helix_slope: self.helix_slope.map(&f),
            profile_crowning: self.profile_crowning.map(&f),
            helix_crowning: self.helix_crowning.map(&f),
            twist: self.twist.map(&f),
        }
    }

    /// Returns these figures, each that is missing from `other`.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        FlankFigures {
            profile_slope: self.profile_slope.or(other.profile_slope),
            helix_slope: self.helix_slope.or(other.helix_slope),
            profile_crowning: self.profile_crowning.or(other.profile_crowning),
            helix_crowning: self.helix_crowning.or(other.helix_crowning),
            twist: self.twist.or(other.twist),
        }
    }

    /// References to the figures.
    pub fn as_refs(&self) -> FlankFigures<&T> {
        FlankFigures {
            profile_slope: self.profile_slope.as_ref(),
            helix_slope: self.helix_slope.as_ref(),
            profile_crowning: self.profile_crowning.as_ref(),
            helix_crowning: self.helix_crowning.as_ref(),
            twist: self.twist.as_ref(),
        }
    }

    /// Each figure with its name.
    pub fn named(self) -> [(&'static str, Option<T>); 5] {
        [
            ("profile_slope", self.profile_slope),
            ("helix_slope", self.helix_slope),
            ("profile_crowning", self.profile_crowning),
            ("helix_crowning", self.helix_crowning),
            ("twist", self.twist),
        ]
    }

    /// The figures that `keeps` keeps by their names.
    #[must_use]
    pub fn kept(self, keeps: impl Fn(&str) -> bool) -> Self {
        let FlankFigures { profile_slope, helix_slope, profile_crowning, helix_crowning, twist } = self;
        FlankFigures {
            profile_slope: profile_slope.filter(|_| keeps("profile_slope")),
            helix_slope: helix_slope.filter(|_| keeps("helix_slope")),
            profile_crowning: profile_crowning.filter(|_| keeps("profile_crowning")),
            helix_crowning: helix_crowning.filter(|_| keeps("helix_crowning")),
            twist: twist.filter(|_| keeps("twist")),
        }
    }

    /// Each figure that both have, with that of `other`.
    pub fn zip<U>(self, other: FlankFigures<U>) -> FlankFigures<(T, U)> {
        FlankFigures {
            profile_slope: self.profile_slope.zip(other.profile_slope),
            helix_slope: self.helix_slope.zip(other.helix_slope),
            profile_crowning: self.profile_crowning.zip(other.profile_crowning),
            helix_crowning: self.helix_crowning.zip(other.helix_crowning),
            twist: self.twist.zip(other.twist),
        }
    }
}

/// A figure with its error from the residuals of its own fit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct EstimatedFigure {
    /// In µm.
    #[cfg_attr(feature = "contract", serde(rename = "value_um"))]
    pub value: f64,
    /// In µm; absent without degrees of freedom.
    #[cfg_attr(feature = "contract", serde(rename = "std_error_um"))]
    pub std_error: Option<f64>,
    /// Student's interval `[low, high]` of the true figure in µm, at 0.95 for figures computed over
    /// the nodes; absent without degrees of freedom.
    #[cfg_attr(feature = "contract", serde(rename = "interval_um"), schema(min_items = 2, max_items = 2))]
    pub interval: Option<[f64; 2]>,
    /// The estimate that its conformity is judged by; `None` without degrees of freedom.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub about: Option<Inferred>,
    /// Warnings that the error may be another, or is not known.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub doubts: Doubts,
}

impl EstimatedFigure {
    /// From an estimate, `factor` times which is the figure, with the standard error and the
    /// degrees of freedom that it was estimated from.
    pub(crate) fn new(estimate: f64, std_error: Option<f64>, freedom: usize, factor: f64) -> Self {
        let value = factor * estimate;
        let std_error = std_error.map(|error| factor.abs() * error).filter(|_| freedom > 0);
        let half = std_error.map(|error| student_two_sided(MISS, freedom as f64) * error);
        let student = Student::new(freedom as f64);
        EstimatedFigure {
            value,
            std_error,
            interval: half.map(|half| [value - half, value + half]),
            about: std_error.map(|std_error| Inferred { value, std_error, student, ..Inferred::default() }),
            doubts: Doubts::default(),
        }
    }

    /// Returns the figure with further doubts about its error.
    #[must_use]
    pub fn doubted(self, doubts: Doubts) -> Self {
        let doubts = self.doubts.or(doubts);
        EstimatedFigure { about: self.about.map(|about| Inferred { doubts, ..about }), doubts, ..self }
    }

    /// Returns the figure moved to `value` by an exactly known change.
    #[must_use]
    pub fn at(self, value: f64) -> Self {
        let by = value - self.value;
        EstimatedFigure {
            value,
            std_error: self.std_error,
            interval: self.interval.map(|ends| ends.map(|end| end + by)),
            about: self.about.map(|about| Inferred { value: about.value + by, ..about }),
            doubts: self.doubts,
        }
    }

    /// Returns the figure of the fits of the teeth in place of this one of their nodes: of one
    /// tooth that of its fit, of several the mean with the error of this one. Without fits it is
    /// this one.
    #[must_use]
    pub fn by_fits(self, fits: &[Self]) -> Self {
        match fits {
            [] => self,
            [one] => *one,
            several => {
                let mean = several.iter().map(|one| one.value).sum::<f64>() / several.len() as f64;
                several.iter().map(|one| one.doubts).fold(self.at(mean), Self::doubted)
            }
        }
    }
}

/// Probability with which intervals miss figures.
const MISS: f64 = 0.05;

/// The figures by plain least squares: how `settings` would regularise and scale is not looked at.
/// `None` where the nodes do not tell them.
pub fn flank_figures(gear: &Gear, nodes: &FlankNodes, settings: &SurfaceSettings) -> Option<FlankFigures> {
    Some(estimated_figures(gear, nodes, settings)?.map(|figure| figure.value))
}

/// The same with their errors.
pub fn estimated_figures(
    gear: &Gear,
    nodes: &FlankNodes,
    settings: &SurfaceSettings,
) -> Option<FlankFigures<EstimatedFigure>> {
    let spec =
        FitSpec { regularization: Regularization::None, scaling: Scaling::None, errors: None, ..settings.spec.clone() };
    let spec = FitSpec { variance: Variance::Constant, ..spec };
    let settings = SurfaceSettings { spec, ..settings.clone() };
    // what cannot be fitted is left out
    if let Ok(surface) = flank_surface(gear, nodes, &settings)
        && is_determined(&surface.result)
    {
        let result = &surface.result;
        let freedom = result.residuals.degrees_of_freedom;
        let figure = |figure: Figure| {
            Some(EstimatedFigure::new(figure.value, figure.std_error, freedom, 1.0).doubted(result.doubts()))
        };
        return Some(FlankFigures {
            profile_slope: figure(surface.profile_slope),
            helix_slope: figure(surface.helix_slope),
            profile_crowning: figure(surface.profile_crowning),
            helix_crowning: figure(surface.helix_crowning),
            twist: figure(surface.twist),
        });
    }
    let (trimmed, result) = crossed(gear, nodes, &settings).ok().filter(|(_, result)| is_determined(result))?;
    let freedom = result.residuals.degrees_of_freedom;
    let scale = settings.terms.factor(gear, settings.direction);
    let Slopes { factors, .. } = trimmed.slopes(gear, settings.terms);
    let figure = |column: usize, factor: f64| {
        let found = result.coefficients.get(column)?;
        Some(EstimatedFigure::new(found.value, found.std_error, freedom, scale * factor).doubted(result.doubts()))
    };
    let [profile, helix] = settings.signs();
    Some(FlankFigures {
        profile_slope: Some(figure(1, 2.0 * profile * factors[0])?),
        helix_slope: Some(figure(2, 2.0 * helix * factors[1])?),
        profile_crowning: Some(figure(3, -1.0)?),
        helix_crowning: Some(figure(4, -1.0)?),
        twist: None,
    })
}

/// Whether the nodes of a fit without scaling tell its terms apart and how large each is: over [-1,
/// 1] a short column is one that hardly is there.
fn is_determined(result: &FitResult) -> bool {
    result.spectrum.condition.is_some_and(|condition| condition < DEFAULT_CONDITION_LIMIT)
}

/// The surface without its mixed term: columns 1, u, v, u², v².
fn crossed(gear: &Gear, nodes: &FlankNodes, settings: &SurfaceSettings) -> Result<(Trimmed, FitResult), FitError> {
    let (trimmed, _, posted) = Trimmed::new(gear, nodes, settings)?;
    let (mut columns, mut heights) = (Vec::new(), Vec::new());
    let mut add = |u: f64, v: f64, height: f64| {
        if !height.is_nan() {
            columns.extend([1.0, u, v, u * u, v * v]);
            heights.push(height);
        }
    };
    match &posted {
        Nodes::Grid(grid) => {
            let (u, v) = (grid.u(), grid.v());
            for (k, height) in grid.z().iter().enumerate() {
                add(u[k / v.len()], v[k % v.len()], *height);
            }
        }
        Nodes::Scattered(nodes) => {
            for ((u, v), height) in nodes.u().iter().zip(nodes.v()).zip(nodes.z()) {
                add(*u, *v, *height);
            }
        }
        // a flank has nodes with u and v: a matrix without rows is refused below
        Nodes::Curve(_) | Nodes::Matrix(_) => {}
    }
    let nodes = Nodes::matrix(columns, 5, heights, None, None);
    let nodes = nodes.map_err(|faults| FitError::from(faults.within("nodes")))?;
    let spec = FitSpec { model: Model::Linear, domain: None, ..settings.spec.clone() };
    Ok((trimmed, flankfit_estimation::fit(&nodes, &spec)?))
}
