//! Curves and a surface under constraints on their shape, compared with non-negative least squares
//! on fine grids.

use crate::folder::{number, numbers, reference};
use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{
        Constraint, ConstraintKind, Degree, Domain, FilterAxis, Knots, Model, PolynomialBasis, Regularization, Terms,
    },
};
use serde_json::Value;

fn range(value: &Value) -> Option<[f64; 2]> {
    value.as_array().map(|ends| [number(&ends[0]), number(&ends[1])])
}

fn constraint(value: &Value) -> Constraint {
    Constraint {
        kind: match value["kind"].as_str().unwrap() {
            "increasing" => ConstraintKind::Increasing,
            "decreasing" => ConstraintKind::Decreasing,
            "convex" => ConstraintKind::Convex,
            "concave" => ConstraintKind::Concave,
            other => panic!("{other}"),
        },
        along: value["along"].as_str().map(|name| if name == "u" { FilterAxis::U } else { FilterAxis::V }),
        domain: range(&value["domain"]).map(|u| Domain { u: Some(u), v: None }),
    }
}

fn model(value: &Value) -> Model {
    let degree = match &value["degree"] {
        Value::Array(each) => Degree::Each(each[0].as_u64().unwrap() as usize, each[1].as_u64().unwrap() as usize),
        one => Degree::Both(one.as_u64().unwrap() as usize),
    };
    match value["type"].as_str().unwrap() {
        "chebyshev" => Model::Polynomial { degree, basis: PolynomialBasis::Chebyshev, terms: Terms::Tensor },
        _ => Model::BSpline { degree, knots: Knots::Curve(numbers(&value["knots"])), weights: None },
    }
}

#[test]
fn monotone_and_convex_least_squares() {
    let file = reference("constrained");
    let cases = file["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 5);
    for case in cases {
        let (name, nodes) = (case["name"].as_str().unwrap(), &case["nodes"]);
        let nodes = match nodes.get("x") {
            Some(x) => Nodes::curve(numbers(x), numbers(&nodes["y"]), None),
            None => Nodes::grid(numbers(&nodes["u"]), numbers(&nodes["v"]), numbers(&nodes["z"]), None, None),
        };
        let spec = FitSpec {
            domain: Some(Domain { u: range(&case["domain"]["u"]), v: range(&case["domain"]["v"]) }),
            constraints: case["constraints"].as_array().unwrap().iter().map(constraint).collect(),
            regularization: Regularization::None,
            ..FitSpec::new(model(&case["model"]))
        };
        let found = fit(&nodes.unwrap(), &spec).unwrap();
        let report = found.constraints.unwrap();
        let rss = number(&case["rss"]);
        assert!((report.rss / rss - 1.0).abs() < 2e-7, "{name}: {} {rss}", report.rss);
        assert!(report.rss - report.rss_bound < 1e-6 * rss && report.rss_bound <= report.rss, "{name}");
        assert!(report.holds_back(), "{name}");
        let expected = numbers(&case["coefficients"]);
        for (found, expected) in found.coefficients.iter().zip(&expected) {
            // the reference knows places on a grid only
            assert!((found.value - expected).abs() < 2e-5, "{name} {}: {} {expected}", found.term, found.value);
            assert!((found.value - found.least_squares).abs() > 1e-9, "{name} {}", found.term);
        }
    }
}
