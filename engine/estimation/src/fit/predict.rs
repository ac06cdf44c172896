//! Heights, slopes and bands at places of the domain.

use std::collections::BTreeMap;

use super::forms::{Estimated, Forms};
use crate::{
    design::{Along, Design},
    inference::{Among, Noise, SimultaneousMethod, Tube, path_length, scheffe, sheet, simultaneous_factor},
    regularized::LinearMap,
    result::{Predictions, Simultaneous, Slopes},
    spec::{Domain, FitSpec, Places, Predict},
};
use flankfit_numerics::{
    cancel::Asking,
    check::Faults,
    distribution::Student,
    length, triangular,
    words::{Shown, counted},
};

/// Products of places and coefficients at most: some seconds, and 100 MB.
const MOST_PRODUCTS: usize = 2_000_000;
/// Coefficients that every place counts for at least.
const LEAST_COEFFICIENTS: usize = 20;
/// Bands whose filter is chosen place by place count for so many others.
const CHOSEN: usize = 16;

/// Refuses levels and places that the fit of `design` does not have.
pub(crate) fn check(design: &Design, spec: &FitSpec) -> Result<(), Faults> {
    let mut faults = Faults::default();
    let mut level = |path: &str, level: f64| {
        if !(level > 0.5 && level < 1.0) {
            faults.push(path, format_args!("{} is not a level: it must be above 0.5 and below 1", Shown(level)));
        }
    };
    level("level", spec.level);
    if let Some(Predict { level: Some(own), .. }) = spec.predict {
        level("predict.level", own);
    }
    if let Some(asked) = &spec.predict {
        match (unsuited(design, spec, asked), &asked.at) {
            (Some(message), _) => faults.push("predict.at", message),
            (None, Places::Rows(rows)) => check_rows(design.size(), rows, asked.slopes, &mut faults),
            (None, _) => {}
        }
    }
    faults.into_result(())
}

fn check_rows(columns: usize, rows: &[Vec<f64>], slopes: bool, faults: &mut Faults) {
    if slopes {
        faults.push("predict.slopes", "columns have no slopes");
    }
    for (k, row) in rows.iter().enumerate().filter(|(_, row)| row.len() != columns) {
        faults.push(
            format_args!("predict.at.x[{k}]"),
            format_args!("{} in a row, where the matrix has {columns}", counted(row.len(), "number", "numbers")),
        );
    }
}

fn unsuited(design: &Design, spec: &FitSpec, asked: &Predict) -> Option<String> {
    let (at, places) = (&asked.at, asked.at.count());
    let each = if spec.coefficient_norm_limit.is_some() { CHOSEN } else { 1 };
    let most = MOST_PRODUCTS / design.size().max(LEAST_COEFFICIENTS) / each;
    let said = |message: &str| Some(message.to_owned());
    match (design.domain, at) {
        (None, Places::Curve(_) | Places::Points { .. } | Places::Grid { .. }) => {
            said("a measurement matrix has no places: give rows with its columns")
        }
        (Some(_), Places::Rows(_)) => said("rows are for a measurement matrix: give places of the curve or surface"),
        (Some(Domain { v: None, .. }), Places::Points { .. } | Places::Grid { .. }) => {
            said("a curve needs abscissae, not points of a surface")
        }
        (Some(Domain { v: Some(_), .. }), Places::Curve(_)) => {
            said("a surface needs points or a grid, not abscissae of a curve")
        }
        (_, Places::Points { u, v }) if u.len() != v.len() => {
            Some(format!("{} abscissae along u and {} along v: give equal numbers", u.len(), v.len()))
        }
        _ if places == 0 => said("there are no places"),
        _ if places > most => Some(format!("{places} places; a fit of this size allows at most {most}")),
        _ => None,
    }
}

/// Number of places outside the domain, where polynomials run away and nothing was measured.
pub(super) fn outside(design: &Design, at: &Places) -> usize {
    let beyond = |range: Option<[f64; 2]>, x: f64| range.is_some_and(|[low, high]| x < low || x > high);
    let Some(Domain { u, v }) = design.domain else { return 0 };
    (0..at.count()).filter_map(|k| at.at(k)).filter(|place| beyond(u, place[0]) || beyond(v, place[1])).count()
}

