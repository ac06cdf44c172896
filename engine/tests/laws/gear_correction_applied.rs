//! Comparison with changes that were entered in place of the proposed ones, by simulation: how
//! often a machine that responds correctly is classified as anything else, and the response ratio
//! that is reported.

use crate::machines::{Plant, each};
use flankfit_engine::estimation::spec::Regularization;
use flankfit_engine::gear::correction::{Answer, Correction, Damping, Verdict, compare};

const SIX: Plant = Plant { grid: [5, 9], settings: 6, apart: 1.0, off: 10.0, sigma: 0.3, eta: 0.02, whole: false };

/// The changes entered, given the proposed ones.
type Entered = fn(&[f64]) -> Vec<f64>;

const FIRST_TWO: Entered = |change| change.iter().enumerate().map(|(j, c)| if j < 2 { *c } else { 0.0 }).collect();
const OF_ITS_OWN: Entered = |change| change.iter().enumerate().map(|(j, _)| if j < 2 { 3.0 } else { 0.0 }).collect();
const HALF: Entered = |change| change.iter().map(|c| 0.5 * c).collect();

/// Returns the responses of a machine on which `entered` was set: compared with these changes, and
/// with the proposal.
fn answers(plant: &Plant, entered: Entered, least_squares: bool, seed: u64) -> [Answer; 2] {
    let mut machine = plant.machine(seed);
    let before = machine.measure();
    let mut asked = plant.asked(&machine, before);
    if least_squares {
        asked.damping = Damping::Given(Regularization::None);
    }
    let correction = Correction::new(asked).unwrap();
    let solution = correction.solve().unwrap();
    let proposed: Vec<f64> = solution.settings.iter().map(|setting| setting.change).collect();
    let change = entered(&proposed);
    let share: Vec<f64> = change.iter().zip(&proposed).map(|(a, b)| (a / b).clamp(0.0, 1.0)).collect();
    let leverage = correction.leverage_of(&solution, &share).unwrap();
    machine.change(change.iter().copied());
    let measured = machine.measure();
    let noise = solution.noise.unwrap();
    [(change, leverage), (proposed, solution.leverage.clone())]
        .map(|(change, leverage)| compare(&correction.comparison(&change, leverage, noise, measured.clone())).unwrap())
}

/// At most 3 false alarms in 1,000 runs, and at most 18 in one set-up of 2,000, where at most 8 are
/// expected; the response ratio is 1 within four standard errors of its mean.
#[test]
fn the_entered_change_rarely_raises_a_false_alarm() {
    const PAIRS: u64 = 2000;
    let mut alarms = 0;
    for (name, plant, entered, least_squares) in [
        ("two of six", SIX, FIRST_TWO, false),
        ("two of six, least squares", SIX, FIRST_TWO, true),
        ("near the noise", Plant { off: 1.0, eta: 0.0, ..SIX }, FIRST_TWO, true),
        ("two others", SIX, OF_ITS_OWN, false),
        ("two others near the noise", Plant { off: 1.0, eta: 0.0, ..SIX }, OF_ITS_OWN, true),
        ("half", SIX, HALF, false),
        ("half near the noise", Plant { off: 1.5, eta: 0.0, ..SIX }, HALF, true),
    ] {
        let all = each(PAIRS, |seed| answers(&plant, entered, least_squares, seed));
        let alarm = |answer: &Answer| !matches!(answer.verdict, Verdict::AsPredicted | Verdict::Undecided);
        let [ours, proposal] = [0, 1].map(|which| all.iter().filter(|pair| alarm(&pair[which])).count());
        assert!(ours <= 18, "{name}: {ours}");
        alarms += ours;
        // without the entry, most machines raise a false alarm
        assert!(proposal > PAIRS as usize / 2, "{name}: {proposal}");
        let errors: Vec<f64> = all
            .iter()
            .filter_map(|[answer, _]| Some((answer.response_ratio? - 1.0) / answer.response_ratio_std_error?))
            .collect();
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let spread = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / count).sqrt();
        println!(
            "{name}: alarms {ours}, {proposal} with the proposal; {count} ratios, mean {mean:.3}, spread {spread:.3}"
        );
        assert!(count > 0.5 * PAIRS as f64, "{name}: {count}");
        assert!(mean.abs() < 4.0 / count.sqrt() + 0.02 && spread < 1.1, "{name}: {mean} {spread}");
    }
    assert!(alarms as u64 <= 3 * 7 * PAIRS / 1000, "{alarms}");
}

/// Entering the changes as proposed gives the same comparison, bit for bit, as no entry.
#[test]
fn leverage_of_the_proposal_is_that_of_the_solution() {
    for seed in 0..50 {
        let mut machine = SIX.machine(seed);
        let before = machine.measure();
        let correction = Correction::new(SIX.asked(&machine, before)).unwrap();
        let solution = correction.solve().unwrap();
        let all = correction.leverage_of(&solution, &[1.0; 6]).unwrap();
        let none = correction.leverage_of(&solution, &[0.0; 6]).unwrap();
        assert_eq!(all, solution.leverage);
        assert!(none.iter().all(|h| *h == 0.0));
        // each setting has its part, and the parts make up the whole
        let parts: f64 = (0..6)
            .map(|j| {
                let only: Vec<f64> = (0..6).map(|k| f64::from(u8::from(k == j))).collect();
                correction.leverage_of(&solution, &only).unwrap().iter().sum::<f64>()
            })
            .sum();
        let whole: f64 = solution.leverage.iter().sum();
        assert!((parts - whole).abs() < 1e-9 * whole);
    }
}
