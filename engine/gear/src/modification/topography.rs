//! Discrete modifications: relief given at the nodes of a grid over roll length and z.
//!
//! Between the nodes a tensor-product B-spline of degree 1 (bilinear) or 3 goes through all of
//! them; an axis of fewer nodes has the degree that they allow, and an axis of a single one is
//! constant. Beyond the border the value of the nearest border place goes on.

use super::{LEAST_LENGTH, relief::Relief};
use flankfit_geometry::{
    BSplineBasis,
    surface::{BSplineSurface, NodeGrid, interpolate::interpolate},
};
use flankfit_numerics::{
    cancel::Asking,
    check::Faults,
    words::{Shown, counted},
};

/// Most nodes of one topography.
pub const MOST_NODES: usize = 1_000_000;

/// Surface through the values of a grid. Default `bilinear`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = ReliefInterpolation)
)]
pub enum Interpolation {
    /// Bilinear.
    #[default]
    Bilinear,
    /// Bicubic.
    BSpline,
}

impl Interpolation {
    fn degree(self) -> usize {
        match self {
            Interpolation::Bilinear => 1,
            Interpolation::BSpline => 3,
        }
    }
}

/// Checked relief on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Topography {
    surface: BSplineSurface,
}

impl Topography {
    /// `relief` in µm has a row for each roll length and in it a value for each z; both axes ascend
    /// strictly (mm).
    pub fn new(
        roll_lengths: &[f64],
        positions: &[f64],
        relief: &[Vec<f64>],
        interpolation: Interpolation,
    ) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        for (path, axis) in [("profile.values", roll_lengths), ("face_width_positions_mm", positions)] {
            if axis.is_empty() {
                faults.push(path, "a grid has at least one place on every axis");
            }
            if let Some(index) = axis.iter().position(|x| !(x.abs() <= 1e6)) {
                let place = Shown(axis[index]);
                faults.push(format_args!("{path}[{index}]"), format_args!("{place} is not within ±1000000 mm"));
            } else if let Some(index) = axis.windows(2).position(|pair| !(pair[1] - pair[0] >= LEAST_LENGTH)) {
                let place = Shown(axis[index + 1]);
                faults.push(
                    format_args!("{path}[{}]", index + 1),
                    format_args!("{place} does not lie above the place before it by {LEAST_LENGTH} mm or more"),
                );
            }
        }
        let count = roll_lengths.len().saturating_mul(positions.len());
        if count > MOST_NODES {
            faults.push("", format_args!("{count} nodes; a topography has at most {MOST_NODES}"));
        }
        if relief.len() != roll_lengths.len() {
            let rows = counted(relief.len(), "row", "rows");
            let wanted = counted(roll_lengths.len(), "profile value", "profile values");
            faults.push("relief_um", format_args!("{rows} for {wanted}"));
        }
        for (row, values) in relief.iter().enumerate() {
            if values.len() != positions.len() {
                let (values, wanted) = (counted(values.len(), "value", "values"), positions.len());
                faults.push(format_args!("relief_um[{row}]"), format_args!("{values} for {wanted}"));
            }
            if let Some(column) = values.iter().position(|x| !(x.abs() <= 1e6)) {
                let path = format_args!("relief_um[{row}][{column}]");
                faults.push(path, format_args!("{} is not within ±1000000 µm", Shown(values[column])));
            }
        }
        faults.into_result(())?;
        let (u, v, heights) = widened(roll_lengths, positions, relief);
        let degree = interpolation.degree();
        let degrees = [degree.min(u.len() - 1), degree.min(v.len() - 1)];
        NodeGrid::heights(u, v, &heights)
            .and_then(|grid| interpolate(&grid, degrees, [None, None]))
            .map(|surface| Topography { surface })
            .map_err(|found| Faults::one("", &found.list()[0].message))
    }

    /// Place at which the surface along `axis` is evaluated, with 0 or 1 for what a derivative
    /// there counts.
    fn within(&self, axis: usize, x: f64) -> (f64, f64) {
        let (low, high) = self.surface.bases()[axis].domain();
        if x < low {
            (low, 0.0)
        } else if x > high {
            (high, 0.0)
        } else {
            (x, 1.0)
        }
    }

    /// Sums over the profile at a roll length: what is left is a spline along z, and one of its
    /// growth.
    pub(super) fn contracted(&self, roll_length: f64) -> Contracted {
        let [along, across] = self.surface.bases();
        let (x, counts) = self.within(0, roll_length);
        let weights = Weights::at(along, x, counts);
        let mut contracted = Contracted { value: vec![0.0; across.size()], growth: vec![0.0; across.size()] };
        let rows = self.surface.control_points().chunks_exact(across.size()).skip(weights.first);
        for (k, row) in rows.take(along.degree() + 1).enumerate() {
            for (j, point) in row.iter().enumerate() {
                contracted.value[j] += weights.value[k] * point.x;
                contracted.growth[j] += weights.slope[k] * point.x;
            }
        }
        contracted
    }

    /// The functions along z at one place.
    pub(super) fn columns(&self, z: f64) -> Columns {
        let (x, counts) = self.within(1, z);
        let basis = &self.surface.bases()[1];
        Columns { weights: Weights::at(basis, x, counts), count: basis.degree() + 1 }
    }
}

/// An axis of one node is constant: it gets a second one with the same values.
fn widened(u: &[f64], v: &[f64], relief: &[Vec<f64>]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let two = |axis: &[f64]| {
        if axis.len() == 1 { vec![axis[0], axis[0].abs().mul_add(0.5, axis[0]) + 1.0] } else { axis.to_vec() }
    };
    let (wide_u, wide_v) = (two(u), two(v));
    let value = |i: usize, j: usize| relief[i.min(u.len() - 1)][j.min(v.len() - 1)];
    let heights = (0..wide_u.len()).flat_map(|i| (0..wide_v.len()).map(move |j| (i, j)));
    let heights = heights.map(|(i, j)| value(i, j)).collect();
    (wide_u, wide_v, heights)
}

/// Functions of one axis that are not 0 at a place, and their slopes.
#[derive(Clone, Copy, Debug, Default)]
struct Weights {
    first: usize,
    value: [f64; 4],
    slope: [f64; 4],
}

impl Weights {
    fn at(basis: &BSplineBasis, x: f64, counts: f64) -> Self {
        let mut weights = Weights::default();
        let functions = basis.degree() + 1;
        weights.first = basis.values(x, &mut weights.value[..functions]);
        basis.derivatives(x, &mut weights.slope[..functions]);
        weights.slope.iter_mut().for_each(|slope| *slope *= counts);
        weights
    }
}

/// A topography along one profile's section.
#[derive(Clone, Debug)]
pub(super) struct Contracted {
    value: Vec<f64>,
    growth: Vec<f64>,
}

/// A topography's functions at one z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns {
    weights: Weights,
    count: usize,
}

impl Contracted {
    pub(super) fn at(&self, columns: &Columns) -> Relief {
        let mut relief = Relief::default();
        for k in (0..columns.count).asking(50) {
            let j = columns.weights.first + k;
            relief.value += columns.weights.value[k] * self.value[j];
            relief.by_roll += columns.weights.value[k] * self.growth[j];
            relief.by_z += columns.weights.slope[k] * self.value[j];
        }
        relief
    }
}
