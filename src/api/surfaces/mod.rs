//! Surfaces of grids, points, boundaries, meshes and nodes: requests, readers, responses,
//! evaluation, closest points and sections by planes.

pub mod closest;
pub mod evaluate;
pub mod given;
pub mod methods;
pub mod near;
pub mod request;
pub mod result;
pub mod sections;
pub mod source;
pub mod values;

pub use self::request::build;
