//! The paper's Figs. 4 and 5 from a study: what k does to stability and to accuracy.

use super::svg::{Curve, Line, Panel, page};
use crate::api::study_result::{Quartiles, RandomizationResult, StudyLevel};

/// Fig. 4: condition and determinant of the randomised Fisher information matrix.
pub fn stability(result: &RandomizationResult) -> String {
    page(
        "Stability of the estimate under randomisation in space",
        &[
            panel(result, "log₁₀ cond(X̃ᵀX̃)", true, |level| level.condition, |r| r.condition),
            panel(result, "log₁₀ det(X̃ᵀX̃)", false, |level| level.log10_determinant, |r| r.log10_determinant),
        ],
    )
}

/// Fig. 5: error of the coefficients and residual sum of squares.
pub fn accuracy(result: &RandomizationResult) -> String {
    page(
        "Accuracy of the estimate under randomisation in space",
        &[
            panel(result, "log₁₀ ‖A − Â‖²", true, |level| level.bias_norm_squared, |r| r.bias),
            panel(result, "log₁₀ RSS, ‖y − X Â‖²", true, |level| level.rss, |r| r.rss),
        ],
    )
}

/// What a reference has to show.
struct Shown {
    condition: Option<Quartiles>,
    log10_determinant: Option<Quartiles>,
    bias: Option<Quartiles>,
    rss: Option<Quartiles>,
}

fn panel(
    result: &RandomizationResult,
    title: &str,
    logarithm: bool,
    of_level: fn(&StudyLevel) -> Option<Quartiles>,
    of_reference: fn(&Shown) -> Option<Quartiles>,
) -> Panel {
    let scale = |x: f64| if logarithm { libm::log10(x) } else { x };
    // level 0 has no place on a logarithmic axis; it is the line of least squares
    let points = result.levels.iter().filter(|level| level.level > 0.0).filter_map(|level| {
        let q = of_level(level)?;
        let point = [libm::log10(level.level), scale(q.q1), scale(q.median), scale(q.q3)];
        point.iter().all(|x| x.is_finite()).then_some(point)
    });
    let mut points: Vec<[f64; 4]> = points.collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let references = &result.references;
    let plain = &references.least_squares;
    let mut lines = vec![(
        "least squares",
        Shown {
            condition: plain.condition,
            log10_determinant: plain.log10_determinant,
            bias: plain.bias_norm_squared,
            rss: plain.rss,
        },
    )];
    let regularized = [
        ("spectral, first order", references.spectral_first_order.as_ref()),
        ("spectral, exact", references.spectral_exact.as_ref()),
        ("ridge", Some(&references.ridge)),
    ];
    for (name, reference) in regularized {
        let Some(r) = reference else { continue };
        let shown = Shown {
            condition: r.condition,
            log10_determinant: r.log10_determinant,
            bias: r.bias_norm_squared,
            rss: r.rss,
        };
        lines.push((name, shown));
    }
    let lines = lines.iter().filter_map(|(name, shown)| {
        let at = scale(of_reference(shown)?.median);
        at.is_finite().then(|| Line { name: (*name).to_owned(), at })
    });
    Panel { title: title.to_owned(), curve: Curve { points }, lines: lines.collect() }
}
