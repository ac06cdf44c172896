//! Distributions behind intervals and tests: normal, Student's t, Fisher's F, χ².
//!
//! Tails are upper tails, since those are small where they are used: `P(T > t)` keeps its digits
//! where `1 - P(T ≤ t)` has none left. Logarithms, exponentials and the error function are libm's,
//! which returns the same bits on every machine.

mod beta;
pub mod chi_squared;
pub mod fisher;
pub mod gamma;
pub mod normal;
pub mod pearson;
pub mod student;

pub use student::Student;