/// Bands of `asked` at its places; those whose figures leave the range of double are left out.
pub(super) fn predictions(forms: &Forms, asked: &Predict, level: f64) -> Predictions {
    let n = forms.linear.design.size();
    let mut places: Vec<[f64; 2]> = (0..asked.at.count()).filter_map(|k| asked.at.at(k)).collect();
    let at =
        |along: Along| -> Vec<Estimated> { places.iter().asking(n * n).map(|&place| forms.at(place, along)).collect() };
    let mut heights: Vec<Estimated> = match &asked.at {
        Places::Rows(rows) => rows.iter().asking(n * n).map(|row| forms.at_row(row)).collect(),
        _ => at(Along::Value),
    };
    let mut slopes: Vec<Vec<Estimated>> = match (asked.slopes, &asked.at) {
        (false, _) | (true, Places::Rows(_)) => vec![],
        (true, Places::Curve(_)) => vec![at(Along::U)],
        (true, _) => vec![at(Along::U), at(Along::V)],
    };
    let kept: Vec<usize> =
        (0..heights.len()).filter(|&k| is_finite(&heights[k]) && slopes.iter().all(|s| is_finite(&s[k]))).collect();
    let all = kept.len() == heights.len();
    if !all {
        let mut next = kept.iter().copied().peekable();
        let keeps: Vec<bool> = (0..heights.len()).map(|k| next.next_if_eq(&k).is_some()).collect();
        retain(&mut heights, &keeps);
        slopes.iter_mut().for_each(|found| retain(found, &keeps));
        if !places.is_empty() {
            retain(&mut places, &keeps);
        }
    }
    let slopes_of = |found: &Vec<Estimated>| Slopes {
        value: values(found),
        std_error: errors(forms, found),
        confidence: intervals(forms, found, 0.0),
    };
    let mut found = Predictions {
        place_indices: (!all).then_some(kept),
        level,
        value: values(&heights),
        std_error: errors(forms, &heights),
        bias_bound: heights.iter().map(|h| h.bias_bound).collect(),
        confidence: if asked.kinds.confidence { intervals(forms, &heights, 0.0) } else { None },
        prediction: forms
            .further
            .filter(|_| asked.kinds.prediction)
            .and_then(|sigma| intervals(forms, &heights, sigma)),
        simultaneous: forms
            .noise
            .filter(|_| asked.kinds.simultaneous && !heights.is_empty())
            .and_then(|noise| simultaneous(forms, &heights, &places, &noise)),
        slope_u: slopes.first().map(&slopes_of),
        slope_v: slopes.get(1).map(&slopes_of),
    };
    found.retain_finite();
    found
}

fn is_finite(one: &Estimated) -> bool {
    let errors = [one.conditional_error, one.least_squares_error].into_iter().flatten();
    errors.chain([one.value, one.bias_bound]).all(f64::is_finite)
}

fn retain<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    list.retain(|_| kept.next().copied().unwrap_or(false));
}

fn values(found: &[Estimated]) -> Vec<f64> {
    found.iter().map(|one| one.value).collect()
}

fn errors(forms: &Forms, found: &[Estimated]) -> Option<Vec<f64>> {
    found.iter().map(|one| forms.std_error(one)).collect()
}

fn intervals(forms: &Forms, found: &[Estimated], own: f64) -> Option<Vec<[f64; 2]>> {
    found.iter().asking(1000).map(|one| forms.interval(one, own)).collect()
}

/// A band about least squares, or about the mean of a posterior. Where r was given, and the filter
/// does not follow from the heights, also that about the estimate with its bias, and the narrower
/// of the two on the whole is taken: their widths know no heights but σ̂.
fn simultaneous(forms: &Forms, heights: &[Estimated], places: &[[f64; 2]], noise: &Noise) -> Option<Simultaneous> {
    let plain = band(forms, heights, places, noise, forms.posterior)?;
    // r bounds no bias of a constrained estimate
    let constrained = matches!(forms.map, LinearMap::Constrained { .. });
    if forms.given_limit.is_none() || forms.posterior || constrained || forms.chosen_by_heights {
        return Some(plain);
    }
    let width = |found: &Simultaneous| found.band.iter().map(|[low, high]| high - low).sum::<f64>();
    let aware = band(forms, heights, places, noise, true).filter(|aware| width(aware) < width(&plain));
    Some(aware.unwrap_or(plain))
}

fn band(
    forms: &Forms,
    heights: &[Estimated],
    places: &[[f64; 2]],
    noise: &Noise,
    biased: bool,
) -> Option<Simultaneous> {
    let n = forms.linear.design.size();
    let among = match places.is_empty() {
        true => Some(Among::Each(heights.len())),
        false => tube(forms, places, biased).map(Among::Tube),
    };
    let mut factors = Factors { n, among, whole: *noise, known: BTreeMap::new() };
    let band = heights
        .iter()
        .asking(1000)
        .map(|one| {
            if biased {
                let factor = factors.of(noise);
                if forms.posterior {
                    // the interval that by itself misses as often as this factor does
                    let miss = 2.0 * noise.student.upper_tail(factor);
                    return forms.of_posterior(one, &Noise { miss, ..*noise }, 0.0);
                }
                let half = factor * one.conditional_error? + one.bias_bound;
                return Some([one.value - half, one.value + half]);
            }
            let own = forms.noise_of(&one.form)?;
            let (middle, factor) = (forms.least_squares(&one.form), factors.of(&own));
            let half = factor * one.least_squares_error?;
            // of a mixture the standard error says less than the quantiles: the band of a place by
            // itself lies within the one of the whole
            let miss = own.miss;
            let alone = forms.errors.and_then(|errors| errors.interval(&one.form.q, middle, 0.0, miss));
            let [low, high] = alone.unwrap_or([middle; 2]);
            Some([low.min(middle - half), high.max(middle + half)])
        })
        .collect::<Option<Vec<_>>>()?;
    let (factor, method, scheffe) = factors.largest()?;
    Some(Simultaneous { band, factor, method, scheffe })
}

