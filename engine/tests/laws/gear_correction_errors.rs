//! Errors that a correction reports, by simulation: standard errors cover 0.60 to 0.76 of the draws
//! for a nominal 0.683. Over 1,000 draws a coverage has itself a standard deviation of 0.015, so
//! that the bounds lie five of them away; seeds are fixed.

use crate::machines::{Machine, Plant, each, times};
use crate::oracle::random::Random;
use flankfit_engine::estimation::result::Coefficient;
use flankfit_engine::estimation::spec::Regularization;
use flankfit_engine::gear::correction::{Change, Correction, CorrectionSpec, Damping, ResponseErrors, Solution};
use nalgebra::{DMatrix, DVector};

const DRAWS: u64 = 1000;
const BASE: Plant = Plant { grid: [5, 9], settings: 6, apart: 1.0, off: 10.0, sigma: 0.3, eta: 0.0, whole: false };

/// Changes that the settings should have had: least squares of the machine's true response over
/// `free` settings, the others being changed as they were.
fn wanted(machine: &Machine, form: &[f64], solution: &Solution) -> Vec<Option<f64>> {
    let n = machine.off.len();
    let free: Vec<usize> = (0..n).filter(|&j| !solution.settings[j].limited).collect();
    let fixed: Vec<f64> = solution.settings.iter().map(|s| if s.limited { s.change } else { 0.0 }).collect();
    let flank: Vec<f64> =
        machine.flank().iter().zip(times(&machine.response, &fixed)).zip(form).map(|((a, b), c)| a + b + c).collect();
    let g = DMatrix::from_fn(flank.len(), free.len(), |k, i| machine.response[k * n + free[i]]);
    let x = g.svd(true, true).solve(&-DVector::from_vec(flank), 1e-14).unwrap();
    let mut all = vec![None; n];
    free.iter().zip(x.iter()).for_each(|(&j, x)| all[j] = Some(*x));
    all
}

struct Way {
    plant: Plant,
    plain: bool,
    errors: ResponseErrors,
    sigma_known: bool,
    limit: Option<f64>,
    /// Size of what no setting makes, µm.
    form: f64,
}

const PLAIN: Way =
    Way { plant: BASE, plain: true, errors: ResponseErrors::Independent, sigma_known: true, limit: None, form: 0.0 };

impl Way {
    fn asked(&self, machine: &Machine, measured: Vec<f64>) -> CorrectionSpec {
        let mut asked = self.plant.asked(machine, measured);
        asked.response_errors = self.errors;
        if self.plain {
            asked.damping = Damping::Given(Regularization::None);
        }
        if !self.sigma_known {
            asked.noise_sigma = None;
        }
        asked.settings[1].min = self.limit;
        asked.settings[1].max = self.limit.map(f64::abs);
        asked
    }
}

fn solve(asked: CorrectionSpec) -> Solution {
    Correction::new(asked).unwrap().solve().unwrap()
}

/// Share of the settings' errors within their standard errors, by setting.
fn coverage(way: &Way) -> Vec<f64> {
    let form: Vec<f64> =
        (0..way.plant.nodes()).map(|k| way.form * (1.7 * k as f64 + 0.05 * (k * k) as f64).sin()).collect();
    let draws = each(DRAWS, |seed| {
        let mut machine = way.plant.machine(seed);
        let measured = machine.measure().iter().zip(&form).map(|(d, f)| d + f).collect();
        let solution = solve(way.asked(&machine, measured));
        let wanted = wanted(&machine, &form, &solution);
        let within = |(s, w): (&Change, &Option<f64>)| w.map(|w| (s.change - w).abs() <= s.std_error.unwrap());
        solution.settings.iter().zip(&wanted).map(within).collect::<Vec<Option<bool>>>()
    });
    (0..way.plant.settings)
        .filter_map(|j| {
            let there: Vec<bool> = draws.iter().filter_map(|draw| draw[j]).collect();
            // a setting that is nearly always at its limit is no evidence
            (there.len() > 300).then(|| there.iter().filter(|within| **within).count() as f64 / there.len() as f64)
        })
        .collect()
}

/// With least squares the error is all random.
#[test]
fn standard_errors_have_their_coverage() {
    let eta = |eta: f64, whole: bool| Plant { eta, whole, ..BASE };
    let off = ResponseErrors::PerSetting;
    for (name, way) in [
        ("noise alone", PLAIN),
        ("noise alone, unknown", Way { sigma_known: false, ..PLAIN }),
        ("entries 5 % off", Way { plant: eta(0.05, false), ..PLAIN }),
        ("entries 20 % off", Way { plant: eta(0.2, false), ..PLAIN }),
        ("entries 20 % off, noise unknown", Way { plant: eta(0.2, false), sigma_known: false, ..PLAIN }),
        ("columns 5 % off", Way { plant: eta(0.05, true), errors: off, ..PLAIN }),
        ("columns 20 % off", Way { plant: eta(0.2, true), errors: off, ..PLAIN }),
        ("columns 20 % off, noise unknown", Way { plant: eta(0.2, true), errors: off, sigma_known: false, ..PLAIN }),
        ("entries 20 % off, form 3 µm", Way { plant: eta(0.2, false), form: 3.0, ..PLAIN }),
        ("entries 20 % off, one limited", Way { plant: eta(0.2, false), limit: Some(-4.0), ..PLAIN }),
        ("columns 20 % off, one limited", Way { plant: eta(0.2, true), errors: off, limit: Some(-4.0), ..PLAIN }),
        ("small changes", Way { plant: Plant { off: 0.3, ..eta(0.2, false) }, ..PLAIN }),
        ("nearly parallel settings", Way { plant: Plant { apart: 0.05, ..eta(0.02, false) }, ..PLAIN }),
        ("default, well conditioned", Way { plant: eta(0.02, false), plain: false, ..PLAIN }),
    ] {
        let found = coverage(&way);
        assert!(found.len() >= 5 && found.iter().all(|c| (0.60..=0.76).contains(c)), "{name}: {found:?}");
        println!("{name}: {found:.2?}");
    }
}

