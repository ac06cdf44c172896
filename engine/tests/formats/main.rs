//! Exported files, read by small parsers of the formats' grammars that share nothing with the
//! writers. `tools/check_cad.py` does the same with a CAD kernel. Files that are read come from
//! writers of the tests' own.

mod gear_files;
mod gms;
mod iges;
mod iges_file;
mod klingelnberg;
mod klingelnberg_file;
mod klingelnberg_values;
mod meshes;
mod p40;
mod qdas;
mod qdas_file;
mod rexs;
mod rexs_file;
mod shapes;
mod solid_meshes;
mod step;
mod step_file;
mod table_dialects;
mod tables;
