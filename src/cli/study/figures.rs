//! The paper's Figs. 4 and 5 from a study: what k does to stability and to accuracy.

use super::svg::{Curve, Line, Panel, page};
use crate::api::studies::result::RandomizationResult;
use flankfit_engine::estimation::randomization::{Figures, Summary};

/// Fig. 4: condition and determinant of the randomised Fisher information matrix.
pub fn stability(result: &RandomizationResult) -> String {
    page(
        "Stability of the estimate under randomisation in space",
        &[
            panel(result, "log₁₀ cond(X̃ᵀX̃)", true, |f| f.condition),
            panel(result, "log₁₀ det(X̃ᵀX̃)", false, |f| f.log10_determinant),
        ],
    )
}

/// Fig. 5: error of the coefficients and residual sum of squares.
pub fn accuracy(result: &RandomizationResult) -> String {
    page(
        "Accuracy of the estimate under randomisation in space",
        &[
            panel(result, "log₁₀ ‖A − Â‖²", true, |f| f.bias_norm_squared),
            panel(result, "log₁₀ RSS, ‖y − X Â‖²", true, |f| f.rss),
        ],
    )
}

fn panel(result: &RandomizationResult, title: &str, logarithm: bool, figure: fn(&Figures) -> Option<Summary>) -> Panel {
    let scale = |x: f64| if logarithm { libm::log10(x) } else { x };
    // level 0 has no place on a logarithmic axis; it is the line of least squares
    let points = result.levels.iter().filter(|level| level.level > 0.0).filter_map(|level| {
        let q = figure(&level.figures)?;
        let point = [libm::log10(level.level), scale(q.q1), scale(q.median), scale(q.q3)];
        point.iter().all(|x| x.is_finite()).then_some(point)
    });
    let mut points: Vec<[f64; 4]> = points.collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let references = &result.references;
    let shown = [
        ("least squares", Some(&references.least_squares)),
        ("spectral, first order", references.spectral_first_order.as_ref().map(|r| &r.chosen.figures)),
        ("spectral, exact", references.spectral_exact.as_ref().map(|r| &r.chosen.figures)),
        ("ridge", Some(&references.ridge.chosen.figures)),
    ];
    let lines = shown.iter().filter_map(|(name, figures)| {
        let at = scale(figure((*figures)?)?.median);
        at.is_finite().then(|| Line { name: (*name).to_owned(), at })
    });
    Panel { title: title.to_owned(), curve: Curve { points }, lines: lines.collect() }
}
