//! The table of fits: which place in a request a field of the estimation stands at.

use flankfit_engine::estimation::{
    Faults as FitFaults, Field, FitError, NodeList, Reason, Refused,
    fault::{
        ConstraintReason, FilterReason, ModelReason, NearReason, PriorReason, RegularizationReason, RobustReason,
        StreamReason,
    },
    near::fault::{CurveField, CurveRefused},
    smoothing::choice::NoParameter,
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
        Field::Terms => "/terms".to_owned(),
        Field::Term(index) => format!("/terms/{index}"),
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
        sentence(reason)
    }
}

/// The engine's words, but where the contract has names for what they speak of.
fn sentence(reason: &Reason) -> String {
    let said = match reason {
        Reason::Unsuited { field, reason } => {
            return format!(
                "the stream's {} does not suit these nodes: {}",
                faults::Field::pointer(field),
                sentence(reason)
            );
        }
        Reason::For { surface, reason } => {
            return format!("for {}: {}", if *surface { "a surface" } else { "a curve" }, sentence(reason));
        }
        Reason::Model(ModelReason::LinearIsForMatrix) => "`linear` is for nodes of type `matrix`",
        Reason::Model(ModelReason::MatrixTakesLinear) => "nodes of type `matrix` take the model `linear`",
        Reason::Stream(StreamReason::LinearTakesMatrix) => "the model `linear` takes nodes of type `matrix`",
        Reason::Stream(StreamReason::NoEarlierIterations) => {
            "a stream does not look at earlier iterations: give `mean` with `std_error` or `covariance`, or refit its \
             iteration with this `prior` when the stream is finished"
        }
        Reason::Stream(StreamReason::NoOtherFit) => {
            "a stream does not look at other fits: give `piece`, which the `spec` of a fit by it holds"
        }
        Reason::Earlier { number, reason } => return format!("iteration {number}: {}", sentence(reason)),
        Reason::Prior(reason) => return of_prior(reason),
        Reason::Constraint(reason) => return of_constraint(reason),
        Reason::Regularization(reason) => return of_regularization(reason),
        Reason::Robust(reason) => return of_estimator(reason),
        Reason::Filter(reason) => return of_filter(reason),
        Reason::Near(reason) => return near(reason),
        other => return other.to_string(),
    };
    said.to_owned()
}

fn of_regularization(reason: &RegularizationReason) -> String {
    use RegularizationReason::*;
    let said = match reason {
        NoConstant => "`standardized` needs exactly one constant column or term, which it leaves unpenalised",
        OnlyConstant => "`standardized` leaves one column aside, and there is no other",
        PenalisedMean => "`standardized` needs a constant that the penalty leaves free",
        PenalisedConstant => {
            "order 0 penalises the constant, which `standardized` leaves unpenalised: take another scaling or order"
        }
        NoJob => "iterations are those of a job, and this request has none: give `piece`",
        NoGrandMean => "`efron_morris` shrinks to the grand mean, which these columns cannot make: give a target",
        RidgeOnly(criterion) => {
            return format!(
                "`{}` is for ridge, and needs coefficients that are not all 0 (`hkb_1975` one, the others three)",
                criterion.name()
            );
        }
        NodesNotKept(criterion) => {
            return format!(
                "`{}` looks at every node, and a stream keeps sums only: take another criterion",
                criterion.name()
            );
        }
        Criterion(criterion) => return format!("`{}` is not for this regularisation", criterion.name()),
        other => return other.to_string(),
    };
    said.to_owned()
}

fn of_prior(reason: &PriorReason) -> String {
    let said = match reason {
        PriorReason::NoJob => {
            "earlier iterations are those of a job, and this request has none: give `mean` with `std_error` or \
             `covariance`"
        }
        PriorReason::FilterOnTop => "a `prior` excludes regularisation: leave `regularization` out, or take `none`",
        PriorReason::LeastSquaresOnly => {
            "a `prior` is for the estimator `least_squares`, whose errors it is weighed against"
        }
        PriorReason::Standardized => {
            "a `prior` is of all coefficients, the constant too, which `standardized` excludes"
        }
        PriorReason::NormLimit => {
            "the `prior` says how large the coefficients are: a limit of their norm cannot be given as well"
        }
        PriorReason::NoNoise => "there is no estimate of the noise to weigh the `prior` against: give `noise_sigma`",
        other => return other.to_string(),
    };
    said.to_owned()
}

