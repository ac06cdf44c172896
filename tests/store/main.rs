//! The store on real files: what the schema refuses, what the trace keeps, what survives.

mod backup;
mod carry;
mod conformance;
mod cut_connections;
mod disk;
mod failover;
mod group_commit;
mod heard;
mod held_seals;
mod many_jobs;
mod migrations;
mod misplaced;
mod power_loss;
mod refusals;
mod restarts;
mod restore;
mod schema;
mod server;
mod service;
mod snapshots;
mod starts;
mod support;
mod upkeep;
mod wakes;
