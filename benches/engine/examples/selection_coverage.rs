//! Cost of choosing a model by the nodes, and how often each criterion finds the true one: the
//! tables of docs/explanation/selection.md.
//!
//! A flank on a grid of 9 × 7 nodes has the terms 1, T₁(u), T₁(v), T₁(u)T₁(v), all large, and
//! T₂(u), which is as large as so many of its standard errors. Looked at are all degrees up to (4,
//! 3), and subsets of the 20 terms of the largest; the intervals are those of the heights on a grid
//! of 5 × 5 places. `cargo run --release -p engine-benches --example selection_coverage -- 2000`
//! draws 2000 times each.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/random.rs"]
mod random;

use flankfit_engine::estimation::{
    FitResult, FitSpec, Nodes, fit,
    result::Candidate,
    spec::{
        Candidates, Degree, Folds, FoldsBy, Kinds, Model, ModelCriterion, Places, PolynomialBasis, Predict,
        Regularization, Select, TermSearch, Terms,
    },
};
use random::Random;

type Failed = Box<dyn std::error::Error>;

const U: usize = 9;
const V: usize = 7;

/// Places −1 to 1.
fn axis(count: usize) -> Vec<f64> {
    (0..count).map(|k| 2.0 * k as f64 / (count - 1) as f64 - 1.0).collect()
}

/// The true flank, `size` standard errors of T₂(u) large.
struct Truth {
    coefficient: f64,
}

impl Truth {
    fn new(size: f64) -> Self {
        // the standard error of T₂ next to 1 and T₁ on a symmetric axis
        let t2: Vec<f64> = axis(U).iter().map(|u| 2.0 * u * u - 1.0).collect();
        let mean = t2.iter().sum::<f64>() / U as f64;
        let squares: f64 = t2.iter().map(|t| (t - mean).powi(2)).sum();
        Truth { coefficient: size / (squares * V as f64).sqrt() }
    }

    fn height(&self, u: f64, v: f64) -> f64 {
        3.0 - 5.0 * u + 2.0 * v - 3.0 * u * v + self.coefficient * (2.0 * u * u - 1.0)
    }

    /// Heights with noise of variance 1, of which the share `common` is that of a whole row.
    fn nodes(&self, common: f64, random: &mut Random) -> Result<Nodes, Failed> {
        let mut heights = Vec::with_capacity(U * V);
        for u in axis(U) {
            let row = common.sqrt() * random.normal();
            heights.extend(axis(V).iter().map(|&v| self.height(u, v) + row + (1.0 - common).sqrt() * random.normal()));
        }
        Ok(Nodes::grid(axis(U), axis(V), heights, None, None)?)
    }
}

fn spec(degree: Degree, terms: Terms) -> FitSpec {
    let places = Places::Grid { u: axis(5), v: axis(5) };
    FitSpec {
        regularization: Regularization::None,
        predict: Some(Predict { at: places, level: None, kinds: Kinds::default(), slopes: false }),
        ..FitSpec::new(Model::Polynomial { degree, basis: PolynomialBasis::Chebyshev, terms })
    }
}

/// Way to choose a model.
#[derive(Clone, Copy)]
enum Way {
    Full,
    Degrees(ModelCriterion),
    Terms(TermSearch, ModelCriterion),
}

impl Way {
    fn name(self) -> String {
        match self {
            Way::Full => "none: the largest model".to_owned(),
            Way::Degrees(criterion) => format!("degrees, `{}`", criterion.name()),
            Way::Terms(TermSearch::Backward, criterion) => format!("`backward`, `{}`", criterion.name()),
            Way::Terms(_, criterion) => format!("`elastic_net`, `{}`", criterion.name()),
        }
    }

    /// The fit of the model that is chosen, and whether that is the true one and one that holds it.
    fn fit(self, nodes: &Nodes) -> Result<(FitResult, bool, bool), Failed> {
        let full = spec(Degree::Each(4, 3), Terms::Tensor);
        let (candidates, criterion) = match self {
            Way::Full => return Ok((fit(nodes, &full)?, false, true)),
            Way::Degrees(criterion) => (Candidates::Degrees(Degree::Each(4, 3)), criterion),
            Way::Terms(search, criterion) => (Candidates::Terms(search), criterion),
        };
        let select = Some(Select::new(candidates, criterion));
        let folds = Some(Folds { by: FoldsBy::Rows, count: None });
        let result = fit(nodes, &FitSpec { select, folds, ..full })?;
        let chosen = result.selection.as_ref().map(|selection| &selection.candidates[selection.chosen]);
        let (is, holds) = chosen.map_or((false, false), judged);
        Ok((result, is, holds))
    }
}

