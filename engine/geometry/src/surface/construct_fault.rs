//! Reasons for refusing a surface, with the place in the input.

use super::{
    bezier::BezierFault, boundaries::BoundaryFault, gregory::GregoryFault, grid_fault::GridFault,
    mesh_fault::MeshFault, patchwork::PatchworkFault,
};
use crate::{curve::CurveFault, space::ControlFault};
use flankfit_numerics::fault::words::counted;

/// The part of what was given that a fault speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// The u, or their number.
    U,
    /// The v, or their number.
    V,
    /// Heights `[row][column]`.
    Z,
    /// Points in rows.
    Points,
    /// Boundary curves: index 0 to 3 for u0, u1, v0, v1.
    Boundaries,
    /// Derivatives across these.
    Cross,
    /// Curves of a mesh: index 0 for those over v, 1 for those over u, then the curve.
    Mesh,
    /// Control points in rows.
    ControlPoints,
    /// The second points of a Gregory patch's pairs.
    Inner,
    /// Weights in rows.
    Weights,
    /// Index 0 for u, 1 for v, then the knot.
    Knots,
    /// Index 0 for u, 1 for v.
    Degrees,
    /// Index 0 for u, 1 for v.
    Spans,
    /// Index 0 for u, 1 for v.
    Domain,
    /// Twists at the corners.
    Twists,
    /// The distance up to which curves count as meeting.
    Tolerance,
    /// The method of construction.
    Method,
}

/// Why a surface is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceFault {
    /// A method that does not apply to what is given.
    #[error("of {given} no surface is made by the method {method}")]
    Combination {
        /// What is given.
        given: &'static str,
        /// The method asked for.
        method: &'static str,
    },
    /// Twists of one patch for something made of several.
    #[error("twists are given for one patch, not for {given}")]
    OwnTwists {
        /// What is given.
        given: &'static str,
    },
    /// The grid of nodes is refused.
    #[error(transparent)]
    Grid(#[from] GridFault),
    /// The boundary curves are refused.
    #[error(transparent)]
    Boundary(#[from] BoundaryFault),
    /// The mesh of curves is refused.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
    /// The Gregory net is refused.
    #[error(transparent)]
    Gregory(#[from] GregoryFault),
    /// The Bézier net is refused.
    #[error("{fault}")]
    Bezier {
        /// Why it is refused.
        fault: BezierFault,
        /// Points in a row of the net, from which row and column of an index follow.
        columns: usize,
    },
    /// The control points or weights are refused.
    #[error("{fault}")]
    Control {
        /// Why they are refused.
        fault: ControlFault,
        /// Points in a row of the net, from which row and column of an index follow.
        columns: usize,
    },
    /// No spline can be laid through a line of nodes.
    #[error("no curve goes through a line of nodes: {fault}")]
    Network {
        /// The axis along which the line runs: 0 for u, 1 for v.
        axis: usize,
        /// Why the curve is refused.
        fault: CurveFault,
    },
    /// Rows of the net of unequal length.
    #[error("row {row} of the net has {}, the first one {wanted}", counted(*.given, "point", "points"))]
    RaggedNet {
        /// Index of the row, from 0.
        row: usize,
        /// Points in it.
        given: usize,
        /// Points in the first row.
        wanted: usize,
    },
    /// A net of points of the plane.
    #[error("control points of a surface are heights or points of space, not of a plane")]
    PlaneNet,
    /// Rows of weights that are not as many as those of the net.
    #[error(
        "{} of weights for {} of control points",
        counted(*.given, "row", "rows"),
        counted(*.wanted, "row", "rows")
    )]
    WeightRows {
        /// Rows of weights given.
        given: usize,
        /// Rows of control points.
        wanted: usize,
    },
    /// A row of weights that is not as long as those of the net.
    #[error(
        "row {row} of the weights has {}, a row of the net {}",
        counted(*.given, "number", "numbers"),
        counted(*.wanted, "point", "points")
    )]
    RaggedWeights {
        /// Index of the row, from 0.
        row: usize,
        /// Weights in it.
        given: usize,
        /// Control points in a row of the net.
        wanted: usize,
    },
    /// Knots that are not as many as degree and control points ask for.
    #[error("{}; degree and control points ask for {wanted}", counted(*.given, "knot", "knots"))]
    KnotCount {
        /// The axis: 0 for u, 1 for v.
        axis: usize,
        /// Knots given.
        given: usize,
        /// Knots needed: control points along the axis + degree + 1.
        wanted: usize,
    },
    /// A net that is not that of a Gregory patch.
    #[error(
        "a Gregory patch has a net of 4 × 4 points, 2 × 2 further inner points and no weights; the net is {rows} × \
         {columns}"
    )]
    GregoryNet {
        /// Control points along u.
        rows: usize,
        /// Control points along v.
        columns: usize,
    },
}

