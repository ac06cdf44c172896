//! The constraints of a request: wire parts to checked values.

use crate::api::{
    faults::Faults,
    fits::spec::constraint::{ConstraintBody, MOST_CONSTRAINTS},
    json::value::read_value,
};
use flankfit_engine::estimation::spec::Constraint;

/// The constraints, when none has a fault by itself; whether they suit the model is the engine's to
/// say.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<Vec<Constraint>> {
    let bodies: Vec<ConstraintBody> = read_value(slice, "/constraints", faults)?;
    if bodies.len() > MOST_CONSTRAINTS {
        faults.push("/constraints", format!("{} constraints; at most {MOST_CONSTRAINTS}", bodies.len()));
        return None;
    }
    Some(bodies.into_iter().map(Constraint::from).collect())
}
