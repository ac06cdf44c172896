//! Recursive estimation (mathematics: keep R, Qᵀy and the residual sum of squares only).
//!
//! Nodes come in blocks and are forgotten: each is a Givens update of `[R | Qᵀ√Ωz]` in double-double, O(n²) whatever was seen
//! before. Everything from the factor on is the way of any fit, so spectrum, λ*, bounds and standard errors are there after
//! every block. After any split into blocks the result equals that of all nodes at once to rounding.
//!
//! Forgetting with a factor φ in (0, 1]: every counted node multiplies the weights of those before it by φ, so the result is
//! that of a fit in which the node k before the last has φᵏ times its weight. (m in σ̂² still counts every node, as for any
//! weights, which are relative 1/σ².)
//!
//! The working basis must be chosen before the nodes are known. Where the caller gives a domain it lives there; else, for raw
//! powers, on a box that grows with the nodes: its half-width is a power of 2 that at least doubles, and R goes over to the new
//! basis by the triangular matrix that leads from one to the other.

use nalgebra::DMatrix;

use super::{
    accumulate::Row,
    admission::{self, within_range},
    blocks::Form,
    design::{self, Axis, Basis, Boxes, Design},
    digits,
    error::{Fault, Faults, FitError},
    evidence::Evidence,
    factor::{Factor, scaled_condition},
    fit::report,
    nodes::Nodes,
    perturbation,
    regularized::suited,
    residuals::{Heights, Place},
    result::{Arithmetic, FitResult, Warning},
    sample::Sample,
    seen::Seen,
    spec::{Degree, Domain, Estimator, FitSpec, Knots, Model, PolynomialBasis},
    state::{Numbers, State},
    words::Shown,
};
use crate::{
    geometry::{Mapping, polynomial, polynomial::Family},
    numerics::{Dd, Real, Triangle, triangular},
};

/// An estimate that nodes are added to.
#[derive(Clone)]
pub struct Recursive {
    spec: FitSpec,
    forgetting: f64,
    sums: Option<Sums>,
}

/// What is kept of the nodes.
#[derive(Clone)]
pub(super) struct Sums {
    pub form: Form,
    pub design: Design,
    /// Where the working functions live.
    pub boxes: Boxes,
    pub triangle: Triangle<Dd>,
    /// `Σ w W`, by column.
    pub ones: Vec<Dd>,
    /// Σ w, Σ w z, Σ w z².
    pub moments: [Dd; 3],
    /// max √w |z|, max |z|.
    pub largest: [f64; 2],
    /// For a measurement matrix: the first row, and which columns have not varied since.
    pub first: Vec<f64>,
    pub same: Vec<bool>,
    pub seen: Seen,
}

