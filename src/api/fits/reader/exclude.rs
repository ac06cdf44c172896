//! Excluded nodes: from wire form to checked values.

use crate::api::{
    faults::Faults,
    fits::spec::exclude::{NodeAtBody, NodeCellBody},
    json::{
        cursor::{Cursor, Token},
        slice::Slice,
        value::read_value,
    },
};
use flankfit_engine::estimation::spec::NodeAt;

/// Returns the excluded nodes if they are well-formed; the engine checks that they exist.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<Vec<NodeAt>> {
    let parts: Vec<Slice> = read_value(slice, "/exclude", faults)?;
    let before = faults.count();
    let read: Vec<NodeAtBody> =
        parts.iter().enumerate().filter_map(|(k, part)| one(part.0, &format!("/exclude/{k}"), faults)).collect();
    (faults.count() == before).then(|| read.into_iter().map(NodeAt::from).collect())
}

fn one(slice: &[u8], at: &str, faults: &mut Faults) -> Option<NodeAtBody> {
    match Cursor::new(slice).token() {
        Ok(Token::Object) => read_value::<NodeCellBody>(slice, at, faults).map(NodeAtBody::Cell),
        _ => read_value(slice, at, faults).map(NodeAtBody::Index),
    }
}
