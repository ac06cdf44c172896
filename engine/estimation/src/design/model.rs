//! A model checked against the nodes.

use std::collections::BTreeSet;

use super::{
    axis::Axis,
    columns::columns,
    domain::{Boxes, bounding_box, checked_domain},
    label::label,
    measurement_matrix::{Basis, Design, MOST_COEFFICIENTS, too_many},
    splines::{splines, weight_net, within_knots},
};
use crate::{
    data::{Nodes, Sample},
    result::TermKey,
    spec::{Degree, Domain, FitSpec, Knots, Model, PolynomialBasis, Terms},
};
use flankfit_geometry::{Mapping, polynomial::Family};
use flankfit_numerics::check::Faults;

/// Messages for a matrix with another model, and for other nodes with a linear one.
pub(crate) const MATRIX_TAKES_LINEAR: &str = "nodes of type `matrix` need the model `linear`";
const LINEAR_IS_FOR_MATRIX: &str = "`linear` is for nodes of type `matrix`";

/// Nodes of which none counts.
pub(crate) fn none_counts(nodes: &Nodes) -> Faults {
    Faults::one(format_args!("nodes.{}", nodes.heights()), "every node is missing or of weight 0")
}

/// Fewer nodes than coefficients.
pub(crate) fn too_few_nodes(coefficients: usize, nodes: usize) -> String {
    format!(
        "{coefficients} coefficients cannot be determined from {nodes} counted nodes: lower the degree or measure more \
         nodes"
    )
}

impl Design {
    /// Checks `spec` against the nodes.
    pub(crate) fn new(nodes: &Nodes, sample: &Sample, spec: &FitSpec) -> Result<Self, Faults> {
        if sample.count() == 0 {
            return Err(match spec.exclude.is_empty() {
                true => none_counts(nodes),
                false => Faults::one("exclude", "no node is left: exclude fewer"),
            });
        }
        let design = match (&spec.model, nodes) {
            (Model::Linear, Nodes::Matrix(matrix)) => {
                if spec.domain.is_some() {
                    return Err(Faults::one("domain", "a measurement matrix has no domain"));
                }
                columns(sample, matrix.columns, matrix.names.as_deref())?
            }
            (Model::Linear, _) => {
                return Err(Faults::one("model.type", LINEAR_IS_FOR_MATRIX));
            }
            (_, Nodes::Matrix(_)) => {
                return Err(Faults::one("model.type", MATRIX_TAKES_LINEAR));
            }
            (model, _) => product(nodes, sample, model, spec.domain)?,
        };
        let (n, m) = (design.size(), sample.count());
        if n > m {
            if !spec.exclude.is_empty() {
                let message =
                    format_args!("{m} nodes are left for {n} coefficients: exclude fewer, or lower the degree");
                return Err(Faults::one("exclude", message));
            }
            let path = if matches!(spec.model, Model::Linear) { "nodes.x" } else { "model.degree" };
            return Err(Faults::one(path, too_few_nodes(n, m)));
        }
        Ok(design)
    }
}

fn product(nodes: &Nodes, sample: &Sample, model: &Model, domain: Option<Domain>) -> Result<Design, Faults> {
    let surface = !matches!(nodes, Nodes::Curve(_));
    let boxes = bounding_box(sample);
    let domains = checked_domain(nodes, sample, surface, domain, boxes)?;
    let design = product_on(surface, model, domains, boxes)?;
    within_knots(&design, nodes, sample)?;
    Ok(design)
}

