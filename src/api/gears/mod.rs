//! Gears on the wire: data, what follows from them, flanks, evaluation, correction.

pub mod closed_loop;
pub mod correction;
pub mod correction_answer;
pub mod correction_request;
pub mod deviations;
pub mod deviations_request;
pub mod evaluate;
pub mod evaluate_request;
pub mod file;
pub mod file_import;
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
