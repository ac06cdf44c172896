//! Exported files, read by small parsers of the formats' grammars that share nothing with the writers.
//! `tools/check_cad.py` does the same with a CAD kernel.

mod iges;
mod iges_file;
mod meshes;
mod shapes;
mod step;
mod step_file;
