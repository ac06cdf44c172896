//! The store on real files: what the schema refuses, what the trace keeps, what survives.

mod backup;
mod disk;
mod group_commit;
mod migrations;
mod paging;
mod power_loss;
mod records;
mod schema;
mod streams;
mod support;
mod teeth;
mod trace;
mod upkeep;
