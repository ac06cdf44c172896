//! Regularisations that a model excludes: a stream refuses them before any node, by the pointer of
//! the batch fit.

use crate::oracle::random::Random;
use crate::problems::polynomial;
use flankfit_engine::estimation::spec::{
    Attraction, Constraint, ConstraintKind, Count, Criterion, Degree, Domain, FitSpec, JamesStein, Knots, Model,
    Parameter, PolynomialBasis, Regularization, Scaling, Scheme, ShrinkageFactor, Terms, Tikhonov,
};
use flankfit_engine::estimation::spec::{Filter, Gaussian};
use flankfit_engine::estimation::{FitError, Nodes, Recursive, fit};

const BY: Parameter = Parameter::Criterion(Criterion::Gcv);

fn models() -> Vec<FitSpec> {
    let surface = Some(Domain { u: Some([0.0, 1.0]), v: Some([0.0, 1.0]) });
    let curve = Some(Domain { u: Some([0.0, 1.0]), v: None });
    let chebyshev = |degree| polynomial(degree, PolynomialBasis::Chebyshev);
    let total = Model::Polynomial { degree: Degree::Both(2), basis: PolynomialBasis::Legendre, terms: Terms::Total };
    let spline = |degree, spans, weights| {
        FitSpec::new(Model::BSpline { degree: Degree::Both(degree), knots: Knots::Spans(spans), weights })
    };
    vec![
        // n = 4, 3, 1, 2, 2 on a curve
        FitSpec { domain: curve, ..chebyshev(Degree::Both(3)) },
        FitSpec { domain: curve, ..chebyshev(Degree::Both(2)) },
        FitSpec { domain: curve, ..chebyshev(Degree::Both(0)) },
        FitSpec { domain: curve, ..spline(1, 1, None) },
        FitSpec { domain: curve, ..spline(1, 1, Some(vec![1.0, 2.0])) },
        // n = 4, 6, 9, 2, 16, 4 on a surface
        FitSpec { domain: surface, ..polynomial(Degree::Both(1), PolynomialBasis::Monomial) },
        FitSpec { domain: surface, ..FitSpec::new(total) },
        polynomial(Degree::Each(2, 2), PolynomialBasis::Monomial),
        FitSpec { domain: surface, ..chebyshev(Degree::Each(0, 1)) },
        FitSpec { domain: surface, ..spline(2, 2, None) },
        // W depends on v alone
        FitSpec { domain: surface, ..spline(1, 1, Some(vec![1.0, 2.0, 1.0, 2.0])) },
    ]
}

fn regularizations() -> Vec<Regularization> {
    let mut all = vec![Regularization::None, Regularization::default()];
    for rank in [0, 1, 3, 4, 5, 10] {
        all.push(Regularization::TruncatedSvd { rank });
        all.push(Regularization::Spectral {
            scheme: Scheme::Exact,
            count: Count::Given(rank),
            condition_limit: 900.0,
            lambda_star: BY,
        });
    }
    for criterion in [Criterion::Gcv, Criterion::MinCondition] {
        all.push(Regularization::Ridge { parameter: Parameter::Criterion(criterion) });
    }
    for length in [1, 3, 4, 6, 9] {
        let target = vec![0.5; length];
        all.push(Regularization::Attraction(Attraction { target: target.clone(), parameter: BY }));
        for factor in [ShrinkageFactor::JamesStein, ShrinkageFactor::EfronMorris] {
            let target = Some(target.clone());
            all.push(Regularization::JamesStein(JamesStein { factor, positive_part: true, target }));
        }
    }
    for factor in [ShrinkageFactor::HoerlKennard, ShrinkageFactor::EfronMorris] {
        all.push(Regularization::JamesStein(JamesStein { factor, positive_part: false, target: None }));
    }
    for order in 0..=4 {
        for weights in [None, Some(vec![2.0]), Some(vec![1.0, 0.5]), Some(vec![0.0, 1.0]), Some(vec![-1.0])] {
            all.push(Regularization::Tikhonov(Tikhonov { order, weights, parameter: BY }));
        }
    }
    all
}

fn path(error: &FitError) -> &str {
    match error {
        FitError::Invalid(faults) => &faults.list()[0].path,
        other => panic!("{other:?}"),
    }
}

fn places(seed: u64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut random = Random::new(seed);
    let mut draw = |_| random.between(0.0, 1.0);
    let (u, v): (Vec<f64>, Vec<f64>) = ((0..40).map(&mut draw).collect(), (0..40).map(&mut draw).collect());
    let z = (0..40).map(|i| 1.0 + u[i] - 0.3 * v[i] + 0.01 * draw(i)).collect();
    (u, v, z)
}

