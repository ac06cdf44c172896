//! Gears on the wire: data, what follows from them, flanks, evaluation, correction.

pub mod borders;
pub mod closed_loop;
pub mod correction;
pub mod correction_answer;
pub mod correction_csv;
pub mod correction_request;
pub mod deviations;
pub mod deviations_request;
pub mod evaluate;
pub mod evaluate_request;
pub mod file;
mod file_curves;
pub mod file_gears;
pub mod file_import;
mod file_points;
pub mod flank;
pub mod flank_surface;
pub mod gear;
pub mod geometry;
pub mod iteration_nodes;
pub mod modification;
pub mod notice;
pub mod pitch;
pub mod profile;
pub mod registration;
pub mod tolerances;
pub mod trace;
