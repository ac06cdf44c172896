//! The best level, and the plateau about it: how far k may be off without harm, and where on the
//! plateau the matrix is conditioned best.

use super::result::{LevelRatios, LevelResult, MethodResults, Optimum, Summary};

/// ‖A − Â_R‖ on the plateau is at most this many times the least.
pub const PLATEAU: f64 = 1.05;

pub(super) fn optimum(levels: &[LevelResult], least_squares: &MethodResults) -> Option<Optimum> {
    let mut known: Vec<(&LevelResult, f64)> =
        levels.iter().filter_map(|level| median(level.results.bias_norm_squared).map(|error| (level, error))).collect();
    known.sort_by(|a, b| a.0.level.total_cmp(&b.0.level));
    let at = (0..known.len()).min_by(|&a, &b| known[a].1.total_cmp(&known[b].1))?;
    let within = |(_, error): &&(&LevelResult, f64)| *error <= PLATEAU * PLATEAU * known[at].1;
    let below = known[..at].iter().rev().take_while(within).count();
    let above = known[at..].iter().take_while(within).count();
    let plateau = &known[at - below..at + above];
    let condition = |level: &LevelResult| median(level.results.condition).unwrap_or(f64::INFINITY);
    let (calmest, _) = plateau.iter().min_by(|a, b| condition(a.0).total_cmp(&condition(b.0)))?;
    Some(Optimum {
        best: ratios(known[at].0, least_squares)?,
        plateau: [plateau.first()?.0.level, plateau.last()?.0.level],
        least_condition: ratios(calmest, least_squares)?,
    })
}

fn ratios(level: &LevelResult, least_squares: &MethodResults) -> Option<LevelRatios> {
    let ratio = |a: Option<Summary>, b: Option<Summary>| Some(median(a)? / median(b)?).filter(|r| r.is_finite());
    let results = &level.results;
    Some(LevelRatios {
        level: level.level,
        error_ratio: ratio(least_squares.bias_norm_squared, results.bias_norm_squared)?,
        condition_ratio: ratio(least_squares.condition, results.condition),
        rss_ratio: ratio(results.rss, least_squares.rss),
    })
}

fn median(summary: Option<Summary>) -> Option<f64> {
    summary.map(|s| s.median)
}
