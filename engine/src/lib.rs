#![doc = include_str!("../README.md")]
#![warn(unreachable_pub, unnameable_types)]

pub mod estimation;
pub mod fault;
pub mod formats;
pub mod gear;
pub mod geometry;
pub mod numerics;
