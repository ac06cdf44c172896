//! Published and exactly computed reference results. `tests/refdata/README.md` says where each file
//! comes from.

#[expect(dead_code, reason = "the oracle is shared by the test binaries, each of which uses a part")]
#[path = "../oracle/mod.rs"]
mod oracle;

mod answers;
mod b_spline;
mod collinearity;
mod constrained;
mod curves;
mod enclosure;
mod errors;
mod filip;
mod folder;
mod gear_p40;
mod gear_p40_curves;
mod influence;
mod near;
mod nist;
mod oracle_check;
mod positions;
mod prior;
mod recursive;
mod reml;
mod ridge;
mod robust;
mod robust_more;
mod selection;
mod shrinkage;
mod spectral;
mod surfaces;
mod tensor;
