//! Requests that the document shows and that the tests send.

/// One example of a request body.
#[derive(Clone, Copy, Debug)]
pub struct RequestExample {
    /// The operation that takes it.
    pub operation_id: &'static str,
    /// Its name in the document.
    pub name: &'static str,
    /// Subject of the example.
    pub summary: &'static str,
    /// The JSON text.
    pub text: &'static str,
}

/// An example from the file `examples/requests/NAME.json`.
macro_rules! example {
    ($operation:literal, $name:literal, $summary:literal) => {
        RequestExample {
            operation_id: $operation,
            name: $name,
            summary: $summary,
            text: include_str!(concat!("../../examples/requests/", $name, ".json")),
        }
    };
}

/// Every example. A new endpoint's examples are lines here and files there.
pub const REQUEST_EXAMPLES: &[RequestExample] = &[
    example!("create_fit", "fit_curve", "A boundary curve, plain polynomial, every default"),
    example!("create_fit", "fit_grid", "A flank grid with missing nodes and every diagnostic"),
    example!("create_fit", "fit_scattered", "Scattered nodes with weights, Chebyshev basis, fixed λ*"),
    example!("create_fit", "fit_b_spline", "A B-spline curve with equal spans, ridge by generalised cross-validation"),
    example!("create_fit", "fit_matrix", "A measurement matrix with named columns, no regularisation"),
    example!("create_fit", "fit_filtered", "A flank grid with peaks and roughness, filtered before the fit"),
    example!("create_fit", "fit_filtered_curve", "A profile trace with a robust Gaussian filter"),
    example!(
        "study_randomization",
        "study_flank",
        "An involute section whose columns are nearly parallel: the set-up of the paper's figures"
    ),
    example!("study_randomization", "study_matrix", "A measurement matrix, seen in columns of unit length"),
    example!(
        "create_fit",
        "fit_m_estimator",
        "A flank grid with two gross peaks, Tukey's biweight from least trimmed squares"
    ),
    example!("create_fit", "fit_huber", "A curve with a gross peak, Huber's loss and proposal 2"),
    example!("create_fit", "fit_least_absolute", "The same curve by least absolute deviations"),
    example!("create_fit", "fit_lp", "The same curve by least sum of |r|^1.5"),
    example!("create_fit", "fit_quantile", "A line below which a quarter of the nodes lies"),
    example!("create_fit", "fit_least_trimmed", "The same curve by least trimmed squares"),
    example!("create_fit", "fit_rank", "The same curve by least rank dispersion"),
    example!("create_fit", "fit_normal_scores", "The same curve by least rank dispersion with normal scores"),
    example!("create_fit", "fit_minimax", "A curve by Huber's minimax estimator against one gross error in ten"),
    example!("create_fit", "fit_contamination", "The same curve, the share of gross errors estimated"),
    example!("create_fit", "fit_trimmed", "The same curve with a tenth of the nodes trimmed at either end"),
    example!("create_fit", "fit_winsorized", "The same curve with a tenth of the nodes winsorized at either end"),
    example!("create_fit", "fit_trimean", "The same curve by Tukey's trimean of regression quantiles"),
    example!("create_fit", "fit_student", "The same curve with errors of Student's distribution"),
    example!("create_fit", "fit_laplace", "The same curve with errors of Laplace's distribution"),
    example!(
        "create_fit",
        "fit_generalized_normal",
        "The same curve with generalised normal errors, their exponent estimated"
    ),
    example!(
        "create_fit",
        "fit_ridge_trace",
        "Ridge by Hoerl, Kennard and Baldwin, with the trace of its coefficients"
    ),
    example!("create_fit", "fit_tikhonov", "A B-spline surface with a penalty on its bending, stiffer along v"),
    example!("create_fit", "fit_truncated_svd", "Raw powers far from 0, the smallest direction left out"),
    example!("create_fit", "fit_james_stein", "James–Stein toward the grand mean with the positive-part factor"),
    example!(
        "create_fit",
        "fit_attraction",
        "Attracted to the coefficients of the nominal flank by the explicit \
        optimum"
    ),
    example!("create_fit", "fit_influence", "Influence of each node on the fit"),
    example!("create_fit", "fit_select", "The degrees of a flank, chosen by leaving out blocks of rows"),
    example!("create_fit", "fit_select_terms", "The terms of a flank that the elastic net keeps, chosen by bic"),
    example!("create_fit", "fit_terms", "Terms one by one, k of ridge by leaving out columns"),
    example!("create_fit", "fit_predict", "Bands of the flank and its slopes, where a norm limit is known"),
    example!("create_fit", "fit_shape", "A polynomial flank as the B-spline surface that meshes and exports take"),
    example!("create_fit", "fit_representative", "Regularised by the matrix B of another tooth"),
    example!("create_fit", "fit_constrained", "A flank that rises along u and is concave along v at every place"),
    example!("create_fit", "fit_prior", "A profile with a prior of its coefficients and their covariance"),
    example!("create_fit", "fit_correlated", "A scanned profile with autocorrelated errors"),
    example!("create_fit", "fit_matern", "Two scan lines at unequal steps, errors correlated over a distance"),
    example!("create_fit", "fit_groups", "Two probes of unequal noise"),
    example!("create_fit", "fit_positions", "A steep profile with errors of position"),
    example!("create_curve", "curve_lagrange", "The polynomial through eight nodes, with its Lebesgue constant"),
    example!("create_curve", "curve_newton", "The polynomial by divided differences"),
    example!("create_curve", "curve_hermite", "A polynomial with derivatives of mixed order"),
    example!("create_curve", "curve_cubic_hermite", "Cubic pieces with Akima's tangents"),
    example!("create_curve", "curve_cubic_spline", "A cubic spline through a profile, not-a-knot ends"),
    example!("create_curve", "curve_b_spline_space", "A B-spline through points in space, centripetal parameters"),
    example!("create_curve", "curve_least_squares", "A B-spline near points with a peak among them, robust"),
    example!("create_curve", "curve_adaptive", "Knots inserted until no point is further off than 0.1"),
    example!("create_curve", "curve_nurbs_least_squares", "A NURBS with given weights near points of a circle"),
    example!("create_curve", "curve_smoothing", "A smoothing spline, λ by generalised cross-validation"),
    example!("evaluate_curve", "curve_evaluate", "A quarter of a circle with derivatives, curvature and length"),
    example!("closest_points_of_curve", "curve_closest", "Distances of three points from a Bézier curve"),
    example!("export_curve", "curve_export", "An arc as STEP AP242"),
    example!("create_surface", "surface_coons", "A bilinearly blended Coons patch of four cubic borders"),
    example!("create_surface", "surface_grid", "The B-spline surface through a grid of heights"),
    example!("create_surface", "surface_mesh", "Gregory patches between two families of curves"),
    example!("create_surface", "surface_scattered", "A B-spline surface near scattered nodes, smoothed"),
    example!("evaluate_surface", "surface_evaluate", "A Bézier patch with normals, curvatures and area"),
    example!("closest_points_of_surface", "surface_closest", "Orthogonal distances of three nodes from a patch"),
    example!("sections_of_surface", "surface_sections", "A patch cut by two families of planes, and their mesh"),
    example!("export_surface", "surface_export", "A patch as binary STL"),
    example!("create_iteration_curve", "iteration_curve", "A smoothing spline of a measured profile, stored with it"),
    example!(
        "create_iteration_surface",
        "iteration_surface",
        "A B-spline surface near the measured grid, stored with it"
    ),
    example!("gear_geometry", "gear_geometry", "A helical gear with its rack tool"),
    example!("gear_flank", "gear_flank", "A left flank with tip relief and helix crowning"),
    example!("gear_profile", "gear_profile", "The section of a spur gear's tooth"),
    example!(
        "gear_solid_mesh",
        "gear_solid_mesh",
        "A helical tooth with its rim in quadratic elements, for Abaqus or CalculiX"
    ),
    example!("gear_envelope", "gear_envelope", "The flank that a rack with a sharp tip generates"),
    example!("gear_tolerances", "gear_tolerances", "Class 5"),
    example!("evaluate_gear", "gear_evaluate", "Two profiles and a helix of a spur gear, signs of DIN"),
    example!("gear_pitch", "gear_pitch", "Index deviations of both flanks, with the run-out that follows"),
    example!(
        "gear_pitch",
        "gear_pitch_limits",
        "The same pitches compared with a class and limits, with uncertainties"
    ),
    example!(
        "gear_deviations",
        "gear_deviations",
        "Points of both flanks of a tooth, registered by a turn and two shifts"
    ),
    example!(
        "gear_flank_surface",
        "gear_flank_surface",
        "Slopes, crownings and twist of a flank, compared with limits"
    ),
    example!("simulate_closed_loop", "closed_loop", "Settings that cannot be separated, with two correction methods"),
    example!(
        "create_iteration_correction",
        "iteration_correction",
        "A form grinder's settings by the nodes of a flank"
    ),
    example!("create_applied_changes", "applied_changes", "Only the two angles were entered"),
    example!(
        "create_gear_correction",
        "gear_correction",
        "A generating grinder's settings by all teeth, the profile of its worm dressed by flank"
    ),
    example!("create_gear_applied_changes", "gear_applied_changes", "The crownings are not changed"),
    example!("create_iteration_evaluation", "iteration_evaluation", "A helix that was measured with the nodes"),
    example!("create_iteration_pitch", "iteration_pitch", "Single pitches of the left flank, and readings of a ball"),
    example!(
        "create_iteration_pitch",
        "iteration_pitch_limits",
        "Single pitches compared with limits of their own instead of the job's, with uncertainties"
    ),
    example!("create_iteration_deviations", "iteration_deviations", "Deviations on a grid, the tip trimmed"),
    example!("purge_job", "purge", "A job that is old enough"),
    example!("create_job", "job", "A spur gear on a form grinder"),
    example!("create_job", "job_requirements", "A gear with its class, limits of figures and bands of K-charts"),
    example!("create_iteration", "iteration", "The flank after the first cut, with one missing node"),
    example!("create_iteration_fit", "refit", "The same nodes with λ* by generalised cross-validation"),
    example!("create_iteration_fit", "refit_prior", "The same nodes with the job's earlier iterations as prior"),
    example!("preview_iteration_fit", "preview", "A larger λ*, with the fitted heights; stores nothing"),
    example!("choose_fit", "chosen_fit", "Choose another fit (put in the id of a stored fit)"),
    example!("create_stream", "stream", "A flank that is fitted while the probe moves, on a given domain"),
    example!("add_stream_nodes", "stream_block", "The first block of nodes"),
    example!("finish_stream", "stream_finish", "Details of the measurement"),
    example!("update_iteration", "decision", "The flank is machined again"),
    example!("create_key", "key", "A key of a machine, which stores measurements"),
    example!("create_key", "key_certificate", "The certificate of a measuring machine, scopes one by one"),
    example!("rotate_key", "key_rotation", "Another secret, with a day of overlap"),
    example!("create_tenant", "tenant", "Another plant"),
];
