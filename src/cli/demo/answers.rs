//! What the demonstration reads of the service's answers: a client's view of the contract, which
//! may leave fields out.

use serde::Deserialize;

#[derive(Clone, Debug, Deserialize)]
pub struct Job {
    pub id: String,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Iteration {
    pub number: u32,
    pub fits: Vec<StoredFit>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct StoredFit {
    pub id: String,
    pub result: Fit,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Fit {
    pub coefficients: Vec<Coefficient>,
    pub domain: Option<Domain>,
    pub spectrum: Spectrum,
    pub regularization: Regularization,
    pub bias: Bias,
    pub collinearity: Collinearity,
    pub residuals: Residuals,
    #[serde(default)]
    pub warnings: Vec<Warning>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Coefficient {
    pub term: String,
    pub powers: Option<Vec<usize>>,
    pub value: f64,
    pub std_error: Option<f64>,
    pub least_squares: f64,
    pub least_squares_std_error: Option<f64>,
    pub bias_bound: f64,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Domain {
    pub u: Option<[f64; 2]>,
    pub v: Option<[f64; 2]>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Spectrum {
    pub eigenvalues: Vec<f64>,
    pub condition: Option<f64>,
    pub regularized: RegularizedSpectrum,
}

#[derive(Clone, Debug, Deserialize)]
pub struct RegularizedSpectrum {
    pub eigenvalues: Vec<f64>,
    pub condition: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Regularization {
    pub count: Option<usize>,
    pub lambda_star: Option<f64>,
    pub criterion: Option<String>,
    #[serde(default)]
    pub filter_factors: Vec<f64>,
    #[serde(default)]
    pub choices: Vec<Choice>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Choice {
    pub criterion: String,
    pub lambda_star: Option<f64>,
    pub condition: Option<f64>,
    pub bias_norm: f64,
    pub predicted_mse: Option<f64>,
    pub rms: f64,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Bias {
    pub norm: f64,
    pub sharp_bound: f64,
    pub paper_bound: Option<f64>,
    pub coefficient_norm_limit: f64,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Collinearity {
    pub near_dependencies: Vec<NearDependency>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct NearDependency {
    pub sentence: String,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Residuals {
    pub count: usize,
    pub degrees_of_freedom: usize,
    pub sigma: Option<f64>,
    pub rms: f64,
    pub max_abs: f64,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Warning {
    pub code: String,
    pub message: String,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Trace {
    pub iterations: Vec<TracedIteration>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct TracedIteration {
    pub number: u32,
    pub fits: Vec<TracedFit>,
    pub choices: Vec<TracedChoice>,
    pub decisions: Vec<TracedDecision>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct TracedFit {
    pub id: String,
    pub lambda_star: Option<f64>,
    pub criterion: Option<String>,
    pub condition: Option<f64>,
    pub regularized_condition: Option<f64>,
    pub bias_norm: Option<f64>,
    pub rms: Option<f64>,
    pub created_at: String,
    pub reason: Option<String>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct TracedChoice {
    pub fit_id: String,
    pub reason: Option<String>,
    pub created_at: String,
}

#[derive(Clone, Debug, Deserialize)]
pub struct TracedDecision {
    pub decision: String,
    pub reason: Option<String>,
    pub created_at: String,
}