impl Recursive {
    /// An estimate of `spec` before the first node; `forgetting` in (0, 1].
    ///
    /// Refuses what cannot be known node by node (estimators other than least squares, filters, mapped bases or equal spans
    /// without a domain), and what the model rules out whatever the nodes will be.
    pub fn new(spec: &FitSpec, forgetting: f64) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        if !(forgetting > 0.0 && forgetting <= 1.0) {
            faults.push("/forgetting_factor", format!("{} is not in (0, 1]", Shown(forgetting)));
        }
        if spec.estimator != Estimator::LeastSquares {
            faults.push("/estimator/type", "a stream is estimated by least squares; refit its iteration with others");
        }
        if !spec.filters.is_empty() {
            faults.push("/filters", "a stream has no neighbours to filter by; refit its iteration with filters");
        }
        check_domain(spec, &mut faults);
        faults.into_result(())?;
        if spec.model != Model::Linear {
            check_model(spec)?;
        }
        Ok(Recursive { spec: spec.clone(), forgetting, sums: None })
    }

    /// Counted nodes so far.
    pub fn count(&self) -> usize {
        self.sums.as_ref().map_or(0, |sums| sums.seen.count)
    }

    /// n, once the first block has told it.
    pub fn size(&self) -> Option<usize> {
        self.sums.as_ref().map(|sums| sums.design.size())
    }

    /// Adds a block. After an error nothing has changed.
    pub fn push(&mut self, nodes: &Nodes) -> Result<(), Faults> {
        let sample = Sample::new(nodes);
        if sample.count() == 0 {
            return Err(Faults::one(nodes.heights_pointer(), "every node is missing or of weight 0"));
        }
        let mut sums = match &self.sums {
            Some(sums) => {
                sums.form.check(nodes)?;
                sums.clone()
            }
            None => Sums::new(nodes, &sample, &self.spec)?,
        };
        if !matches!(nodes, Nodes::Matrix(_)) {
            let surface = sums.form == Form::Surface;
            design::checked_domain(nodes, &sample, surface, self.spec.domain, design::bounding_box(&sample))?;
            design::within_knots(&sums.design, nodes, &sample)?;
            sums.make_room(&sample, &self.spec)?;
        }
        sums.add(&sample, self.forgetting, self.spec.node_uncertainty.is_some());
        if !sums.is_finite() {
            return Err(Faults::one(
                "/nodes",
                "powers or squares of these numbers leave the range of double precision: choose another unit or basis",
            ));
        }
        sums.columns_within_range()?;
        self.sums = Some(sums);
        Ok(())
    }

    /// The fit of all nodes so far; `None` while there are fewer than coefficients.
    ///
    /// What needs the nodes themselves is left out, which a warning says: `max_abs`, single residuals and B.
    pub fn result(&self) -> Result<Option<FitResult>, FitError> {
        let Some(sums) = self.sums.as_ref().filter(|sums| sums.seen.count >= sums.design.size()) else {
            return Ok(None);
        };
        let design = sums.told_design(&self.spec);
        let heights = sums.heights();
        within_range(if sums.form == Form::Surface { "/nodes/z" } else { "/nodes/y" }, &heights)?;
        let factor = sums.factor(&design, &heights)?;
        let place = Place {
            design: &design,
            factor: &factor,
            heights: heights.about_zero,
            evidence: Evidence::Summed(&sums.seen),
        };
        let mut result = report(&place, &heights, &self.spec)?;
        result.warnings.push(Warning {
            code: "nodes_not_kept",
            message:
                "an estimate of a stream keeps sums only: the largest residual, single residuals and the rows of B \
                      are given when the stream is finished"
                    .into(),
        });
        if self.forgetting < 1.0 {
            result.warnings.push(Warning {
                code: "forgetting",
                message: format!(
                    "with a forgetting factor of {} the weights of all {} nodes add up to {:.6}; weights are relative 1/σ², so \
                     sigma is that of the newest node, older ones counting as noisier",
                    Shown(self.forgetting), sums.seen.count, heights.weight
                ),
            });
        }
        Ok(Some(result))
    }

    /// Everything that [`Recursive::restore`] needs beside spec and forgetting factor; `None` before the first block.
    pub fn state(&self) -> Option<State> {
        self.sums.as_ref().map(Sums::state)
    }

    /// The estimate whose [`Recursive::state`] this is, to the last bit; `None` when it is not one of this spec.
    pub fn restore(spec: &FitSpec, forgetting: f64, state: &State) -> Option<Self> {
        let sums = Sums::restore(spec, state)?;
        Some(Recursive { spec: spec.clone(), forgetting, sums: Some(sums) })
    }
}

/// Whether the spec is of a surface, where that can be told.
fn is_surface(spec: &FitSpec) -> Option<bool> {
    let domain = spec.domain.unwrap_or_default();
    match &spec.model {
        _ if domain.v.is_some() => Some(true),
        Model::Polynomial { degree: Degree::Each(..), .. } | Model::BSpline { degree: Degree::Each(..), .. } => {
            Some(true)
        }
        Model::BSpline { knots: Knots::Surface(..) | Knots::SpansEach(..), .. } => Some(true),
        Model::BSpline { knots: Knots::Curve(_), .. } => Some(false),
        model if needs_domain(model) && domain.u.is_some() => Some(false),
        _ => None,
    }
}

