//! The named figures of a flank by themselves, as far as its nodes tell them.
//!
//! Nodes over the whole flank tell the second-order surface with all of them. Crossed profiles and
//! leads tell it without the mixed term, that is all but the twist; a single trace tells nothing of
//! the kind. What is told has a condition below Belsley's limit, of columns over [-1, 1] as they
//! are: scaled to one length, a column that hardly is there would look as good as any other.

use super::{super::fault::SurfaceRefused, FlankNodes, SurfaceSettings, Trimmed, flank_surface};
use crate::{
    estimation::{
        self, FitError, FitResult, FitSpec, Nodes,
        spec::{DEFAULT_CONDITION_LIMIT, Model, Regularization, Scaling, Variance},
    },
    gear::Gear,
};

/// Figures in µm over the trimmed range, signs as asked for; `None` where the nodes do not tell
/// one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlankFigures {
    /// Profile slope: 2 c_u.
    pub profile_slope: Option<f64>,
    /// Helix slope: 2 c_v.
    pub helix_slope: Option<f64>,
    /// Profile crowning: −c_uu.
    pub profile_crowning: Option<f64>,
    /// Lengthwise crowning: −c_vv.
    pub helix_crowning: Option<f64>,
    /// Twist: 4 c_uv.
    pub twist: Option<f64>,
}

/// The figures by plain least squares: how `settings` would regularise and scale is not looked at.
/// `None` where the nodes do not tell them.
pub fn flank_figures(gear: &Gear, nodes: &FlankNodes, settings: &SurfaceSettings) -> Option<FlankFigures> {
    let spec =
        FitSpec { regularization: Regularization::None, scaling: Scaling::None, errors: None, ..settings.spec.clone() };
    let spec = FitSpec { variance: Variance::Constant, ..spec };
    let settings = SurfaceSettings { spec, ..settings.clone() };
    // what cannot be fitted is not told
    if let Ok(surface) = flank_surface(gear, nodes, &settings)
        && told(&surface.result)
    {
        return Some(FlankFigures {
            profile_slope: Some(surface.profile_slope.value),
            helix_slope: Some(surface.helix_slope.value),
            profile_crowning: Some(surface.profile_crowning.value),
            helix_crowning: Some(surface.helix_crowning.value),
            twist: Some(surface.twist.value),
        });
    }
    let result = crossed(gear, nodes, &settings).ok().filter(told)?;
    let value = |column: usize| result.coefficients.get(column).map(|coefficient| coefficient.value);
    let [profile, helix] = settings.signs();
    Some(FlankFigures {
        profile_slope: Some(2.0 * profile * value(1)?),
        helix_slope: Some(2.0 * helix * value(2)?),
        profile_crowning: Some(-value(3)?),
        helix_crowning: Some(-value(4)?),
        twist: None,
    })
}

/// Whether the nodes of a fit without scaling tell its terms apart and how large each is: over [-1,
/// 1] a short column is one that hardly is there.
fn told(result: &FitResult) -> bool {
    result.spectrum.condition.is_some_and(|condition| condition < DEFAULT_CONDITION_LIMIT)
}

/// The surface without its mixed term: columns 1, u, v, u², v².
fn crossed(gear: &Gear, nodes: &FlankNodes, settings: &SurfaceSettings) -> Result<FitResult, SurfaceRefused> {
    let (_, _, posted) = Trimmed::new(gear, nodes, settings)?;
    let (mut columns, mut heights) = (Vec::new(), Vec::new());
    let mut add = |u: f64, v: f64, height: f64| {
        if !height.is_nan() {
            columns.extend([1.0, u, v, u * u, v * v]);
            heights.push(height);
        }
    };
    match &posted {
        Nodes::Grid(grid) => {
            for (k, height) in grid.z.iter().enumerate() {
                add(grid.u[k / grid.v.len()], grid.v[k % grid.v.len()], *height);
            }
        }
        Nodes::Scattered(nodes) => {
            for ((u, v), height) in nodes.u.iter().zip(&nodes.v).zip(&nodes.z) {
                add(*u, *v, *height);
            }
        }
        // a flank has nodes with u and v: a matrix without rows is refused below
        Nodes::Curve(_) | Nodes::Matrix(_) => {}
    }
    let nodes = Nodes::matrix(columns, 5, heights, None, None).map_err(FitError::from)?;
    Ok(estimation::fit(&nodes, &FitSpec { model: Model::Linear, domain: None, ..settings.spec.clone() })?)
}
