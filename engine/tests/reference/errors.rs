//! Correlated errors and unequal variances against statsmodels, nlme and dense sums.

use crate::answers::{answer, curve, monomials, plain, std_errors, values};
use flankfit_engine::estimation::{
    FitResult, FitSpec,
    result::VarianceReport,
    spec::{Along, Correlation, Errors, Matern, Variance},
};

/// `round(2 − 0.3 i + 0.02 i² + 0.8 sin 0.9 i + 0.5 cos(2.3 i + 1) + 0.4 sin 0.37 i², 3)`.
const Y: [f64; 24] = [
    2.27, 1.998, 3.045, 1.524, 0.267, 0.786, 0.268, 0.541, 1.544, 0.82, 1.284, 1.234, 0.072, 1.186, 1.537, 2.749,
    3.772, 2.675, 2.888, 3.509, 2.768, 4.768, 5.844, 6.334,
];

fn x() -> Vec<f64> {
    (0..24).map(f64::from).collect()
}

fn found(correlation: Correlation) -> FitResult {
    let errors = Some(Errors { correlation, along: Along::Order, lines: None });
    answer(&curve(&x(), &Y), &FitSpec { errors, ..plain(monomials(2)) })
}

fn close(got: &[f64], expected: &[f64], relative: f64) {
    assert_eq!(got.len(), expected.len());
    for (got, expected) in got.iter().zip(expected) {
        assert!((got - expected).abs() <= relative * expected.abs(), "{got} {expected}");
    }
}

/// statsmodels.regression.linear_model.GLS with the dense correlations.
#[test]
fn generalised_least_squares_is_that_of_statsmodels() {
    let cases = [
        (
            Correlation::Ar1 { rho: Some(0.6) },
            [2.386_565_859_114_318_4, -0.394_282_114_932_148_04, 0.024_343_198_532_554_04],
            [0.821_765_625_152_460_8, 0.162_086_971_325_233_8, 0.006_749_148_032_684_299],
        ),
        (
            Correlation::Ar2 { phi: Some([1.1, -0.5]) },
            [2.352_681_711_508_774_6, -0.376_967_019_823_208, 0.023_354_116_021_773_015],
            [1.198_908_958_810_682_7, 0.243_676_572_117_544_8, 0.010_214_167_602_051_205],
        ),
        (
            Correlation::Matern { parameters: Some(Matern { length: 2.5, nugget: 0.2 }) },
            [2.319_813_420_164_933, -0.384_922_834_122_165_4, 0.024_109_255_313_328_276],
            [0.968_185_188_149_213_5, 0.189_969_863_800_783_32, 0.007_895_244_705_076_384],
        ),
    ];
    for (correlation, value, error) in cases {
        let result = found(correlation);
        close(&values(&result), &value, 1e-11);
        close(&std_errors(&result), &error, 1e-10);
    }
    let sigma = found(Correlation::Ar1 { rho: Some(0.6) }).residuals.sigma.unwrap();
    assert!((sigma - 0.942_460_966_958_250_9).abs() < 1e-12, "{sigma}");
}

/// The mixture over 160 values of θ, with dense matrices (numpy) and scipy's t and brentq.
#[test]
fn the_mixture_over_rho_is_that_of_dense_sums() {
    let result = found(Correlation::Ar1 { rho: None });
    close(&values(&result), &[2.386_083_086_538_729_7, -0.394_011_750_551_677_75, 0.024_325_330_333_510_226], 1e-8);
    close(&std_errors(&result), &[1.983_478_298_239_681_5, 0.181_302_629_063_927_9, 0.007_327_692_369_273_784], 1e-6);
    let intervals = [
        [-0.873_938_471_458_837, 5.474_877_571_953_808],
        [-0.792_344_353_425_476_9, 0.011_383_505_609_962_39],
        [0.008_208_923_124_170_589, 0.040_637_677_682_226_286],
    ];
    for (c, expected) in result.coefficients.iter().zip(intervals) {
        close(&c.interval.unwrap().ends, &expected, 1e-6);
    }
    let report = result.errors.unwrap();
    let parameters = &report.parameters;
    close(
        &[parameters.rho.unwrap(), parameters.std_error.unwrap()],
        &[0.466_016_843_948_310_06, 0.299_045_056_709_787_87],
        1e-7,
    );
}