impl SurfaceFault {
    /// The field at fault and the place in it, outermost index first.
    pub fn place(&self) -> (Field, Vec<usize>) {
        use SurfaceFault::*;
        match self {
            Combination { .. } => (Field::Method, vec![]),
            OwnTwists { .. } => (Field::Twists, vec![]),
            Grid(fault) => of_grid(fault),
            Boundary(fault) => of_boundary(fault),
            Mesh(fault) => of_mesh(fault),
            Gregory(GregoryFault::Domain { axis, .. }) => (Field::Domain, vec![*axis]),
            Gregory(GregoryFault::Control(fault)) => match fault.index() {
                Some(index) if index >= 16 => (Field::Inner, vec![(index - 16) / 2, index % 2]),
                Some(index) => (Field::ControlPoints, vec![index / 4, index % 4]),
                None => (Field::ControlPoints, vec![]),
            },
            Bezier { fault: BezierFault::Net { .. }, .. } => (Field::ControlPoints, vec![]),
            Bezier { fault: BezierFault::Domain { axis, .. }, .. } => (Field::Domain, vec![*axis]),
            Bezier { fault: BezierFault::Control(fault), columns } | Control { fault, columns } => {
                of_controls(fault, *columns)
            }
            Network { axis, .. } => (if *axis == 0 { Field::U } else { Field::V }, vec![]),
            RaggedNet { row, .. } => (Field::ControlPoints, vec![*row]),
            PlaneNet | GregoryNet { .. } => (Field::ControlPoints, vec![]),
            WeightRows { .. } => (Field::Weights, vec![]),
            RaggedWeights { row, .. } => (Field::Weights, vec![*row]),
            KnotCount { axis, .. } => (Field::Knots, vec![*axis]),
        }
    }
}

fn of_controls(fault: &ControlFault, columns: usize) -> (Field, Vec<usize>) {
    let at = |index: &usize| vec![index / columns, index % columns];
    match fault {
        ControlFault::Weight { index, .. } => (Field::Weights, at(index)),
        ControlFault::WeightCount { .. } | ControlFault::NoWeight { .. } => (Field::Weights, vec![]),
        ControlFault::NotFinite { index } => (Field::ControlPoints, at(index)),
        ControlFault::Degree { .. } | ControlFault::Count { .. } => (Field::ControlPoints, vec![]),
    }
}

fn of_grid(fault: &GridFault) -> (Field, Vec<usize>) {
    use GridFault::*;
    let axis_of = |axis: &usize| if *axis == 0 { Field::U } else { Field::V };
    match fault {
        TooFew { axis, .. } => (axis_of(axis), vec![]),
        Count { .. } => (Field::Z, vec![]),
        Ragged { row, .. } => (Field::Z, vec![*row]),
        NotFinite { row, column } => (Field::Z, vec![*row, *column]),
        ParameterNotFinite { axis, index } | NotAscending { axis, index, .. } | OutOfDomain { axis, index, .. } => {
            (axis_of(axis), vec![*index])
        }
        Coincident { row, column, .. } => (Field::Points, vec![*row, *column]),
        NoExtent { .. } => (Field::Points, vec![]),
        Degree { axis, .. } => (Field::Degrees, vec![*axis]),
        Spans { axis, .. } => (Field::Spans, vec![*axis]),
        Knots { axis, fault } => (Field::Knots, std::iter::once(*axis).chain(fault.index()).collect()),
        Functions { axis, .. } => (Field::Knots, vec![*axis]),
        SchoenbergWhitney { axis, function, .. } | Rank { axis, function, .. } => {
            (Field::Knots, vec![*axis, *function])
        }
        NotRepresentable { .. } => (Field::Z, vec![]),
    }
}

fn of_boundary(fault: &BoundaryFault) -> (Field, Vec<usize>) {
    match fault {
        BoundaryFault::Cross { border, .. } => (Field::Cross, vec![*border as usize]),
        BoundaryFault::Tolerance { .. } => (Field::Tolerance, vec![]),
        BoundaryFault::Twist { corner } => (Field::Twists, corner.to_vec()),
        other => (Field::Boundaries, other.border().map(|b| b as usize).into_iter().collect()),
    }
}

fn of_mesh(fault: &MeshFault) -> (Field, Vec<usize>) {
    match fault {
        MeshFault::Lines(fault) => of_grid(fault),
        MeshFault::Count { family, .. } => (Field::Mesh, vec![*family]),
        MeshFault::Missing { family, index }
        | MeshFault::Dimension { family, index, .. }
        | MeshFault::Domain { family, index, .. }
        | MeshFault::Curve { family, index, .. } => (Field::Mesh, vec![*family, *index]),
        MeshFault::Crossing { i, .. } => (Field::Mesh, vec![0, *i]),
        MeshFault::Patch { fault: BoundaryFault::Tolerance { .. }, .. } => (Field::Tolerance, vec![]),
        MeshFault::Patch { i, .. } => (Field::Mesh, vec![0, *i]),
        MeshFault::Patchwork(PatchworkFault::Lines(fault)) => of_grid(fault),
        MeshFault::Patchwork(_) => (Field::Mesh, vec![]),
    }
}