/// Decides if a candidate is the true model, and if it contains it.
fn judged(chosen: &Candidate) -> (bool, bool) {
    if let Some(Degree::Each(p, q)) = chosen.degree {
        return ((p, q) == (2, 1), p >= 2 && q >= 1);
    }
    let terms = chosen.terms.as_deref().unwrap_or_default();
    let holds = ["1", "T1(u)", "T1(v)", "T1(u)*T1(v)", "T2(u)"].iter().all(|term| terms.iter().any(|t| t == term));
    (holds && terms.len() == 5, holds)
}

/// Counts for one way of choosing.
#[derive(Default)]
struct Count {
    is: usize,
    holds: usize,
    hits: Vec<usize>,
    width: f64,
}

fn count(way: Way, size: f64, common: f64, draws: usize) -> Result<Count, Failed> {
    let truth = Truth::new(size);
    let mut random = Random::new(11);
    let mut count = Count { hits: vec![0; 25], ..Count::default() };
    for _ in 0..draws {
        let nodes = truth.nodes(common, &mut random)?;
        let (result, is, holds) = way.fit(&nodes)?;
        count.is += usize::from(is);
        count.holds += usize::from(holds);
        let bands = result.predictions.and_then(|predictions| predictions.confidence).ok_or("no bands")?;
        for (k, [low, high]) in bands.into_iter().enumerate() {
            let height = truth.height(axis(5)[k / 5], axis(5)[k % 5]);
            count.hits[k] += usize::from(low <= height && height <= high);
            count.width += (high - low) / 25.0;
        }
    }
    Ok(count)
}

fn ways() -> Vec<Way> {
    let net = TermSearch::ElasticNet { alpha: 0.8 };
    let mut ways = vec![Way::Full];
    ways.extend(ModelCriterion::ALL.map(Way::Degrees));
    ways.extend([
        Way::Terms(TermSearch::Backward, ModelCriterion::Aicc),
        Way::Terms(TermSearch::Backward, ModelCriterion::Bic),
        Way::Terms(net, ModelCriterion::Bic),
        Way::Terms(net, ModelCriterion::BlockedCv),
    ]);
    ways
}

fn main() -> Result<(), Failed> {
    let draws: usize = std::env::args().nth(1).map_or(Ok(2000), |text| text.parse())?;
    let sizes = [1.0, 2.0, 3.0, 5.0];
    println!("{draws} draws each; T₂(u) is 1, 2, 3 and 5 standard errors large\n");
    for (what, common) in [("Independent noise", 0.0), ("Half of the variance common to each row", 0.5)] {
        println!("{what}: mean coverage / that of the worst place / width over that of the largest model\n");
        println!("| chosen | 1 | 2 | 3 | 5 |\n|---|---|---|---|---|");
        let mut chosen = String::from("| chosen | 1 | 2 | 3 | 5 |\n|---|---|---|---|---|\n");
        let mut whole = Vec::new();
        for way in ways() {
            let (mut coverage, mut found) = (format!("| {} ", way.name()), format!("| {} ", way.name()));
            for (k, size) in sizes.into_iter().enumerate() {
                let count = count(way, size, common, draws)?;
                if matches!(way, Way::Full) {
                    whole.push(count.width);
                }
                let shares: Vec<f64> = count.hits.iter().map(|&h| h as f64 / draws as f64).collect();
                let mean = shares.iter().sum::<f64>() / 25.0;
                let worst = shares.iter().copied().fold(1.0, f64::min);
                coverage += &format!("| {mean:.3} / {worst:.3} / {:.2} ", count.width / whole[k]);
                let percent = |n: usize| 100.0 * n as f64 / draws as f64;
                found += &format!("| {:.0} / {:.0} ", percent(count.is), percent(count.holds));
            }
            println!("{coverage}|");
            if !matches!(way, Way::Full) {
                chosen += &format!("{found}|\n");
            }
        }
        println!("\n{what}: how often (%) the true model is chosen / one that holds it\n\n{chosen}");
    }
    Ok(())
}
