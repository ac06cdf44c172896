//! Curves and surfaces on the wire: how they are written, asked for, evaluated and kept.

pub mod curve_closest;
pub mod curve_evaluate;
mod curve_method_reader;
pub mod curve_methods;
mod curve_near;
pub mod curve_points;
pub mod curve_request;
pub mod curve_result;
pub mod curve_shape;
pub mod export;
mod fault;
pub mod near_result;
mod net;
mod places;
pub mod point;
pub mod surface_closest;
pub mod surface_evaluate;
mod surface_given;
mod surface_method_reader;
pub mod surface_methods;
mod surface_near;
mod surface_reader;
pub mod surface_request;
pub mod surface_result;
pub mod surface_shape;
pub mod surface_values;

/// Why a method that passes through its points takes nothing of a fit.
const THROUGH: &str = "it belongs to methods near points, which fit; this one passes through all of them";
