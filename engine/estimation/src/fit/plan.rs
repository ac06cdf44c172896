//! Plans: what a full grid and a spec decide before a height is seen, kept for the next flank.
//!
//! A gear is measured on one grid of nodes tooth after tooth, so the QR of the axes, the spectrum,
//! the collinearity report and its sentences come out the same, bit for bit, while only heights
//! change. A [`Plan`] holds them; [`Plans`] finds the plan of a grid again by comparing every
//! number of it. A response does not depend on whether a plan was found or made.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nalgebra::DMatrix;

use crate::{
    data::{Grid, Nodes, Sample},
    design::Design,
    error::FitError,
    estimate::Frame,
    factor::{Axes, Factor, Separable},
    spec::{Domain, FitSpec, Model, Scaling},
};
use flankfit_numerics::Dd;

/// Plans kept at most. With the two limits below a plan takes at most about 1 MB.
const KEPT: usize = 32;
const MOST_COEFFICIENTS: usize = 64;
const MOST_POSITIONS: usize = 4_096;

/// Parts of a fit that positions and spec determine.
pub(super) struct Plan {
    pub design: Design,
    axes: Arc<Axes>,
    r: DMatrix<Dd>,
    change: DMatrix<Dd>,
    frame: OnceLock<Frame>,
}

impl Plan {
    /// `None` where the grid does not separate into its axes.
    fn new(nodes: &Nodes, grid: &Grid, sample: &Sample, spec: &FitSpec) -> Result<Option<Self>, FitError> {
        let design = Design::new(nodes, sample, spec)?;
        let Some(axes) = design.is_full_product().then(|| Axes::new(&design, grid)).flatten() else { return Ok(None) };
        let (r, change) = (axes.r(), design.change_of_basis());
        Ok(Some(Plan { design, axes: Arc::new(axes), r, change, frame: OnceLock::new() }))
    }

    /// The factor with the heights of `grid`.
    pub(super) fn factor(&self, grid: &Grid) -> Result<Factor, FitError> {
        let separable = Separable::new(Arc::clone(&self.axes), grid);
        Factor::of_axes(self.r.clone(), self.change.clone(), separable).finite()
    }

    /// The analysis of the columns, made once.
    pub(super) fn frame(&self, factor: &Factor, spec: &FitSpec, weight: f64) -> Result<&Frame, FitError> {
        match self.frame.get() {
            Some(frame) => Ok(frame),
            None => {
                let frame = Frame::new(&self.design, factor, spec, weight)?;
                Ok(self.frame.get_or_init(|| frame))
            }
        }
    }
}

/// Everything that a plan depends on.
struct Key {
    u: Vec<f64>,
    v: Vec<f64>,
    model: Model,
    scaling: Scaling,
    domain: Option<Domain>,
    all_matrices: bool,
}

impl Key {
    fn of(grid: &Grid, spec: &FitSpec) -> Self {
        Key {
            u: grid.u.clone(),
            v: grid.v.clone(),
            model: spec.model.clone(),
            scaling: spec.scaling,
            domain: spec.domain,
            all_matrices: spec.include.collinearity,
        }
    }

    fn is_of(&self, grid: &Grid, spec: &FitSpec) -> bool {
        same(&self.u, &grid.u)
            && same(&self.v, &grid.v)
            && self.scaling == spec.scaling
            && self.domain == spec.domain
            && self.all_matrices == spec.include.collinearity
            && self.model == spec.model
    }
}

/// Equal bit by bit: 0 and −0 may lead to zeros of different sign.
fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

/// The latest used one first.
type Cached = Vec<(Key, Arc<Plan>)>;

/// The plans made last. Clones share them.
#[derive(Clone, Default)]
pub struct Plans {
    kept: Arc<Mutex<Cached>>,
}

impl std::fmt::Debug for Plans {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner).len();
        f.debug_struct("Plans").field("kept", &kept).finish()
    }
}

impl Plans {
    /// The grid of `nodes` and its plan, found or made; `None` for nodes that do not separate into
    /// axes.
    pub(super) fn of<'a>(
        &self,
        nodes: &'a Nodes,
        sample: &Sample,
        spec: &FitSpec,
    ) -> Result<Option<(&'a Grid, Arc<Plan>)>, FitError> {
        let Nodes::Grid(grid) = nodes else { return Ok(None) };
        if spec.scaling == Scaling::Standardized || !sample.separates() {
            return Ok(None);
        }
        if let Some(plan) = self.find(grid, spec) {
            return Ok(Some((grid, plan)));
        }
        let Some(plan) = Plan::new(nodes, grid, sample, spec)?.map(Arc::new) else { return Ok(None) };
        if plan.design.size() <= MOST_COEFFICIENTS && grid.u.len() + grid.v.len() <= MOST_POSITIONS {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            kept.truncate(KEPT - 1);
            kept.insert(0, (Key::of(grid, spec), Arc::clone(&plan)));
        }
        Ok(Some((grid, plan)))
    }

    fn find(&self, grid: &Grid, spec: &FitSpec) -> Option<Arc<Plan>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let at = kept.iter().position(|(key, _)| key.is_of(grid, spec))?;
        kept[..=at].rotate_right(1);
        Some(Arc::clone(&kept[0].1))
    }
}
