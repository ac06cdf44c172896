#![doc = include_str!("../README.md")]
#![warn(missing_docs, unnameable_types, unreachable_pub)]

pub mod estimation;
pub mod fault;
pub mod formats;
pub mod gear;
pub mod geometry;
pub mod numerics;
