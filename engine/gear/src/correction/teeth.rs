//! The mean of a flank over several teeth, and what their scatter says of its errors.
//!
//! A machine moves all teeth alike, while teeth differ from each other by far more than noise. A
//! correction of the gear is therefore made for the mean over t teeth, node by node. Where a tooth
//! was measured at other places, its least-squares surface of second order over roll length and z
//! is evaluated at the nodes of the mean; that surface holds whatever the settings of a machine and
//! the figures of a flank have a part in.
//!
//! With s² the variance between teeth at a node and v̄ the mean variance of noise in one tooth, the
//! mean at a node has the variance `max(s², v̄)/t`. (s² is of measured teeth and holds the noise
//! already; s² + v̄ would count it twice.) Teeth scatter by whole shapes, such as their slopes,
//! rather than node by node. So the covariance of the mean is estimated along an orthonormal basis
//! of the surfaces of second order, from t − 1 degrees of freedom along each of them: [`Scatter`].
//! Standard errors of settings and figures are the greater of those by noise and those by scatter.
//! Where places are not known, as with a matrix, the covariance is the empirical one of the teeth.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::{machine::FlankNode, scatter::Scatter};
use flankfit_numerics::{cancel::Asking, qr_with_rhs, svd};

/// Places that are equal within this, mm, are one node.
const SAME_PLACE: f64 = 1e-3;
/// Terms of a surface of second order.
const TERMS: usize = 6;
/// Share below which a singular value or what is left of a column is none.
const RANK: f64 = 1e-8;

/// The flank of one tooth as it was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Tooth {
    /// µm for each node, NaN where undefined.
    pub deviation: Vec<f64>,
    /// ≥ 0 for each node; 0 leaves a node out.
    pub weight: Option<Vec<f64>>,
    /// Places of the nodes; `None` where only their order is known.
    pub places: Option<Vec<FlankNode>>,
}

/// The nodes that a mean is taken at, and the zeros of their deviations.
#[derive(Clone, Copy, Debug)]
pub struct MeanNodes<'a> {
    /// How many nodes there are.
    pub count: usize,
    /// Places of the nodes.
    pub places: Option<&'a [FlankNode]>,
    /// Whether deviations have a datum. Where they have none, teeth are compared about their means.
    pub absolute: bool,
    /// Without a datum: the trace of each node, where every trace has a zero of its own.
    pub traces: Option<&'a [usize]>,
}

/// The mean of a flank over teeth.
#[derive(Clone, Debug, PartialEq)]
pub struct TeethMean {
    /// µm for each node, NaN where no tooth is defined.
    pub deviation: Vec<f64>,
    /// Relative weight of each node; `None` where all are alike.
    pub weight: Option<Vec<f64>>,
    /// How many teeth there are.
    pub count: usize,
    /// Standard deviation between teeth at a node, root mean square over the nodes, µm; `None` of
    /// one tooth.
    pub spread: Option<f64>,
    /// Standard deviation of noise at a node of one tooth, µm, by what surfaces of second order
    /// leave of the teeth; `None` where the places are not known.
    pub noise: Option<f64>,
    /// Deviation of each tooth from the mean, µm for each node, 0 where undefined.
    residuals: Vec<Vec<f64>>,
}

/// A tooth that was measured at other places and whose nodes do not determine a surface of second
/// order, or have traces with a zero each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unmatched {
    /// Place in the list of teeth.
    pub tooth: usize,
}

