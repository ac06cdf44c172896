//! Requests that the document shows and that the tests send.

/// One example of a request body.
#[derive(Clone, Copy, Debug)]
pub struct RequestExample {
    /// The operation that takes it.
    pub operation_id: &'static str,
    /// Its name in the document.
    pub name: &'static str,
    /// What it shows.
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
    example!("study_randomization", "study_flank", "The profile of a flank whose columns are nearly parallel"),
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
    example!(
        "create_fit",
        "fit_ridge_trace",
        "Ridge by Hoerl, Kennard and Baldwin, with the trace of its coefficients"
    ),
    example!("create_fit", "fit_tikhonov", "A B-spline surface with a penalty on its bending, stiffer along v"),
    example!("create_fit", "fit_truncated_svd", "Raw powers far from 0, the smallest direction left out"),
    example!("create_fit", "fit_james_stein", "James–Stein toward the grand mean, never beyond it"),
    example!("create_fit", "fit_attraction", "Drawn to the coefficients of the nominal flank by the explicit optimum"),
    example!("create_job", "job", "A spur gear on a form grinder"),
    example!("create_iteration", "iteration", "The flank after the first cut, with one missing node"),
    example!("create_iteration_fit", "refit", "The same nodes with λ* by generalised cross-validation"),
    example!("choose_fit", "chosen_fit", "Another fit stands from now on (put in the id of a stored fit)"),
    example!("create_stream", "stream", "A flank that is fitted while the probe moves, on a domain known beforehand"),
    example!("add_stream_nodes", "stream_block", "The first block of nodes"),
    example!("finish_stream", "stream_finish", "What is known of the measurement"),
    example!("update_iteration", "decision", "The flank is machined again"),
];