fn needs_domain(model: &Model) -> bool {
    match model {
        Model::Polynomial { basis, .. } => *basis != PolynomialBasis::Monomial,
        Model::BSpline { knots, .. } => matches!(knots, Knots::Spans(_) | Knots::SpansEach(..)),
        Model::Linear => false,
    }
}

fn check_domain(spec: &FitSpec, faults: &mut Faults) {
    let domain = spec.domain.unwrap_or_default();
    if spec.model == Model::Linear {
        if spec.domain.is_some() {
            faults.push("/domain", "a measurement matrix has no domain");
        }
        return;
    }
    for (name, range) in [("u", domain.u), ("v", domain.v)] {
        if let Some([low, high]) = range
            && !(low < high && (high - low).is_finite())
        {
            faults.push(
                format!("/domain/{name}"),
                format!("[{}, {}] is not a range from low to high", Shown(low), Shown(high)),
            );
        }
    }
    if needs_domain(&spec.model) {
        const WHY: &str = "missing; a stream must know beforehand where a mapped basis or equal spans live";
        match (domain.u, domain.v, is_surface(spec)) {
            (None, None, _) => faults.push("/domain", WHY),
            (None, Some(_), _) => faults.push("/domain/u", WHY),
            (Some(_), None, Some(true)) => faults.push("/domain/v", WHY),
            _ => {}
        }
    }
}

/// Degrees, knots, limits, and a regularisation for so many coefficients. Where the first block is to tell a curve from a
/// surface, one of them must be possible.
fn check_model(spec: &FitSpec) -> Result<(), Faults> {
    // the boxes only have to be some
    let domain = spec.domain.unwrap_or_default();
    let boxes = (domain.u.unwrap_or([-1.0, 1.0]), domain.v.unwrap_or([-1.0, 1.0]));
    let check = |surface| suited(&design::product_on(surface, &spec.model, boxes, boxes)?, spec);
    if let Some(surface) = is_surface(spec) {
        return check(surface);
    }
    match (check(false), check(true)) {
        (Err(curve), Err(surface)) if curve == surface => Err(curve),
        (Err(curve), Err(surface)) => {
            let mut both = Faults::default();
            for (what, faults) in [("a curve", curve), ("a surface", surface)] {
                for Fault { pointer, detail } in faults.list() {
                    both.push(pointer, format!("for {what}: {detail}"));
                }
            }
            Err(both)
        }
        _ => Ok(()),
    }
}

impl Sums {
    fn new(nodes: &Nodes, sample: &Sample, spec: &FitSpec) -> Result<Self, Faults> {
        let form = Form::of(nodes);
        let (design, boxes) = match (&spec.model, &form) {
            (Model::Linear, Form::Matrix { columns, names }) => {
                (design::columns(sample, *columns, names.as_deref())?, ([0.0; 2], [0.0; 2]))
            }
            (Model::Linear, _) => {
                return Err(Faults::one("/nodes/type", "the model `linear` takes nodes of type `matrix`"));
            }
            (_, Form::Matrix { .. }) => {
                return Err(Faults::one("/nodes/type", "nodes of type `matrix` take the model `linear`"));
            }
            (model, _) => {
                let surface = form == Form::Surface;
                if is_surface(spec).is_some_and(|told| told != surface) {
                    let what = if surface { "a curve" } else { "a surface" };
                    return Err(Faults::one(
                        "/nodes/type",
                        format!("model and domain of the stream are those of {what}"),
                    ));
                }
                let (u, v) = design::bounding_box(sample);
                let domain = spec.domain.unwrap_or_default();
                let boxes = (
                    domain.u.unwrap_or_else(|| roomy(u)),
                    if surface { domain.v.unwrap_or_else(|| roomy(v)) } else { [0.0; 2] },
                );
                (model_faults(design::product_on(surface, model, boxes, boxes), "/nodes/type")?, boxes)
            }
        };
        let n = design.size();
        let matrix = matches!(form, Form::Matrix { .. });
        model_faults(suited(&design, spec), if matrix { "/nodes/x" } else { "/nodes/type" })?;
        Ok(Sums {
            boxes,
            triangle: Triangle::new(n),
            ones: vec![Dd::ZERO; n],
            moments: [Dd::ZERO; 3],
            largest: [0.0; 2],
            first: if matrix { sample.matrix_row(0).to_vec() } else { Vec::new() },
            same: if matrix { vec![true; n] } else { Vec::new() },
            seen: Seen {
                count: 0,
                rss: Dd::ZERO,
                rounded_heights: false,
                rounded_places: [0.0; 2],
                bounds: [[f64::INFINITY, f64::NEG_INFINITY]; 2],
                rounded_columns: if matrix { vec![0.0; n] } else { Vec::new() },
                slopes: vec![0.0; if spec.node_uncertainty.is_some() { n } else { 0 }],
            },
            form,
            design,
        })
    }

