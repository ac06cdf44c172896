//! Nodes in blocks: however they are split, the estimate is that of all of them at once.

use crate::oracle::random::Random;
use crate::problems::{config, polynomial};
use flankfit_engine::estimation::spec::{
    Criterion, Degree, Domain, FitSpec, Knots, Model, NodeUncertainty, Parameter, PolynomialBasis, Regularization,
    Scaling,
};
use flankfit_engine::estimation::{FitResult, Nodes, Recursive, data, fit};
use proptest::prelude::*;

/// Relative, against the largest of the numbers compared.
fn close(what: &str, one: &[f64], two: &[f64], slack: f64) {
    assert_eq!(one.len(), two.len(), "{what}");
    let size = one.iter().chain(two).fold(0.0f64, |s, x| s.max(x.abs()));
    for (a, b) in one.iter().zip(two) {
        assert!((a - b).abs() <= slack * size, "{what}: {a} and {b}\n{one:?}\n{two:?}");
    }
}

/// Everything that does not need the nodes.
fn same(batch: &FitResult, stream: &FitResult, slack: f64) {
    let of = |r: &FitResult, f: &dyn Fn(&flankfit_engine::estimation::result::Coefficient) -> f64| {
        r.coefficients.iter().map(f).collect::<Vec<f64>>()
    };
    close("least squares", &of(batch, &|c| c.least_squares), &of(stream, &|c| c.least_squares), slack);
    close("values", &of(batch, &|c| c.value), &of(stream, &|c| c.value), slack);
    let error = |c: &flankfit_engine::estimation::result::Coefficient| c.error_given_lambda().unwrap_or(0.0);
    close("standard errors", &of(batch, &error), &of(stream, &error), slack);
    close("bounds", &of(batch, &|c| c.bias_bound), &of(stream, &|c| c.bias_bound), slack.max(1e-9));
    for (a, b) in batch.spectrum.eigenvalues.iter().zip(&stream.spectrum.eigenvalues) {
        close("eigenvalue", &[*a], &[*b], slack);
    }
    assert_eq!(batch.spectrum.rank, stream.spectrum.rank);
    let (a, b) = (&batch.regularization, &stream.regularization);
    assert_eq!((a.count, a.criterion, a.lambda_star.is_some()), (b.count, b.criterion, b.lambda_star.is_some()));
    if let (Some(a), Some(b)) = (a.lambda_star, b.lambda_star) {
        close("λ*", &[a], &[b], slack.max(1e-6));
    }
    let (a, b) = (&batch.residuals, &stream.residuals);
    assert_eq!((a.count, a.degrees_of_freedom), (b.count, b.degrees_of_freedom));
    close("rss", &[a.least_squares_rss, a.rss], &[b.least_squares_rss, b.rss], slack);
    close("r²", &[a.r_squared.unwrap()], &[b.r_squared.unwrap()], slack);
    assert_eq!(b.max_abs, None);
    assert!(a.max_abs.is_some());
    let vifs = |r: &FitResult| r.collinearity.columns.iter().filter_map(|c| c.vif).collect::<Vec<f64>>();
    close("vif", &vifs(batch), &vifs(stream), slack);
    let moved = |r: &FitResult| r.perturbation.as_ref().and_then(|p| p.least_squares.first_order_bound);
    if let (Some(a), Some(b)) = (moved(batch), moved(stream)) {
        close("perturbation", &[a], &[b], slack);
    }
    assert_eq!(batch.domain, stream.domain);
    assert!(stream.numerics.correct_digits <= batch.numerics.correct_digits + 2.0);
}

/// Nodes of a wavy surface, some of weight 0, at places that wander from a corner so that boxes
/// must grow.
struct Track {
    u: Vec<f64>,
    v: Vec<f64>,
    z: Vec<f64>,
    w: Vec<f64>,
}

impl Track {
    fn new(seed: u64, count: usize) -> Self {
        let mut random = Random::new(seed);
        let mut track = Track { u: Vec::new(), v: Vec::new(), z: Vec::new(), w: Vec::new() };
        for i in 0..count {
            let reach = (i + 1) as f64 / count as f64;
            let (u, v) = (30.0 + 4.0 * reach * random.between(0.0, 1.0), 20.0 * reach * random.between(0.0, 1.0));
            track.u.push(u);
            track.v.push(v);
            track.z.push(0.3 + 0.01 * u - 0.02 * v + 1e-3 * (u * v).sin() + 1e-4 * random.between(0.0, 1.0));
            track.w.push(if i % 7 == 3 { 0.0 } else { 0.5 + random.between(0.0, 1.0) });
        }
        track
    }

    fn block(&self, range: std::ops::Range<usize>, weighted: bool) -> Nodes {
        let part = |x: &[f64]| x[range.clone()].to_vec();
        Nodes::scattered(part(&self.u), part(&self.v), part(&self.z), weighted.then(|| part(&self.w))).unwrap()
    }

