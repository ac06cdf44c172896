//! Fits whose errors are correlated or of unequal variance: from plain least squares to the problem
//! that the model of the errors makes of it, and on as any fit.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    conclude::{conclude, conclude_with},
    error_checks::{check, given},
    error_course::{Course, undetermined},
};
use crate::{
    data::{Heights, Nodes, Sample},
    design::Design,
    diagnostics::{dependence, outliers, within_range},
    error::FitError,
    error_model::{
        lines::Lines,
        mixture::Mixture,
        process::Whitening,
        sandwich::Sandwich,
        spread::ErrorSpread,
        unequal::{self, Rows},
        variance_spread::VarianceSpread,
        white::{white_heights, white_rows},
    },
    estimate::Frame,
    factor::{Factor, orthonormal_rows},
    problem::{Evidence, LinearProblem},
    result::{ErrorsReport, FitResult, GroupSigma, NotEnclosed, VarianceReport, Warning, Whiteness},
    spec::{Along, Errors, FitSpec, Include, Variance},
};
use flankfit_numerics::{Dd, check::Faults, triangular};

/// Numbers that rows may hold: 128 MB.
const MOST: usize = 8_000_000;
/// Products of a search for parameters, and of looks at every node: some seconds.
pub(super) const MOST_PRODUCTS: usize = 1_000_000_000;
/// Degrees of freedom below which the variance of a group is warned of.
const FEW_OF_GROUP: f64 = 3.0;
/// Degrees of freedom below which a power is warned of.
const FEW_OF_POWER: usize = 8;
/// Degrees of freedom that estimates of errors take at least.
const LEAST_FREEDOM: usize = 3;
/// Logarithms of a coordinate that differ by at most this are of one place: standard deviations of
/// any searched power then differ by less than residuals can show.
const LEVEL: f64 = 1e-9;

/// Messages for what residuals leave open.
const OPEN_GROUP: &str = "the residuals do not determine the variance of every group: join small groups";
const OPEN_POWER: &str = "the residuals determine no power between -6 and 6";

/// More nodes or coefficients than a model of the errors takes.
pub(super) fn too_large(nodes: usize, coefficients: usize) -> String {
    format!("this model of the errors takes too long for {nodes} nodes and {coefficients} coefficients")
}

/// Fits nodes whose errors are as `spec` says.
pub(super) fn fit_errors(nodes: &Nodes, sample: &Sample, spec: &FitSpec) -> Result<FitResult, FitError> {
    check(nodes, spec)?;
    let (spec, warnings) = with_what_exists(spec);
    let mut result = fit_checked(nodes, sample, &spec)?;
    result.warnings.extend(warnings);
    Ok(result)
}

/// The spec without what is included but does not exist where errors are not white.
fn with_what_exists(spec: &FitSpec) -> (FitSpec, Vec<Warning>) {
    let (mut spec, mut warnings) = (spec.clone(), Vec::new());
    let correlated = spec.errors.as_ref();
    let known = correlated.is_none_or(|errors| given(errors.correlation, errors.along).is_some());
    let sandwich = spec.variance == Variance::Hc3;
    if spec.include.influence && (correlated.is_some() || sandwich) {
        spec.include.influence = false;
        warnings.push(Warning::NoInfluenceOfErrors);
    }
    if spec.include.predicted_mse && (!known || sandwich) {
        spec.include.predicted_mse = false;
        warnings.push(Warning::NoCorrectedError);
    }
    if spec.include.enclosure {
        spec.include.enclosure = false;
        warnings.push(Warning::NoEnclosure { reason: NotEnclosed::OtherFit });
    }
    if let Some(asked) = &mut spec.predict
        && asked.kinds.prediction
        && spec.variance != Variance::Constant
    {
        asked.kinds.prediction = false;
        warnings.push(Warning::NoPredictionIntervals);
    }
    (spec, warnings)
}