    fn is_finite(&self) -> bool {
        self.triangle.is_finite()
            && self.ones.iter().chain(&self.moments).all(|x| x.is_finite())
            && self.seen.slopes.iter().all(|x| x.is_finite())
    }

    /// Lets the working box grow where nodes fall outside of it and the caller fixed no domain.
    fn make_room(&mut self, sample: &Sample, spec: &FitSpec) -> Result<(), Faults> {
        let Model::Polynomial { .. } = &spec.model else { return Ok(()) };
        let domain = spec.domain.unwrap_or_default();
        let (u, v) = design::bounding_box(sample);
        let old = self.boxes;
        let grown = |own: [f64; 2], of: [f64; 2], fixed: bool| {
            if fixed || (own[0] <= of[0] && of[1] <= own[1]) {
                own
            } else {
                roomy([own[0].min(of[0]), own[1].max(of[1])])
            }
        };
        let surface = self.form == Form::Surface;
        let new = (grown(old.0, u, domain.u.is_some()), grown(old.1, v, domain.v.is_some() || !surface));
        if new == old {
            return Ok(());
        }
        if ![new.0, new.1].as_flattened().iter().all(|x| x.is_finite()) {
            return Err(Faults::one("/nodes", "these abscissae leave the range of double precision"));
        }
        let Basis::Product { u: axis_u, v: axis_v } = &self.design.basis else { return Ok(()) };
        let (tu, tv) = (rebased(axis_u, old.0, new.0), rebased(axis_v, old.1, new.1));
        let n = self.design.size();
        let terms = &self.design.terms;
        let change = DMatrix::from_fn(n, n, |row, column| {
            let ((i, j), (p, q)) = (terms[row], terms[column]);
            if i <= p && j <= q { tu[(i, p)] * tv[(j, q)] } else { Dd::ZERO }
        });
        self.triangle.set_r(&triangular::multiply_upper(&self.triangle.r(), &change));
        self.ones = (0..n).map(|j| (0..=j).fold(Dd::ZERO, |sum, i| sum + change[(i, j)] * self.ones[i])).collect();
        self.boxes = new;
        self.design = model_faults(design::product_on(surface, &spec.model, new, new), "/nodes/type")?;
        Ok(())
    }

