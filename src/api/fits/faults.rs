//! The table of fits: which place in a request a field of the estimation stands at.

use flankfit_engine::estimation::{
    Faults as FitFaults, Field, FitError, NodeList, Reason, Refused,
    near::fault::{CurveField, CurveRefused},
};

use crate::api::{
    faults::{self, Faults},
    problem::Problem,
};

/// Within the object `nodes`; `None` for what is not of it.
pub fn within_nodes(field: &Field) -> Option<String> {
    let name = |list: NodeList| match list {
        NodeList::X => "x",
        NodeList::Y => "y",
        NodeList::U => "u",
        NodeList::V => "v",
        NodeList::Z => "z",
        NodeList::Weight => "weight",
        NodeList::Valid => "valid",
        NodeList::Names => "names",
    };
    Some(match *field {
        Field::Nodes => String::new(),
        Field::NodesType => "/type".to_owned(),
        Field::List(list) => format!("/{}", name(list)),
        Field::Entry(list, index) => format!("/{}/{index}", name(list)),
        Field::Cell(list, row, column) => format!("/{}/{row}/{column}", name(list)),
        _ => return None,
    })
}

/// Within the object `model`; `None` for what is not of it.
fn within_model(field: &Field) -> Option<String> {
    Some(match *field {
        Field::Model => String::new(),
        Field::ModelType => "/type".to_owned(),
        Field::Degree => "/degree".to_owned(),
        Field::Knots => "/knots".to_owned(),
        Field::Knot(index) => format!("/knots/{index}"),
        Field::AxisKnots(axis) => format!("/knots/{axis}"),
        Field::AxisKnot(axis, index) => format!("/knots/{axis}/{index}"),
        Field::Spans => "/spans".to_owned(),
        Field::AxisSpans(axis) => format!("/spans/{axis}"),
        Field::ControlWeights => "/weights".to_owned(),
        Field::ControlWeight(index) => format!("/weights/{index}"),
        Field::NetWeight(row, column) => format!("/weights/{row}/{column}"),
        _ => return None,
    })
}

/// Of a request for a fit, or for what is read like one.
impl faults::Field<Reason> for Field {
    fn pointer(&self) -> String {
        place(self, "/nodes", "/model")
    }

    fn detail(&self, reason: &Reason) -> String {
        match reason {
            Reason::Unsuited { field, reason } => {
                format!("the stream's {} does not suit these nodes: {}", field.pointer(), field.detail(reason))
            }
            other => other.to_string(),
        }
    }
}

/// Where nodes stand at `nodes` and the model at `model`.
fn place(field: &Field, nodes: &str, model: &str) -> String {
    if let Some(within) = within_nodes(field) {
        return format!("{nodes}{within}");
    }
    if let Some(within) = within_model(field) {
        return format!("{model}{within}");
    }
    let name = match *field {
        Field::Domain => "/domain",
        Field::DomainU => "/domain/u",
        Field::DomainV => "/domain/v",
        Field::Scaling => "/scaling",
        Field::Regularization => "/regularization",
        Field::RegularizationType => "/regularization/type",
        Field::Order => "/regularization/order",
        Field::PenaltyWeights => "/regularization/weights",
        Field::PenaltyWeight(index) => return format!("/regularization/weights/{index}"),
        Field::Parameter => "/regularization/parameter",
        Field::Criterion => "/regularization/parameter/criterion",
        Field::Rank => "/regularization/rank",
        Field::Count => "/regularization/count",
        Field::Target => "/regularization/target",
        Field::Variant => "/regularization/variant",
        Field::Estimator => "/estimator",
        Field::EstimatorType => "/estimator/type",
        Field::Coverage => "/estimator/coverage",
        Field::MaxIterations => "/estimator/max_iterations",
        Field::Tuning => "/estimator/tuning",
        Field::ScaleValue => "/estimator/scale/value",
        Field::CoefficientNormLimit => "/coefficient_norm_limit",
        Field::NoiseSigma => "/noise_sigma",
        Field::NodeUncertainty => "/node_uncertainty",
        Field::Include => "/include",
        Field::Filters => "/filters",
        Field::Filter(index) => return format!("/filters/{index}"),
        Field::FilterType(index) => return format!("/filters/{index}/type"),
        Field::FilterAxis(index) => return format!("/filters/{index}/axis"),
        Field::FilterWindow(index) => return format!("/filters/{index}/window"),
        Field::FilterCutoff(index) => return format!("/filters/{index}/cutoff"),
        Field::ForgettingFactor => "/forgetting_factor",
        _ => "",
    };
    name.to_owned()
}

/// Of a request for a shape, whose method is the model and whose nodes stand at `base`.
pub fn of_shape(field: &Field, base: &str) -> String {
    place(field, base, "/method")
}

/// Faults of a shape's nodes or method.
pub fn shape_faults(found: &FitFaults, base: &str) -> Faults {
    Faults::by(found, |field| of_shape(field, base))
}

/// A fit of a shape that was refused.
pub fn refused_shape(error: FitError, base: &str) -> Problem {
    Problem::of_fit(error, |field| of_shape(field, base))
}

/// Of a request for a curve near points.
impl faults::Field<Reason> for CurveField {
    fn pointer(&self) -> String {
        match *self {
            CurveField::Points => "/points".to_owned(),
            CurveField::Parametrization => "/points/parametrization".to_owned(),
            CurveField::Abscissa(index) => format!("/points/x/{index}"),
            CurveField::Ordinate(index) => format!("/points/y/{index}"),
            CurveField::Parameter(index) => format!("/points/parameters/{index}"),
            CurveField::Point(index) => format!("/points/xyz/{index}"),
            CurveField::Coordinate(index, coordinate) => format!("/points/xyz/{index}/{coordinate}"),
            CurveField::Curve => "/method".to_owned(),
            CurveField::Weights => "/method/weight".to_owned(),
            CurveField::Weight(index) => format!("/method/weight/{index}"),
            CurveField::ControlCount => "/method/control_count".to_owned(),
            CurveField::Tolerance => "/method/tolerance".to_owned(),
            CurveField::MostControls => "/method/most_control_points".to_owned(),
            CurveField::Fit(field) => of_shape(&field, "/points"),
        }
    }
}

/// A curve near points that was refused.
pub fn refused_curve(error: CurveRefused) -> Problem {
    match error {
        Refused::Invalid(faults) => Problem::invalid(faults),
        Refused::Fit(error) => refused_shape(error, "/points"),
    }
}
