//! Parts of specs, drawn.

use flankfit_engine::estimation::spec;

/// Places of every kind, or none.
pub fn predict(which: usize, value: f64) -> Option<spec::Predict> {
    let at = match which % 5 {
        0 => return None,
        4 => spec::Places::Rows(vec![vec![1.0, value], vec![-value, 2.0]]),
        1 => spec::Places::Curve(vec![0.5, value]),
        2 => spec::Places::Points { u: vec![-value, 1.0], v: vec![0.0, value] },
        _ => spec::Places::Grid { u: vec![value], v: vec![0.0, 1.0, 2.0] },
    };
    let kinds = spec::Kinds { confidence: which > 4, prediction: which & 2 > 0, simultaneous: which & 1 > 0 };
    Some(spec::Predict { at, level: (which > 8).then_some(0.99), kinds, slopes: which > 10 })
}

pub fn select(which: usize, value: f64) -> Option<spec::Select> {
    let criterion = spec::ModelCriterion::ALL[which % 5];
    let candidates = match which {
        3 => spec::Candidates::Degrees(spec::Degree::Both(7)),
        4 => spec::Candidates::Degrees(spec::Degree::Each(2, 0)),
        5 => spec::Candidates::Terms(spec::TermSearch::Backward),
        6 => spec::Candidates::Terms(spec::TermSearch::ElasticNet { alpha: value.min(1.0) }),
        _ => return None,
    };
    Some(spec::Select { candidates, criterion, hierarchical: which != 5 })
}

pub fn folds(which: usize) -> Option<spec::Folds> {
    let by = match which & 3 {
        1 => spec::FoldsBy::Rows,
        2 => spec::FoldsBy::Columns,
        3 => spec::FoldsBy::Lines(vec![-1, 7]),
        _ => return None,
    };
    Some(spec::Folds { by, count: (which > 6).then_some(which) })
}
