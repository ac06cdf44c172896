//! The measurement matrix `X` (Eqs. 13–14): which functions, under which names, on which domain.
//!
//! Two bases are kept apart. The *caller's* basis is what coefficients are reported in. The
//! *working* basis is what is computed in: Chebyshev polynomials of the mapped abscissae, B-splines
//! as they are, or the posted columns divided by powers of 2. An upper triangular `T` leads from
//! one to the other, `X = W · T`. A curve is a surface whose second axis carries the single
//! function 1.

use nalgebra::DMatrix;

use super::{
    error::Faults,
    nodes::Nodes,
    result::TermKey,
    sample::Sample,
    spec::{Degree, Domain, FitSpec, Knots, Model, PolynomialBasis, Terms},
};
use crate::{
    fault::words::Shown,
    geometry::{BSplineBasis, KnotFault, Mapping, WeightNet, polynomial, polynomial::Family, rational::WeightFault},
    numerics::{Dd, Real, cancel::Asking},
};

/// The largest number of coefficients: the n×n analysis must stay within seconds.
pub const MOST_COEFFICIENTS: usize = 600;

/// A checked model on checked nodes.
#[derive(Clone)]
pub struct Design {
    pub basis: Basis,
    /// `(i, j)` of every coefficient, in coefficient order.
    pub terms: Vec<(usize, usize)>,
    pub labels: Vec<String>,
    pub keys: Vec<TermKey>,
    /// Which coefficient multiplies the constant function, where one does.
    pub constant: Option<usize>,
    /// Whether the constant lies in the span of the columns, where that is known beforehand.
    pub constant_in_span: Option<bool>,
    pub domain: Option<Domain>,
    /// Weights of NURBS: working functions are then `NᵢNⱼ / W`, the caller's `wᵢⱼ` times those.
    pub rational: Option<WeightNet>,
}

/// The working basis.
#[derive(Clone)]
pub enum Basis {
    Product {
        u: Axis,
        v: Axis,
    },
    /// Posted columns divided by these powers of 2.
    Columns {
        scale: Vec<f64>,
    },
}

/// The functions on one axis.
#[derive(Clone)]
pub enum Axis {
    Polynomial { family: Family, mapping: Mapping, size: usize },
    Spline(BSplineBasis),
}

impl Axis {
    pub fn size(&self) -> usize {
        match self {
            Axis::Polynomial { size, .. } => *size,
            Axis::Spline(basis) => basis.size(),
        }
    }

    /// Every working function at `x`, zeros included.
    pub fn row<T: Real>(&self, x: f64, out: &mut [T]) {
        match self {
            Axis::Polynomial { mapping, .. } => polynomial::chebyshev_values(mapping.map::<T>(x), out),
            Axis::Spline(basis) => {
                let p = basis.degree();
                out.fill(T::of(0.0));
                let mut local = vec![T::of(0.0); p + 1];
                let first = basis.values(x, &mut local);
                out[first..=first + p].copy_from_slice(&local);
            }
        }
    }

    /// Values and first derivatives of the *caller's* functions at `x`.
    pub fn caller_row(&self, x: f64, values: &mut [f64], derivatives: &mut [f64]) {
        match self {
            Axis::Polynomial { family, .. } => polynomial::values_and_derivatives(*family, x, values, derivatives),
            Axis::Spline(basis) => {
                self.row(x, values);
                derivatives.fill(0.0);
                let mut local = vec![0.0; basis.degree() + 1];
                let first = basis.derivatives(x, &mut local);
                derivatives[first..first + local.len()].copy_from_slice(&local);
            }
        }
    }

    /// The change of basis of this axis.
    pub fn change(&self) -> DMatrix<Dd> {
        match self {
            Axis::Polynomial { family, mapping, size } => polynomial::change_of_basis(*family, *mapping, *size),
            Axis::Spline(basis) => identity(basis.size()),
        }
    }
}

fn identity(n: usize) -> DMatrix<Dd> {
    DMatrix::from_fn(n, n, |i, j| if i == j { Dd::ONE } else { Dd::ZERO })
}

impl Design {
    /// n, the number of coefficients.
    pub fn size(&self) -> usize {
        self.terms.len()
    }

    /// Whether coefficients are all products of the two axes' functions.
    pub fn is_full_product(&self) -> bool {
        match &self.basis {
            // a denominator that is no product of functions of u and v does not separate
            Basis::Product { u, v } => self.terms.len() == u.size() * v.size() && self.rational.is_none(),
            Basis::Columns { .. } => false,
        }
    }

