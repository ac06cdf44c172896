//! The models that are looked at.

use super::{backward, path, problem::Problem, terms::Hierarchy};
use crate::{
    design::Design,
    result::Candidate,
    spec::{Candidates, Degree, Select, TermSearch},
};
use flankfit_numerics::{cancel::Asking, check::Faults};

/// Models at most.
const MOST_CANDIDATES: usize = 400;
/// Products of two numbers at most, over all models: some seconds.
const MOST_PRODUCTS: usize = 3_000_000_000;
/// Numbers of Q at most: 32 MB.
const MOST_NUMBERS: usize = 4_000_000;

/// A candidate: its degree, or its columns among those of the largest model.
pub(super) enum Of {
    Degree(Degree),
    Columns(Vec<usize>),
}

/// Every degree up to `largest`, ascending; `total` for products of a total degree.
pub(super) fn degrees(largest: Degree, surface: bool, total: bool) -> Result<Vec<Degree>, Faults> {
    let refused = |message: &str| Err(Faults::one("select.degrees", message));
    let (p, q) = match (largest, surface) {
        (Degree::Both(p), _) => (p, p),
        (Degree::Each(..), false) => return refused("a curve takes one degree, not one for each axis"),
        (Degree::Each(p, q), true) if total && p != q => {
            return refused("products up to a total degree take one degree for both axes");
        }
        (Degree::Each(p, q), true) => (p, q),
    };
    let one = !surface || total;
    let candidates = if one { p.saturating_add(1) } else { p.saturating_add(1).saturating_mul(q.saturating_add(1)) };
    if candidates > MOST_CANDIDATES {
        return refused(&format!("these degrees give {candidates} models; at most {MOST_CANDIDATES} can be compared"));
    }
    Ok(match one {
        true => (0..=p).map(Degree::Both).collect(),
        false => (0..=p).flat_map(|i| (0..=q).map(move |j| Degree::Each(i, j))).collect(),
    })
}

/// Refuses more work than a request may ask for, where a product costs `cost` of doubles.
pub(super) fn check_work(asked: &Select, models: usize, m: usize, n: usize, cost: usize) -> Result<(), Faults> {
    let each = (2 * m * n).saturating_mul(n).saturating_add((24 + 4 * cost) * n * n * n);
    if m.saturating_mul(n) > MOST_NUMBERS || each.saturating_mul(models) > MOST_PRODUCTS {
        let field = match asked.candidates {
            Candidates::Degrees(_) => "select.degrees",
            Candidates::Terms(_) => "select.terms",
        };
        return Err(Faults::one(
            field,
            format_args!("{n} coefficients and {m} nodes take too long: use fewer of them"),
        ));
    }
    Ok(())
}

/// Every candidate with its criteria; `degrees` are those up to the largest one, if requested.
pub(super) fn looked_at(
    asked: &Select,
    problem: &Problem,
    design: &Design,
    degrees: &[Degree],
    ordered: bool,
) -> Vec<(Of, Candidate)> {
    let hierarchy = Hierarchy::new(&design.terms, ordered, design.constant);
    let n = design.size();
    let terms = |found: Vec<(Vec<usize>, Candidate)>| {
        let named = |columns: &[usize]| columns.iter().map(|&j| design.labels[j].clone()).collect();
        found
            .into_iter()
            .map(|(columns, figures)| {
                let figures = Candidate { terms: Some(named(&columns)), ..figures };
                (Of::Columns(columns), figures)
            })
            .collect()
    };
    match asked.candidates {
        Candidates::Degrees(_) => {
            let each = degrees.iter().asking(problem.b.len() * n * n);
            each.map(|&degree| {
                let columns = within(design, degree);
                let figures = problem.figures(&problem.triangle.subspace(&columns));
                (Of::Degree(degree), Candidate { degree: Some(degree), ..figures })
            })
            .collect()
        }
        Candidates::Terms(TermSearch::Backward) => terms(backward::path(problem, &hierarchy, n)),
        Candidates::Terms(TermSearch::ElasticNet { alpha }) => terms(path::path(problem, &hierarchy, alpha)),
    }
}

/// The columns of the largest model that one of `degree` has.
fn within(design: &Design, degree: Degree) -> Vec<usize> {
    let has = |&(i, j): &(usize, usize)| match degree {
        Degree::Both(d) => i + j <= d,
        Degree::Each(p, q) => i <= p && j <= q,
    };
    (0..design.size()).filter(|&k| has(&design.terms[k])).collect()
}