    /// All nodes, weights fading by `forgetting` for every counted node after.
    fn faded(&self, forgetting: f64) -> Nodes {
        let mut w = self.w.clone();
        let mut after = 0;
        for w in w.iter_mut().rev() {
            if *w > 0.0 {
                *w *= forgetting.powi(after);
                after += 1;
            }
        }
        Nodes::scattered(self.u.clone(), self.v.clone(), self.z.clone(), Some(w)).unwrap()
    }
}

fn pieces(count: usize, cuts: &[usize]) -> Vec<std::ops::Range<usize>> {
    let mut ends: Vec<usize> = cuts.iter().map(|c| c % count).chain([0, count]).collect();
    ends.sort_unstable();
    ends.dedup();
    ends.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

fn specs() -> Vec<FitSpec> {
    let domain = Some(Domain { u: Some([30.0, 34.5]), v: Some([0.0, 20.5]) });
    let uncertain = Some(NodeUncertainty { position: 1e-6, height: 0.0, kind: None });
    let plain = |basis| FitSpec {
        regularization: Regularization::None,
        node_uncertainty: uncertain,
        ..polynomial(Degree::Both(2), basis)
    };
    vec![
        plain(PolynomialBasis::Monomial),
        FitSpec { domain, ..plain(PolynomialBasis::Chebyshev) },
        FitSpec { domain, ..polynomial(Degree::Each(2, 1), PolynomialBasis::Legendre) },
        FitSpec {
            scaling: Scaling::Standardized,
            regularization: Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Gcv) },
            ..polynomial(Degree::Both(1), PolynomialBasis::Monomial)
        },
        FitSpec {
            domain,
            regularization: Regularization::None,
            ..FitSpec::new(Model::BSpline { degree: Degree::Both(2), knots: Knots::Spans(2), weights: None })
        },
    ]
}

/// `None` where the nodes do not determine the model.
fn streamed(spec: &FitSpec, blocks: &[Nodes], forgetting: f64) -> Option<FitResult> {
    let mut estimate = Recursive::new(spec, forgetting).unwrap();
    for block in blocks {
        estimate.push(block).unwrap();
    }
    estimate.result().ok().flatten()
}

proptest! {
    #![proptest_config(config(12))]

    #[test]
    fn any_split_equals_the_batch(seed: u64, cuts in prop::collection::vec(0usize..80, 0..12), weighted: bool) {
        let track = Track::new(seed, 80);
        let blocks: Vec<Nodes> = pieces(80, &cuts)
            .into_iter()
            .map(|range| track.block(range, weighted))
            // a block of nothing but weight 0 is refused, as by a fit
            .filter(|block| Recursive::new(&specs()[0], 1.0).unwrap().push(block).is_ok())
            .collect();
        let whole = data::join(blocks.clone()).unwrap();
        for spec in specs() {
            let batch = fit(&whole, &spec).unwrap();
            same(&batch, &streamed(&spec, &blocks, 1.0).unwrap(), 1e-10);
        }
    }

    #[test]
    fn forgetting_is_weighting(seed: u64, cuts in prop::collection::vec(0usize..80, 0..12), forgetting in 0.8f64..1.0) {
        let track = Track::new(seed, 80);
        let blocks: Vec<Nodes> = pieces(80, &cuts).into_iter().map(|range| track.block(range, true)).collect();
        prop_assume!(blocks.iter().all(|b| Recursive::new(&specs()[0], 1.0).unwrap().push(b).is_ok()));
        let m = track.w.iter().filter(|w| **w > 0.0).count() as i32;
        let sum = |ratio: f64| (0..m).map(|k| ratio.powi(k)).sum::<f64>();
        let effective = (sum(forgetting).powi(2) / sum(forgetting * forgetting)).round();
        for spec in specs().iter().filter(|spec| spec.regularization == Regularization::None) {
            let batch = fit(&track.faded(forgetting), spec).unwrap();
            let stream = streamed(spec, &blocks, forgetting).unwrap();
            // weights round once in the batch, and the model's condition amplifies that
            let of = |r: &FitResult| r.coefficients.iter().map(|c| c.value).collect::<Vec<f64>>();
            close("values", &of(&batch), &of(&stream), 1e-7);
            // all nodes are equally good: RSS is divided by their effective number
            let (every, freedom) = (batch.residuals.degrees_of_freedom, stream.residuals.degrees_of_freedom);
            prop_assert_eq!(stream.residuals.count, m as usize);
            let count = effective.max(batch.coefficients.len() as f64);
            prop_assert_eq!(freedom as f64, count - stream.spectrum.rank as f64);
            let wider = (every as f64 / freedom as f64).sqrt();
            for (a, b) in batch.coefficients.iter().zip(&stream.coefficients).filter(|_| freedom > 0) {
                let (a, b) = (wider * a.std_error.unwrap(), b.std_error.unwrap());
                prop_assert!((a - b).abs() <= 1e-6 * a, "{} {}", a, b);
            }
        }
    }

    #[test]
    fn a_restored_estimate_goes_on_to_the_last_bit(seed: u64, cut in 1usize..79) {
        let track = Track::new(seed, 80);
        let (first, second) = (track.block(0..cut, true), track.block(cut..80, true));
        for spec in specs() {
            let mut whole = Recursive::new(&spec, 0.97).unwrap();
            prop_assume!(whole.push(&first).is_ok());
            let mut again = Recursive::restore(&spec, 0.97, &whole.state().unwrap()).unwrap();
            if whole.push(&second).is_ok() {
                again.push(&second).unwrap();
                prop_assert_eq!(whole.state(), again.state());
                prop_assert_eq!(whole.result(), again.result());
            }
        }
    }
}