#[test]
fn streams_refuse_at_opening_what_their_fit_would_refuse() {
    let (u, v, z) = places(5);
    let nodes = [Nodes::curve(u.clone(), z.clone(), None).unwrap(), Nodes::scattered(u, v, z, None).unwrap()];
    let (mut refused, mut opened) = (0, 0);
    for (i, model) in models().into_iter().enumerate() {
        let nodes = &nodes[usize::from(i >= 5)];
        for regularization in regularizations() {
            for scaling in [Scaling::UnitLength, Scaling::Standardized] {
                let spec = FitSpec { regularization: regularization.clone(), scaling, ..model.clone() };
                match (fit(nodes, &spec), Recursive::new(&spec, 1.0)) {
                    (Ok(_), Ok(mut stream)) => {
                        stream.push(nodes).unwrap();
                        assert!(stream.result().unwrap().is_some(), "{spec:?}");
                        opened += 1;
                    }
                    (Err(batch), Err(stream)) => {
                        assert_eq!(path(&batch), stream.list()[0].path, "{spec:?}");
                        refused += 1;
                    }
                    (batch, stream) => panic!("{batch:?} {:?} {spec:?}", stream.err()),
                }
            }
        }
    }
    assert!(refused > 300 && opened > 100, "{refused} {opened}");
}

/// The first block of a measurement matrix determines n, that of raw powers without a domain the
/// number of axes.
#[test]
fn where_the_first_block_decides_it_is_refused_and_changes_nothing() {
    let (u, v, z) = places(6);
    let wide = |columns: usize| {
        let row = |i: usize| (0..columns).map(move |j| 1.0 / (1 + i + j * j) as f64);
        Nodes::matrix((0..40).flat_map(row).collect(), columns, z.clone(), None, None).unwrap()
    };
    let (curve, surface) = (
        Nodes::curve(u.clone(), z.clone(), None).unwrap(),
        Nodes::scattered(u.clone(), v.clone(), z.clone(), None).unwrap(),
    );
    let of = |model: &FitSpec, regularization| FitSpec { regularization, ..model.clone() };
    let linear = FitSpec::new(Model::Linear);
    let raw = polynomial(Degree::Both(3), PolynomialBasis::Monomial);
    let tikhonov = |order, weights| Regularization::Tikhonov(Tikhonov { order, weights, parameter: BY });
    let attraction = |n| Regularization::Attraction(Attraction { target: vec![0.0; n], parameter: BY });
    let cases = [
        (of(&linear, Regularization::TruncatedSvd { rank: 3 }), wide(2), "nodes.x", wide(3)),
        (of(&linear, attraction(3)), wide(4), "nodes.x", wide(3)),
        (of(&linear, tikhonov(2, None)), wide(2), "nodes.x", wide(3)),
        (of(&raw, Regularization::TruncatedSvd { rank: 5 }), curve.clone(), "nodes.type", surface.clone()),
        (of(&raw, attraction(4)), surface.clone(), "nodes.type", curve.clone()),
        (of(&raw, tikhonov(1, Some(vec![1.0, 2.0]))), curve.clone(), "nodes.type", surface.clone()),
        (of(&raw, tikhonov(1, Some(vec![1.0]))), surface.clone(), "nodes.type", curve.clone()),
    ];
    for (spec, wrong, place, right) in cases {
        let batch = fit(&wrong, &spec).unwrap_err();
        let batch = path(&batch).replace(['.', '['], "/").replace(']', "");
        let mut stream = Recursive::new(&spec, 1.0).unwrap();
        let faults = stream.push(&wrong).expect_err(&format!("{spec:?}"));
        assert_eq!(faults.list()[0].path, place, "{spec:?}");
        let message = &faults.list()[0].message;
        assert!(message.starts_with(&format!("the stream's /{batch} does not fit these nodes: ")), "{message}");
        assert_eq!((stream.count(), stream.size(), stream.state()), (0, None, None));
        stream.push(&right).unwrap();
        assert!(stream.result().unwrap().is_some());
    }
    // as a curve or as a surface: one place, and what is wrong with either
    for regularization in [Regularization::TruncatedSvd { rank: 17 }, attraction(5), tikhonov(1, Some(vec![1.0; 3]))] {
        let faults = Recursive::new(&of(&raw, regularization.clone()), 1.0).err().unwrap();
        let paths: Vec<&str> = faults.list().iter().map(|fault| &*fault.path).collect();
        let expected = match regularization {
            Regularization::TruncatedSvd { .. } => "regularization.rank",
            Regularization::Attraction(_) => "regularization.target",
            _ => "regularization.weights",
        };
        assert_eq!(paths, [expected; 2]);
        assert!(faults.list()[1].message.starts_with("for a surface: "), "{}", faults.list()[1].message);
    }
}

#[test]
fn constraints_are_for_all_nodes_together() {
    let rising = Constraint { kind: ConstraintKind::Increasing, along: None, domain: None };
    let spec = FitSpec {
        constraints: vec![rising],
        regularization: Regularization::None,
        ..polynomial(Degree::Each(1, 1), PolynomialBasis::Monomial)
    };
    assert_eq!(Recursive::new(&spec, 1.0).err().unwrap().list()[0].path, "constraints");
}

#[test]
fn filters_are_for_whole_profiles() {
    let spec = FitSpec {
        filters: vec![Filter::Gaussian(Gaussian { axis: None, cutoff: 1.0, robust: None })],
        ..polynomial(Degree::Each(1, 1), PolynomialBasis::Monomial)
    };
    assert_eq!(Recursive::new(&spec, 1.0).err().unwrap().list()[0].path, "filters");
}
