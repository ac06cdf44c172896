//! A model by a criterion: every candidate's figures are those of a fit of its own, and the chosen
//! one is fitted.

use crate::oracle::random::Random;
use crate::problems::{assert_close, by, fit, linear, polynomial, warned};
use flankfit_engine::estimation::{
    FitError, FitResult, Nodes, fit as try_fit,
    result::TermKey,
    spec::{
        Candidates, Criterion, Degree, FitSpec, Folds, FoldsBy, Include, Model, ModelCriterion, Places,
        PolynomialBasis, Predict, Regularization, Select, TermSearch, Terms, Variance,
    },
};
use std::f64::consts::TAU;

fn plain(degree: Degree) -> FitSpec {
    FitSpec {
        regularization: Regularization::None,
        include: Include { influence: true, ..Include::default() },
        ..polynomial(degree, PolynomialBasis::Chebyshev)
    }
}

fn selecting(degrees: Degree, criterion: ModelCriterion) -> FitSpec {
    FitSpec { select: Some(Select::new(Candidates::Degrees(degrees), criterion)), ..plain(Degree::Both(1)) }
}

fn by_terms(search: TermSearch, criterion: ModelCriterion) -> Option<Select> {
    Some(Select::new(Candidates::Terms(search), criterion))
}

/// A surface of degree (2, 1), some nodes missing, with weights.
struct Surface {
    u: Vec<f64>,
    v: Vec<f64>,
    z: Vec<f64>,
    weight: Vec<f64>,
}

impl Surface {
    fn new() -> Self {
        let (u, v): (Vec<f64>, Vec<f64>) = ((0..9).map(f64::from).collect(), (0..7).map(f64::from).collect());
        let mut random = Random::new(3);
        let place = |k: usize| (u[k / 7], v[k % 7]);
        let exact = (0..63).map(place).map(|(u, v)| 1.0 + 0.5 * u - 0.2 * u * u + 0.3 * u * v).collect::<Vec<f64>>();
        let z = exact.into_iter().map(|z| z + 0.3 * random.normal()).collect();
        let mut weight: Vec<f64> = (0..63).map(|_| random.between(0.5, 2.0)).collect();
        weight[11] = 0.0;
        weight[30] = 0.0;
        Surface { u, v, z, weight }
    }

    fn nodes(&self) -> Nodes {
        self.without(|_| false)
    }

    /// Nodes that are left out have no weight.
    fn without(&self, out: impl Fn(usize) -> bool) -> Nodes {
        let weight = self.weight.iter().enumerate().map(|(k, w)| if out(k) { 0.0 } else { *w }).collect();
        Nodes::grid(self.u.clone(), self.v.clone(), self.z.clone(), None, Some(weight)).unwrap()
    }

    /// `Σ w r²` of the nodes of each block, foretold by a fit without them.
    fn left_out(&self, spec: &FitSpec, blocks: usize, block: impl Fn(usize) -> usize) -> f64 {
        let u = (0..63).map(|k| self.u[k / 7]).collect();
        let v = (0..63).map(|k| self.v[k % 7]).collect();
        // polynomials live on the whole domain, whatever is left out of it
        let whole = |ends: [f64; 2]| Some(ends);
        let domain = flankfit_engine::estimation::spec::Domain { u: whole([0.0, 8.0]), v: whole([0.0, 6.0]) };
        let predict =
            Some(Predict { at: Places::Points { u, v }, level: None, kinds: Default::default(), slopes: false });
        let spec = FitSpec { predict, domain: Some(domain), include: Include::default(), ..spec.clone() };
        (0..blocks)
            .map(|left| {
                let value = fit(&self.without(|k| block(k) == left), &spec).predictions.unwrap().value;
                let out = (0..63).filter(|&k| block(k) == left);
                out.map(|k| self.weight[k] * (self.z[k] - value[k]).powi(2)).sum::<f64>()
            })
            .sum()
    }
}