/// statsmodels OLS(…).fit().HC3_se.
#[test]
fn the_sandwich_is_that_of_statsmodels() {
    let result = answer(&curve(&x(), &Y), &FitSpec { variance: Variance::Hc3, ..plain(monomials(2)) });
    close(&values(&result), &[2.429_189_615_384_611, -0.396_332_899_057_463_66, 0.024_229_955_913_651_5], 1e-12);
    close(
        &std_errors(&result),
        &[0.403_702_379_351_708_1, 0.073_778_433_653_419_55, 0.002_892_502_857_518_391_7],
        1e-11,
    );
}

/// nlme::gls(…, method = "REML") with varIdent(form = ~1 | g) and varPower(form = ~x), x = 1 … 24:
/// both stop where the likelihood is flat to 1e-6. Standard errors of groups are Kenward and
/// Roger's at these variances, intervals Satterthwaite's, by dense matrices in numpy; nlme's own,
/// which take the variances for known, are 0.390296, 0.077542 and 0.0033295.
#[test]
fn estimated_variances_are_those_of_nlme() {
    let places: Vec<f64> = x().iter().map(|x| x + 1.0).collect();
    let groups: Vec<i64> = (0..24).map(|k| k / 8).collect();
    let by_group = answer(&curve(&x(), &Y), &FitSpec { variance: Variance::Groups(groups), ..plain(monomials(2)) });
    close(&values(&by_group), &[2.442_909_478_166_179_8, -0.398_359_080_799_981_9, 0.024_329_045_048_513_1], 1e-4);
    close(
        &std_errors(&by_group),
        &[0.401_663_466_621_388_4, 0.083_080_690_109_486_59, 0.003_578_007_556_282_180_7],
        1e-4,
    );
    let ends: Vec<f64> = by_group.coefficients.iter().flat_map(|c| c.interval.unwrap().ends).collect();
    let expected = [
        [1.524_636_422_152_04, 3.361_182_517_450_048_7],
        [-0.572_939_672_778_932_2, -0.223_778_472_848_234_57],
        [0.016_886_923_830_135_722, 0.031_771_165_442_668_38],
    ];
    close(&ends, expected.as_flattened(), 1e-4);
    let sigmas = by_group.variance.unwrap().groups.unwrap();
    let expected = [
        0.690_842_052_880_07,
        0.690_842_052_880_07 * 0.876_195_323_616_929,
        0.690_842_052_880_07 * 1.169_484_858_386_236,
    ];
    close(&sigmas.iter().map(|group| group.sigma).collect::<Vec<_>>(), &expected, 1e-4);

    let power = Variance::Power { of: Along::U, exponent: None };
    let by_power = answer(&curve(&places, &Y), &FitSpec { variance: power, ..plain(monomials(2)) });
    let Some(VarianceReport { exponent: Some(exponent), at: Some(at), .. }) = by_power.variance else {
        panic!("no power")
    };
    assert!((exponent - 0.042_945_556_463_520_5).abs() < 1e-5, "{exponent}");
    // nlme's σ is that at x = 1
    let sigma = by_power.residuals.sigma.unwrap() / at.powf(exponent);
    assert!((sigma - 0.637_950_364_777_019).abs() < 1e-5, "{sigma}");
    // heights at the middle of both parametrisations
    let [a, b, c] = values(&by_power)[..] else { panic!("three coefficients") };
    let expected = 2.437_441_040_914_694_5 - 0.398_217_383_398_284_9 * 11.0 + 0.024_306_237_658_984_7 * 121.0;
    assert!((a + 12.0 * b + 144.0 * c - expected).abs() < 1e-5);
}