    /// `T`, n×n upper triangular (diagonal for posted columns).
    pub fn change_of_basis(&self) -> DMatrix<Dd> {
        let n = self.size();
        if let Some(net) = &self.rational {
            let weights = net.weights();
            return DMatrix::from_fn(n, n, |i, j| if i == j { Dd::from(weights[i]) } else { Dd::ZERO });
        }
        match &self.basis {
            Basis::Product { u, v } => {
                let (tu, tv) = (u.change(), v.change());
                DMatrix::from_fn(n, n, |row, column| {
                    let ((i, j), (p, q)) = (self.terms[row], self.terms[column]);
                    if i <= p && j <= q { tu[(i, p)] * tv[(j, q)] } else { Dd::ZERO }
                })
            }
            Basis::Columns { scale } => {
                DMatrix::from_fn(n, n, |i, j| if i == j { Dd::from(scale[i]) } else { Dd::ZERO })
            }
        }
    }

    /// Checks `spec` against the nodes.
    pub fn new(nodes: &Nodes, sample: &Sample, spec: &FitSpec) -> Result<Self, Faults> {
        if sample.count() == 0 {
            return Err(Faults::one(nodes.heights_pointer(), "every node is missing or of weight 0"));
        }
        let design = match (&spec.model, nodes) {
            (Model::Linear, Nodes::Matrix(matrix)) => {
                if spec.domain.is_some() {
                    return Err(Faults::one("/domain", "a measurement matrix has no domain"));
                }
                columns(sample, matrix.columns, matrix.names.as_deref())?
            }
            (Model::Linear, _) => {
                return Err(Faults::one("/model/type", "`linear` is for nodes of type `matrix`"));
            }
            (_, Nodes::Matrix(_)) => {
                return Err(Faults::one("/model/type", "nodes of type `matrix` take the model `linear`"));
            }
            (model, _) => product(nodes, sample, model, spec.domain)?,
        };
        let (n, m) = (design.size(), sample.count());
        if n > m {
            return Err(Faults::one(
                if matches!(spec.model, Model::Linear) { "/nodes/x" } else { "/model/degree" },
                format!(
                    "{n} coefficients cannot be told from {m} counted nodes: lower the degree or measure more nodes"
                ),
            ));
        }
        Ok(design)
    }
}

pub fn columns(sample: &Sample, n: usize, names: Option<&[String]>) -> Result<Design, Faults> {
    too_many(n, "/nodes/x")?;
    let mut largest = vec![0.0f64; n];
    let mut same = vec![true; n];
    let first = sample.matrix_row(0);
    for k in (0..sample.count()).asking(100) {
        for (j, x) in sample.matrix_row(k).iter().enumerate() {
            largest[j] = largest[j].max(x.abs());
            same[j] &= *x == first[j];
        }
    }
    let scale = largest.iter().map(|&x| if x > 0.0 { power_of_two(x) } else { 1.0 }).collect();
    let constants: Vec<usize> = (0..n).filter(|&j| same[j] && first[j] != 0.0).collect();
    Ok(of_columns(scale, &constants, names))
}

/// Posted columns divided by `scale`, of which `constants` do not vary.
pub fn of_columns(scale: Vec<f64>, constants: &[usize], names: Option<&[String]>) -> Design {
    let n = scale.len();
    Design {
        basis: Basis::Columns { scale },
        terms: (0..n).map(|j| (j, 0)).collect(),
        labels: (0..n).map(|j| names.map_or_else(|| format!("x{j}"), |names| names[j].clone())).collect(),
        keys: (0..n).map(TermKey::Column).collect(),
        constant: if constants.len() == 1 { Some(constants[0]) } else { None },
        constant_in_span: if constants.is_empty() { None } else { Some(true) },
        domain: None,
        rational: None,
    }
}

/// The power of 2 next below `x > 0`.
pub fn power_of_two(x: f64) -> f64 {
    let truncated = f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000);
    if truncated > 0.0 { truncated } else { f64::MIN_POSITIVE }
}

