//! Gears: data, what follows from them, evaluation, deviations, correction, files.

pub mod correction;
pub mod design;
pub mod design_at_nodes;
pub mod deviations;
pub mod evaluation;
pub mod figure_limits;
pub mod files;
pub mod fit_figures;
pub mod flank_design;
pub mod gear;
pub mod of_iteration;
pub mod plausibility;
pub mod quality_data;
pub mod requirements;
pub mod trace;