/// Factors of a band, by degrees of freedom.
struct Factors {
    n: usize,
    among: Option<Among>,
    /// With the degrees of freedom that places have unless they have their own.
    whole: Noise,
    known: BTreeMap<i64, (f64, SimultaneousMethod, f64)>,
}

impl Factors {
    /// The factor of a place. Degrees of freedom of its own are rounded down by a hundredth at
    /// most, so that they are few.
    fn of(&mut self, noise: &Noise) -> f64 {
        let freedom = noise.student.freedom();
        let own = freedom != self.whole.student.freedom();
        let step = (100.0 * libm::log(freedom)).floor();
        let key = if own { step as i64 } else { i64::MAX };
        let (factor, ..) = *self.known.entry(key).or_insert_with(|| {
            let student = Student::new(libm::exp(0.01 * step).max(1.0));
            let noise = if own { Noise { student, ..*noise } } else { self.whole };
            let (factor, method) = simultaneous_factor(self.n, self.among.as_ref(), &noise);
            (factor, method, scheffe(self.n, &noise))
        });
        factor
    }

    /// Largest factor that was requested, with its method and Scheffé's.
    fn largest(&self) -> Option<(f64, SimultaneousMethod, f64)> {
        self.known.values().copied().max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// Steps along an axis of the first look at a path or sheet, and at most.
const FIRST: usize = 32;
const MOST_OF_PATHS: usize = 4096;
const MOST_OF_SHEETS: usize = 128;
/// Products of a tube at most, of the plain band and of a filtered one: about a second. Beyond them
/// the band is Scheffé's.
const MOST_OF_TUBE: usize = 1_500_000_000;
/// Cost of a filtered row in plain ones.
const FILTERED: usize = 6;
/// Coefficients above which the unit vectors of a tube are found in doubles.
const BY_DOUBLES: usize = 32;
/// Relative change by twice the steps at which they are enough.
const SETTLED: f64 = 1e-3;

/// The path or sheet of unit vectors over the domain, widened to the requested places; `None` for a
/// robust estimate, whose errors do not follow from R alone.
fn tube(forms: &Forms, places: &[[f64; 2]], biased: bool) -> Option<Tube> {
    if forms.robust.is_some() || forms.errors.is_some_and(|errors| !errors.is_weighted()) {
        return None;
    }
    let design: &Design = forms.linear.design;
    let domain = design.domain?;
    let n = design.size();
    let vectors = if domain.v.is_some() { MOST_OF_SHEETS * MOST_OF_SHEETS } else { MOST_OF_PATHS };
    if 2 * vectors * n * n * if biased { FILTERED } else { 1 } > MOST_OF_TUBE {
        return None;
    }
    let root = (n > BY_DOUBLES && !biased).then(|| forms.linear.factor.r.map(|x| x.to_f64()));
    let widened = |axis: usize, range: [f64; 2]| {
        places.iter().fold(range, |[low, high], place| [low.min(place[axis]), high.max(place[axis])])
    };
    let u = widened(0, domain.u?);
    let v = domain.v.map(|v| widened(1, v));
    let place = |[low, high]: [f64; 2], k: usize, steps: usize| low + (high - low) * k as f64 / steps as f64;
    let unit = |at: [f64; 2]| {
        let row = match &root {
            Some(root) => {
                let mut row: Vec<f64> = design.row_at(at, Along::Value).iter().map(|x| x.to_f64()).collect();
                triangular::solve_upper_transposed(root, &mut row);
                row
            }
            None if biased => forms.at(at, Along::Value).row,
            None => forms.at(at, Along::Value).form.q,
        };
        let size = length(&row);
        row.iter().map(|x| if size > 0.0 { x / size } else { 0.0 }).collect::<Vec<f64>>()
    };
    let look = |steps: usize| match v {
        None => {
            let path: Vec<_> = (0..=steps).asking(4000).map(|k| unit([place(u, k, steps), 0.0])).collect();
            Tube { length: path_length(&path), area: 0.0 }
        }
        Some(v) => {
            let each = (0..(steps + 1) * (steps + 1)).asking(4000);
            let vectors: Vec<_> =
                each.map(|k| unit([place(u, k / (steps + 1), steps), place(v, k % (steps + 1), steps)])).collect();
            sheet(&vectors, steps + 1, steps + 1)
        }
    };
    let most = if v.is_some() { MOST_OF_SHEETS } else { MOST_OF_PATHS };
    let (mut steps, mut before) = (FIRST, look(FIRST));
    loop {
        steps *= 2;
        let now = look(steps);
        // errors fall with the square of the step: a third of the change is what is left
        let settled = |before: f64, now: f64| (now - before).abs() <= 3.0 * SETTLED * now;
        let better = |before: f64, now: f64| now + (now - before).max(0.0) / 3.0;
        let found = Tube { length: better(before.length, now.length), area: better(before.area, now.area) };
        if steps >= most || settled(before.length, now.length) && settled(before.area, now.area) {
            return Some(found);
        }
        before = now;
    }
}
