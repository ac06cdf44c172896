//! Curves and surfaces on the wire: how they are written, asked for, evaluated and kept.

pub mod curve_shape;
mod fault;
mod net;
pub mod point;
pub mod surface_reader;
pub mod surface_shape;