    fn add(&mut self, sample: &Sample, forgetting: f64, slopes: bool) {
        let fading = Dd::from(forgetting);
        let root_fading = fading.sqrt();
        let n = self.design.size();
        let mut row = Row::<Dd>::new(&self.design);
        let mut x = vec![Dd::ZERO; n];
        let mut slope = slopes.then(|| Slopes::new(&self.design));
        for k in 0..sample.count() {
            if forgetting < 1.0 {
                self.triangle.scale(root_fading, fading);
                self.ones.iter_mut().chain(&mut self.moments).for_each(|sum| *sum *= fading);
                self.seen.slopes.iter_mut().for_each(|sum| *sum *= forgetting);
            }
            let (weight, z) = (sample.w(k), sample.z(k));
            let root = if weight == 1.0 { Dd::ONE } else { Dd::from(weight).sqrt() };
            row.at(&self.design, sample, k);
            x.fill(Dd::ZERO);
            for (&j, &value) in row.index.iter().zip(&row.values) {
                x[j] = value * root;
                self.ones[j] += value * weight;
            }
            self.triangle.fold(&mut x, root * z);
            let weighted = Dd::product(weight, z);
            self.moments[0] += Dd::from(weight);
            self.moments[1] += weighted;
            self.moments[2] += weighted * z;
            self.largest[0] = self.largest[0].max(root.to_f64() * z.abs());
            self.largest[1] = self.largest[1].max(z.abs());
            if let Some(slope) = &mut slope {
                slope.add(&self.design, sample, k, &mut self.seen.slopes);
            }
            self.look_at(sample, k, root.to_f64());
        }
        self.seen.rss = self.triangle.rss();
    }

    /// What the estimate of correct digits and the report want to know of a node.
    fn look_at(&mut self, sample: &Sample, k: usize, root: f64) {
        let seen = &mut self.seen;
        seen.count += 1;
        seen.rounded_heights |= !digits::exact(sample.z(k));
        let (u, v) = sample.place(k);
        for (axis, at) in [u, v].into_iter().enumerate() {
            let [low, high] = &mut seen.bounds[axis];
            (*low, *high) = (low.min(at), high.max(at));
            if !digits::exact(at) {
                seen.rounded_places[axis] = seen.rounded_places[axis].max(at.abs());
            }
        }
        for (j, &x) in sample.matrix_row(k).iter().enumerate() {
            self.same[j] &= x == self.first[j];
            if !digits::exact(x) {
                seen.rounded_columns[j] = seen.rounded_columns[j].max(root * x.abs());
            }
        }
    }

    /// The design with what only the nodes could tell.
    fn told_design(&self, spec: &FitSpec) -> Design {
        match &self.form {
            Form::Matrix { names, .. } => {
                let Basis::Columns { scale } = &self.design.basis else { return self.design.clone() };
                let constants: Vec<usize> =
                    (0..scale.len()).filter(|&j| self.same[j] && self.first[j] != 0.0).collect();
                design::of_columns(scale.clone(), &constants, names.as_deref())
            }
            form => {
                let given = spec.domain.unwrap_or_default();
                let [u, v] = self.seen.bounds;
                let v = (*form == Form::Surface).then(|| given.v.unwrap_or(v));
                Design { domain: Some(Domain { u: Some(given.u.unwrap_or(u)), v }), ..self.design.clone() }
            }
        }
    }

    fn heights(&self) -> Heights {
        let [weight, sum, squares] = self.moments;
        Heights {
            weight: weight.to_f64(),
            about_mean: (squares - sum * sum / weight).to_f64().max(0.0),
            about_zero: squares.to_f64(),
            largest: self.largest[0],
            largest_plain: self.largest[1],
        }
    }

    /// Whether every later fit can take the caller's columns; a block that spoils them is refused, since it could not be
    /// taken back.
    fn columns_within_range(&self) -> Result<(), Faults> {
        let beyond = || Faults::one("/nodes", "powers of these numbers leave the range of double precision");
        let change = self.design.change_of_basis();
        if !change.iter().all(|x| x.is_finite()) {
            return Err(beyond());
        }
        let caller = triangular::multiply_upper(&self.triangle.r(), &change);
        admission::columns_within_range(&self.design, &caller).map_err(|error| match error {
            FitError::Invalid(faults) => faults,
            _ => beyond(),
        })
    }

