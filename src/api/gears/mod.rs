//! Gears on the wire: data, what follows from them, flanks, evaluation, correction.

pub mod gear;