#[test]
fn figures_are_those_of_the_fits() {
    let surface = Surface::new();
    let nodes = surface.nodes();
    let weight: Vec<f64> = surface.weight.iter().copied().filter(|w| *w > 0.0).collect();
    for criterion in ModelCriterion::ALL {
        let folds = Some(Folds { by: FoldsBy::Columns, count: Some(4) });
        let result = fit(&nodes, &FitSpec { folds, ..selecting(Degree::Each(3, 2), criterion) });
        let selection = result.selection.as_ref().unwrap();
        assert!(warned(&result, "post_selection"));
        assert_eq!((selection.criterion, selection.candidates.len()), (criterion, 12));
        let (m, logarithms) = (weight.len() as f64, weight.iter().map(|w| w.ln()).sum::<f64>());
        for candidate in &selection.candidates {
            let spec = plain(candidate.degree.unwrap());
            let blocked = surface.left_out(&spec, 4, |k| (k % 7) * 4 / 7);
            let own = fit(&nodes, &spec);
            let (n, rss) = (own.coefficients.len(), own.residuals.rss);
            assert_eq!(candidate.coefficients, n);
            assert_close("rss", candidate.rss, rss, 1e-10, 0.0);
            assert_close("σ̂", candidate.sigma.unwrap(), own.residuals.sigma.unwrap(), 1e-10, 0.0);
            assert_close("press", candidate.press.unwrap(), own.influence.unwrap().press.unwrap(), 1e-9, 0.0);
            assert_close("blocked_cv", candidate.blocked_cv.unwrap(), blocked, 1e-9, 0.0);
            // Σ ln of the normal densities at the variance rss/m over the weights
            let likelihood = 0.5 * logarithms - 0.5 * m * ((TAU * rss / m).ln() + 1.0);
            let k = n as f64 + 1.0;
            assert_close("aic", candidate.aic.unwrap(), 2.0 * k - 2.0 * likelihood, 1e-10, 0.0);
            let more = 2.0 * k * (k + 1.0) / (m - k - 1.0);
            assert_close("aicc", candidate.aicc.unwrap(), candidate.aic.unwrap() + more, 1e-12, 0.0);
            assert_close("bic", candidate.bic.unwrap(), k * m.ln() - 2.0 * likelihood, 1e-10, 0.0);
        }
        let chosen = &selection.candidates[selection.chosen];
        for other in &selection.candidates {
            assert!(chosen.figure(criterion).unwrap() <= other.figure(criterion).unwrap());
        }
        assert_eq!(chosen.degree, Some(Degree::Each(2, 1)), "{criterion:?}");
        // bit by bit the fit of that degree
        let own = fit(&nodes, &plain(chosen.degree.unwrap()));
        let numbers = |found: &FitResult| {
            found.coefficients.iter().map(|c| (c.value, c.std_error, c.interval.map(|i| i.ends))).collect::<Vec<_>>()
        };
        assert_eq!((numbers(&result), &result.influence), (numbers(&own), &own.influence));
    }
}

/// statsmodels 0.15: OLS(y, vander(x, d + 1)).fit(), y = 1 − x + x²/2 + sin(7x²)/10 at x = 0, 1/4,
/// … 3; bic of RegressionResults counts no σ²: ln 13 is added, and 2 to aic.
#[test]
fn information_criteria_agree_with_statsmodels() {
    let x: Vec<f64> = (0..13).map(|k| 0.25 * f64::from(k)).collect();
    let y = x.iter().map(|x| 1.0 - x + 0.5 * x * x + 0.1 * (7.0 * x * x).sin()).collect();
    let nodes = Nodes::curve(x, y, None).unwrap();
    let selection = fit(&nodes, &selecting(Degree::Both(3), ModelCriterion::Bic)).selection.unwrap();
    for (candidate, (aic, bic)) in selection.candidates.iter().zip(STATSMODELS) {
        assert_close("aic", candidate.aic.unwrap(), aic + 2.0, 1e-10, 0.0);
        assert_close("bic", candidate.bic.unwrap(), bic + 13f64.ln(), 1e-10, 0.0);
    }
}

const STATSMODELS: [(f64, f64); 4] = [
    (26.172602822311, 26.737552179773),
    (17.319389706046, 18.449288420969),
    (-32.200850161137, -30.506002088752),
    (-30.418198839202, -28.158401409356),
];

#[test]
fn terms_of_a_total_degree() {
    let nodes = Surface::new().nodes();
    let model = |degree| Model::Polynomial { degree, basis: PolynomialBasis::Monomial, terms: Terms::Total };
    let select = Some(Select::new(Candidates::Degrees(Degree::Both(4)), ModelCriterion::Aicc));
    let result = fit(&nodes, &FitSpec { select, ..FitSpec::new(model(Degree::Both(0))) });
    let selection = result.selection.unwrap();
    let sizes: Vec<usize> = selection.candidates.iter().map(|candidate| candidate.coefficients).collect();
    assert_eq!(sizes, [1, 3, 6, 10, 15]);
    assert_eq!(result.coefficients.len(), sizes[selection.chosen]);
}