fn of_constraint(reason: &ConstraintReason) -> String {
    let said = match reason {
        ConstraintReason::LeastSquaresOnly => "`constraints` are for the estimator `least_squares`",
        ConstraintReason::Regularized => {
            "`constraints` exclude regularisation: leave `regularization` out, or take `none`"
        }
        ConstraintReason::WithPrior => {
            "`prior` and `constraints` exclude each other: the posterior would be that of a truncated distribution"
        }
        ConstraintReason::WithErrors => {
            "`constraints` are for independent errors of one variance: leave `errors` and `variance` out"
        }
        ConstraintReason::NoNoise => {
            "as many coefficients as nodes leave no estimate of the noise, which `constraints` need: give `noise_sigma`"
        }
        other => return other.to_string(),
    };
    said.to_owned()
}

fn of_estimator(reason: &RobustReason) -> String {
    match reason {
        RobustReason::TooLarge { nodes, coefficients, most } => format!(
            "this estimator holds {nodes} nodes × {coefficients} coefficients at once; at most {most} numbers are \
             taken: use an m_estimator, or fewer nodes"
        ),
        RobustReason::TooMuchWork { nodes, coefficients } => format!(
            "least trimmed squares of {nodes} nodes and {coefficients} coefficients is too much work: use an \
             m_estimator, or fewer nodes"
        ),
        RobustReason::FewWeights { left, nodes, coefficients } => format!(
            "{left} of {nodes} nodes keep a weight, which do not determine {coefficients} coefficients: choose a \
             larger scale or tuning constant, or the start least_trimmed_squares"
        ),
        other => other.to_string(),
    }
}

fn of_filter(reason: &FilterReason) -> String {
    match reason {
        FilterReason::Scattered(filter) => {
            format!("scattered nodes lie on no lines along which `{}` could run; send a grid or a curve", filter.name())
        }
        FilterReason::MatrixHasNoAxis(filter) => {
            format!("a measurement matrix has no axis along which `{}` could run", filter.name())
        }
        FilterReason::NoV => "a curve has no v; its x is `u`".to_owned(),
        FilterReason::AxisMissing => "missing; a grid needs `u` or `v`".to_owned(),
        FilterReason::Products { products, most } => format!(
            "the windows hold {products} nodes all together, more than the {most} that this filter may have; choose \
             a shorter cut-off, thin the nodes out, or take `spline`, whose work does not grow with the cut-off"
        ),
        other => other.to_string(),
    }
}

/// Of a curve near points or of a big surface.
fn near(reason: &NearReason) -> String {
    let said = match reason {
        NearReason::BSplinesOnly => "big surfaces are of type `b_spline`",
        NearReason::NotStandardized => "B-splines have no constant to centre by: take `unit_length` or `none`",
        NearReason::NoSpectrum => "with so many coefficients there is no spectrum: take `none`, `ridge` or `tikhonov`",
        NearReason::FewNodes { coefficients, nodes } => {
            return format!(
                "{coefficients} coefficients cannot be determined from {nodes} counted nodes: take fewer spans, or ask for \
                 `tikhonov`"
            );
        }
        NearReason::Undetermined { coefficient, penalised: false } => {
            return format!("{coefficient}: take fewer spans there, measure more nodes, or ask for `tikhonov`");
        }
        NearReason::Parameter(why) => return no_parameter(why),
        other => return other.to_string(),
    };
    said.to_owned()
}

/// Why there is no parameter of a penalty on many coefficients.
pub fn no_parameter(why: &NoParameter) -> String {
    match why {
        NoParameter::NoSigma(criterion) => {
            format!("`{}` needs `noise_sigma`, the standard deviation of a height of weight 1", criterion.name())
        }
        NoParameter::NotHere(criterion) => format!(
            "`{}` is not for a penalty on so many coefficients: gcv, discrepancy, l_curve and min_mse are",
            criterion.name()
        ),
        other => other.to_string(),
    }
}

