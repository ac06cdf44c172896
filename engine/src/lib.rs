#![doc = include_str!("../README.md")]

pub mod estimation;
pub mod fault;
pub mod formats;
pub mod gear;
pub mod geometry;
pub mod numerics;