/// A product of functions of u and v (of x alone for a curve) before any node is known: the
/// caller's functions live on `domains`, the working ones on `boxes`.
pub(crate) fn product_on(
    surface: bool,
    model: &Model,
    (domain_u, domain_v): Boxes,
    (box_u, box_v): Boxes,
) -> Result<Design, Faults> {
    let degree = match model {
        Model::Polynomial { degree, .. } | Model::BSpline { degree, .. } => *degree,
        Model::Linear => Degree::Both(0),
    };
    let (p, q) = match (degree, surface) {
        (Degree::Both(p), true) => (p, p),
        (Degree::Both(p), false) => (p, 0),
        (Degree::Each(p, q), true) => (p, q),
        (Degree::Each(..), false) => {
            return Err(Faults::one("model.degree", "a curve has one degree, not two"));
        }
    };
    if p.saturating_add(1).saturating_mul(q.saturating_add(1)) > 4 * MOST_COEFFICIENTS * MOST_COEFFICIENTS {
        too_many(usize::MAX, "model.degree")?;
    }
    let (mut rational, mut crowded) = (None, "model.degree");
    let (u, v, part, letter) = match model {
        Model::Polynomial { basis, terms, .. } => {
            if *terms == Terms::Total && surface && p != q {
                return Err(Faults::one("model.degree", "a total degree is one number, not two different ones"));
            }
            let axis = |domain: [f64; 2], bounds: [f64; 2], degree: usize| Axis::Polynomial {
                family: match basis {
                    PolynomialBasis::Monomial => Family::Monomial,
                    PolynomialBasis::Chebyshev => Family::Chebyshev { low: domain[0], high: domain[1] },
                    PolynomialBasis::Legendre => Family::Legendre { low: domain[0], high: domain[1] },
                },
                mapping: Mapping::over(bounds[0], bounds[1]),
                size: degree.saturating_add(1),
            };
            let letter = match basis {
                PolynomialBasis::Monomial => None,
                PolynomialBasis::Chebyshev => Some('T'),
                PolynomialBasis::Legendre => Some('P'),
            };
            if let Terms::Listed(listed) = terms {
                check_terms(listed, (p, q), surface)?;
            }
            (axis(domain_u, box_u, p), axis(domain_v, box_v, q), Part::of(terms, p), letter)
        }
        Model::BSpline { knots, weights, .. } => {
            let (u, v) = splines(knots, (p, q), surface, (domain_u, domain_v))?;
            crowded =
                if matches!(knots, Knots::Spans(_) | Knots::SpansEach(..)) { "model.spans" } else { "model.knots" };
            too_many(u.size().saturating_mul(v.size()), crowded)?;
            if let Some(weights) = weights {
                rational = Some(weight_net(weights, (u.size(), v.size()), surface)?);
            }
            (u, v, Part::All, Some(if rational.is_some() { 'R' } else { 'B' }))
        }
        Model::Linear => return Err(Faults::one("model.type", LINEAR_IS_FOR_MATRIX)),
    };
    let count = match &part {
        Part::UpTo(d) if surface => d.saturating_add(1).saturating_mul(d.saturating_add(2)) / 2,
        Part::Listed(listed) => listed.len(),
        _ => u.size().saturating_mul(v.size()),
    };
    let spline = matches!(letter, Some('B' | 'R'));
    too_many(count, crowded)?;
    let terms: Vec<(usize, usize)> =
        (0..u.size()).flat_map(|i| (0..v.size()).map(move |j| (i, j))).filter(|&term| part.has(term)).collect();
    Ok(Design {
        labels: terms.iter().map(|&term| label(term, letter, surface)).collect(),
        keys: terms
            .iter()
            .map(|&(i, j)| {
                let place = if surface { vec![i, j] } else { vec![i] };
                if spline { TermKey::Index(place) } else { TermKey::Powers(place) }
            })
            .collect(),
        terms,
        basis: Basis::Product { u, v },
        constant: (!spline).then_some(0),
        constant_in_span: Some(true),
        domain: Some(Domain { u: Some(domain_u), v: surface.then_some(domain_v) }),
        rational,
    })
}

/// Products of powers that take part.
enum Part<'a> {
    All,
    /// Terms whose powers add up to at most so many.
    UpTo(usize),
    Listed(BTreeSet<&'a [usize; 2]>),
}

impl<'a> Part<'a> {
    fn of(terms: &'a Terms, degree: usize) -> Self {
        match terms {
            Terms::Tensor => Part::All,
            Terms::Total => Part::UpTo(degree),
            Terms::Listed(listed) => Part::Listed(listed.iter().collect()),
        }
    }

    fn has(&self, (i, j): (usize, usize)) -> bool {
        match self {
            Part::All => true,
            Part::UpTo(degree) => i + j <= *degree,
            Part::Listed(listed) => listed.contains(&[i, j]),
        }
    }
}

/// Every product once, within the degrees, with those that divide it.
fn check_terms(listed: &[[usize; 2]], (p, q): (usize, usize), surface: bool) -> Result<(), Faults> {
    if !surface {
        return Err(Faults::one(
            "model.terms",
            "a curve has every power up to its degree: products are listed for surfaces",
        ));
    }
    if listed.is_empty() {
        return Err(Faults::one("model.terms", "at least one term"));
    }
    too_many(listed.len(), "model.terms")?;
    let all: BTreeSet<[usize; 2]> = listed.iter().copied().collect();
    let mut seen = BTreeSet::new();
    let mut faults = Faults::default();
    for (k, &[i, j]) in listed.iter().enumerate() {
        let missing = [i.checked_sub(1).map(|i| [i, j]), j.checked_sub(1).map(|j| [i, j])];
        let missing = missing.into_iter().flatten().find(|divisor| !all.contains(divisor));
        if i > p || j > q {
            faults.push(format_args!("model.terms[{k}]"), format_args!("[{i}, {j}] exceeds the degrees [{p}, {q}]"));
        } else if !seen.insert([i, j]) {
            faults.push(format_args!("model.terms[{k}]"), format_args!("[{i}, {j}] is listed twice"));
        } else if let Some(divisor) = missing {
            faults.push(
                format_args!("model.terms[{k}]"),
                format_args!(
                    "[{i}, {j}] without [{}, {}], which divides it: the fit would depend on the origin of u and v",
                    divisor[0], divisor[1]
                ),
            );
        }
    }
    faults.into_result(())
}
