//! Parameters of warnings about suspected gross errors.

use serde_json::{Value, json};

use super::Params;
use flankfit_engine::{
    estimation::result::{MovedCoefficient, Outliers, SuspectedNode},
    gear::evaluation::flank_surface::Figure,
};

/// Greatest number of nodes listed.
const MOST_NODES: usize = 1_000;
/// Greatest number of coefficients listed.
const MOST_COEFFICIENTS: usize = 64;

impl From<&Outliers> for Params {
    fn from(found: &Outliers) -> Self {
        Params::new()
            .list("nodes", found.nodes.iter().take(MOST_NODES).map(node))
            .with("count", found.nodes.len())
            .list("coefficients", found.coefficients.iter().take(MOST_COEFFICIENTS).map(coefficient))
            .list("moved", found.moved().take(MOST_COEFFICIENTS).map(|one| one.term.clone()))
            .with("moves_beyond_interval", found.moved().next().is_some())
    }
}

fn node(node: &SuspectedNode) -> Value {
    let mut told = json!({
        "index": node.index, "place": node.place, "height": node.height, "off": node.off,
        "off_sigmas": node.off_sigmas,
    });
    if let Some([row, column]) = node.cell {
        (told["row"], told["column"]) = (row.into(), column.into());
    }
    told
}

fn coefficient(one: &MovedCoefficient) -> Value {
    let told = json!({
        "term": one.term, "value": one.value, "without": one.without,
        "moves_beyond_interval": one.moves_beyond_interval(),
    });
    with_half_width(told, one.half_width)
}

fn with_half_width(mut told: Value, half_width: Option<f64>) -> Value {
    if let Some(half_width) = half_width {
        told["half_width"] = half_width.into();
    }
    told
}

/// A figure of a flank with and without the suspected nodes.
pub struct MovedFigure {
    pub name: String,
    pub value: f64,
    pub without: f64,
    /// Half-width of the confidence interval without them.
    half_width: Option<f64>,
}

impl MovedFigure {
    pub fn new(name: &str, with: &Figure, without: &Figure) -> Self {
        let half_width = without.inference.as_ref().map(|one| 0.5 * (one.interval[1] - one.interval[0]));
        MovedFigure { name: format!("{name}_um"), value: with.value, without: without.value, half_width }
    }

    /// Whether the suspected nodes change it by more than the half-width of its interval.
    pub fn moves_beyond_interval(&self) -> bool {
        self.half_width.is_some_and(|half| (self.value - self.without).abs() > half)
    }
}

impl From<&[MovedFigure]> for Params {
    fn from(figures: &[MovedFigure]) -> Self {
        let figure = |one: &MovedFigure| {
            let told = json!({
                "name": one.name, "value": one.value, "without": one.without,
                "moves_beyond_interval": one.moves_beyond_interval(),
            });
            with_half_width(told, one.half_width)
        };
        let moved = figures.iter().filter(|one| one.moves_beyond_interval()).map(|one| one.name.clone());
        let moves = figures.iter().any(MovedFigure::moves_beyond_interval);
        Params::new()
            .list("figures", figures.iter().map(figure))
            .list("moved", moved)
            .with("moves_beyond_interval", moves)
    }
}