/// Regularised: the standard error is that of the correction about its own average, and with the
/// bias bound it covers what is wanted.
#[test]
fn regularised_errors_are_about_their_average_and_bounds_do_the_rest() {
    for (name, plant) in [
        ("near mixture", Plant { apart: 1e-3, eta: 0.02, ..BASE }),
        ("near mixture, 20 % off", Plant { apart: 1e-2, eta: 0.2, ..BASE }),
        ("collinear, noisy", Plant { apart: 0.03, eta: 0.01, sigma: 1.0, off: 5.0, ..BASE }),
        ("nearly exact, collinear", Plant { apart: 1e-5, eta: 0.005, ..BASE }),
    ] {
        let off = Random::new(7).normals(plant.settings).iter().map(|x| plant.off * x).collect::<Vec<f64>>();
        let j = plant.sensitivity();
        let n = plant.settings;
        let length = |c: usize| j.iter().skip(c).step_by(n).map(|x| x * x).sum::<f64>().sqrt();
        let norm = (0..n).map(|c| (off[c] * length(c)).powi(2)).sum::<f64>().sqrt();
        let draws = each(DRAWS, |seed| {
            let mut machine = plant.machine_off(off.clone(), Random::new(seed));
            let measured = machine.measure();
            let asked = CorrectionSpec { coefficient_norm_limit: Some(norm), ..plant.asked(&machine, measured) };
            solve(asked)
                .settings
                .iter()
                .map(|s| [s.change, s.std_error.unwrap(), s.bias_bound.unwrap()])
                .collect::<Vec<_>>()
        });
        let share = |count: usize| count as f64 / DRAWS as f64;
        let (mut own, mut whole) = (Vec::new(), Vec::new());
        for c in 0..n {
            let mean = draws.iter().map(|draw| draw[c][0]).sum::<f64>() / DRAWS as f64;
            own.push(share(draws.iter().filter(|draw| (draw[c][0] - mean).abs() <= draw[c][1]).count()));
            whole.push(share(
                draws.iter().filter(|draw| (draw[c][0] + off[c]).abs() <= draw[c][1] + draw[c][2]).count(),
            ));
        }
        println!("{name}: about the average {own:.2?}, with the bias bound {whole:.2?}");
        assert!(own.iter().all(|c| (0.60..=0.76).contains(c)), "{name}: {own:?}");
        assert!(whole.iter().all(|c| *c >= 0.64), "{name}: {whole:?}");
    }
}

/// Bounds that limits cap cover what is wanted within the limits as often as the sharp ones would.
#[test]
fn bounds_capped_by_limits_have_their_coverage() {
    for (name, plant) in [
        ("near mixture", Plant { apart: 1e-3, eta: 0.02, ..BASE }),
        ("collinear, noisy", Plant { apart: 0.03, eta: 0.01, sigma: 1.0, off: 5.0, ..BASE }),
    ] {
        let n = plant.settings;
        let draws = each(DRAWS, |seed| {
            let mut machine = plant.machine(seed);
            let mut random = Random::new(seed + 1_000_000);
            let measured = machine.measure();
            let mut asked = plant.asked(&machine, measured);
            for (c, setting) in asked.settings.iter_mut().enumerate() {
                // wide for some and narrow for others; what is wanted is anywhere between
                let width = if c % 2 == 0 { 10.0 } else { 1.0 } * plant.off;
                let below = width * random.normal().abs();
                setting.min = Some(-machine.off[c] - below);
                setting.max = Some(-machine.off[c] + width * random.normal().abs());
            }
            let solution = solve(asked);
            // with settings at their limits the others make up for them, and want something else
            let whole = solution.limited_fit.is_none() && solution.settings.iter().all(|s| !s.limited);
            let each = solution.settings.iter().zip(&solution.fit.coefficients).zip(&machine.off);
            let of = |((s, sharp), off): ((&Change, &Coefficient), &f64)| {
                let (bound, missed) = (s.bias_bound.unwrap(), (s.change + off).abs());
                (missed <= s.std_error.unwrap() + bound, bound < sharp.bias_bound)
            };
            whole.then(|| each.map(of).collect::<Vec<(bool, bool)>>())
        });
        let draws: Vec<Vec<(bool, bool)>> = draws.into_iter().flatten().collect();
        let mut all_capped = 0.0;
        for c in 0..n {
            let share = |of: &dyn Fn(&(bool, bool)) -> bool| {
                draws.iter().filter(|draw| of(&draw[c])).count() as f64 / draws.len() as f64
            };
            let (covered, capped) = (share(&|found| found.0), share(&|found| found.1));
            println!("{name}, setting {c}: {} draws, {covered:.2} covered, {capped:.2} capped", draws.len());
            assert!(covered >= 0.60, "{name}, setting {c}: {covered}");
            assert!(draws.iter().all(|draw| draw[c].0 || !draw[c].1), "a cap leaves nothing out");
            all_capped += capped;
        }
        assert!(draws.len() > 200 && all_capped > 0.2, "{name}: {} draws, {all_capped}", draws.len());
    }
}