    fn factor(&self, design: &Design, heights: &Heights) -> Result<Factor, FitError> {
        let r = self.triangle.r();
        let qty = self.triangle.qty().to_vec();
        let change = design.change_of_basis();
        if !change.iter().all(|x| x.is_finite()) {
            return Err(Faults::one("/nodes", "powers of these numbers leave the range of double precision").into());
        }
        // rounding of so many updates adds up like a random walk
        let rounded = (self.seen.count as f64).sqrt();
        let rss = self.triangle.rss().to_f64();
        let (working, relative_error) = match scaled_condition(&r) {
            Some((_, condition)) => {
                let mut working = qty.clone();
                triangular::solve_upper(&r, &mut working);
                let ratio = if heights.about_zero > 0.0 { (rss / heights.about_zero).sqrt() } else { 0.0 };
                let error = 4.0 * Dd::EPSILON * rounded * condition * (1.0 + condition * ratio);
                (Some(working), error.clamp(1e-30, 1.0))
            }
            None => (None, f64::EPSILON),
        };
        Ok(Factor {
            r,
            change,
            qty,
            working,
            ones: Some(self.ones.iter().map(|x| x.to_f64()).collect()),
            arithmetic: Arithmetic::DoubleDouble,
            relative_error,
            rss,
            max_abs: None,
            separable: None,
            rounded,
        })
    }

    fn state(&self) -> State {
        let mut numbers = Vec::new();
        let (form, names) = match &self.form {
            Form::Curve => (0.0, None),
            Form::Surface => (1.0, None),
            Form::Matrix { names, .. } => (2.0, names.clone()),
        };
        numbers.extend([form, self.design.size() as f64, self.seen.count as f64]);
        numbers.extend(self.boxes.0.into_iter().chain(self.boxes.1));
        numbers.extend(self.largest);
        numbers.extend(self.seen.bounds.as_flattened());
        numbers.extend(self.seen.rounded_places);
        numbers.push(f64::from(u8::from(self.seen.rounded_heights)));
        let triangle = self.triangle.rows().iter().chain(self.triangle.qty());
        for x in triangle.chain([&self.seen.rss]).chain(&self.moments).chain(&self.ones) {
            numbers.extend([x.hi, x.lo]);
        }
        numbers.extend(&self.seen.slopes);
        if let Basis::Columns { scale } = &self.design.basis {
            numbers.extend(scale.iter().chain(&self.first).chain(&self.seen.rounded_columns));
            numbers.extend(self.same.iter().map(|&same| f64::from(u8::from(same))));
        }
        State { numbers, names }
    }

    fn restore(spec: &FitSpec, state: &State) -> Option<Self> {
        let mut input = Numbers::new(&state.numbers);
        let [form, size, count] = input.array()?;
        let (n, count) = (size as usize, count as usize);
        if n > design::MOST_COEFFICIENTS {
            return None;
        }
        let boxes: Boxes = (input.array()?, input.array()?);
        let largest = input.array()?;
        let bounds = [input.array()?, input.array()?];
        let rounded_places = input.array()?;
        let [rounded_heights] = input.array()?;
        let triangle = (input.wide(n * (n + 1) / 2)?, input.wide(n)?);
        let rss = input.wide(1)?[0];
        let triangle = Triangle::from_parts(n, triangle.0, triangle.1, rss)?;
        let moments = input.wide(3)?.try_into().ok()?;
        let ones = input.wide(n)?;
        let slopes = input.take(if spec.node_uncertainty.is_some() { n } else { 0 })?;
        let matrix = form == 2.0;
        let columns = if matrix { n } else { 0 };
        let (scale, first, rounded_columns) = (input.take(columns)?, input.take(columns)?, input.take(columns)?);
        let same: Vec<bool> = input.take(columns)?.iter().map(|&x| x != 0.0).collect();
        let (form, design) = if matrix {
            let form = Form::Matrix { columns: n, names: state.names.clone() };
            (form, design::of_columns(scale, &[], state.names.as_deref()))
        } else {
            let surface = form == 1.0;
            let form = if surface { Form::Surface } else { Form::Curve };
            (form, design::product_on(surface, &spec.model, boxes, boxes).ok()?)
        };
        let seen = Seen {
            count,
            rss,
            rounded_heights: rounded_heights != 0.0,
            rounded_places,
            bounds,
            rounded_columns,
            slopes,
        };
        (design.size() == n && input.is_at_end()).then_some(Sums {
            form,
            design,
            boxes,
            triangle,
            ones,
            moments,
            largest,
            first,
            same,
            seen,
        })
    }
}