fn name_of_axis(axis: usize) -> &'static str {
    if axis == 0 { "u" } else { "v" }
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
        Field::LambdaCriterion => "/regularization/lambda_star/criterion",
        Field::Rank => "/regularization/rank",
        Field::Count => "/regularization/count",
        Field::Target => "/regularization/target",
        Field::Variant => "/regularization/variant",
        Field::PieceIteration => "/regularization/iteration",
        Field::PieceModel => "/regularization/piece/model",
        Field::PieceDomain => "/regularization/piece/domain",
        Field::PieceLambdaStar => "/regularization/piece/lambda_star",
        Field::PieceEigenvalues => "/regularization/piece/eigenvalues",
        Field::PieceEigenvalue(index) => return format!("/regularization/piece/eigenvalues/{index}"),
        Field::PieceDirections => "/regularization/piece/directions",
        Field::PieceDirection(index) => return format!("/regularization/piece/directions/{index}"),
        Field::PieceScale => "/regularization/piece/scale",
        Field::PieceScaleOf(index) => return format!("/regularization/piece/scale/{index}"),
        Field::Estimator => "/estimator",
        Field::EstimatorType => "/estimator/type",
        Field::Coverage => "/estimator/coverage",
        Field::MaxIterations => "/estimator/max_iterations",
        Field::Tuning => "/estimator/tuning",
        Field::Share => "/estimator/share",
        Field::ScaleValue => "/estimator/scale/value",
        Field::CoefficientNormLimit => "/coefficient_norm_limit",
        Field::NoiseSigma => "/noise_sigma",
        Field::NodeUncertainty => "/node_uncertainty",
        Field::PositionKind => "/node_uncertainty/position_kind",
        Field::Errors => "/errors",
        Field::ErrorsAlong => "/errors/along",
        Field::ErrorsLine => "/errors/line",
        Field::ErrorsParameters => "/errors/parameters",
        Field::ErrorsRho => "/errors/parameters/rho",
        Field::ErrorsPhi => "/errors/parameters/phi",
        Field::ErrorsLength => "/errors/parameters/length",
        Field::ErrorsNugget => "/errors/parameters/nugget",
        Field::Variance => "/variance",
        Field::VarianceGroups => "/variance/groups",
        Field::VariancePowerOf => "/variance/power_of",
        Field::Level => "/level",
        Field::PredictLevel => "/predict/level",
        Field::PredictAt => "/predict/at",
        Field::PredictRow(index) => return format!("/predict/at/x/{index}"),
        Field::PredictSlopes => "/predict/slopes",
        Field::Prior => "/prior",
        Field::PriorMean => "/prior/mean",
        Field::PriorStdError => "/prior/std_error",
        Field::PriorStdErrorOf(index) => return format!("/prior/std_error/{index}"),
        Field::PriorCovariance => "/prior/covariance",
        Field::PriorRow(index) => return format!("/prior/covariance/{index}"),
        Field::PriorIterations => "/prior/iterations",
        Field::PriorIteration(index) => return format!("/prior/iterations/{index}"),
        Field::PriorMove => "/prior/move",
        Field::PriorMoveOf(index) => return format!("/prior/move/{index}"),
        Field::Select => "/select",
        Field::SelectDegrees => "/select/degrees",
        Field::SelectTerms => "/select/terms",
        Field::SelectAlpha => "/select/alpha",
        Field::SelectHierarchical => "/select/hierarchical",
        Field::SelectCriterion => "/select/criterion",
        Field::Folds => "/folds",
        Field::FoldsBy => "/folds/by",
        Field::FoldsCount => "/folds/count",
        Field::FoldsLine => "/folds/line",
        Field::Constraints => "/constraints",
        Field::Constraint(index) => return format!("/constraints/{index}"),
        Field::ConstraintAlong(index) => return format!("/constraints/{index}/along"),
        Field::ConstraintRange(index, axis) => return format!("/constraints/{index}/domain/{}", name_of_axis(axis)),
        Field::Include => "/include",
        Field::Filters => "/filters",
        Field::Filter(index) => return format!("/filters/{index}"),
        Field::FilterType(index) => return format!("/filters/{index}/type"),
        Field::FilterAxis(index) => return format!("/filters/{index}/axis"),
        Field::FilterWindow(index) => return format!("/filters/{index}/window"),
        Field::FilterCutoff(index) => return format!("/filters/{index}/cutoff"),
        Field::Exclude => "/exclude",
        Field::Excluded(entry) => return format!("/exclude/{entry}"),
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

    fn detail(&self, reason: &Reason) -> String {
        sentence(reason)
    }
}

/// A curve near points that was refused.
pub fn refused_curve(error: CurveRefused) -> Problem {
    match error {
        Refused::Invalid(faults) => Problem::invalid(faults),
        Refused::Fit(error) => refused_shape(error, "/points"),
    }
}