impl TeethMean {
    /// The mean of `teeth` at `nodes`.
    ///
    /// ```
    /// use flankfit_gear::correction::teeth::{MeanNodes, TeethMean, Tooth};
    ///
    /// let tooth = |deviation: [f64; 2]| {
    ///     Tooth { deviation: deviation.to_vec(), weight: None, places: None }
    /// };
    /// let nodes = MeanNodes { count: 2, places: None, absolute: true, traces: None };
    /// let mean = TeethMean::of(&[tooth([1.0, 4.0]), tooth([3.0, 4.0])], nodes)?;
    /// assert_eq!(mean.deviation, [2.0, 4.0]);
    /// // Variances 2 and 0 at the two nodes.
    /// assert_eq!(mean.spread, Some(1.0));
    /// # Ok::<(), flankfit_gear::correction::teeth::Unmatched>(())
    /// ```
    pub fn of(teeth: &[Tooth], nodes: MeanNodes<'_>) -> Result<Self, Unmatched> {
        let mut noise = Vec::new();
        let mut aligned: Vec<Aligned> = Vec::with_capacity(teeth.len());
        for (index, tooth) in teeth.iter().enumerate() {
            let one = Aligned::of(tooth, nodes, &mut noise).ok_or(Unmatched { tooth: index })?;
            aligned.push(one);
        }
        if !nodes.absolute {
            centre(&mut aligned, nodes);
        }
        let (mut deviation, mut weight) = (vec![f64::NAN; nodes.count], vec![0.0; nodes.count]);
        let mut residuals = vec![vec![0.0; nodes.count]; teeth.len()];
        let (mut variance, mut spread_nodes) = (0.0, 0usize);
        for k in (0..nodes.count).asking(teeth.len()) {
            let defined: Vec<&Aligned> = aligned.iter().filter(|one| !one.values[k].is_nan()).collect();
            if defined.is_empty() {
                continue;
            }
            let count = defined.len() as f64;
            let mean = defined.iter().map(|one| one.values[k]).sum::<f64>() / count;
            deviation[k] = mean;
            // Σ 1/w of the teeth is what the variance of their sum is proportional to
            let inverse: f64 = defined.iter().map(|one| 1.0 / one.weight(k)).sum();
            weight[k] = count * count / (inverse * teeth.len() as f64);
            for (residual, one) in residuals.iter_mut().zip(&aligned).filter(|(_, one)| !one.values[k].is_nan()) {
                residual[k] = one.values[k] - mean;
            }
            if defined.len() > 1 {
                variance += residuals.iter().map(|residual| residual[k].powi(2)).sum::<f64>() / (count - 1.0);
                spread_nodes += 1;
            }
        }
        let alike = weight.iter().zip(&deviation).all(|(weight, d)| d.is_nan() || *weight == 1.0);
        let noise = (!noise.is_empty()).then(|| (noise.iter().sum::<f64>() / noise.len() as f64).sqrt());
        Ok(TeethMean {
            deviation,
            weight: (!alike).then_some(weight),
            count: teeth.len(),
            spread: (spread_nodes > 0).then(|| (variance / spread_nodes as f64).sqrt()),
            noise,
            residuals,
        })
    }

    /// The deviations of one tooth as they were measured, of which nothing else is known.
    pub fn one(deviation: Vec<f64>, weight: Option<Vec<f64>>) -> Self {
        TeethMean { deviation, weight, count: 1, spread: None, noise: None, residuals: Vec::new() }
    }

    /// Variance at a node of one tooth: max(s², v̄).
    fn variance(&self) -> f64 {
        let square = |sigma: Option<f64>| sigma.map_or(0.0, |sigma| sigma * sigma);
        square(self.spread).max(square(self.noise))
    }

    /// Standard error of the mean at a node, µm; `None` where nothing is known of it.
    pub fn std_error(&self) -> Option<f64> {
        self.spread.or(self.noise)?;
        Some((self.variance() / self.count as f64).sqrt())
    }
}

/// The deviations of a tooth at the nodes of the mean.
struct Aligned {
    values: Vec<f64>,
    weight: Option<Vec<f64>>,
}

impl Aligned {
    /// `None` where the tooth was measured elsewhere and has no surface. The variance of its noise
    /// is added to `noise`, for as many nodes as the mean has.
    fn of(tooth: &Tooth, nodes: MeanNodes<'_>, noise: &mut Vec<f64>) -> Option<Self> {
        let at_nodes = match (nodes.places, &tooth.places) {
            (Some(wanted), Some(own)) => is_same(wanted, own),
            _ => tooth.deviation.len() == nodes.count,
        };
        let weight = |k: usize| tooth.weight.as_ref().map_or(1.0, |weight| weight[k]);
        let counted = |k: usize| if weight(k) > 0.0 { tooth.deviation[k] } else { f64::NAN };
        let values: Vec<f64> = (0..tooth.deviation.len()).map(counted).collect();
        let surface = match (nodes.traces, &tooth.places) {
            (None, Some(places)) => Surface::through(places, &values),
            _ => None,
        };
        noise.extend(surface.as_ref().and_then(|surface| {
            // fewer nodes than the mean has must not seem to know more
            let share = if at_nodes { 1.0 } else { nodes.count as f64 / surface.nodes as f64 };
            Some(share * surface.variance?)
        }));
        if at_nodes {
            return Some(Aligned { values, weight: tooth.weight.clone() });
        }
        let surface = surface.filter(|surface| surface.full)?;
        Some(Aligned { values: nodes.places?.iter().map(|place| surface.at(place)).collect(), weight: None })
    }