/// Faults of the stream's own model, met when its first block tells what the nodes are: at the `place` that told it.
fn model_faults<T>(result: Result<T, Faults>, place: &str) -> Result<T, Faults> {
    result.map_err(|faults| {
        let mut told = Faults::default();
        for Fault { pointer, detail } in faults.list() {
            told.push(place, format!("the stream's {pointer} does not suit these nodes: {detail}"));
        }
        told
    })
}

/// A box around `[low, high]` with some room whose half-width is a power of 2 and whose centre is a multiple of an eighth of
/// it, so that mapping it to [-1, 1] is exact.
fn roomy([low, high]: [f64; 2]) -> [f64; 2] {
    /// Half-width around a lone 0.
    const LONE: f64 = 1.0 / 1_048_576.0;
    /// Narrowest half-width against the distance from 0.
    const NARROW: f64 = 1.0 / (1u64 << 40) as f64;
    let far = low.abs().max(high.abs());
    let half = (0.5 * high - 0.5 * low).max(far * NARROW);
    let wanted = 1.25 * if half > 0.0 { half } else { LONE };
    let below = design::power_of_two(wanted);
    let half = if below < wanted { 2.0 * below } else { below };
    let step = 0.125 * half;
    let center = ((0.5 * low + 0.5 * high) / step).round() * step;
    [center - half, center + half]
}

/// Chebyshev polynomials on the box `new` in those on `old`.
fn rebased(axis: &Axis, old: [f64; 2], new: [f64; 2]) -> DMatrix<Dd> {
    let n = axis.size();
    if old == new {
        return DMatrix::from_fn(n, n, |i, j| if i == j { Dd::ONE } else { Dd::ZERO });
    }
    let family = Family::Chebyshev { low: new[0], high: new[1] };
    polynomial::change_of_basis(family, Mapping::over(old[0], old[1]), n)
}

/// Slopes of the caller's columns at a node.
struct Slopes {
    u: [Vec<f64>; 2],
    v: [Vec<f64>; 2],
}

impl Slopes {
    fn new(design: &Design) -> Self {
        let zeros = |axis: &Axis| [vec![0.0; axis.size()], vec![0.0; axis.size()]];
        match &design.basis {
            Basis::Product { u, v } => Slopes { u: zeros(u), v: zeros(v) },
            Basis::Columns { .. } => Slopes { u: Default::default(), v: Default::default() },
        }
    }

    /// Adds `w ((∂x/∂u)² + (∂x/∂v)²)` of every column (w for entries that are posted themselves).
    fn add(&mut self, design: &Design, sample: &Sample, k: usize, sums: &mut [f64]) {
        let weight = sample.w(k);
        let Basis::Product { u, v } = &design.basis else {
            sums.iter_mut().for_each(|sum| *sum += weight);
            return;
        };
        let (x, y) = sample.place(k);
        let ([fu, du], [fv, dv]) = (&mut self.u, &mut self.v);
        u.caller_row(x, fu, du);
        v.caller_row(y, fv, dv);
        perturbation::add_slopes(design, weight, [fu, du], [fv, dv], sums);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_have_room_and_map_exactly() {
        for [low, high] in [[0.0, 0.0], [30.0, 34.0], [-1e-9, 1e-9], [1e9, 1e9], [1e300, 1e300], [0.1, 0.3]] {
            let [a, b] = roomy([low, high]);
            assert!(a <= low && high <= b && a < b, "{low} {high}: {a} {b}");
            let map = Mapping::over(a, b);
            assert_eq!((map.map::<f64>(a), map.map::<f64>(b)), (-1.0, 1.0));
            assert_eq!(map.scale, design::power_of_two(map.scale));
        }
    }
}
