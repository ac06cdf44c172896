//! The blocks of nodes that cross-validation leaves out: wire form to checked values.

use crate::api::{
    faults::Faults,
    fits::spec::folds::{FoldsBody, FoldsByName},
    json::value::read_object,
};
use flankfit_engine::estimation::spec::{Folds, FoldsBy};

/// The blocks, when nothing is wrong with them; whether they suit the nodes is the engine's to say.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<Folds> {
    let body: FoldsBody = read_object(slice, "/folds", faults)?;
    let by = match (body.by, body.line) {
        (FoldsByName::Rows, None) => FoldsBy::Rows,
        (FoldsByName::Columns, None) => FoldsBy::Columns,
        (FoldsByName::Lines, Some(line)) => FoldsBy::Lines(line),
        (FoldsByName::Lines, None) => {
            faults.push_missing("/folds/line", "missing; `lines` needs the line of each node");
            return None;
        }
        (_, Some(_)) => {
            faults.push("/folds/line", "only `lines` takes it");
            return None;
        }
    };
    Some(Folds { by, count: body.count })
}
