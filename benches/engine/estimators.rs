//! Robust estimators: `cargo xtask bench estimators`. One call of `fit` on a flank grid of degree
//! (3,3) on which every tenth node is a gross peak; `least_squares` is there to compare with.

use divan::Bencher;
use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{
        Contamination, Degree, Distribution, Estimator, LEstimator, Loss, MEstimator, Model, PolynomialBasis, Start,
        Terms,
    },
};

/// 45, 1,000 and 10,000 nodes.
const SHAPES: [(usize, usize); 3] = [(5, 9), (25, 40), (100, 100)];

fn nodes((nu, nv): (usize, usize)) -> Nodes {
    let axis = |from: f64, to: f64, n: usize| -> Vec<f64> {
        (0..n).map(|i| from + (to - from) * i as f64 / (n - 1) as f64).collect()
    };
    let (u, v) = (axis(5.97, 11.52, nu), axis(0.75, 14.25, nv));
    let z = (0..nu * nv)
        .map(|k| {
            let (u, v) = (u[k / nv], v[k % nv]);
            let (s, t) = ((u - 8.745) / 2.775, (v - 7.5) / 6.75);
            let peak = if k % 10 == 3 { 25.0 } else { 0.0 };
            4.5 * s - 3.0 * s * s - 4.0 * t * t + 0.75 * s * t + 0.3 * (37.0 * u + 19.0 * v).sin() + peak
        })
        .collect();
    Nodes::grid(u, v, z, None, None).expect("a full grid is valid")
}

fn run(bencher: Bencher, shape: (usize, usize), estimator: Estimator) {
    let nodes = nodes(shape);
    let model = Model::Polynomial { degree: Degree::Both(3), basis: PolynomialBasis::Chebyshev, terms: Terms::Tensor };
    let spec = FitSpec { estimator, ..FitSpec::new(model) };
    bencher.bench_local(|| fit(divan::black_box(&nodes), &spec));
}

/// One benchmark for each estimator.
macro_rules! estimators {
    ($($name:ident = $estimator:expr;)*) => {$(
        #[divan::bench(args = SHAPES.map(Shape), sample_count = 10, sample_size = 1)]
        fn $name(bencher: Bencher, shape: Shape) {
            run(bencher, shape.0, $estimator);
        }
    )*};
}

/// A shape that prints itself.
#[derive(Clone, Copy)]
struct Shape((usize, usize));

impl std::fmt::Display for Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} nodes", self.0.0 * self.0.1)
    }
}

estimators! {
    least_squares = Estimator::LeastSquares;
    huber = Estimator::M(MEstimator::new(Loss::HUBER));
    tukey = Estimator::M(MEstimator::new(Loss::TUKEY));
    tukey_from_trimmed_squares =
        Estimator::M(MEstimator { start: Start::LeastTrimmed, ..MEstimator::new(Loss::TUKEY) });
    least_absolute_deviations = Estimator::LeastAbsolute;
    lp = Estimator::Lp { p: 1.5 };
    quantile = Estimator::Quantile { tau: 0.25 };
    least_trimmed_squares = Estimator::LeastTrimmed { coverage: 0.75, seed: 0 };
    rank = Estimator::Rank;
    normal_scores = Estimator::NormalScores;
    huber_contamination_estimated = Estimator::M(MEstimator::minimax(Contamination::Estimated));
    trimmed = Estimator::L(LEstimator::Trimmed { share: 0.1 });
    winsorized = Estimator::L(LEstimator::Winsorized { share: 0.1 });
    student = Estimator::Likelihood(Distribution::Student { freedom: Some(4.0) });
    student_estimated = Estimator::Likelihood(Distribution::Student { freedom: None });
    generalized_normal_estimated = Estimator::Likelihood(Distribution::GeneralizedNormal { exponent: None });
}
