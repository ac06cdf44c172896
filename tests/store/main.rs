//! The store on real files: what the schema refuses, what the trace keeps, what survives.

mod backup;
mod group_commit;
mod migrations;
mod paging;
mod schema;
mod support;
mod trace;