fn fit_checked(nodes: &Nodes, sample: &Sample, spec: &FitSpec) -> Result<FitResult, FitError> {
    let design = Design::new(nodes, sample, spec)?;
    let heights = Heights::new(sample);
    within_range(nodes.heights(), &heights)?;
    let (m, n) = (sample.count(), design.size());
    let field = if spec.errors.is_some() { "errors" } else { "variance" };
    if m.saturating_mul(n + 2) > MOST {
        return Err(Faults::one(field, too_large(m, n)).into());
    }
    // with unknown variances every place needs every node
    let places = spec.predict.as_ref().filter(|_| spec.variance == Variance::Hc3).map_or(0, |asked| asked.at.count());
    let most = MOST_PRODUCTS / m.saturating_mul(n).max(1);
    if places > most {
        return Err(Faults::one(
            "predict.at",
            format_args!("{places} places; a fit of this size allows at most {most}"),
        )
        .into());
    }
    // a given model of the errors needs no residuals
    let known = match &spec.errors {
        Some(errors) => given(errors.correlation, errors.along).is_some(),
        None => matches!(spec.variance, Variance::Power { exponent: Some(_), .. }),
    };
    let least = if known && spec.noise_sigma.is_some() { 0 } else { LEAST_FREEDOM };
    if m < n + least {
        return Err(Faults::one(
            field,
            format_args!("{m} nodes for {n} coefficients leave too little to estimate the errors from"),
        )
        .into());
    }
    let factor = Factor::new(&design, sample)?;
    if factor.working.is_none() {
        return Err(dependence(&design, &factor, heights.weight));
    }
    if !known && factor.rss == 0.0 {
        return Err(Faults::one(
            field,
            "the model fits every height exactly, so the errors cannot be estimated: omit this",
        )
        .into());
    }
    let plain = Plain { nodes, sample, spec, design: &design, heights: &heights, factor: &factor };
    match (&spec.errors, &spec.variance) {
        (Some(errors), _) => plain.correlated(errors),
        (None, Variance::Hc3) => plain.sandwich(),
        (None, Variance::Groups(groups)) => plain.groups(groups),
        (None, Variance::Power { of, exponent }) => plain.power(*of, *exponent),
        (None, Variance::Constant) => conclude_plain(&plain),
    }
}

fn conclude_plain(plain: &Plain) -> Result<FitResult, FitError> {
    let frame = Frame::new(plain.design, plain.factor, plain.spec, plain.heights.weight)?;
    conclude(&plain.linear(), plain.heights, plain.spec, &frame, None)
}

/// Plain least squares, where every model of the errors begins.
pub(super) struct Plain<'a> {
    pub(super) nodes: &'a Nodes,
    pub(super) sample: &'a Sample<'a>,
    pub(super) spec: &'a FitSpec,
    pub(super) design: &'a Design,
    pub(super) heights: &'a Heights,
    pub(super) factor: &'a Factor,
}