    fn weight(&self, k: usize) -> f64 {
        self.weight.as_ref().map_or(1.0, |weight| weight[k])
    }
}

fn is_same(a: &[FlankNode], b: &[FlankNode]) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= SAME_PLACE;
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(a.roll_length, b.roll_length) && near(a.z, b.z))
}

/// Moves the teeth to their common mean, of each trace by itself, over the nodes that all of them
/// have.
fn centre(teeth: &mut [Aligned], nodes: MeanNodes<'_>) {
    let group = |k: usize| nodes.traces.map_or(0, |traces| traces[k]);
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for k in (0..nodes.count).asking(teeth.len()) {
        groups.entry(group(k)).or_default().push(k);
    }
    for own in groups.values().asking(teeth.len()) {
        let common: Vec<usize> =
            own.iter().copied().filter(|&k| teeth.iter().all(|one| !one.values[k].is_nan())).collect();
        if common.is_empty() {
            continue;
        }
        let mean = |one: &Aligned| common.iter().map(|&k| one.values[k]).sum::<f64>() / common.len() as f64;
        let means: Vec<f64> = teeth.iter().map(mean).collect();
        let whole = means.iter().sum::<f64>() / means.len() as f64;
        for (one, mean) in teeth.iter_mut().zip(means) {
            own.iter().for_each(|&k| one.values[k] -= mean - whole);
        }
    }
}

/// A surface of second order over roll length and z by least squares.
struct Surface {
    ranges: [[f64; 2]; 2],
    coefficients: Vec<f64>,
    /// Whether the nodes determine every coefficient.
    full: bool,
    nodes: usize,
    /// Variance of the residuals; `None` without degrees of freedom.
    variance: Option<f64>,
}

impl Surface {
    fn through(places: &[FlankNode], values: &[f64]) -> Option<Self> {
        let ranges = ranges(places);
        let defined: Vec<usize> = (0..values.len().min(places.len())).filter(|&k| !values[k].is_nan()).collect();
        if defined.is_empty() {
            return None;
        }
        let rows: Vec<[f64; TERMS]> = defined.iter().map(|&k| terms(&places[k], ranges)).collect();
        let matrix = DMatrix::from_fn(rows.len(), TERMS, |i, j| rows[i][j]);
        let heights = DVector::from_iterator(rows.len(), defined.iter().map(|&k| values[k]));
        let found = qr_with_rhs(matrix, heights);
        let parts = svd(found.r)?;
        let least = RANK * parts.sigma.last()?;
        let determined: Vec<usize> = (0..TERMS).filter(|&i| parts.sigma[i] > least).collect();
        let along: Vec<f64> = determined
            .iter()
            .map(|&i| parts.us.column(i).dot(&found.qty) / (parts.sigma[i] * parts.sigma[i]))
            .collect();
        let coefficient = |j: usize| determined.iter().zip(&along).map(|(&i, a)| parts.v[(j, i)] * a).sum::<f64>();
        let coefficients: Vec<f64> = (0..TERMS).map(coefficient).collect();
        let left = |(row, &k): (&[f64; TERMS], &usize)| {
            values[k] - row.iter().zip(&coefficients).map(|(x, c)| x * c).sum::<f64>()
        };
        let rss: f64 = rows.iter().zip(&defined).map(left).map(|left| left * left).sum();
        let freedom = rows.len().saturating_sub(determined.len());
        Some(Surface {
            ranges,
            full: determined.len() == TERMS,
            nodes: rows.len(),
            variance: (freedom > 0).then(|| rss / freedom as f64),
            coefficients,
        })
    }

    fn at(&self, place: &FlankNode) -> f64 {
        terms(place, self.ranges).iter().zip(&self.coefficients).map(|(x, c)| x * c).sum()
    }
}

/// Ranges of the places in roll length and z; never without length.
fn ranges(places: &[FlankNode]) -> [[f64; 2]; 2] {
    let span = |of: fn(&FlankNode) -> f64| {
        let ends = places.iter().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
        if ends[0] < ends[1] { ends } else { [ends[0] - 1.0, ends[0] + 1.0] }
    };
    [span(|place| place.roll_length), span(|place| place.z)]
}

