//! Laws of the mathematics, checked from outside: properties over random and graded problems, and
//! simulations. The answers are compared with sums and solutions of the tests' own oracle, which
//! shares no code with the crate.

#[expect(dead_code, reason = "the oracle is shared by the test binaries, each of which uses a part")]
#[path = "../oracle/mod.rs"]
mod oracle;

mod bases;
mod bounds;
mod chosen_errors;
mod collinearity;
mod criteria;
mod curves;
mod edges;
mod estimable;
mod extremes;
mod fit_shapes;
mod gear_correction;
mod gear_correction_compare;
mod gear_correction_errors;
mod gear_correction_limits;
mod gear_correction_loop;
mod gear_correction_machine;
mod gear_correction_traces;
mod gear_correction_verdict;
mod gear_evaluation;
mod gear_evaluation_classes;
mod gear_evaluation_dust;
mod gear_evaluation_gaps;
mod gear_evaluation_holes;
mod gear_evaluation_quality;
mod gear_evaluation_signs;
mod gear_evaluation_surface;
mod gear_evaluation_traces;
mod gear_geometry;
mod gear_geometry_grid;
mod gear_geometry_tool;
mod gear_registration;
mod gear_registration_motion;
mod gear_registration_points;
mod gear_registration_screw;
mod gear_registration_start;
mod gear_registration_teeth;
mod hard;
mod influence;
mod intervals;
mod large;
mod least_condition;
mod machines;
mod near;
mod near_curve;
mod near_smoothing;
mod near_surface;
mod nodes;
mod opening;
mod penalised;
mod perturbation;
mod plans;
mod predictions;
mod prior;
mod problems;
mod rank;
mod recursive;
mod ridge;
mod robust;
mod robust_answers;
mod serial_correlation;
mod shrinkage;
mod simulation;
mod spectral;
mod statistics;
mod surfaces;
mod surfaces_grid;
mod surfaces_measure;
mod surfaces_mesh;
mod tikhonov;
mod units;