impl Plain<'_> {
    fn linear(&self) -> LinearProblem<'_> {
        let evidence = Evidence::Posted { sample: self.sample, nodes: self.nodes };
        LinearProblem { design: self.design, factor: self.factor, heights: self.heights.about_zero, evidence }
    }

    fn working(&self) -> &[Dd] {
        self.factor.working.as_deref().unwrap_or(&[])
    }

    /// Residuals times the root of the weight, by counted node.
    fn residuals(&self) -> Vec<f64> {
        let found = self.linear().of_working(self.working(), true).values.unwrap_or_default();
        found.iter().enumerate().map(|(k, r)| r * self.sample.w(k).sqrt()).collect()
    }

    pub(super) fn orthonormal(&self) -> Vec<f64> {
        orthonormal_rows(self.design, self.factor, self.sample)
    }

    /// Generalised least squares.
    fn correlated(&self, errors: &Errors) -> Result<FitResult, FitError> {
        let refused = || {
            let known = given(errors.correlation, errors.along).is_some();
            FitError::from(match known {
                true => Faults::one(
                    "errors.parameters",
                    "with these parameters heights determine their neighbours to rounding: give a weaker correlation",
                ),
                false => undetermined(),
            })
        };
        let residuals = self.residuals();
        let Course { along, lines, process, mixture } = self.course(errors, &residuals)?;
        let std_errors = mixture.as_ref().map(|mixture| mixture.std_errors);
        let at_end = mixture.as_ref().and_then(|mixture| mixture.at_end);
        let whitening = Whitening::new(&process, &lines).ok_or_else(refused)?;
        let rows = white_rows(self.design, self.sample, &lines, &whitening);
        let heights = white_heights(&rows, self.heights);
        let sample = self.sample.whitened(&rows);
        let white = Factor::new(self.design, &sample)?;
        if white.working.is_none() {
            return Err(dependence(self.design, &white, heights.weight));
        }
        let (factor, spread) = match mixture {
            None => (white, None),
            Some(mixture) => {
                let factor = self.averaged(&white, &sample, &heights, &mixture);
                let spread = ErrorSpread::of_mixture(mixture, &white.r, self.factor);
                (factor, Some(spread.ok_or_else(refused)?))
            }
        };
        let evidence = Evidence::Posted { sample: &sample, nodes: self.nodes };
        let linear = LinearProblem { design: self.design, factor: &factor, heights: heights.about_zero, evidence };
        let errors = Some(Errors { along, ..errors.clone() });
        let spec = FitSpec { include: Include { residuals: true, ..self.spec.include }, errors, ..self.spec.clone() };
        let frame = Frame::new(self.design, &factor, &spec, heights.weight)?;
        let mut result = conclude_with(&linear, &heights, &spec, &frame, None, spread.as_ref())?;
        result.warnings.extend(at_end.map(|correlation| Warning::CorrelationAtBound { correlation }));
        result.warnings.extend(outliers(&self.linear(), self.heights.largest).map(Warning::OutliersSuspected));
        let left = result.residuals.values.take().unwrap_or_default();
        // as many coefficients as nodes leave rounding
        let lags = if left.len() > self.design.size() { Whiteness::lags(&lines) } else { 0 };
        let whiteness = |residuals: &[f64]| Whiteness::of(residuals, &lines, lags);
        result.errors = Some(ErrorsReport::new(
            process.correlation(),
            along,
            process.along_v(),
            std_errors,
            heights.weight * sample.count() as f64 / self.heights.weight,
            whiteness(&residuals).zip(whiteness(&left)).map(|(before, after)| [before, after]),
            lags,
        ));
        self.in_heights(&mut result, left, &lines, &whitening);
        Ok(result)
    }

    /// The white problem with the mean of the mixture as its solution.
    fn averaged(&self, white: &Factor, sample: &Sample, heights: &Heights, mixture: &Mixture) -> Factor {
        let mut working: Vec<Dd> = mixture.step.iter().map(|&x| Dd::from(x)).collect();
        triangular::solve_upper(&self.factor.r, &mut working);
        working.iter_mut().zip(self.working()).for_each(|(c, plain)| *c += *plain);
        let mut factor = white.with_working(working.clone());
        let evidence = Evidence::Posted { sample, nodes: self.nodes };
        let linear = LinearProblem { design: self.design, factor: white, heights: heights.about_zero, evidence };
        let found = linear.of_working(&working, false);
        (factor.rss, factor.max_abs) = (found.rss, found.max_abs);
        factor
    }

    /// Residuals of the heights in place of white ones.
    fn in_heights(&self, result: &mut FitResult, white: Vec<f64>, lines: &Lines, whitening: &Whitening) {
        let mut along: Vec<f64> = lines.nodes.iter().map(|&k| white[k]).collect();
        whitening.colour(&mut along);
        let mut values = white;
        let (mut squares, mut largest) = (0.0, 0.0f64);
        for (&k, r) in lines.nodes.iter().zip(along) {
            squares += r * r;
            values[k] = r / self.sample.w(k).sqrt();
            largest = largest.max(values[k].abs());
        }
        let report = &mut result.residuals;
        report.rms = (squares / self.heights.weight).sqrt();
        report.max_abs = Some(largest);
        let wanted = self.spec.include.residuals;
        report.values = wanted.then_some(values);
        report.node_indices = report.node_indices.take().filter(|_| wanted);
    }

    /// Least squares with the sandwich about it.
    fn sandwich(&self) -> Result<FitResult, FitError> {
        let found = Sandwich::new(self.design.size(), self.orthonormal(), &self.residuals());
        let Some(spread) = found.and_then(ErrorSpread::of_sandwich) else {
            return Err(Faults::one(
                "variance",
                "a coefficient depends on one node alone: its residual does not show its variance",
            )
            .into());
        };
        let frame = Frame::new(self.design, self.factor, self.spec, self.heights.weight)?;
        conclude_with(&self.linear(), self.heights, self.spec, &frame, None, Some(&spread))
    }

    fn groups(&self, groups: &[i64]) -> Result<FitResult, FitError> {
        let (q, residuals) = (self.orthonormal(), self.residuals());
        let rows = Rows { n: self.design.size(), q: &q, residuals: &residuals };
        let group: Vec<i64> = (0..residuals.len()).map(|k| groups[self.sample.posted(k)]).collect();
        let (count, most) = (group.iter().collect::<BTreeSet<_>>().len(), VarianceSpread::most(self.design.size()));
        if count > most {
            return Err(Faults::one(
                "variance",
                format_args!("{count} groups; a fit with so many coefficients allows at most {most}"),
            )
            .into());
        }
        let Some(weights) = unequal::groups(&rows, &group) else {
            return Err(Faults::one("variance", OPEN_GROUP).into());
        };
        let omega: Vec<f64> = group.iter().map(|g| weights[g]).collect();
        let places: BTreeMap<i64, usize> = weights.keys().enumerate().map(|(place, &g)| (g, place)).collect();
        let place: Vec<usize> = group.iter().map(|g| places[g]).collect();
        // a posterior has weights for known
        let alone = weights.len() == 1 || self.spec.prior.is_some();
        let estimated = Estimated::Groups { place: &place, count: weights.len() };
        let (mut result, few) = self.weighted(&omega, (!alone).then_some(estimated))?;
        if let Some((place, freedom)) = few.filter(|(_, freedom)| *freedom < FEW_OF_GROUP) {
            let group = weights.keys().nth(place).copied().unwrap_or(0);
            result.warnings.push(Warning::GroupVarianceUncertain { group, degrees_of_freedom: freedom });
        }
        let sigma = result.residuals.sigma.unwrap_or(0.0);
        let sigmas = weights.iter().map(|(&group, &w)| GroupSigma { group, sigma: sigma / w.sqrt() }).collect();
        result.variance = Some(VarianceReport { groups: Some(sigmas), exponent: None, at: None });
        Ok(result)
    }

    fn power(&self, of: Along, exponent: Option<f64>) -> Result<FitResult, FitError> {
        let places: Vec<f64> = (0..self.sample.count())
            .map(|k| if of == Along::V { self.sample.place(k).1.abs() } else { self.sample.place(k).0.abs() })
            .collect();
        if places.contains(&0.0) {
            return Err(Faults::one(
                "variance.power_of",
                "a node lies at 0, where a power of the coordinate gives no variance",
            )
            .into());
        }
        let middle = libm::exp(places.iter().map(|x| libm::log(*x)).sum::<f64>() / places.len() as f64);
        let x: Vec<f64> = places.iter().map(|x| x / middle).collect();
        let logs: Vec<f64> = x.iter().map(|x| libm::log(*x)).collect();
        // a given power is known, and a posterior takes weights as known
        let estimated = exponent.is_none() && self.spec.prior.is_none();
        let exponent = match exponent {
            Some(exponent) => exponent,
            None => {
                let ends = logs.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &x| [a.min(x), b.max(x)]);
                if ends[1] - ends[0] <= LEVEL {
                    return Err(Faults::one(
                        "variance.power_of",
                        "the coordinate is the same at every node, so no power of it can be estimated: use another \
                         one, groups or hc3",
                    )
                    .into());
                }
                let (q, residuals) = (self.orthonormal(), self.residuals());
                let rows = Rows { n: self.design.size(), q: &q, residuals: &residuals };
                unequal::exponent(&rows, &logs).ok_or_else(|| Faults::one("variance", OPEN_POWER))?
            }
        };
        let omega: Vec<f64> = x.iter().map(|x| libm::pow(*x, -2.0 * exponent)).collect();
        let (mut result, _) = self.weighted(&omega, estimated.then_some(Estimated::Power { logs: &logs }))?;
        let freedom = self.sample.count() - self.design.size();
        if estimated && freedom < FEW_OF_POWER {
            result
                .warnings
                .push(Warning::PowerUncertain { degrees_of_freedom: freedom, more_nodes: FEW_OF_POWER - freedom });
        }
        result.variance = Some(VarianceReport { groups: None, exponent: Some(exponent), at: Some(middle) });
        Ok(result)
    }

    /// Least squares with the weights of the nodes times ω, by counted node, and what of them was
    /// estimated. Of groups also the one whose variance is known least, and on how many degrees of
    /// freedom that rests.
    fn weighted(
        &self,
        omega: &[f64],
        estimated: Option<Estimated>,
    ) -> Result<(FitResult, Option<(usize, f64)>), FitError> {
        if omega.iter().all(|w| *w == 1.0) && estimated.is_none() {
            return Ok((conclude_plain(self)?, None));
        }
        let mut weights = vec![0.0; self.nodes.posted()];
        for (k, omega) in omega.iter().enumerate() {
            weights[self.sample.posted(k)] = self.sample.w(k) * omega;
        }
        let sample = self.sample.reweighted(&weights);
        let heights = Heights::new(&sample);
        within_range(self.nodes.heights(), &heights)?;
        let factor = Factor::new(self.design, &sample)?;
        if factor.working.is_none() {
            return Err(dependence(self.design, &factor, heights.weight));
        }
        let evidence = Evidence::Posted { sample: &sample, nodes: self.nodes };
        let linear = LinearProblem { design: self.design, factor: &factor, heights: heights.about_zero, evidence };
        let frame = Frame::new(self.design, &factor, self.spec, heights.weight)?;
        let Some(estimated) = estimated else {
            return Ok((conclude(&linear, &heights, self.spec, &frame, None)?, None));
        };
        let undetermined = || FitError::from(Faults::one("variance", estimated.open()));
        let (m, n) = (sample.count(), self.design.size());
        let rows = orthonormal_rows(self.design, &factor, &sample);
        let (found, few) = match estimated {
            Estimated::Groups { place, count } => {
                let found = VarianceSpread::of_groups(n, &rows, place, count).ok_or_else(undetermined)?;
                let few = found.least_freedom();
                (found, Some(few))
            }
            Estimated::Power { logs } => (VarianceSpread::of_power(n, &rows, logs).ok_or_else(undetermined)?, None),
        };
        let sigma = (factor.rss / (m - n) as f64).sqrt();
        let spread = ErrorSpread::of_variances(found, sigma).ok_or_else(undetermined)?;
        Ok((conclude_with(&linear, &heights, self.spec, &frame, None, Some(&spread))?, few))
    }
}

/// Estimated part of the weights, by counted node.
#[derive(Clone, Copy)]
enum Estimated<'a> {
    /// The variances of groups: the place of each node's group among so many.
    Groups { place: &'a [usize], count: usize },
    /// The power of a coordinate with these logarithms.
    Power { logs: &'a [f64] },
}

impl Estimated<'_> {
    /// Message if the residuals do not determine it.
    fn open(self) -> &'static str {
        match self {
            Estimated::Groups { .. } => OPEN_GROUP,
            Estimated::Power { .. } => OPEN_POWER,
        }
    }
}
