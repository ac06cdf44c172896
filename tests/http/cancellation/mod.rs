//! Work ends with its client, and with the server: the dearest request of every operation that
//! computes is begun over real HTTP on a real store, its client leaves, and the process rests.

pub mod dear;
mod ends;
mod registry;