#[test]
fn columns_of_a_matrix_and_their_constant() {
    let mut random = Random::new(3);
    let rows: Vec<[f64; 3]> =
        (0..40).map(|_| [1.0, random.between(0.0, 1.0), 1e3 * random.between(0.0, 1.0)]).collect();
    let y: Vec<f64> = rows.iter().map(|r| 2.0 + r[1] - 0.5 * r[2] + 0.01 * random.between(0.0, 1.0)).collect();
    let names = Some(vec!["one".to_owned(), "a".to_owned(), "b".to_owned()]);
    let spec = FitSpec { scaling: Scaling::Standardized, ..FitSpec::new(Model::Linear) };
    let whole = Nodes::matrix(rows.concat(), 3, y.clone(), names.clone(), None).unwrap();
    let blocks: Vec<Nodes> = rows
        .iter()
        .zip(&y)
        .enumerate()
        .map(|(i, (row, y))| Nodes::matrix(row.to_vec(), 3, vec![*y], names.clone().filter(|_| i == 0), None).unwrap())
        .collect();
    same(&fit(&whole, &spec).unwrap(), &streamed(&spec, &blocks, 1.0).unwrap(), 1e-11);
}

#[test]
fn unsupported_streams_are_refused_with_their_path() {
    let refused =
        |spec: &FitSpec, forgetting: f64| Recursive::new(spec, forgetting).err().map(|f| f.list()[0].path.clone());
    let monomial = polynomial(Degree::Both(2), PolynomialBasis::Monomial);
    assert_eq!(refused(&monomial, 1.0), None);
    for forgetting in [0.0, -1.0, 1.5, f64::NAN] {
        assert_eq!(refused(&monomial, forgetting).as_deref(), Some("forgetting_factor"));
    }
    let chebyshev = polynomial(Degree::Both(2), PolynomialBasis::Chebyshev);
    assert_eq!(refused(&chebyshev, 1.0).as_deref(), Some("domain"));
    let domain = |v: Option<[f64; 2]>| Some(Domain { u: Some([0.0, 1.0]), v });
    assert_eq!(refused(&FitSpec { domain: domain(None), ..chebyshev.clone() }, 1.0), None);
    let each = polynomial(Degree::Each(2, 1), PolynomialBasis::Chebyshev);
    assert_eq!(refused(&FitSpec { domain: domain(None), ..each }, 1.0).as_deref(), Some("domain.v"));
    let upside_down = FitSpec { domain: Some(Domain { u: Some([1.0, 0.0]), v: None }), ..chebyshev.clone() };
    assert_eq!(refused(&upside_down, 1.0).as_deref(), Some("domain.u"));

    let mut estimate = Recursive::new(&FitSpec { domain: domain(None), ..chebyshev }, 1.0).unwrap();
    let outside = Nodes::curve(vec![0.5, 1.5], vec![0.0, 0.0], None).unwrap();
    assert_eq!(estimate.push(&outside).unwrap_err().list()[0].path, "nodes.x[1]");
    assert_eq!(estimate.count(), 0);
    let surface = Nodes::scattered(vec![0.5], vec![0.5], vec![0.0], None).unwrap();
    assert_eq!(estimate.push(&surface).unwrap_err().list()[0].path, "nodes.type");
    estimate.push(&Nodes::curve(vec![0.5, 0.7], vec![0.0, 1.0], None).unwrap()).unwrap();
    assert_eq!((estimate.count(), estimate.result().unwrap().is_none()), (2, true));
}

/// A flank that does not move, scanned round by round: intervals hold after few and many nodes.
#[test]
fn intervals_hold_while_old_nodes_fade() {
    let model = polynomial(Degree::Both(1), PolynomialBasis::Legendre);
    let spec = FitSpec {
        regularization: Regularization::None,
        domain: Some(Domain { u: Some([0.0, 8.0]), v: None }),
        ..model
    };
    let mut random = Random::new(71);
    for count in [60usize, 400, 2_000] {
        let (mut held, draws) = (0, 300);
        for _ in 0..draws {
            let x: Vec<f64> = (0..count).map(|k| (k % 9) as f64).collect();
            let nodes = Nodes::curve(x, random.normals(count), None).unwrap();
            let found = streamed(&spec, &[nodes], 0.99).unwrap();
            held += found
                .coefficients
                .iter()
                .filter(|c| c.interval.is_some_and(|i| i.ends[0] <= 0.0 && 0.0 <= i.ends[1]))
                .count();
        }
        let coverage = held as f64 / (2 * draws) as f64;
        assert!((0.92..0.975).contains(&coverage), "{count}: {coverage}");
    }
}