fn powers(result: &FitResult) -> Vec<[usize; 2]> {
    let of = |key: &TermKey| match key {
        TermKey::Powers(powers) => [powers[0], powers[1]],
        other => panic!("{other:?}"),
    };
    result.coefficients.iter().map(|c| of(&c.key)).collect()
}

/// The terms 1, u, u², v and uv make the surface. In every basis the same functions are candidates,
/// each set of terms is that of a fit of its own, and the true one is found.
#[test]
fn terms_are_found_in_every_basis() {
    let surface = Surface::new();
    let nodes = surface.nodes();
    for search in [TermSearch::Backward, TermSearch::ElasticNet { alpha: 0.8 }] {
        let mut first: Option<Vec<f64>> = None;
        for basis in [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre] {
            let degree = Degree::Each(3, 2);
            let of =
                |terms: Terms| FitSpec { model: Model::Polynomial { degree, basis, terms }, ..plain(Degree::Both(1)) };
            let spec = FitSpec { select: by_terms(search, ModelCriterion::Bic), ..of(Terms::Tensor) };
            let result = fit(&nodes, &spec);
            let found = powers(&result);
            assert_eq!(found, [[0, 0], [0, 1], [1, 0], [1, 1], [2, 0]], "{search:?}");
            let selection = result.selection.as_ref().unwrap();
            assert_eq!(selection.candidates[selection.chosen].coefficients, 5);
            // terms that are listed, in whatever order
            let listed = Terms::Listed(found.iter().rev().copied().collect());
            let own = fit(&nodes, &of(listed));
            assert_eq!((powers(&own), &own.influence.is_some()), (found, &true));
            for (a, b) in own.coefficients.iter().zip(&result.coefficients) {
                assert_close(&a.term, a.value, b.value, 1e-9, 1e-12);
            }
            let chosen = &selection.candidates[selection.chosen];
            assert_close("rss", chosen.rss, own.residuals.rss, 1e-10, 0.0);
            let rss: Vec<f64> = selection.candidates.iter().map(|candidate| candidate.rss).collect();
            match &first {
                None => first = Some(rss),
                Some(first) => {
                    assert_eq!(first.len(), rss.len());
                    first.iter().zip(&rss).for_each(|(a, b)| assert_close("rss", *a, *b, 1e-10, 0.0));
                }
            }
        }
    }
}

/// Backward elimination of a surface, compared with dense least squares of every set of terms that
/// it can go to.
#[test]
fn every_step_loses_least() {
    let surface = Surface::new();
    let spec = FitSpec { select: by_terms(TermSearch::Backward, ModelCriterion::Aicc), ..plain(Degree::Each(2, 2)) };
    let selection = fit(&surface.nodes(), &spec).selection.unwrap();
    let rss = |terms: &[[usize; 2]]| {
        let model = Model::Polynomial {
            degree: Degree::Each(2, 2),
            basis: PolynomialBasis::Monomial,
            terms: Terms::Listed(terms.to_vec()),
        };
        let spec = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
        try_fit(&surface.nodes(), &spec).ok().map(|result| result.residuals.rss)
    };
    let mut terms: Vec<[usize; 2]> = (0..3).flat_map(|i| (0..3).map(move |j| [i, j])).collect();
    for pair in selection.candidates.windows(2) {
        // sets without a divisor are refused
        let next = (0..terms.len()).filter_map(|at| {
            let mut fewer = terms.clone();
            fewer.remove(at);
            rss(&fewer).map(|rss| (fewer, rss))
        });
        let (best, least) = next.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert_close("rss", pair[1].rss, least, 1e-9, 0.0);
        terms = best;
    }
    assert_eq!(terms, [[0, 0]]);
}

