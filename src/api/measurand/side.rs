//! Left and right flanks on the wire.

pub use flankfit_engine::gear::Side as SideName;
