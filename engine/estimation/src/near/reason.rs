//! Errors in a curve near points, or a large surface.

use std::fmt;

use crate::smoothing::choice::NoParameter;
use flankfit_geometry::{curve::CurveFault, space::ControlFault};
use flankfit_numerics::fault::words::{Shown, counted, entries};

/// A coefficient of a surface that nodes and penalty leave open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenCoefficient {
    /// Which one, along u and v.
    pub index: [usize; 2],
    /// Where its function lives on u.
    pub u: [f64; 2],
    /// Where its function lives on v.
    pub v: [f64; 2],
    /// Nodes there.
    pub nodes: usize,
}

impl fmt::Display for OpenCoefficient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let OpenCoefficient { index: [i, j], u: [a, b], v: [c, d], nodes } = self;
        write!(
            f,
            "the coefficient of B{i}(u)*B{j}(v), which lives on u from {a} to {b} and v from {c} to {d}, is not \
             determined by the {nodes} nodes there"
        )
    }
}

/// Why it is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NearReason {
    /// A tolerance that is no length.
    #[error("a finite length greater than 0")]
    Tolerance,
    /// A limit of control points out of its range.
    #[error("not within {least} (the first knots) and {most}")]
    MostControls {
        /// Control points to start with.
        least: usize,
        /// Coefficients at most.
        most: usize,
    },
    /// Points that all have weight 0.
    #[error("every point is of weight 0")]
    NoPointCounts,
    /// Fewer points than control points.
    #[error("{controls} control points cannot be determined from so few points, {points}")]
    FewPoints {
        /// Control points.
        controls: usize,
        /// Points that count.
        points: usize,
    },
    /// More spans than a fit may have.
    #[error("{0} spans are more than a fit may have")]
    Spans(usize),
    /// A wrong number of knot vectors.
    #[error("one knot vector")]
    KnotVectors,
    /// A wrong number of coordinates of a curve.
    #[error("one, two or three coordinates make a curve")]
    CurveCoordinates,
    /// Coordinates of different lengths.
    #[error("coordinate {coordinate} has {}, the first one {first}", entries(*.given))]
    CoordinateCount {
        /// Which one.
        coordinate: usize,
        /// Its entries.
        given: usize,
        /// Entries of the first one.
        first: usize,
    },
    /// A number that is none.
    #[error("{0} is not a finite number")]
    NotFinite(f64),
    /// Parameters by the points of a graph.
    #[error("a graph y(x) has x for its parameter")]
    GraphHasX,
    /// A wrong number of parameters.
    #[error("{} for {points} points", counted(*.given, "parameter", "parameters"))]
    ParameterCount {
        /// Parameters.
        given: usize,
        /// Points.
        points: usize,
    },
    /// A wrong number of weights of points.
    #[error("{} for {points} points", entries(*.given))]
    WeightCount {
        /// Weights.
        given: usize,
        /// Points.
        points: usize,
    },
    /// Filters of points.
    #[error("points of a curve are not filtered")]
    CurveHasNoFilters,
    /// Weights of NURBS whose number is not known.
    #[error("with knots placed by residuals the number of control points is not known beforehand")]
    UnknownControls,
    /// What is wrong with control points or degree.
    #[error(transparent)]
    Control(#[from] ControlFault),
    /// What is wrong with points or parameters.
    #[error(transparent)]
    Curve(#[from] CurveFault),
    /// Nodes that all have weight 0.
    #[error("every node is of weight 0")]
    NoNodeCounts,
    /// More nodes than are numbered.
    #[error("there are more nodes than 32 bits can number")]
    TooManyNodes,
    /// A wrong number of coordinates of a surface.
    #[error("one coordinate (z) or three (x, y, z) are fitted")]
    SurfaceCoordinates,
    /// A list of another length than u.
    #[error("{}, but u asks for {wanted}", entries(*.given))]
    CountAlongU {
        /// Entries.
        given: usize,
        /// Entries of u.
        wanted: usize,
    },
    /// A domain that does not ascend.
    #[error("not a range from low to high")]
    Range,
    /// A node beyond the knots.
    #[error("{value} lies outside the span of the knots [{}, {}]", Shown(.span[0]), Shown(.span[1]), value = Shown(*.value))]
    OutsideKnots {
        /// Its abscissa.
        value: f64,
        /// The span.
        span: [f64; 2],
    },
    /// A degree that is not offered.
    #[error("big surfaces have degrees up to {highest}")]
    Degree {
        /// The highest one.
        highest: usize,
    },
    /// A surface with one knot vector.
    #[error("a surface wants knots for u and for v")]
    SurfaceKnots,
    /// A surface of another model.
    #[error("big surfaces are B-splines")]
    BSplinesOnly,
    /// NURBS.
    #[error("big surfaces are B-splines without weights")]
    NoControlWeights,
    /// A robust estimator.
    #[error("big surfaces are fitted by least squares")]
    LeastSquaresOnly,
    /// Filters of scattered nodes.
    #[error("filters are for nodes in lines, not for scattered ones")]
    SurfaceHasNoFilters,
    /// Standardised columns.
    #[error("B-splines have no constant to centre by: take columns of unit length, or as they are")]
    NotStandardized,
    /// An uncertainty of the nodes.
    #[error("big surfaces have no perturbation bounds")]
    NoPerturbationBounds,
    /// A limit of the coefficients' norm.
    #[error("big surfaces have no bias bounds")]
    NoBiasBounds,
    /// A standard deviation that is none.
    #[error("σ is a finite number greater than 0")]
    NoiseSigma,
    /// Weights of a penalty that are none.
    #[error("a surface takes [w_u, w_v], none negative, one greater than 0")]
    PenaltyWeights,
    /// A regularisation that needs the whole spectrum.
    #[error("with so many coefficients there is no spectrum: take none, ridge or Tikhonov regularisation")]
    NoSpectrum,
    /// Derivatives that the model does not have.
    #[error("derivatives of order {0} vanish for every function of this model")]
    VanishingDerivatives(usize),
    /// More coefficients than the banded factorisation takes.
    #[error("{coefficients} coefficients with a band of {width} are more than a fit may have: take fewer spans")]
    TooLarge {
        /// Coefficients.
        coefficients: usize,
        /// Width of the band.
        width: usize,
    },
    /// Fewer nodes than coefficients.
    #[error(
        "{coefficients} coefficients cannot be determined from {nodes} counted nodes: take fewer spans, or Tikhonov \
         regularisation"
    )]
    FewNodes {
        /// Coefficients.
        coefficients: usize,
        /// Nodes that count.
        nodes: usize,
    },
    /// A coefficient that is left open.
    #[error(
        "{coefficient}: {}",
        if *.penalised {
            "the penalty leaves it open too: take a lower order or fewer spans"
        } else {
            "take fewer spans there, measure more nodes, or take Tikhonov regularisation"
        }
    )]
    Undetermined {
        /// Which one.
        coefficient: OpenCoefficient,
        /// Whether there is a penalty.
        penalised: bool,
    },
    /// No weight of the penalty.
    #[error(transparent)]
    Parameter(#[from] NoParameter),
}