/// Columns keep their numbers and names, and requested rows are those of all columns.
#[test]
fn columns_of_a_matrix() {
    let mut random = Random::new(8);
    let rows: Vec<Vec<f64>> =
        (0..30).map(|_| std::iter::once(1.0).chain((0..4).map(|_| random.normal())).collect()).collect();
    let y = rows.iter().map(|row| 2.0 + 3.0 * row[2] - row[4] + 0.1 * random.normal()).collect();
    let names = Some(["a", "b", "c", "d", "e"].map(str::to_owned).to_vec());
    let nodes = Nodes::matrix(rows.concat(), 5, y, names, None).unwrap();
    let at = |rows| Some(Predict { at: Places::Rows(rows), level: None, kinds: Default::default(), slopes: false });
    let row = vec![1.0, 7.0, 0.5, -3.0, 2.0];
    let spec =
        FitSpec { select: by_terms(TermSearch::Backward, ModelCriterion::Bic), predict: at(vec![row]), ..linear() };
    let result = fit(&nodes, &spec);
    let found: Vec<(&str, &TermKey)> = result.coefficients.iter().map(|c| (c.term.as_str(), &c.key)).collect();
    assert_eq!(found, [("a", &TermKey::Column(0)), ("c", &TermKey::Column(2)), ("e", &TermKey::Column(4))]);
    let value = result.predictions.as_ref().unwrap().value[0];
    let [a, c, e] = [0, 1, 2].map(|k| result.coefficients[k].value);
    assert_close("value", value, a + 0.5 * c + 2.0 * e, 1e-12, 0.0);
    // as wide as the columns that were chosen, not as those that were posted
    let wrong = FitSpec { predict: at(vec![vec![1.0; 3]]), ..spec };
    assert_eq!(refused(&nodes, wrong), "predict.at.x[0]");
}

