//! L-estimators, the minimax estimator and maximum likelihood on the stack loss data, against R
//! 4.2 (quantreg `rq`, `lm` on what it leaves, MASS `rlm`) and against mpmath 1.3, which solved the
//! score equations (`findroot` on derivatives of −ln L, 30 digits) from the simplex search of
//! scipy.

use crate::answers::{answer, matrix, plain, values};
use crate::folder::{numbers, reference};
use flankfit_engine::estimation::{
    FitResult, FitSpec, Nodes,
    spec::{Contamination, Distribution, Estimator, Include, LEstimator, MEstimator, Model, QuantileWeights},
};

fn stack_loss() -> Nodes {
    let data = &reference("robust_stackloss_lad")["data"];
    let columns = ["AirFlow", "WaterTemp", "AcidConc"].map(|name| numbers(&data[name]));
    let y = numbers(&data["StackLoss"]);
    let x: Vec<Vec<f64>> =
        (0..y.len()).map(|k| std::iter::once(1.0).chain(columns.iter().map(|c| c[k])).collect()).collect();
    matrix(&x, &y)
}

fn of(nodes: &Nodes, estimator: Estimator) -> FitResult {
    let include = Include { robust_weights: true, ..Include::default() };
    answer(nodes, &FitSpec { estimator, include, ..plain(Model::Linear) })
}

fn agree(name: &str, got: &[f64], wanted: &[f64], tolerance: f64) {
    assert_eq!(got.len(), wanted.len());
    for (a, b) in got.iter().zip(wanted) {
        assert!((a - b).abs() <= tolerance * b.abs(), "{name}: {a} {b}");
    }
}

/// R: `rq(tau = .1)`, `rq(tau = .9)`; `lm` of the nodes between them, and of heights clamped to
/// them; `.25*rq(.25) + .5*rq(.5) + .25*rq(.75)`.
#[test]
fn l_estimators_are_those_of_quantreg() {
    let nodes = stack_loss();
    let trimmed = of(&nodes, Estimator::L(LEstimator::Trimmed { share: 0.1 }));
    assert_eq!(trimmed.robust.as_ref().unwrap().rejected.as_ref().unwrap(), &[3]);
    let wanted = [-38.590_987_114_965_53, 0.766_963_482_895_995_1, 1.086_421_056_106_546, -0.156_009_045_834_666_2];
    agree("trimmed", &values(&trimmed), &wanted, 1e-12);
    let winsorized = of(&nodes, Estimator::L(LEstimator::Winsorized { share: 0.1 }));
    let wanted = [-39.365_200_747_571, 0.737_057_887_532_685_8, 1.208_124_772_708_055, -0.153_744_403_181_640_2];
    agree("winsorized", &values(&winsorized), &wanted, 1e-12);
    let weights = QuantileWeights::new(&[[0.25, 0.25], [0.5, 0.5], [0.75, 0.25]]).unwrap();
    let trimean = of(&nodes, Estimator::L(LEstimator::Quantiles(weights)));
    let wanted = [-42.392_341_329_335_36, 0.758_614_442_778_610_6, 0.782_646_176_911_545_8, -0.030_434_782_608_695_68];
    agree("trimean", &values(&trimean), &wanted, 1e-11);
}

/// R: `rlm(psi = psi.huber, k = 1.140171145835742, acc = 1e-15)`.
#[test]
fn the_minimax_estimator_is_hubers_with_its_k() {
    let found = of(&stack_loss(), Estimator::M(MEstimator::minimax(Contamination::Share(0.1))));
    let wanted = [-40.215_553_274_854_28, 0.825_419_074_807_799, 0.830_031_654_651_259_2, -0.112_830_633_967_792_5];
    agree("minimax", &values(&found), &wanted, 1e-10);
    let robust = found.robust.unwrap();
    assert!((robust.scale.unwrap() / 2.082_817_806_314_354 - 1.0).abs() < 1e-10);
    let minimax = robust.minimax.unwrap();
    assert!((minimax.variance / 1.489_854_475_671_965_6 - 1.0).abs() < 1e-12 && !minimax.estimated);
}