fn terms(place: &FlankNode, [profile, helix]: [[f64; 2]; 2]) -> [f64; TERMS] {
    let along = |x: f64, [from, to]: [f64; 2]| ((x - from) + (x - to)) / (to - from);
    let (u, v) = (along(place.roll_length, profile), along(place.z, helix));
    [1.0, u, v, u * u, u * v, v * v]
}

/// A flank that a scatter is made for.
#[derive(Clone, Debug)]
pub struct ScatterOf<'a> {
    /// The means that are subtracted from each other, or the only one.
    pub means: Vec<&'a TeethMean>,
    /// Places of the nodes.
    pub places: Option<&'a [FlankNode]>,
    /// Weight of its nodes against those of other flanks.
    pub weight: f64,
}

impl Scatter {
    /// The scatter of flanks whose nodes stand one behind the other. Means that are subtracted have
    /// the scatter of their teeth in common.
    pub fn of(flanks: &[ScatterOf<'_>]) -> Self {
        let count = |flank: &ScatterOf<'_>| flank.means.first().map_or(0, |mean| mean.deviation.len());
        let all: usize = flanks.iter().map(count).sum();
        let (mut scatter, mut before, mut square) = (Scatter::default(), 0, 0.0);
        for flank in flanks {
            let freedom: usize = flank.means.iter().map(|mean| mean.count.saturating_sub(1)).sum();
            if freedom > 0 {
                let least = if scatter.freedom == 0 { freedom } else { scatter.freedom.min(freedom) };
                scatter.freedom = least;
                for own in flank.columns(freedom) {
                    let mut column = vec![0.0; all];
                    column[before..before + own.len()].copy_from_slice(&own);
                    scatter.columns.push(column);
                }
            }
            if let Some(first) = flank.means.first() {
                let variance = first.variance() / first.count.max(1) as f64;
                square += flank.weight * variance * count(flank) as f64;
            }
            before += count(flank);
        }
        scatter.node = if all > 0 { (square / all as f64).sqrt() } else { 0.0 };
        scatter
    }
}

impl ScatterOf<'_> {
    fn columns(&self, freedom: usize) -> Vec<Vec<f64>> {
        let residuals: Vec<&Vec<f64>> = self.means.iter().flat_map(|mean| &mean.residuals).collect();
        let share = self.means.iter().map(|mean| 1.0 / mean.count.max(1) as f64).sum::<f64>() / freedom as f64;
        let scaled = |column: &[f64], factor: f64| column.iter().map(|x| factor * x).collect::<Vec<f64>>();
        let Some(places) = self.places else {
            return residuals.iter().map(|residual| scaled(residual, share.sqrt())).collect();
        };
        let defined = |k: usize| self.means.iter().all(|mean| !mean.deviation[k].is_nan());
        let basis = orthonormal(places, defined);
        let column = |shape: &Vec<f64>| {
            let square: f64 = residuals.iter().map(|residual| dot(shape, residual).powi(2)).sum();
            scaled(shape, (share * square).sqrt())
        };
        basis.iter().map(column).filter(|column| column.iter().any(|x| *x != 0.0)).collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// An orthonormal basis of the surfaces of second order over the nodes that are defined, 0
/// elsewhere (modified Gram and Schmidt, twice).
fn orthonormal(places: &[FlankNode], defined: impl Fn(usize) -> bool) -> Vec<Vec<f64>> {
    let ranges = ranges(places);
    let rows: Vec<[f64; TERMS]> = places
        .iter()
        .enumerate()
        .asking(TERMS)
        .map(|(k, place)| if defined(k) { terms(place, ranges) } else { [0.0; TERMS] })
        .collect();
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(TERMS);
    for j in 0..TERMS {
        let mut column: Vec<f64> = rows.iter().map(|row| row[j]).collect();
        let whole = dot(&column, &column).sqrt();
        for _ in 0..2 {
            for shape in &basis {
                let share = dot(shape, &column);
                column.iter_mut().zip(shape).for_each(|(x, s)| *x -= share * s);
            }
        }
        let length = dot(&column, &column).sqrt();
        if length > RANK * whole {
            column.iter_mut().for_each(|x| *x /= length);
            basis.push(column);
        }
    }
    basis
}