fn refused(nodes: &Nodes, spec: FitSpec) -> String {
    match try_fit(nodes, &spec) {
        Err(FitError::Invalid(faults)) => faults.list()[0].path.clone(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn invalid_selections_are_refused() {
    let nodes = Surface::new().nodes();
    let bic = ModelCriterion::Bic;
    assert_eq!(refused(&nodes, selecting(Degree::Each(8, 8), bic)), "select.degrees");
    assert_eq!(refused(&nodes, selecting(Degree::Both(usize::MAX), bic)), "select.degrees");
    let curve = Nodes::curve(vec![0.0, 1.0, 2.0, 3.0], vec![1.0, 0.0, 2.0, 1.0], None).unwrap();
    assert_eq!(refused(&curve, selecting(Degree::Each(1, 1), bic)), "select.degrees");
    let few = Nodes::curve(vec![0.0, 1.0], vec![1.0, 0.0], None).unwrap();
    assert_eq!(refused(&few, selecting(Degree::Both(0), ModelCriterion::Aicc)), "select.criterion");
    let matrix = Nodes::matrix(vec![1.0, 1.0, 2.0], 1, vec![1.0, 2.0, 1.0], None, None).unwrap();
    let of_matrix = FitSpec { model: Model::Linear, ..selecting(Degree::Both(1), bic) };
    assert_eq!(refused(&matrix, of_matrix), "select.degrees");
    let free = Select { hierarchical: false, ..by_terms(TermSearch::Backward, bic).unwrap() };
    assert_eq!(refused(&nodes, FitSpec { select: Some(free), ..plain(Degree::Both(1)) }), "select.hierarchical");
    let unequal = FitSpec { variance: Variance::Hc3, ..selecting(Degree::Both(1), bic) };
    assert_eq!(refused(&nodes, unequal), "variance");
    for alpha in [0.0, 1.5, f64::NAN] {
        let select = by_terms(TermSearch::ElasticNet { alpha }, bic);
        assert_eq!(refused(&nodes, FitSpec { select, ..plain(Degree::Both(1)) }), "select.alpha");
    }
    let folds = |by, count| Some(Folds { by, count });
    let ridge = Regularization::Ridge { parameter: by(Criterion::BlockedCv) };
    let with = |folds| FitSpec { regularization: ridge.clone(), folds, ..plain(Degree::Both(1)) };
    assert_eq!(refused(&nodes, with(folds(FoldsBy::Rows, Some(10)))), "folds.count");
    assert_eq!(refused(&nodes, with(folds(FoldsBy::Lines(vec![1]), None))), "folds.line");
    assert_eq!(refused(&curve, with(folds(FoldsBy::Columns, None))), "folds.by");
    let unused = FitSpec { folds: folds(FoldsBy::Rows, None), ..plain(Degree::Both(1)) };
    assert_eq!(refused(&nodes, unused), "folds");
}

#[test]
fn invalid_term_lists_are_refused() {
    let nodes = Surface::new().nodes();
    let of = |listed: &[[usize; 2]]| {
        let terms = Terms::Listed(listed.to_vec());
        FitSpec::new(Model::Polynomial { degree: Degree::Each(2, 1), basis: PolynomialBasis::Monomial, terms })
    };
    assert_eq!(refused(&nodes, of(&[])), "model.terms");
    assert_eq!(refused(&nodes, of(&[[0, 0], [1, 0], [1, 1]])), "model.terms[2]");
    assert_eq!(refused(&nodes, of(&[[0, 0], [1, 0], [1, 0]])), "model.terms[2]");
    assert_eq!(refused(&nodes, of(&[[0, 0], [0, 1], [0, 2]])), "model.terms[2]");
    let curve = Nodes::curve(vec![0.0, 1.0, 2.0], vec![1.0, 0.0, 2.0], None).unwrap();
    let listed = Terms::Listed(vec![[0, 0]]);
    let model = Model::Polynomial { degree: Degree::Both(1), basis: PolynomialBasis::Monomial, terms: listed };
    assert_eq!(refused(&curve, FitSpec::new(model)), "model.terms");
}

/// Coverage of the interval of the height in the middle, and how often the parabola is chosen, for
/// a line with T₂ of so many standard errors.
fn coverage(size: f64, select: Option<Select>) -> (f64, f64) {
    const DRAWS: usize = 300;
    let x: Vec<f64> = (0..25).map(|k| f64::from(k) / 12.0 - 1.0).collect();
    let t2: Vec<f64> = x.iter().map(|x| 2.0 * x * x - 1.0).collect();
    let mean = t2.iter().sum::<f64>() / 25.0;
    let bend = size / t2.iter().map(|t| (t - mean).powi(2)).sum::<f64>().sqrt();
    let predict = Predict { at: Places::Curve(vec![0.0]), level: None, kinds: Default::default(), slopes: false };
    let spec = FitSpec { select, predict: Some(predict), include: Include::default(), ..plain(Degree::Both(6)) };
    let mut random = Random::new(5);
    let (mut hits, mut found) = (0, 0);
    for _ in 0..DRAWS {
        let y = x.iter().zip(&t2).map(|(x, t)| 1.0 + 3.0 * x + bend * t + random.normal()).collect();
        let result = fit(&Nodes::curve(x.clone(), y, None).unwrap(), &spec);
        let [low, high] = result.predictions.unwrap().confidence.unwrap()[0];
        hits += usize::from(low <= 1.0 - bend && 1.0 - bend <= high);
        found += usize::from(result.coefficients.len() == 3);
    }
    (hits as f64 / DRAWS as f64, found as f64 / DRAWS as f64)
}

/// The warning is true: intervals hold without a selection, and not after one of what is between
/// large and small. What is large is found.
#[test]
fn selection_costs_coverage() {
    let bic = Some(Select::new(Candidates::Degrees(Degree::Both(6)), ModelCriterion::Bic));
    let (full, _) = coverage(2.0, None);
    assert!((0.92..=0.98).contains(&full), "{full}");
    let (after, _) = coverage(2.0, bic);
    assert!(after < 0.8, "{after}");
    let (large, found) = coverage(7.0, bic);
    assert!(large > 0.9 && found > 0.75, "{large} {found}");
}

/// A model that passes through every node has no likelihood; one that heights lie on but for
/// rounding has none either, and is chosen with as few terms as will do.
#[test]
fn criteria_are_not_made_of_rounding() {
    let x: Vec<f64> = (0..5).map(f64::from).collect();
    let few = Nodes::curve(x, vec![0.0, 1.1, 1.9, 3.2, 3.9], None).unwrap();
    for criterion in [ModelCriterion::Bic, ModelCriterion::Aicc, ModelCriterion::Reml] {
        let found = fit(&few, &selecting(Degree::Both(4), criterion)).selection.unwrap();
        assert!(found.candidates[found.chosen].coefficients < 4, "{criterion:?}: {found:?}");
        let last = found.candidates.iter().find(|candidate| candidate.coefficients == 5).unwrap();
        assert_eq!((last.aic, last.aicc, last.bic, last.reml), (None, None, None, None));
    }
    let x: Vec<f64> = (0..12).map(|k| 0.3 * f64::from(k)).collect();
    let y = x.iter().map(|x| 7.1 - 0.3 * x + 0.9 * x * x).collect();
    let exact = Nodes::curve(x, y, None).unwrap();
    for criterion in [ModelCriterion::Bic, ModelCriterion::Aicc, ModelCriterion::Press, ModelCriterion::Reml] {
        let found = fit(&exact, &selecting(Degree::Both(5), criterion)).selection.unwrap();
        assert_eq!(found.candidates[found.chosen].coefficients, 3, "{criterion:?}: {found:?}");
        assert!(found.candidates[1].bic.is_some() && found.candidates[2].bic.is_none(), "{found:?}");
    }
}