fn too_many(n: usize, pointer: &str) -> Result<(), Faults> {
    if n <= MOST_COEFFICIENTS {
        return Ok(());
    }
    let many = if n == usize::MAX { "so many".to_owned() } else { n.to_string() };
    Err(Faults::one(pointer, format!("{many} coefficients are more than the {MOST_COEFFICIENTS} that a fit may have")))
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
pub fn product_on(
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
            return Err(Faults::one("/model/degree", "a curve has one degree, not one for each of two axes"));
        }
    };
    if p.saturating_add(1).saturating_mul(q.saturating_add(1)) > 4 * MOST_COEFFICIENTS * MOST_COEFFICIENTS {
        too_many(usize::MAX, "/model/degree")?;
    }
    let mut rational = None;
    let (u, v, total, letter) = match model {
        Model::Polynomial { basis, terms, .. } => {
            if *terms == Terms::Total && surface && p != q {
                return Err(Faults::one("/model/degree", "total degree wants one degree, not two different ones"));
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
            let total = (*terms == Terms::Total).then_some(p);
            (axis(domain_u, box_u, p), axis(domain_v, box_v, q), total, letter)
        }
        Model::BSpline { knots, weights, .. } => {
            let (u, v) = splines(knots, (p, q), surface, (domain_u, domain_v))?;
            if let Some(weights) = weights {
                rational = Some(weight_net(weights, (u.size(), v.size()), surface)?);
            }
            (u, v, None, Some(if rational.is_some() { 'R' } else { 'B' }))
        }
        Model::Linear => return Err(Faults::one("/model/type", "`linear` is for nodes of type `matrix`")),
    };
    let count = match total {
        Some(d) if surface => d.saturating_add(1).saturating_mul(d.saturating_add(2)) / 2,
        _ => u.size().saturating_mul(v.size()),
    };
    let spline = matches!(letter, Some('B' | 'R'));
    too_many(count, if spline { "/model/knots" } else { "/model/degree" })?;
    let terms: Vec<(usize, usize)> = (0..u.size())
        .flat_map(|i| (0..v.size()).map(move |j| (i, j)))
        .filter(|(i, j)| total.is_none_or(|d| i + j <= d))
        .collect();
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

pub fn bounding_box(sample: &Sample) -> ([f64; 2], [f64; 2]) {
    if let Some((u, v)) = sample.full_axes() {
        // axes ascend
        return ([u[0], u[u.len() - 1]], [v[0], v[v.len() - 1]]);
    }
    let (u, v) = sample.place(0);
    let (mut box_u, mut box_v) = ([u; 2], [v; 2]);
    for k in (1..sample.count()).asking(20) {
        let (u, v) = sample.place(k);
        box_u = [box_u[0].min(u), box_u[1].max(u)];
        box_v = [box_v[0].min(v), box_v[1].max(v)];
    }
    (box_u, box_v)
}

pub type Boxes = ([f64; 2], [f64; 2]);

/// The caller's domain where one is given (no node may lie outside), else the box.
pub fn checked_domain(
    nodes: &Nodes,
    sample: &Sample,
    surface: bool,
    domain: Option<Domain>,
    (box_u, box_v): Boxes,
) -> Result<Boxes, Faults> {
    let given = domain.unwrap_or_default();
    let mut faults = Faults::default();
    for (name, range) in [("u", given.u), ("v", given.v)] {
        if let Some([low, high]) = range
            && !(low < high && (high - low).is_finite())
        {
            faults.push(
                format!("/domain/{name}"),
                format!("[{}, {}] is not a range from low to high", Shown(low), Shown(high)),
            );
        }
    }
    if given.v.is_some() && !surface {
        faults.push("/domain/v", "a curve has no v");
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let (u, v) = (given.u.unwrap_or(box_u), given.v.unwrap_or(box_v));
    if box_u[0] < u[0] || box_u[1] > u[1] || box_v[0] < v[0] || box_v[1] > v[1] {
        outside(nodes, sample, (u, v), &mut faults, "the domain");
        return Err(faults);
    }
    Ok((u, v))
}

/// Names every axis position or node outside the given ranges.
fn outside(nodes: &Nodes, sample: &Sample, (u, v): Boxes, faults: &mut Faults, of: &str) {
    let out = |x: f64, range: [f64; 2]| x < range[0] || x > range[1];
    let text =
        |x: f64, range: [f64; 2]| format!("{} lies outside {of} [{}, {}]", Shown(x), Shown(range[0]), Shown(range[1]));
    if let Nodes::Grid(grid) = nodes {
        for (name, axis, range) in [("u", &grid.u, u), ("v", &grid.v, v)] {
            for (i, &x) in axis.iter().enumerate().filter(|(_, x)| out(**x, range)) {
                faults.push(format!("/nodes/{name}/{i}"), text(x, range));
            }
        }
        return;
    }
    let name_u = if matches!(nodes, Nodes::Curve(_)) { "x" } else { "u" };
    for k in 0..sample.count() {
        let (x, y) = sample.place(k);
        if out(x, u) {
            faults.push(format!("/nodes/{name_u}/{}", sample.posted(k)), text(x, u));
        }
        if out(y, v) {
            faults.push(format!("/nodes/v/{}", sample.posted(k)), text(y, v));
        }
    }
}

/// The knots asked for, as the functions of each axis.
pub fn splines(
    knots: &Knots,
    (p, q): (usize, usize),
    surface: bool,
    (domain_u, domain_v): Boxes,
) -> Result<(Axis, Axis), Faults> {
    let at = |pointer: &str, fault: KnotFault| {
        let pointer = fault.index().map_or_else(|| pointer.to_owned(), |i| format!("{pointer}/{i}"));
        Faults::one(pointer, fault.to_string())
    };
    let flat = || Axis::Polynomial { family: Family::Monomial, mapping: Mapping::over(0.0, 0.0), size: 1 };
    let uniform = |degree: usize, spans: usize, domain: [f64; 2], pointer: &str| {
        if spans == 0 {
            return Err(Faults::one(pointer, "at least one span"));
        }
        too_many(spans.saturating_add(degree), pointer)?;
        BSplineBasis::uniform(degree, spans, domain[0], domain[1]).map_err(|fault| at(pointer, fault))
    };
    too_many(p.max(q), "/model/degree")?;
    let (u, v) = match (knots, surface) {
        (Knots::Curve(knots), false) => {
            (BSplineBasis::new(p, knots.clone()).map_err(|fault| at("/model/knots", fault))?, None)
        }
        (Knots::Surface(u, v), true) => (
            BSplineBasis::new(p, u.clone()).map_err(|fault| at("/model/knots/0", fault))?,
            Some(BSplineBasis::new(q, v.clone()).map_err(|fault| at("/model/knots/1", fault))?),
        ),
        (Knots::Spans(spans), false) => (uniform(p, *spans, domain_u, "/model/spans")?, None),
        (Knots::Spans(spans), true) => {
            (uniform(p, *spans, domain_u, "/model/spans")?, Some(uniform(q, *spans, domain_v, "/model/spans")?))
        }
        (Knots::SpansEach(a, b), true) => {
            (uniform(p, *a, domain_u, "/model/spans/0")?, Some(uniform(q, *b, domain_v, "/model/spans/1")?))
        }
        (Knots::SpansEach(..), false) => {
            return Err(Faults::one("/model/spans", "a curve has one number of spans"));
        }
        (Knots::Curve(_), true) => {
            return Err(Faults::one("/model/knots", "a surface wants two knot vectors, one for u and one for v"));
        }
        (Knots::Surface(..), false) => return Err(Faults::one("/model/knots", "a curve has one knot vector")),
    };
    Ok((Axis::Spline(u), v.map_or_else(flat, Axis::Spline)))
}

fn weight_net(weights: &[f64], (rows, columns): (usize, usize), surface: bool) -> Result<WeightNet, Faults> {
    too_many(rows.saturating_mul(columns), "/model/knots")?;
    WeightNet::new(weights.to_vec(), rows, columns).map_err(|fault| {
        let pointer = match &fault {
            WeightFault::NotPositive { index, .. } if surface => {
                format!("/model/weights/{}/{}", index / columns, index % columns)
            }
            WeightFault::NotPositive { index, .. } => format!("/model/weights/{index}"),
            WeightFault::Count { .. } | WeightFault::Apart { .. } => "/model/weights".to_owned(),
        };
        Faults::one(pointer, fault.to_string())
    })
}

/// No node may lie beyond the knots.
pub fn within_knots(design: &Design, nodes: &Nodes, sample: &Sample) -> Result<(), Faults> {
    let Basis::Product { u, v } = &design.basis else { return Ok(()) };
    let span = |axis: &Axis| match axis {
        Axis::Spline(basis) => <[f64; 2]>::from(basis.domain()),
        Axis::Polynomial { .. } => [f64::NEG_INFINITY, f64::INFINITY],
    };
    let mut faults = Faults::default();
    outside(nodes, sample, (span(u), span(v)), &mut faults, "the span of the knots");
    faults.into_result(())
}

/// A readable name: `u^2*v`, `T2(u)*T1(v)`, `B3(u)*B0(v)`, `R3,0(u,v)`; curves are written in x.
fn label((i, j): (usize, usize), letter: Option<char>, surface: bool) -> String {
    if letter == Some('R') && surface {
        // a rational function of two parameters is no product
        return format!("R{i},{j}(u,v)");
    }
    let mut name = String::with_capacity(16);
    let mut factor = |power: usize, axis: &str| {
        if power == 0 && !matches!(letter, Some('B' | 'R')) {
            return;
        }
        if !name.is_empty() {
            name.push('*');
        }
        match letter {
            Some(letter) => {
                name.push(letter);
                push_number(&mut name, power);
                name.push('(');
                name.push_str(axis);
                name.push(')');
            }
            None => {
                name.push_str(axis);
                if power > 1 {
                    name.push('^');
                    push_number(&mut name, power);
                }
            }
        }
    };
    if surface {
        factor(i, "u");
        factor(j, "v");
    } else {
        factor(i, "x");
    }
    if name.is_empty() {
        name.push('1');
    }
    name
}

/// Appends a decimal number (labels are made for every fit: the formatting machinery would be half
/// their cost).
fn push_number(to: &mut String, number: usize) {
    if number >= 10 {
        push_number(to, number / 10);
    }
    to.push(char::from(b'0' + (number % 10) as u8));
}
