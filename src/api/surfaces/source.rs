//! Wire form of the data of a surface.

use crate::api::{
    contract::Triple,
    fits::{reader::nodes::RawNodes, spec::nodes::NodesBody},
    json::request::request,
};
use flankfit_engine::geometry::{
    contract::{Borders, Point},
    curve::Parametrization,
    surface::mesh::CurveMesh,
};

request! {
    /// Data of a surface.
    #[derive(Default)]
    pub struct SurfaceSource as SurfaceSourceMembers {
        optional grid: HeightGridBody,
        /// Points `[x, y, z]` in rows.
        #[schema(value_type = Option<Vec<Vec<Triple>>>)]
        optional xyz: Vec<Vec<Point>>,
        /// For `xyz`; default `chord_length`.
        optional parametrization: Parametrization,
        optional boundaries: Borders,
        optional mesh: CurveMesh,
        /// For `boundaries` and `mesh`: largest distance between two curves at their crossing, in
        /// the unit of the request. Default 1e-6 of the largest coordinate at their ends.
        #[schema(minimum = 0)]
        optional tolerance: f64,
        /// Rows along u, within a row along v.
        optional control_points: Vec<Vec<Point>>,
        /// Scattered nodes or a grid with missing nodes, for `b_spline_least_squares`.
        optional nodes: NodesBody as RawNodes,
    }
}

impl SurfaceSourceMembers<'_> {
    /// The members of which exactly one says what the surface is made of, and whether it is there.
    pub fn alternatives(&self) -> [(&'static str, bool); 6] {
        [
            ("grid", self.grid.is_given()),
            ("xyz", self.xyz.is_given()),
            ("boundaries", self.boundaries.is_given()),
            ("mesh", self.mesh.is_given()),
            ("control_points", self.control_points.is_given()),
            ("nodes", self.nodes.is_some()),
        ]
    }

    /// The first of these that is there.
    pub fn kind(&self) -> Option<&'static str> {
        self.alternatives().into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }
}

request! {
    /// A grid of nodes: heights z(u, v) over two axes.
    #[schema(as = HeightGrid)]
    pub struct HeightGridBody as HeightGridMembers {
        /// Ascending.
        required u: Vec<f64>,
        /// Ascending.
        required v: Vec<f64>,
        /// A row for each u, within a row a height for each v. None may be missing.
        required z: Vec<Vec<f64>>,
    }
}