#[test]
fn likelihoods_are_at_the_roots_of_their_scores() {
    let nodes = stack_loss();
    let cases = [
        (
            Distribution::Student { freedom: Some(3.0) },
            [-39.123_944_334_333_76, 0.854_236_231_669_722_4, 0.656_756_878_913_994, -0.103_903_004_845_026],
            (1.755_493_994_603_479, 3.0, -51.068_109_963_628_71),
        ),
        (
            Distribution::Student { freedom: None },
            [-38.482_663_235_678_04, 0.851_989_945_866_388_8, 0.490_246_884_639_753_4, -0.070_564_886_569_463_3],
            (0.914_767_021_097_693_4, 1.076_701_216_030_881, -49.567_676_906_400_93),
        ),
        (
            Distribution::GeneralizedNormal { exponent: Some(1.5) },
            [-38.972_951_850_946_08, 0.794_211_350_055_212_7, 0.946_207_419_045_931_7, -0.133_885_909_913_522_1],
            (3.386_263_364_597_348, 1.5, -52.021_747_583_406_22),
        ),
    ];
    for (distribution, coefficients, (scale, shape, log_likelihood)) in cases {
        let found = of(&nodes, Estimator::Likelihood(distribution));
        let name = format!("{distribution:?}");
        agree(&name, &values(&found), &coefficients, 1e-7);
        let robust = found.robust.unwrap();
        let likelihood = robust.likelihood.unwrap();
        let got = [robust.scale.unwrap(), likelihood.shape.unwrap(), likelihood.log_likelihood];
        agree(&name, &got, &[scale, shape, log_likelihood], 1e-8);
        assert_eq!(robust.objective, -likelihood.log_likelihood);
    }
}

/// Errors that are quantiles of Student's distribution, shuffled: an exponent inside its range.
#[test]
fn an_estimated_exponent_is_at_the_root_too() {
    #[rustfmt::skip]
    let y = [
        -1.749057, 0.782442, 1.956437, 3.106083, 4.94318, 2.523802, 3.780226, 4.904313, 6.325196, 4.174804,
        5.595687, 6.719774, 7.976198, 5.55682, 7.393917, 8.543563, 9.717558, 12.249057, 9.160452, 10.368924,
        11.502332, 13.073501, 10.865843, 12.189476, 13.310524, 14.634157, 12.426499, 13.997668, 15.131076,
        16.339548,
    ];
    let x: Vec<Vec<f64>> = (0..30).map(|i| vec![1.0, f64::from(i)]).collect();
    let found = of(&matrix(&x, &y), Estimator::Likelihood(Distribution::GeneralizedNormal { exponent: None }));
    agree("coefficients", &values(&found), &[0.748_229_845_820_572_1, 0.517_131_543_875_063_1], 1e-5);
    let robust = found.robust.unwrap();
    let likelihood = robust.likelihood.unwrap();
    let got = [robust.scale.unwrap(), likelihood.shape.unwrap(), likelihood.log_likelihood];
    agree("scale, p, ln L", &got, &[1.460_397_223_286_66, 1.690_796_035_603_43, -46.489_605_784_425_31], 1e-6);
    // the inverse of Fisher's information by quadrature (scipy `quad` over `gennorm`)
    assert!((likelihood.shape_std_error.unwrap() / 0.654_789_45 - 1.0).abs() < 1e-5, "{likelihood:?}");
}

/// The linear programme `min Σ (a(j+1) − a(j)) (sum of the m − j largest residuals)`, which is the
/// dispersion: scipy 1.x `linprog(method="highs")`.
#[test]
fn normal_scores_find_the_least_dispersion() {
    let found = of(&stack_loss(), Estimator::NormalScores);
    agree("normal scores", &values(&found), &[-39.175, 0.7625, 1.1, -0.15], 1e-6);
    let robust = found.robust.unwrap();
    assert!(robust.converged, "{robust:?}");
    assert!((robust.objective / 52.027_752_466_055_67 - 1.0).abs() < 1e-12, "{}", robust.objective);
}
