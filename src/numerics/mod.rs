//! Number kernels that know nothing but numbers.
